//! `settle`: static equilibrium in place of a step.

use std::time::Instant;

use rhai::{Engine, EvalAltResult, ImmutableString};

use super::handle::{SimulationHandle, busy, result_used};
use super::recalling::go_on;
use crate::dynamics::{LedgerRow, SettleReport, StepError};
use crate::output::History;
use crate::output::journal::{Computation, Outcome};
use crate::script::api::examples::flight_example;
use crate::script::language::digits::{brief, number_text};
use crate::script::language::prelude::*;

/// Largest number of `settle` calls at one time without any change in between.
const STANDSTILL: u32 = 100;

/// Description of the first argument of `settle`.
const TIME: &str = "an object map of options, or a number";

/// `settle`: equilibrium now or at a later time.
pub fn settle() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "settle")
        .summary(
            "brings the model to static equilibrium, now or as it will be at a later time, without inertia; gives a map with `steps`, \
             `newton_iterations`, `strain`, `active`",
        )
        .parameters(vec![
            Parameter::new("time", Kind::Either(TIME), "the time of the equilibrium: loads, supports and obstacles are as then")
                .of("time")
                .otherwise("now; then the options may come first"),
            Parameter::options("what acts").otherwise("everything acts").keys(vec![friction_parameter()]),
        ])
        .returns("Map")
        .see_also(&["run_to"])
        .example(flight_example("sim.settle();\nsim.settle(0.1);\nsim.settle(#{ friction: false });\nprint(sim.time);"))
        .body(|call, handle| {
            let argument = call.argument("time");
            let friction = friction_of(call)?;
            if !argument.is_given() || argument.value().is_map() || call.host.is_check() {
                return handle.settle(call, None, friction);
            }
            let (end, now) = (argument.number()?, handle.with_row(call, |simulation| simulation.time())?);
            let now = handle.0.script_time(now);
            if end < now {
                let failure = argument.refuse(causes::TIME, format!("`settle` goes forward, but {} has passed", number_text(end)));
                let failure = failure.label(format!("the simulation is at t = {}", brief(now)));
                return Err(failure.hint("keep a state with `sim.save()` and go back to it with `sim.restore(state)`").into());
            }
            handle.settle(call, Some(handle.0.kernel_time(end)), friction)
        })
}

/// Description of the option `friction` of `settle`.
fn friction_parameter() -> Parameter {
    Parameter::flag("friction", "whether friction acts; without it surfaces slide freely").or(true)
}

/// Returns the option `friction`; the options may be given in place of the time.
fn friction_of(call: &Call) -> Result<bool, Failure> {
    let first = call.argument("time");
    let Some(map) = first.value().try_cast::<Map>() else { return call.options("options")?.flag("friction") };
    if call.argument("options").is_given() {
        return Err(call
            .argument("options")
            .refuse(causes::OPTIONS_TOGETHER, "`settle` takes options once")
            .hint("write `sim.settle(time, #{ friction: false })`"));
    }
    if let Some(unknown) = map.keys().find(|key| *key != "friction") {
        let failure = first.refuse(causes::NO_SUCH, format!("`settle` has no option `{unknown}`")).label("unknown option");
        return Err(failure.cause("its option is `friction`").hint("write `sim.settle(#{ friction: false })`"));
    }
    let given = map.get("friction").map(|value| value.as_bool());
    given.unwrap_or(Ok(true)).map_err(|_| {
        let failure = first.refuse(causes::WRONG_TYPE, "`friction` of `settle` must be `true` or `false`");
        failure.hint("write `sim.settle(#{ friction: false })`")
    })
}

/// Adds the row of an equilibrium to a history. A single earlier row is replaced if it is that of the start (no equilibrium), or of an
/// equilibrium at the same time.
pub(super) fn push_equilibrium(rows: &mut History, row: LedgerRow) {
    if rows.len() == 1 && rows.last().is_some_and(|only| only.time == 0.0 || only.time == row.time) {
        rows.clear();
    }
    rows.push(row);
}

impl SimulationHandle {
    /// Computes equilibrium, or takes it from an earlier process.
    fn settled(&self, call: &Call, time: Option<f64>, friction: bool) -> Result<SettleReport, Box<EvalAltResult>> {
        let data = &self.0;
        let state = || data.simulation.try_borrow().map(|simulation| simulation.shared_state()).map_err(|_| busy(call));
        let time = time.map_or_else(|| state().map(|now| now.row.time), Ok)?;
        let computation = Computation::Settle(time, friction);
        if let Some(Outcome::Settled(report)) = self.recalled(call, computation)? {
            return Ok(report);
        }
        let before = state()?;
        let begun = Instant::now();
        let mut simulation = data.simulation.try_borrow_mut().map_err(|_| busy(call))?;
        let tally = simulation.tally();
        let settled = if friction { simulation.settle_at(time) } else { simulation.settle_without_friction(time) };
        data.spent.set(data.spent.get() + begun.elapsed());
        match &settled {
            Ok(report) => self.take_down(computation, Outcome::Settled(report.clone()), &before, simulation.tally()),
            Err(StepError::Interrupted { .. } | StepError::Ranks { .. }) => simulation.count_from(&tally),
            Err(_) => self.take_down(computation, Outcome::Failed, &before, simulation.tally()),
        }
        drop(simulation);
        settled.map_err(|error| self.step_failure(call, error).into())
    }

    /// Refuses repeated equilibria at one time without any change, as in a loop that waits for a later time.
    fn refuse_standstill(&self, call: &Call, before: &LedgerRow, now: &LedgerRow) -> Result<(), Failure> {
        let count = if (before.time, before.strain) == (now.time, now.strain) { self.0.standing.get() + 1 } else { 0 };
        self.0.standing.set(count);
        if count < STANDSTILL {
            return Ok(());
        }
        let failure = call.refuse(causes::TIME, "`settle` does not move time");
        let time = brief(self.0.script_time(now.time));
        let failure = failure.cause(format!("it was called {STANDSTILL} times at t = {time}, and nothing has changed"));
        Err(failure.hint("write `sim.settle(time)` for equilibrium at a later time, or `sim.run_to(time)` for motion"))
    }

    fn settle(&self, call: &Call, time: Option<f64>, friction: bool) -> Result<Dynamic, Box<EvalAltResult>> {
        let data = &self.0;
        self.refuse_wrong_way(call)?;
        data.overlaps.borrow_mut().clear();
        if call.host.is_check() {
            return Ok(Dynamic::from(SettleToCome));
        }
        self.refuse_nested(call)?;
        call.host.go_on()?;
        call.host.observer.began(&format!("settling \"{}\"", data.name));
        let before = data.simulation.borrow().row().clone();
        let settled = self.settled(call, time, friction);
        call.host.observer.ended();
        if settled.is_err() {
            go_on(call.host)?;
        }
        let report = settled?;
        self.refuse_standstill(call, &before, data.simulation.borrow().row())?;
        self.looked()?;
        self.show();
        call.host.count_effect();
        data.past.borrow_mut().clear();
        let row = data.script_row(data.simulation.borrow().row().clone());
        self.tell_settled(call.host, &row, &report);
        self.note_contact();
        data.scale.set(data.scale.get().max(row.energy_scale()));
        let mut rows = data.history.borrow().clone();
        push_equilibrium(&mut rows, row);
        self.replace_history(rows)?;
        if let (Some(artifacts), Ok(mut simulation)) = (data.artifacts.borrow_mut().as_mut(), data.simulation.try_borrow_mut()) {
            artifacts.settled(&mut simulation)?;
        }
        go_on(call.host)?;
        Ok(map_of([
            ("steps", (report.steps as i64).into()),
            ("newton_iterations", (report.newton_iterations as i64).into()),
            ("strain", report.strain.into()),
            ("active", (report.active as i64).into()),
        ]))
    }
}

/// Placeholder value of `settle` in `conserva check`, where results are unknown.
#[derive(Clone)]
struct SettleToCome;

/// Registers access to the result of `settle` in `conserva check`, which ends there.
pub fn register_settle_to_come(engine: &mut Engine) {
    engine.register_type_with_name::<SettleToCome>("Map");
    engine.register_indexer_get(|_: &mut SettleToCome, name: ImmutableString| -> Result<Dynamic, Box<EvalAltResult>> {
        Err(result_used(&name).into())
    });
}
