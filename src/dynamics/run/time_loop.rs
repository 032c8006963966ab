//! Time loop: nominal steps, halving after failures of Newton's method, the ledger of every accepted substep, and `settle`.
//!
//! A step is a transaction: it replaces the state by a new one, or leaves the state unchanged.

use std::sync::Arc;

use super::buckling::{Buckling, BucklingError};
use super::closing::Closing;
use super::engine::Engine;
use super::failed::tried;
use super::fields::{
    BodyFields, BodyTotals, CellPlaces, CellStress, ContactFields, ContactSurface, JointLoad, PlacedObstacle, RedundantConstraints,
};
use super::halvings::Halving;
use super::harmonic::{HarmonicError, HarmonicOptions, HarmonicResponse};
use super::ledger::LedgerRow;
use super::modes::{Modes, ModesError};
use super::options::{Options, SettleReport, Statistics};
use super::pace::StepControl;
use super::paths::{Path, PathError, PathOptions};
use super::report::FailureReport;
use super::run_findings::{Measures, RunFinding, RunFindingKind};
use super::section_force::SectionForce;
use super::stable_step::StableStep;
use super::state::{Clock, State};
use super::steps::Steps;
use super::substeps::Substeps;
use super::tally::Tally;
use super::validity::OutOfValidity;
use crate::bodies::{Elements, Space};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::ContactPair;
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
    fn dimension(&self) -> usize {
        D
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn options_mut(&mut self) -> &mut Options {
        &mut self.options
    }

    fn unknowns(&self) -> usize {
        self.system.supports.fixed.iter().filter(|fixed| !**fixed).count()
    }

    fn state(&self) -> &Arc<State> {
        &self.state
    }

    fn restore(&mut self, state: &State) {
        assert_eq!(
            (state.positions.len(), state.lambda.len()),
            (self.state.positions.len(), self.state.lambda.len()),
            "the state is of the same model"
        );
        self.state = Arc::new(state.clone());
        if self.state.row.probes.len() != self.probes.len() {
            // Watched nodes may differ from those of the restored state.
            Arc::make_mut(&mut self.state).row.probes = self.probe_values(&state.displacements, &state.velocities, &state.accelerations);
        }
        self.system.restore_search(&state.search, &state.positions, state.row.time);
    }

    fn look(&mut self) {
        self.restore_search();
    }

    fn recall(&mut self, row: &LedgerRow) {
        Arc::make_mut(&mut self.state).row.clone_from(row);
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

    fn prescribed_jump(&self) -> Result<Option<(String, f64)>, StepError> {
        let supports = &self.system.supports;
        let (displacement, _) = supports.prescribed_motion(self.state.row.time)?;
        let jumps = supports.prescribed.iter().zip(displacement).map(|(one, then)| (one, then - self.state.displacements[one.unknown]));
        let farthest = jumps.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
        let seen = farthest.filter(|(_, jump)| jump.abs() > tolerances::JUMP * self.system.nodes.extent);
        Ok(seen.map(|(one, jump)| (supports.boundary(one).to_string(), jump)))
    }

    fn check_apart(&self) -> Result<(), StepError> {
        self.check_overlaps(&Closing::of(&self.model))
    }

    fn modes(&mut self, count: usize) -> Result<Modes, ModesError> {
        self.find_modes(count)
    }

    fn harmonic_response(&mut self, options: &HarmonicOptions) -> Result<HarmonicResponse, HarmonicError> {
        self.find_response(options)
    }

    fn buckling(&mut self, count: usize) -> Result<Buckling, BucklingError> {
        self.find_buckling(count)
    }

    fn stable_step(&mut self) -> Result<StableStep, StepError> {
        Engine::stable_step(self)
    }

    fn path(&mut self, options: &PathOptions, told: &mut dyn FnMut(&LedgerRow)) -> Result<Path, PathError> {
        self.find_path(options, told)
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

    fn watch(&mut self, node: usize) {
        self.probes.push(node);
        let probes = self.probe_values(&self.state.displacements, &self.state.velocities, &self.state.accelerations);
        Arc::make_mut(&mut self.state).row.probes = probes;
    }

    fn watched(&self) -> &[usize] {
        &self.probes
    }

    fn fields(&self) -> Vec<BodyFields> {
        self.fields_at(&self.state.displacements)
    }

    fn failure(&self) -> Option<&FailureReport> {
        self.failure.as_ref().map(|(report, _)| report)
    }

    fn failed_fields(&self) -> Option<Vec<BodyFields>> {
        self.failure.as_ref().map(|(_, u)| self.fields_at(u))
    }

    fn cell_stresses(&self, body: usize, places: CellPlaces) -> Vec<CellStress> {
        self.cell_stresses(body, places)
    }

    fn section_force(&self, body: usize, point: [f64; 3], normal: [f64; 3]) -> Option<SectionForce> {
        self.section_force_of(body, point, normal)
    }

    fn body(&self, body: usize) -> BodyTotals {
        self.body_totals(body)
    }

    fn excesses(&self) -> Vec<OutOfValidity> {
        self.excessive_cells()
    }

    fn redundant_constraints(&self) -> Vec<RedundantConstraints> {
        self.redundant_constraints()
    }

    fn stress_errors(&self) -> Vec<(&str, f64)> {
        self.system.bodies.iter().enumerate().map(|(index, body)| (body.name.as_str(), self.estimated_error(index))).collect()
    }

    fn loose_joints(&self) -> Vec<(String, f64)> {
        Engine::loose_joints(self)
    }

    fn joint(&self, name: &str) -> Option<JointLoad> {
        self.joint_load(name)
    }

    fn obstacles(&self) -> Vec<PlacedObstacle> {
        self.placed_obstacles()
    }

    fn contact(&self, name: &str) -> Option<ContactFields> {
        self.contact_fields(name)
    }

    fn contact_surfaces(&self) -> Vec<ContactSurface> {
        Engine::contact_surfaces(self)
    }

    fn closed_nodes(&self) -> Vec<usize> {
        self.system.closed_nodes(&self.state.active)
    }

    fn friction_multipliers(&self) -> Vec<[f64; 2]> {
        let lambda = &self.state.lambda;
        let rows: Vec<(usize, usize)> = self.system.pairs.iter().flat_map(ContactPair::tangential).collect();
        let of = |group: &[(usize, usize)]| match *group {
            [(row, normal_row)] => [lambda[normal_row], lambda[row]],
            _ => [lambda[group[0].1], group.iter().map(|&(row, _)| lambda[row]).fold(0.0, f64::hypot)],
        };
        rows.chunk_by(|a, b| a.1 == b.1).map(of).collect()
    }

    fn rank_bytes(&self) -> &[u64] {
        self.system.rank_bytes()
    }

    fn halvings(&self) -> &[Halving] {
        self.halvings.all()
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

    fn findings_at_start(&self) -> Vec<RunFinding> {
        let (dt, row) = (self.options.dt, &self.state.row);
        let motions = self.system.sliding_by_velocity(&self.state.positions, &self.state.velocities, dt);
        motions.iter().map(|motion| RunFinding::of_motion(RunFindingKind::Motion, motion, dt, row.step, row.time)).collect()
    }

    fn statistics(&self) -> Statistics {
        let counters = &self.system.counters;
        let calls = counters.calls_before_resume.plus(self.system.work().solver_calls(), counters.calls_at_resume);
        Statistics {
            factorizations: counters.factorizations,
            discarded: counters.discarded,
            linear: self.system.work(),
            solver_calls: calls,
            taken_over: self.system.taken_over(),
            assemblies: counters.assemblies,
            cells: self.system.bodies.iter().map(|body| body.elements.cliques().len()).sum(),
            factor_bytes: self.system.factor_bytes(),
            times: counters.times,
            ..self.statistics
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
            match self.piece(size, may_be_halved).and_then(|state| self.judged(state, size, &substeps, before)) {
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
