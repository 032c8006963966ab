//! The time loop: nominal steps, halving where Newton's method fails, the ledger of every accepted piece, and `settle`.
//!
//! A step is a transaction: it takes the state and puts a new one in its place, or leaves it alone.

use std::sync::Arc;

use super::error::{ModelError, StepError};
use super::failed::tried;
use super::fields::{BodyFields, ContactFields};
use super::halvings::{Halving, Halvings};
use super::ledger::LedgerRow;
use super::model::Model;
use super::newton::{self, Failure, Solution, Strategy, Task, Trace};
use super::pairs::PairKind;
use super::predictor::{self, rigid_motion};
use super::report::{FailureReport, TryReport};
use super::run_findings::{Measures, RunFinding, RunFindingKind};
use super::simulation::{Clock, Options, SettleReport, State, Statistics, Steps};
use super::system::{AssemblyError, StepStart, System};
use crate::bodies::{Elements, Space};
use crate::contact::{Correction, Outlook, Travel};
use crate::integrators::Integrator;
use crate::linear::Watch;
use crate::math::tolerances;

/// How much more motion than was expected a step may have: impacts add elastic motion to the prediction. Where something was overlooked, as
/// much is expected in a second try.
const MORE_MOTION: f64 = 3.0;

/// A simulation in `D` dimensions.
pub(super) struct TimeLoop<const D: usize> {
    pub(super) model: Model,
    pub(super) system: System<D>,
    pub(super) options: Options,
    /// Shared with whoever keeps it: a step makes a new one.
    pub(super) state: Arc<State>,
    pub(super) statistics: Statistics,
    /// Nodes whose motion every row of the ledger tells.
    pub(super) probes: Vec<usize>,
    /// The course of the last step's Newton method.
    pub(super) trace: Trace,
    /// What the tries of the current step came to.
    pub(super) tries: Vec<TryReport>,
    /// The last step that failed for good, and the iterate at which it was given up.
    pub(super) failure: Option<(FailureReport, Vec<f64>)>,
    /// Why steps were halved.
    halvings: Halvings,
}

impl<const D: usize> TimeLoop<D>
where
    Space<D>: Elements<D>,
{
    pub(super) fn new(model: &Model, options: Options) -> Result<Self, ModelError> {
        let mut system = System::<D>::new(model, options.threads)?;
        system.watch(Watch { interrupt: options.interrupt.clone(), progress: options.progress.clone() });
        let velocities = initial_velocities(&system, model);
        // A time function that fails does so again, with its error, in the first step.
        let _ = system.move_obstacles(0.0, 0.0);
        if D == 2 {
            let reference = system.reference.clone();
            system.survey(&reference);
        }
        let mut row = LedgerRow::default();
        let positions = system.reference.clone();
        row.kinetic = system.kinetic_energy(&velocities);
        row.potential = system.potential_energy(&positions);
        (row.momentum, row.angular_momentum) = system.momenta(&positions, &velocities);
        let state = State {
            row,
            lambda: vec![0.0; system.multipliers],
            felt: vec![0.0; system.multipliers],
            reserve: vec![0.0; system.multipliers],
            active: vec![false; system.multipliers],
            half_force: Arc::new(vec![0.0; positions.len()]),
            clock: Clock { origin: 0.0, count: 0, dt: options.dt },
            search: system.search(),
            level: 0,
            loads_ended: 0.0,
            positions,
            velocities,
        };
        Ok(TimeLoop {
            model: model.clone(),
            system,
            options,
            state: Arc::new(state),
            statistics: Statistics::default(),
            probes: Vec::new(),
            trace: Trace::default(),
            tries: Vec::new(),
            failure: None,
            halvings: Halvings::default(),
        })
    }

    /// One piece of a step from the current state: the new state, or why there is none.
    ///
    /// A step that `may_be_halved` is not tried when its predicted motion is too large.
    fn piece(&mut self, dt: f64, may_be_halved: bool) -> Result<State, Failure> {
        match self.piece_within(dt, 1.0, may_be_halved) {
            Err(Failure::Overlooked { .. }) => self.piece_within(dt, MORE_MOTION, may_be_halved),
            outcome => outcome,
        }
    }

    /// [`Self::piece`] with a multiple of the expected motion.
    fn piece_within(&mut self, dt: f64, factor: f64, may_be_halved: bool) -> Result<State, Failure> {
        let (state, reach) = (self.state.clone(), self.options.reach);
        let (integrator, time) = (self.options.integrator, state.row.time);
        let (displacement, prescribed_v_1) = self.system.prescribed_motion(time + dt).map_err(Failure::Fatal)?;
        let mut predicted = rigid_motion(&self.system, &state.positions, &state.velocities, dt);
        predictor::follow_prescribed(&self.system, &state.positions, &displacement, &mut predicted);
        // What takes part: nodes may move by the prediction or by their velocities.
        let rigid: Vec<f64> = predicted.iter().zip(&state.positions).map(|(new, old)| new - old).collect();
        let elastic: Vec<f64> = state.velocities.iter().map(|v| dt * v).collect();
        let outlook = Outlook { q: &state.positions, travel: Travel::Guessed { displacements: [&rigid, &elastic], factor }, reach };
        self.system.move_obstacles(time, dt).map_err(Failure::Fatal)?;
        self.system.begin_step(&outlook).map_err(Failure::Linear)?;

        let start = StepStart {
            integrator,
            time,
            dt,
            q_0: &state.positions,
            v_0: &state.velocities,
            half_force: &state.half_force,
            prescribed_v_1: &prescribed_v_1,
            damping: None,
        };
        let conditions = self.system.conditions(&start, &state.felt);
        if let Some(motion) = self.system.foreseen(&state.positions, &predicted, &conditions, &state.active) {
            if may_be_halved {
                return Err(Failure::Foreseen(motion));
            }
            self.halvings.refuse(motion, dt, &state.row);
        }
        let energy = self.energy_scale(&start, &predicted);
        let options = &self.options;
        let task = Task {
            start: &start,
            predicted: &predicted,
            lambda: &state.lambda,
            conditions: &conditions,
            energy,
            tolerance: options.tolerance,
            at_least: 0,
            interrupted: &|| options.interrupted(),
        };
        let solution = solve(&mut self.system, &task, &mut self.statistics.newton_iterations, &mut self.trace)?;
        self.check_search(&outlook, MORE_MOTION, &solution)?;
        if may_be_halved && let Some(motion) = self.system.came_through(&conditions) {
            return Err(Failure::Foreseen(motion));
        }
        let jump = self.velocity_jump(&start, &solution, &conditions)?;
        Ok(self.accept(&start, solution, &conditions, jump))
    }

    /// Energy that defects are measured by: that of the state, the predicted kinetic energy, and the work of loads over the prediction.
    fn energy_scale(&self, start: &StepStart, predicted: &[f64]) -> f64 {
        let row = &self.state.row;
        let floor = tolerances::FORCE_FLOOR * self.system.modulus * self.system.extent.powi(D as i32);
        let mut load = vec![0.0; predicted.len()];
        let work = match self.system.loads_into(predicted, start.time + 0.5 * start.dt, &mut load) {
            // Kinetic energy that the loads give to nodes at rest within the step.
            Ok(_) => (0..load.len())
                .map(|k| (load[k] + self.system.weight[k], self.system.nodal_mass[k / D]))
                .filter(|(force, _)| *force != 0.0)
                .map(|(force, mass)| force.powi(2) * start.dt * start.dt / mass)
                .sum::<f64>(),
            Err(_) => 0.0,
        };
        (row.kinetic + row.strain.abs()).max(work).max(floor * tolerances::FORCE_FLOOR)
    }

    /// Bodies must not have moved farther than a multiple of the distance within which pairs may take part, nor into something that took no
    /// part. How far the search has looked does not matter.
    pub(super) fn check_search(&self, outlook: &Outlook, multiple: f64, solution: &Solution) -> Result<(), Failure> {
        for pair in self.system.pairs.iter().filter(|pair| pair.kind == PairKind::Surfaces) {
            let moved = |nodes: &[u32]| {
                nodes.iter().fold(0.0f64, |largest, &node| {
                    let range = node as usize * D..(node as usize + 1) * D;
                    largest.max(range.map(|k| (solution.q_1[k] - self.state.positions[k]).powi(2)).sum::<f64>().sqrt())
                })
            };
            if moved(pair.kernel.secondary().nodes()) + moved(pair.kernel.primary().nodes()) > multiple * pair.kernel.margin(outlook) {
                return Err(Failure::BeyondSearch { pair: pair.name.clone() });
            }
            if pair.kernel.overlooks(outlook.q, &solution.q_1, tolerances::OVERLOOKED * pair.kernel.facet_size()) {
                return Err(Failure::Overlooked { pair: pair.name.clone() });
            }
        }
        Ok(())
    }

    /// Half of the static forces at the current state: where the trapezoidal rule starts from.
    fn start_trapezoidal(&mut self) -> Result<(), StepError> {
        let state = self.state.clone();
        let (zero, undamped) = (vec![0.0; state.positions.len()], vec![0.0; self.system.bodies.len()]);
        let start = StepStart {
            integrator: Integrator::Trapezoidal,
            time: state.row.time,
            dt: 0.0,
            q_0: &state.positions,
            v_0: &zero,
            half_force: &zero,
            prescribed_v_1: &[],
            damping: Some(&undamped),
        };
        self.system.move_obstacles(state.row.time, 0.0)?;
        if let Err(error) = self.system.begin_step(&Outlook::within(&state.positions, 0.0)) {
            return Err(self.failed(&Failure::Linear(error), 0.0, 0));
        }
        match self.system.assemble(&start, &state.positions, &state.lambda) {
            Ok(forces) => {
                let half = forces.without_contact.iter().zip(&forces.contact).map(|(r, c)| r - c).collect();
                Arc::make_mut(&mut self.state).half_force = Arc::new(half);
                Ok(())
            }
            Err(AssemblyError::Load(error)) => Err(error),
            Err(error) => Err(self.failed(&error.into(), 0.0, 0)),
        }
    }
}

/// Newton's method with its second try.
pub(super) fn solve<const D: usize>(
    system: &mut System<D>,
    task: &Task,
    iterations: &mut usize,
    trace: &mut Trace,
) -> Result<Solution, Failure>
where
    Space<D>: Elements<D>,
{
    let before = system.factorizations;
    trace.earlier.clear();
    let attempt = |system: &mut System<D>, strategy: Strategy, trace: &mut Trace| {
        newton::solve(system, task, strategy, trace).map_err(|failure| failure.or_interrupt(task.start.time))
    };
    let mut outcome = attempt(system, Strategy::InnerLoop, trace);
    // A cell that turns inside out on the way of the first strategy does so on that of the others, too.
    let is_hopeless = matches!(outcome, Err(Failure::Inverted { .. }));
    let retries = [
        (Strategy::InnerLoop, Correction::SteadyEnds),
        (Strategy::InnerLoop, Correction::PerNode),
        (Strategy::Backtracking, Correction::PerPatch),
        (Strategy::Backtracking, Correction::PerNode),
    ];
    for (strategy, correction) in retries {
        if system.multipliers == 0 || is_hopeless || matches!(outcome, Ok(_) | Err(Failure::Fatal(_))) {
            break;
        }
        trace.earlier.push(std::mem::take(&mut trace.iterations));
        system.set_correction(correction);
        outcome = attempt(system, strategy, trace);
        system.set_correction(Correction::default());
    }
    *iterations += outcome.as_ref().map_or(system.factorizations - before, |solution| solution.iterations);
    outcome
}

fn initial_velocities<const D: usize>(system: &System<D>, model: &Model) -> Vec<f64>
where
    Space<D>: Elements<D>,
{
    let mut velocities = vec![0.0; system.reference.len()];
    for initial in &model.initial_velocities {
        let nodes = system.bodies[initial.body].nodes.clone();
        let mut center = nalgebra::Vector3::zeros();
        let mut mass = 0.0;
        let position = |node: usize| {
            let mut x = nalgebra::Vector3::zeros();
            x.as_mut_slice()[..D].copy_from_slice(&system.reference[node * D..(node + 1) * D]);
            x
        };
        for node in nodes.clone() {
            mass += system.nodal_mass[node];
            center += position(node) * system.nodal_mass[node];
        }
        center /= mass;
        let (linear, angular) = (nalgebra::Vector3::from(initial.linear), nalgebra::Vector3::from(initial.angular));
        for node in nodes {
            let velocity = linear + angular.cross(&(position(node) - center));
            velocities[node * D..(node + 1) * D].copy_from_slice(&velocity.as_slice()[..D]);
        }
    }
    for (velocity, _) in velocities.iter_mut().zip(&system.fixed).filter(|(_, fixed)| **fixed) {
        *velocity = 0.0;
    }
    // A time function that fails does so again, with its error, in the first step.
    if let Ok((_, rates)) = system.prescribed_motion(0.0) {
        for (prescribed, rate) in system.prescribed.iter().zip(rates) {
            velocities[prescribed.unknown] = rate;
        }
    }
    velocities
}

impl<const D: usize> Steps for TimeLoop<D>
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
        self.system.fixed.iter().filter(|fixed| !**fixed).count()
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
            // A node that was not watched then.
            Arc::make_mut(&mut self.state).row.probes = self.probe_values(&state.positions, &state.velocities);
        }
        self.system.restore_search(&state.search, &state.positions, state.row.time);
    }

    fn step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError> {
        let outcome = self.nominal_step(end, accepted);
        if outcome.is_err() {
            // Nothing of the pieces that failed stays: the state alone decides how it goes on.
            self.system.restore_search(&self.state.search, &self.state.positions, self.state.row.time);
        }
        outcome.map_err(|error| self.options.or_interrupted(error, self.state.row.time))
    }

    fn settle(&mut self, time: f64) -> Result<SettleReport, StepError> {
        let before = self.state.clone();
        let mut outcome = self.settle_at(time);
        if self.options.integrator == Integrator::Trapezoidal && self.state.row.step > 0 {
            // The forces that the rule carries from step to step are those of the new equilibrium.
            outcome = outcome.and_then(|report| self.start_trapezoidal().map(|()| report));
        }
        if outcome.is_err() {
            self.system.restore_search(&before.search, &before.positions, before.row.time);
            self.state = before;
        }
        outcome.map_err(|error| self.options.or_interrupted(error, self.state.row.time))
    }

    fn watch(&mut self, node: usize) {
        self.probes.push(node);
        let probes = self.probe_values(&self.state.positions, &self.state.velocities);
        Arc::make_mut(&mut self.state).row.probes = probes;
    }

    fn watched(&self) -> &[usize] {
        &self.probes
    }

    fn fields(&self) -> Vec<BodyFields> {
        self.fields_at(&self.state.positions)
    }

    fn failure(&self) -> Option<&FailureReport> {
        self.failure.as_ref().map(|(report, _)| report)
    }

    fn failed_fields(&self) -> Option<Vec<BodyFields>> {
        self.failure.as_ref().map(|(_, q)| self.fields_at(q))
    }

    fn contact(&self, name: &str) -> Option<ContactFields> {
        self.contact_fields(name)
    }

    fn closed_nodes(&self) -> Vec<usize> {
        self.system.closed_nodes(&self.state.active)
    }

    fn halvings(&self) -> &[Halving] {
        self.halvings.all()
    }

    fn measures(&self) -> Measures<'_> {
        let system = &self.system;
        let conserves = self.options.integrator == Integrator::EnergyMomentum;
        Measures {
            contacts: system.contacts().map(|(_, pair)| (pair.name.as_str(), pair.kernel.facet_size())).collect(),
            stiffness: system.modulus * system.extent.powi(D as i32),
            defect: conserves.then_some(tolerances::DEFECT * self.options.tolerance),
            halvings: self.halvings.all(),
            refused: self.halvings.refused(),
        }
    }

    fn findings_at_start(&self) -> Vec<RunFinding> {
        let (dt, row) = (self.options.dt, &self.state.row);
        let motions = self.system.sliding_by_velocity(&self.state.positions, &self.state.velocities, dt);
        motions.iter().map(|motion| RunFinding::of_motion(RunFindingKind::Motion, motion, dt, row.step, row.time)).collect()
    }

    fn statistics(&self) -> Statistics {
        Statistics {
            factorizations: self.system.factorizations,
            linear: self.system.work(),
            assemblies: self.system.assemblies,
            cells: self.system.bodies.iter().map(|body| body.elements.cliques().len()).sum(),
            factor_bytes: self.system.factor_bytes(),
            times: self.system.times,
            ..self.statistics
        }
    }
}

impl<const D: usize> TimeLoop<D>
where
    Space<D>: Elements<D>,
{
    /// A nominal step, in pieces where it must be halved.
    fn nominal_step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError> {
        if self.options.integrator == Integrator::Trapezoidal && self.state.row.step == 0 {
            self.start_trapezoidal()?;
        }
        let from = self.state.row.time;
        let Clock { origin, count, dt } = self.state.clock;
        // Steps of another size are counted from here.
        let (origin, count) = if dt == self.options.dt { (origin, count) } else { (from, 0) };
        let nominal_end = origin + self.options.dt * (count + 1) as f64;
        // A last step that is within round-off of the nominal one is the nominal one.
        let (target, whole) = match end {
            Some(end) if end < nominal_end - 1e-9 * self.options.dt => (end, false),
            Some(end) if end < nominal_end + 1e-9 * self.options.dt => (end, true),
            _ => (nominal_end, true),
        };
        let dt = if whole { self.options.dt } else { target - from };
        // The piece in units of dt / 2^level: done, and all.
        let mut level = self.state.level;
        let (mut done, mut halvings) = (0usize, 0);
        let mut all = 1usize << level;
        self.tries.clear();
        while done < all {
            if self.options.interrupted() {
                return Err(StepError::Interrupted { time: self.state.row.time });
            }
            match self.piece(dt / all as f64, level < self.options.max_halvings) {
                Ok(mut state) => {
                    done += 1;
                    state.row.time = if done == all { target } else { from + dt * (done as f64 / all as f64) };
                    state.row.halvings = std::mem::take(&mut halvings);
                    if done == all {
                        state.level = level.saturating_sub(1);
                        let (origin, count) = if whole { (origin, count + 1) } else { (target, 0) };
                        state.clock = Clock { origin, count, dt: self.options.dt };
                    } else {
                        state.level = level;
                        state.clock = Clock { origin: state.row.time, count: 0, dt: self.options.dt };
                    }
                    self.statistics.steps += 1;
                    self.state = Arc::new(state);
                    accepted(&self.state.row);
                }
                Err(Failure::Fatal(error)) => return Err(error),
                Err(failure) => {
                    // What is halved beforehand was no try.
                    if !matches!(failure, Failure::Foreseen(_)) {
                        self.tries.push(tried(&failure, dt / all as f64, &self.trace));
                        if level >= self.options.max_halvings {
                            return Err(self.failed(&failure, dt / all as f64, level));
                        }
                        halvings += 1;
                        self.statistics.halvings += 1;
                    }
                    self.halvings.count(&failure, dt / all as f64, &self.state.row);
                    level += 1;
                    (done, all) = (2 * done, 2 * all);
                }
            }
        }
        Ok(())
    }
}
