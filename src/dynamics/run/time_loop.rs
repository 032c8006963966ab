//! Time loop: nominal steps, halving after failures of Newton's method, the ledger of every accepted substep, and `settle`.
//!
//! A step is a transaction: it replaces the state by a new one, or leaves the state unchanged.

use std::sync::Arc;

use super::engine::Engine;
use super::failed::tried;
use super::ledger::LedgerRow;
use super::options::{Options, SettleReport, Statistics};
use super::pace::StepControl;
use super::present_state::PresentState;
use super::run_findings::Measures;
use super::state::{Clock, State};
use super::steps::Steps;
use super::substeps::Substeps;
use super::tally::Tally;
use super::validity::OutOfValidity;
use crate::bodies::{Elements, Space};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::step::failure::Failure;
use crate::math::tolerances;

/// Largest number of kinks within a step at which the step is divided.
const MOST_CORNERS: usize = 2;

/// Length of a remaining interval, relative to the step, that adaptive steps merge with the step before: a step 1e-13 times as long as its
/// predecessors has no solvable matrix.
const SLIVER: f64 = 1000.0 * tolerances::SAME_MOMENT;

/// Relative distance of two times below which they are equal.
const SAME_TIME: f64 = 4.0 * f64::EPSILON;

impl<const D: usize> Steps for Engine<D>
where
    Space<D>: Elements<D>,
{
    fn options_mut(&mut self) -> &mut Options {
        &mut self.options
    }

    fn state(&self) -> &Arc<State> {
        &self.state
    }

    fn tally(&self) -> Tally {
        let Statistics { steps, newton_iterations, halvings, factorizations, discarded, assemblies, solver_calls, .. } = self.statistics();
        let causes = self.halvings.clone();
        Tally { steps, newton_iterations, halvings, factorizations, discarded, assemblies, solver_calls, causes, passed: None }
    }

    fn count_from(&mut self, tally: &Tally) {
        let Tally { steps, newton_iterations, halvings, factorizations, discarded, assemblies, solver_calls, causes, .. } = tally;
        let counted = Statistics { steps: *steps, newton_iterations: *newton_iterations, halvings: *halvings, ..self.statistics };
        (self.statistics, self.halvings) = (counted, causes.clone());
        let own_calls = self.system.work().solver_calls();
        let counters = &mut self.system.counters;
        (counters.calls_before_resume, counters.calls_at_resume) = (*solver_calls, own_calls);
        (counters.factorizations, counters.discarded, counters.assemblies) = (*factorizations, *discarded, *assemblies);
    }

    fn step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError> {
        let outcome = self.nominal_step(end, accepted).and_then(|()| self.options.undisturbed(self.state.row.time));
        if outcome.is_err() {
            // Failed substeps leave no trace: the state alone determines the continuation.
            self.restore_search();
        }
        outcome.map_err(|error| self.options.or_interrupted(error, self.state.row.time))
    }

    fn settle(&mut self, time: f64, friction: bool) -> Result<SettleReport, StepError> {
        let before = self.state.clone();
        self.rest_friction = friction;
        if !friction {
            // Friction forces of the previous state are removed.
            let (normal_count, State { lambda, active, .. }) = (self.system.normal_count, Arc::make_mut(&mut self.state));
            lambda[normal_count..].fill(0.0);
            active[normal_count..].fill(RowState::Open);
        }
        let mut outcome = self.settle_at(time).and_then(|report| self.options.undisturbed(time).map(|()| report));
        self.rest_friction = true;
        if self.options.control.is_some() {
            Arc::make_mut(&mut self.state).pace.restart();
        }
        if self.state.row.step > 0 {
            // History variables of the integrator are computed for the new equilibrium.
            outcome = outcome.and_then(|report| self.remember().map(|()| report));
        }
        if outcome.is_err() {
            self.state = before;
            self.restore_search();
        }
        // After a failure the state before the call is restored, not an intermediate equilibrium.
        let time = self.state.row.time;
        outcome.map_err(|error| self.options.or_interrupted(error, time))
    }

    fn excesses(&self) -> Vec<OutOfValidity> {
        self.excessive_cells()
    }

    fn stress_errors(&self) -> Vec<(&str, f64)> {
        self.system.bodies.iter().enumerate().map(|(index, body)| (body.name.as_str(), self.estimated_error(index))).collect()
    }

    fn measures(&self) -> Measures<'_> {
        let system = &self.system;
        let conserves = self.options.integrator.promises.energy;
        Measures {
            contacts: system.contacts().map(|(_, pair)| (pair.name.as_str(), pair.kernel.facet_size())).collect(),
            stiffness: system.nodes.stiffness() * system.nodes.extent.powi(2),
            round_off: self.state.row.work_round_off,
            integrator: self.options.integrator.name,
            is_explicit: self.options.integrator.lumping().is_some(),
            is_static: self.options.integrator.is_static(),
            defect: conserves.then_some(tolerances::DEFECT * self.options.tolerance),
            halvings: self.halvings.all(),
            chooses_steps: self.options.control.is_some(),
            refused: self.halvings.refused(),
            factorizations: system.counters.factorizations,
            discarded: system.counters.discarded,
        }
    }
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Newton iterations and factorisations so far.
    fn work(&self) -> [usize; 2] {
        [self.statistics.newton_iterations, self.system.counters.factorizations]
    }

    /// Takes a nominal step: from kink to kink of loads and prescribed motions, in substeps where it must be halved.
    fn nominal_step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError> {
        let state = &self.state;
        let is_new = state.row.step == 0 || !state.scheme_history.is_of(&self.options.integrator);
        if is_new || state.clock.dt != self.options.dt {
            self.check_stable()?;
        }
        if is_new {
            self.remember()?;
        }
        if let Some(control) = self.options.control {
            return self.paced_step(&control, end, accepted);
        }
        let from = self.state.row.time;
        let Clock { origin, count, dt } = self.state.clock;
        // Nominal steps are counted anew if the step size changes.
        let (origin, count) = if dt == self.options.dt { (origin, count) } else { (from, 0) };
        let nominal_end = origin + self.options.dt * (count + 1) as f64;
        // An end within round-off of the nominal end counts as a nominal step.
        let (target, whole) = match end {
            Some(end) if end < nominal_end - tolerances::SAME_MOMENT * self.options.dt => (end, false),
            Some(end) if end < nominal_end + tolerances::SAME_MOMENT * self.options.dt => (end, true),
            // A remainder shorter than half a step is distributed evenly over the last two steps.
            Some(end) if end < nominal_end + (0.5 - tolerances::SAME_MOMENT) * self.options.dt => (from + 0.5 * (end - from), false),
            _ => (nominal_end, true),
        };
        let clock = if whole { (origin, count + 1) } else { (target, 0) };
        // Functions with more kinks than `MOST_CORNERS` per step are not divided at their kinks.
        let near = tolerances::SAME_MOMENT * self.options.dt;
        let corners = self.corners.iter().copied().skip_while(|corner| *corner <= from + near);
        let corners: Vec<f64> = corners.take_while(|corner| *corner < target - near).take(MOST_CORNERS + 1).collect();
        self.tries.clear();
        let mut at = from;
        for corner in if corners.len() > MOST_CORNERS { Vec::new() } else { corners } {
            self.stretch(corner, Substeps::new(at, corner - at, self.state.level), (corner, 0), accepted)?;
            at = corner;
        }
        let dt = if whole && at == from { self.options.dt } else { target - at };
        self.stretch(target, Substeps::new(self.state.row.time, dt, self.state.level), clock, accepted)
    }

    /// Takes a step of the chosen size, or up to the next event: the end, or a kink of loads and prescribed motions.
    fn paced_step(&mut self, control: &StepControl, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError> {
        let from = self.state.row.time;
        let size = self.state.pace.size(control, self.options.dt);
        // A shorter remainder, at a kink next to the end or by round-off of many steps, is no step.
        let near = (SLIVER * size).max(SAME_TIME * from.abs());
        let is_ahead = |corner: &f64| *corner > from + near && end.is_none_or(|end| *corner < end - near);
        let corner = self.corners.iter().copied().find(is_ahead);
        let landing = end.into_iter().chain(corner).fold(f64::INFINITY, f64::min);
        let target = match landing - from {
            rest if rest < size + near => landing,
            // A remainder shorter than half a step is distributed evenly over the last two steps. Remainders of half a step are frequent,
            // with round-off of either sign.
            rest if rest < 1.5 * size - near => from + 0.5 * rest,
            _ => from + size,
        };
        self.tries.clear();
        self.stretch(target, Substeps::one(from, target - from), (target, 0), accepted)
    }

    /// Advances to a time, in substeps if halving is required; `clock`: start and number of the steps counted so far.
    fn stretch(
        &mut self,
        target: f64,
        mut substeps: Substeps,
        clock: (f64, usize),
        accepted: &mut dyn FnMut(&LedgerRow),
    ) -> Result<(), StepError> {
        let (mut halvings, mut booked) = (0, self.work());
        while !substeps.are_done() {
            if self.options.interrupted() {
                return Err(StepError::Interrupted { time: self.state.row.time });
            }
            let (size, may_be_halved) = (substeps.size(), substeps.level() < self.options.max_halvings);
            let before = self.system.counters;
            match self.piece(size, substeps.level()).and_then(|state| self.judged(state, size, &substeps, before)) {
                Ok(mut state) => {
                    let between = substeps.accepted();
                    state.row.time = between.unwrap_or(target);
                    state.slips_until = state.row.time;
                    state.row.halvings = std::mem::take(&mut halvings);
                    let [iterations, factorizations] = std::mem::replace(&mut booked, self.work());
                    state.row.newton_iterations = booked[0] - iterations;
                    state.row.factorizations = booked[1] - factorizations;
                    state.level = substeps.next_level();
                    let (origin, count) = between.map_or(clock, |time| (time, 0));
                    state.clock = Clock { origin, count, dt: self.options.dt };
                    self.statistics.steps += 1;
                    self.state = Arc::new(state);
                    accepted(&self.state.row);
                }
                Err(Failure::Fatal(error)) => return Err(error),
                Err(failure @ Failure::Inexact { size: shorter }) => {
                    self.halvings.count(&failure, size, &self.state.row);
                    substeps.shorten(shorter);
                }
                Err(failure) => {
                    // Steps that are halved by prediction, before any solution, are not listed as attempts.
                    if !matches!(failure, Failure::Foreseen(_)) {
                        self.tries.push(tried(&failure, size, &self.trace));
                        if !may_be_halved {
                            return Err(self.failed(&failure, size, substeps.level()));
                        }
                        halvings += 1;
                        self.statistics.halvings += 1;
                    }
                    self.halvings.count(&failure, size, &self.state.row);
                    substeps.halve();
                }
            }
        }
        Ok(())
    }
}
