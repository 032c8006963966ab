//! Steps: actions of a simulation before, between and after them, and the script functions for steps.
//!
//! A step is either completed or undone, so that an interrupted run can be continued exactly.

use std::time::Instant;

use rhai::EvalAltResult;

use super::artifacts::Artifacts;
use super::following;
use super::handle::{PastState, SimulationHandle, busy};
use super::journal::Journal;
use super::recalling::go_on;
use crate::dynamics::{LedgerRow, Overlap, OverlapKind, StepError};
use crate::math::tolerances::SAME_MOMENT;
use crate::output::journal::{Computation, Outcome};
use crate::script::api::examples::flight_example;
use crate::script::api::remedies::ScriptWords;
use crate::script::language::callback::Callback;
use crate::script::language::digits::{brief, number_text};
use crate::script::language::failure::interrupted;
use crate::script::language::observer::Progress;
use crate::script::language::prelude::*;

/// `step`: a number of steps.
pub fn step() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "step")
        .summary(
            "takes one step of `dt`, or so many; where a step must be halved, each piece is a row of the history and counts in `steps`",
        )
        .parameters(vec![Parameter::integer("count", "how many steps").within(Interval::NonNegative).or(1)])
        .see_also(&["run_to"])
        .example(flight_example("sim.step();"))
        .body(|call, simulation| {
            let count = call.integer("count")?;
            simulation.advance(call, None, count as usize)?;
            Ok(())
        })
}

/// `run_to`: steps until a time.
pub fn run_to() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "run_to")
        .summary("takes steps until a time, which is met exactly")
        .parameters(vec![Parameter::number("time", "time", Interval::Finite, "the time at which it stops")])
        .see_also(&["step", "on_step"])
        .example(flight_example("sim.run_to(0.05);"))
        .body(|call, handle| {
            let end = call.number("time")?;
            let end = handle.0.kernel_time(end);
            let now = handle.0.simulation.try_borrow().map_err(|_| busy(call))?.time();
            if end < now {
                let failure =
                    call.argument("time").refuse(causes::TIME, format!("`run_to` goes forward, but {} has passed", number_text(end)));
                let failure = failure.label(format!("the simulation is at t = {}", brief(now)));
                return Err(failure.hint("keep a state with `sim.save()` and go back to it with `sim.restore(state)`").into());
            }
            handle.advance(call, Some(end), usize::MAX)?;
            Ok(())
        })
}

/// `on_step`: a closure after every step.
pub fn on_step() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "on_step")
        .summary("calls a closure with the simulation after every step from now on")
        .parameters(vec![Parameter::new("action", Kind::Closure("|sim|"), "what is done after a step")])
        .see_also(&["run_to", "history"])
        .example(flight_example("sim.on_step(|s| if s.time > 0.03 { print(s.energy.total) });\nsim.run_to(0.04);"))
        .body(|call, simulation| {
            let callback = call.callback("action")?;
            call.host.count_effect();
            simulation.0.callbacks.borrow_mut().push(callback);
            Ok(())
        })
}

impl SimulationHandle {
    /// Refuses bodies that overlap at the start: this is rarely intended, and contact would keep the overlap.
    fn refuse_overlaps(&self, call: &Call) -> Result<(), Failure> {
        self.refuse(call, |_| true)
    }

    /// Refuses overlaps that `settle` would increase: bodies behind an obstacle whose normal points the wrong way.
    pub(super) fn refuse_wrong_way(&self, call: &Call) -> Result<(), Failure> {
        self.refuse(call, |overlap| matches!(overlap.kind, OverlapKind::Obstacle { whole: true, .. }))
    }

    fn refuse(&self, call: &Call, is_one: impl Fn(&Overlap) -> bool) -> Result<(), Failure> {
        let overlaps = self.0.overlaps.borrow();
        let found: Vec<&Overlap> = overlaps.iter().filter(|overlap| is_one(overlap)).collect();
        let Some(worst) = found.iter().max_by(|a, b| a.facets.total_cmp(&b.facets)) else { return Ok(()) };
        let others = match found.len() - 1 {
            0 => String::new(),
            others => format!("; {others} more overlap"),
        };
        let cause = format!("{}{others}", self.overlap_text(worst.depth, worst.facets, &worst.at));
        Err(call.fail(worst.to_string()).code(worst.code()).cause(cause).hint(worst.remedy()))
    }

    /// Takes steps until `count` are taken or `end` is reached.
    fn advance(&self, call: &Call, end: Option<f64>, count: usize) -> Result<(), Box<EvalAltResult>> {
        self.refuse_overlaps(call)?;
        if call.host.is_check() {
            return Ok(());
        }
        self.refuse_nested(call)?;
        let from = self.0.simulation.try_borrow().map_err(|_| busy(call))?.time();
        self.warn_at_start(call);
        self.begin(call, end)?;
        self.0.advancing.set(true);
        call.host.begin_steps();
        if end.is_none() {
            // A single step of a large model can take long.
            call.host.observer.began(&format!("stepping \"{}\"", self.0.name));
        }
        // A time within round-off of now, such as 0.1 + 0.2 after 0.3, is now.
        let reached = || end.is_some_and(|end| self.0.simulation.borrow().time() >= end - 4.0 * f64::EPSILON * end.abs());
        let mut outcome = Ok(());
        let mut taken = 0;
        while outcome.is_ok() && taken < count && !reached() {
            outcome = self.take_step(call, from, end);
            taken += 1;
        }
        self.0.advancing.set(false);
        self.show();
        call.host.end_steps();
        call.host.observer.ended();
        if end.is_some() {
            // `run_to` waits for its frames. Single steps do not, because the next one reports a frame that was refused.
            let written = self.0.artifacts.borrow_mut().as_mut().map_or(Ok(()), Artifacts::wait);
            outcome = outcome.and(written.map_err(Into::into));
        }
        outcome
    }

    /// Takes one step, and records its rows, its state, and the state before.
    fn take_step(&self, call: &Call, from: f64, end: Option<f64>) -> Result<(), Box<EvalAltResult>> {
        let data = &self.0;
        let stopped = |how: &str| {
            let time = data.simulation.borrow().time();
            interrupted(format!("{how} at t = {}", brief(time))).hint("everything up to this time is kept")
        };
        if call.host.is_stopped() {
            return Err(stopped("interrupted").into());
        }
        let is_last = |until: f64| data.script_time(data.simulation.borrow().time()) >= until;
        if call.host.settings.until.is_some_and(is_last) && !Journal::of(call.host).is_recalling() {
            return Err(stopped("stopped").into());
        }
        let (rows, stepped) = self.computed(call, self.landing(end))?;
        for row in rows {
            self.accept(call, row, from, end)?;
        }
        // After the last step of an earlier process: pictures and restored states continue from its recording.
        go_on(call.host)?;
        self.warn_of_large_motion(call.host);
        stepped.map_err(|error| self.step_failure(call, error))?;
        // No borrow is held here, because a closure may access all data and register further closures.
        let callbacks = data.callbacks.borrow().clone();
        if !callbacks.is_empty() {
            self.show();
        }
        self.checkpoint(call.host)?;
        for callback in callbacks {
            let _ = callback.call([Dynamic::from(self.clone())]).map_err(|error| passed_on(&callback, error))?;
        }
        if call.host.is_interrupted() { Err(stopped("interrupted").into()) } else { Ok(()) }
    }

    /// Returns the time beyond which the next step must not reach: `end` and, for adaptive step sizes, the next frame of the fields.
    fn landing(&self, end: Option<f64>) -> Option<f64> {
        let (data, simulation) = (&self.0, self.0.simulation.borrow());
        let every = data.keeping.fields_every.filter(|_| simulation.options().control.is_some());
        let frame = every.map(|every| {
            let every = data.kernel_time(every);
            let frame = ((simulation.time() / every + SAME_MOMENT).floor() + 1.0) * every;
            // A frame whose time equals the end up to round-off is written at the end.
            end.filter(|end| (frame - end).abs() <= SAME_MOMENT * every).unwrap_or(frame)
        });
        end.into_iter().chain(frame).reduce(f64::min)
    }

    /// Computes a step, or takes it from an earlier process; returns the rows of its substeps, and its outcome.
    fn computed(&self, call: &Call, end: Option<f64>) -> Result<Step, Box<EvalAltResult>> {
        let data = &self.0;
        let state = || data.simulation.try_borrow().map(|simulation| simulation.shared_state()).map_err(|_| busy(call));
        let known = if data.is_behind.get() { None } else { Some(state()?) };
        let mut before = PastState { state: known, rows: data.history.borrow().len(), is_known: data.is_known.get(), size: 0 };
        let (computation, mut rows, mut stepped) = (Computation::Step(end), Vec::new(), Ok(()));
        if let Some(Outcome::Stepped(recalled)) = self.recalled(call, computation)? {
            rows = recalled;
        } else {
            let start = state()?;
            before.state = Some(start.clone());
            let begun = Instant::now();
            let mut simulation = data.simulation.try_borrow_mut().map_err(|_| busy(call))?;
            let tally = simulation.tally();
            stepped = simulation.step(end, &mut |row| rows.push(row.clone()));
            data.spent.set(data.spent.get() + begun.elapsed());
            self.tell_halvings(call.host, &simulation, tally.causes(), &start.row);
            match &stepped {
                Err(error @ (StepError::Interrupted { .. } | StepError::Ranks { .. })) => {
                    // Only whole steps are kept, because continuing from a substep would not give identical bytes.
                    simulation.restore(&start);
                    simulation.count_from(&tally);
                    if let StepError::Ranks { source, .. } = error {
                        let lost = StepError::Ranks { time: start.row.time, source: *source };
                        return Err(self.step_failure(call, lost).into());
                    }
                    let stopped = interrupted(format!("interrupted at t = {}", brief(start.row.time)));
                    return Err(stopped.hint("everything up to this time is kept").into());
                }
                Err(_) => self.take_down(computation, Outcome::Failed, &start, simulation.tally()),
                Ok(()) => self.take_down(computation, Outcome::Stepped(rows.clone()), &start, simulation.tally()),
            }
        }
        if !rows.is_empty() {
            call.host.count_effect();
            self.keep_past(call.host, before);
        }
        Ok((rows, stepped))
    }

    /// Prepares the first step: writes the first frame of the fields.
    fn begin(&self, call: &Call, end: Option<f64>) -> Result<(), Failure> {
        if let Some(artifacts) = self.0.artifacts.borrow_mut().as_mut() {
            let simulation = self.0.simulation.try_borrow().map_err(|_| busy(call))?;
            artifacts.begin(&simulation, end)?;
        }
        // There may be many single steps.
        if end.is_some() {
            following::tell(call.host, self);
        } else {
            following::tell_now_and_then(call.host, self);
        }
        Ok(())
    }

    /// Stores the row of an accepted substep.
    fn accept(&self, call: &Call, row: LedgerRow, from: f64, until: Option<f64>) -> Result<(), Failure> {
        let data = &self.0;
        let row = data.script_row(row);
        data.scale.set(data.scale.get().max(row.energy_scale()));
        self.tell_contacts(call.host, &row);
        let dimension = data.model.model.dimension();
        call.host.observer.advanced(&Progress { model: &data.name, from, until, row: &row, scale: data.scale.get(), dimension });
        if let Some(artifacts) = data.artifacts.borrow_mut().as_mut() {
            let mut simulation = data.simulation.try_borrow_mut().map_err(|_| busy(call))?;
            artifacts.accepted(&row, &mut simulation)?;
        }
        // Every substep of a halved step is checked, because a contact may be inactive again at the end of the step.
        self.note_closed(row.time, row.contacts.iter().map(|contact| contact.active));
        data.history.borrow_mut().push(row);
        Ok(())
    }
}

/// Rows of the substeps of a nominal step, and its outcome.
type Step = (Vec<LedgerRow>, Result<(), StepError>);

/// Converts an error of a closure that a step called, with the closure's place first.
fn passed_on(callback: &Callback, error: Box<EvalAltResult>) -> Box<EvalAltResult> {
    if error.is_catchable() { Failure::script("in a step that this call took").caused_by(callback.wrap(*error)).into() } else { error }
}
