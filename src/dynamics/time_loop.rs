//! The time loop: nominal steps, halving where Newton's method fails, the ledger of every accepted piece, and `settle`.
//!
//! A step is a transaction: it takes the state and puts a new one in its place, or leaves it alone.

use super::error::{ModelError, StepError};
use super::fields::{BodyFields, ContactFields};
use super::ledger::LedgerRow;
use super::model::{Model, UpdateRule};
use super::newton::{self, Failure, Solution, Strategy, Task, Trace};
use super::predictor::{self, rigid_motion};
use super::report::{FailureCause, FailureReport, IterationReport};
use super::simulation::{Clock, Options, SettleReport, State, Statistics, Steps};
use super::system::{AssemblyError, Conditions, Forces, PairKind, StepStart, System, moment, resultant};
use crate::bodies::{Elements, Space};
use crate::integrators::Integrator;
use crate::math::tolerances;

/// Damped steps that `settle` takes at most.
const MAX_SETTLE_STEPS: usize = 60;
/// Damping of `settle` over the stiffness of the slowest elastic motion: small, so that few steps suffice, not zero, so that rigid motions
/// stay regular.
const SETTLE_DAMPING: f64 = 1e-5;
/// Reach of a second search when a step converged with more motion than was expected: impacts add elastic motion to the prediction.
const WIDER_SEARCH: f64 = 3.0;

/// A jump of the velocities at the end of a step.
struct Jump {
    velocity: Vec<f64>,
    /// Impulse of supports and obstacles.
    impulse: Vec<f64>,
    /// Kinetic energy that it gives back.
    energy: f64,
    /// Kinetic energy that moving obstacles add by their push: as seen from the obstacle, only the lost energy returns.
    work: f64,
}

/// A simulation in `D` dimensions.
pub(super) struct TimeLoop<const D: usize> {
    model: Model,
    system: System<D>,
    options: Options,
    state: State,
    statistics: Statistics,
    /// The course of the last step's Newton method.
    trace: Trace,
    /// The last step that failed for good, and the iterate at which it was given up.
    failure: Option<(FailureReport, Vec<f64>)>,
}

impl<const D: usize> TimeLoop<D>
where
    Space<D>: Elements<D>,
{
    pub(super) fn new(model: &Model, options: Options) -> Result<Self, ModelError> {
        let mut system = System::<D>::new(model, options.threads)?;
        let velocities = initial_velocities(&system, model);
        let mut row = LedgerRow::default();
        let positions = system.reference.clone();
        row.kinetic = system.kinetic_energy(&velocities);
        row.potential = system.potential_energy(&positions);
        (row.momentum, row.angular_momentum) = system.momenta(&positions, &velocities);
        let state = State {
            row,
            lambda: vec![0.0; system.multipliers],
            active: vec![false; system.multipliers],
            half_force: vec![0.0; positions.len()],
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
            state,
            statistics: Statistics::default(),
            trace: Trace::default(),
            failure: None,
        })
    }

    /// One piece of a step from the current state: the new state, or why there is none.
    fn piece(&mut self, dt: f64) -> Result<State, Failure> {
        match self.piece_within(dt, 1.0) {
            Err(Failure::BeyondSearch { .. }) => self.piece_within(dt, WIDER_SEARCH),
            outcome => outcome,
        }
    }

    /// [`Self::piece`] with a multiple of the usual reach of the search for contact.
    fn piece_within(&mut self, dt: f64, reach: f64) -> Result<State, Failure> {
        let state = self.state.clone();
        let (integrator, time) = (self.options.integrator, state.row.time);
        let (displacement, prescribed_v_1) = self.system.prescribed_motion(time + dt).map_err(Failure::Fatal)?;
        let mut predicted = rigid_motion(&self.system, &state.positions, &state.velocities, dt);
        predictor::follow_prescribed(&self.system, &state.positions, &displacement, &mut predicted);
        // Reach of the search: a facet, and what both sides move in this step by the prediction or by their velocities.
        let travel = |nodes: &[u32]| {
            nodes.iter().fold(0.0f64, |largest, &node| {
                let range = node as usize * D..(node as usize + 1) * D;
                let rigid: f64 = range.clone().map(|k| (predicted[k] - state.positions[k]).powi(2)).sum();
                let elastic: f64 = range.map(|k| (dt * state.velocities[k]).powi(2)).sum();
                largest.max(rigid.max(elastic).sqrt())
            })
        };
        let margins: Vec<f64> = self
            .system
            .pairs
            .iter()
            .map(|pair| {
                let (secondary, primary) = (pair.kernel.secondary().nodes(), pair.kernel.primary().nodes());
                reach * (pair.kernel.facet_size() + travel(secondary) + travel(primary))
            })
            .collect();
        self.system.move_obstacles(time, dt).map_err(Failure::Fatal)?;
        self.system.begin_step(&state.positions, &margins).map_err(Failure::Linear)?;

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
        let conditions = self.system.conditions(integrator);
        let energy = self.energy_scale(&start, &predicted);
        let options = &self.options;
        let task = Task {
            start: &start,
            predicted: &predicted,
            lambda: &state.lambda,
            conditions: &conditions,
            energy,
            tolerance: options.tolerance,
            interrupted: &|| options.interrupted(),
        };
        let solution = solve(&mut self.system, &task, &mut self.statistics.newton_iterations, &mut self.trace)?;
        self.check_reach(&solution, &margins)?;
        let jump = self.velocity_jump(dt, &solution, &conditions)?;
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
                .map(|k| (load[k] + self.system.weight[k]).powi(2) * start.dt * start.dt / self.system.nodal_mass[k / D])
                .sum::<f64>(),
            Err(_) => 0.0,
        };
        (row.kinetic + row.strain.abs()).max(work).max(floor * tolerances::FORCE_FLOOR)
    }

    /// Bodies must not have moved farther than the candidate pairs reach.
    fn check_reach(&self, solution: &Solution, margins: &[f64]) -> Result<(), Failure> {
        for (pair, margin) in self.system.pairs.iter().zip(margins).filter(|(pair, _)| pair.kind == PairKind::Surfaces) {
            let moved = |nodes: &[u32]| {
                nodes.iter().fold(0.0f64, |largest, &node| {
                    let range = node as usize * D..(node as usize + 1) * D;
                    largest.max(range.map(|k| (solution.q_1[k] - self.state.positions[k]).powi(2)).sum::<f64>().sqrt())
                })
            };
            if moved(pair.kernel.secondary().nodes()) + moved(pair.kernel.primary().nodes()) > *margin {
                return Err(Failure::BeyondSearch { pair: pair.name.clone() });
            }
        }
        Ok(())
    }

    /// The velocity jump that returns the energy `sum lambda Phi(q_0)` which closing pairs of the `velocity` rule lost, and its support
    /// impulse.
    ///
    /// `v_1 + s w` with the root of `1/2 s^2 w.Mw + s (v_1.Mw - work) = lost`, `work` what moving obstacles do by the push of `w`.
    fn velocity_jump(&mut self, dt: f64, solution: &Solution, conditions: &Conditions) -> Result<Option<Jump>, Failure> {
        let mut lambda = vec![0.0; self.system.multipliers];
        let mut lost = 0.0;
        for pair in self.system.pairs.iter().filter(|pair| pair.update == UpdateRule::Velocity && pair.penalty == 0.0) {
            let closed = tolerances::CLOSED * pair.kernel.facet_size().powi(2);
            for row in pair.rows.clone().filter(|&row| solution.active[row] && conditions.gap_n[row].abs() > closed) {
                lambda[row] = solution.lambda[row];
                lost += lambda[row] * conditions.gap_n[row];
            }
        }
        if lost == 0.0 {
            return Ok(None);
        }
        let (mut w, mut impulse, work) = self.system.smoothed_jump(&solution.q_1, dt, &lambda).map_err(Failure::Linear)?;
        let state = &self.state;
        let mut momentum = vec![0.0; w.len()];
        self.system.mass.multiply_into::<D>(&w, &mut momentum);
        let velocity = |k: usize| 2.0 / dt * (solution.q_1[k] - state.positions[k]) - state.velocities[k];
        let (a, b) = (0..w.len()).fold((0.0, 0.0), |(a, b), k| (a + 0.5 * w[k] * momentum[k], b + velocity(k) * momentum[k]));
        let b = b - work;
        let discriminant = b * b + 4.0 * a * lost;
        let divisor = b + discriminant.max(0.0).sqrt();
        if discriminant < 0.0 || divisor <= 0.0 {
            // A gain (a node that had sat out a step) larger than the jump can take away: it stays booked as contact work.
            return Ok(None);
        }
        let s = 2.0 * lost / divisor;
        w.iter_mut().for_each(|w| *w *= s);
        impulse.iter_mut().for_each(|f| *f *= s);
        Ok(Some(Jump { velocity: w, impulse, energy: lost, work: s * work }))
    }

    /// The state at the end of a converged step, with its row of the ledger.
    fn accept(&mut self, start: &StepStart, solution: Solution, conditions: &Conditions, jump: Option<Jump>) -> State {
        let Solution { q_1, mut lambda, active, forces, iterations } = solution;
        let search = self.system.search();
        let (system, dt, unknowns) = (&self.system, start.dt, q_1.len());
        for (lambda, _) in lambda.iter_mut().zip(&active).filter(|(_, active)| !**active) {
            *lambda = 0.0;
        }
        let gaps: Vec<f64> = system.pairs.iter().flat_map(|pair| pair.evaluation.gap.iter().copied()).collect();
        let mut v_1: Vec<f64> = (0..unknowns).map(|k| 2.0 / dt * (q_1[k] - start.q_0[k]) - start.v_0[k]).collect();
        for (prescribed, v) in system.prescribed.iter().zip(start.prescribed_v_1) {
            v_1[prescribed.unknown] = *v;
        }
        let half_force = if start.integrator == Integrator::Trapezoidal {
            // r = inertia + new half + old half, so the new half is what is left after the inertia.
            let rate: Vec<f64> = (0..unknowns).map(|k| (v_1[k] - start.v_0[k]) / dt).collect();
            let mut inertia = vec![0.0; unknowns];
            system.mass.multiply_into::<D>(&rate, &mut inertia);
            (0..unknowns).map(|k| forces.without_contact[k] - forces.contact[k] - inertia[k] - start.half_force[k]).collect()
        } else {
            self.state.half_force.clone()
        };
        if let Some(jump) = &jump {
            v_1.iter_mut().zip(&jump.velocity).for_each(|(v, w)| *v += w);
        }
        let old = &self.state.row;
        let mut row = LedgerRow {
            step: old.step + 1,
            dt,
            kinetic: system.kinetic_energy(&v_1),
            strain: system.strain_energy(&q_1),
            potential: system.potential_energy(&q_1) + system.penalty_energy(&gaps),
            newton_iterations: iterations,
            active: system.touching(&active),
            ..LedgerRow::default()
        };
        (row.momentum, row.angular_momentum) = system.momenta(&q_1, &v_1);

        // The trapezoidal rule's forces are the mean of both ends; the load of the start is part of the half force.
        let weight = start.integrator.placement().weight;
        let mut load = forces.load.clone();
        if start.integrator == Integrator::Trapezoidal {
            let mut load_n = vec![0.0; unknowns];
            if system.loads_into(start.q_0, start.time, &mut load_n).is_ok() {
                load.iter_mut().zip(&load_n).for_each(|(load, n)| *load += 0.5 * n);
            }
        }
        row.load_work = (0..unknowns).map(|k| load[k] * (q_1[k] - start.q_0[k])).sum();
        // Rigid obstacles push from outside, and do work where they move.
        let mut obstacle_force = vec![0.0; unknowns];
        let mut obstacle_work = 0.0;
        for pair in &system.pairs {
            let (lambda_n, lambda) = (&self.state.lambda[pair.rows.clone()], &lambda[pair.rows.clone()]);
            obstacle_work += pair.kernel.obstacle_force_into(start.integrator, &q_1, lambda_n, lambda, &mut obstacle_force);
        }
        obstacle_work += jump.as_ref().map_or(0.0, |jump| jump.work);
        row.load_work += obstacle_work;
        let mut slip_moment = [0.0; 3];
        if !system.prescribed.is_empty() {
            let (work, moment) = self.prescribed_work(start, &forces, &q_1, &v_1);
            row.load_work += work;
            slip_moment = moment;
        }
        let closing: f64 = system
            .pairs
            .iter()
            .filter(|pair| pair.penalty == 0.0)
            .flat_map(|pair| pair.rows.clone())
            .map(|row| lambda[row] * (conditions.targets[row] - conditions.gap_n[row]))
            .sum();
        row.contact_work = weight * closing + jump.as_ref().map_or(0.0, |jump| jump.energy);
        row.energy_defect = row.total() - old.total() - row.load_work - row.contact_work;

        // Reactions of supports are the residual there; with loads and weight they explain the change of the momenta.
        let mut external = load.clone();
        for k in 0..unknowns {
            external[k] += system.weight[k] + obstacle_force[k];
            if system.fixed[k] {
                external[k] += forces.without_contact[k] - forces.contact[k];
            }
        }
        let middle: Vec<f64> = (0..unknowns).map(|k| 0.5 * (q_1[k] + start.q_0[k])).collect();
        let nothing = vec![0.0; unknowns];
        let impulse = jump.as_ref().map_or(&nothing, |jump| &jump.impulse);
        let unexplained = |new: [f64; 3], old: [f64; 3], rate: [f64; 3], impulse: [f64; 3]| {
            (0..3).map(|i| (new[i] - old[i] - dt * rate[i] - impulse[i]).abs()).fold(0.0, f64::max)
        };
        row.momentum_defect = unexplained(row.momentum, old.momentum, resultant::<D>(&external), resultant::<D>(impulse));
        let (rate, mut impulse) = (moment::<D>(&middle, &external), moment::<D>(&q_1, impulse));
        (0..3).for_each(|i| impulse[i] += slip_moment[i]);
        row.angular_momentum_defect = unexplained(row.angular_momentum, old.angular_momentum, rate, impulse);

        for pair in system.pairs.iter().filter(|pair| pair.kind != PairKind::Tie) {
            for (node, (gap, covered)) in pair.evaluation.gap.iter().zip(&pair.evaluation.coverage).enumerate() {
                if *covered > tolerances::SLIVER {
                    row.max_penetration = row.max_penetration.max(-gap / (covered * pair.kernel.weights()[node]));
                }
            }
        }
        let acted = obstacle_work != 0.0 || load.iter().any(|f| *f != 0.0);
        State {
            row,
            positions: q_1,
            velocities: v_1,
            lambda,
            active,
            half_force,
            clock: self.state.clock,
            search,
            level: self.state.level,
            loads_ended: if acted { start.time + dt } else { self.state.loads_ended },
        }
    }

    /// Work of the reactions that move the prescribed nodes, and the angular momentum that they give by moving them by `dq` while their
    /// velocities are those of the time functions: inertia forces work on `dt (v_0 + v_1)/2`, all others on `dq`.
    fn prescribed_work(&self, start: &StepStart, forces: &Forces, q_1: &[f64], v_1: &[f64]) -> (f64, [f64; 3]) {
        let unknowns = q_1.len();
        let change: Vec<f64> = (0..unknowns).map(|k| (v_1[k] - start.v_0[k]) / start.dt).collect();
        let mean: Vec<f64> = (0..unknowns).map(|k| 0.5 * (v_1[k] + start.v_0[k])).collect();
        let (mut inertia, mut momentum, mut slip) = (vec![0.0; unknowns], vec![0.0; unknowns], vec![0.0; unknowns]);
        self.system.mass.multiply_into::<D>(&change, &mut inertia);
        self.system.mass.multiply_into::<D>(&mean, &mut momentum);
        let mut work = 0.0;
        for k in self.system.prescribed.iter().map(|prescribed| prescribed.unknown) {
            let reaction = forces.without_contact[k] - forces.contact[k];
            let moved = q_1[k] - start.q_0[k];
            slip[k] = moved - start.dt * mean[k];
            work += inertia[k] * start.dt * mean[k] + (reaction - inertia[k]) * moved;
        }
        (work, moment::<D>(&slip, &momentum))
    }

    /// Half of the static forces at the current state: where the trapezoidal rule starts from.
    fn start_trapezoidal(&mut self) -> Result<(), StepError> {
        let state = self.state.clone();
        let zero = vec![0.0; state.positions.len()];
        let start = StepStart {
            integrator: Integrator::Trapezoidal,
            time: state.row.time,
            dt: 0.0,
            q_0: &state.positions,
            v_0: &zero,
            half_force: &zero,
            prescribed_v_1: &[],
            damping: Some(0.0),
        };
        let margins: Vec<f64> = self.system.pairs.iter().map(|pair| pair.kernel.facet_size()).collect();
        self.system.move_obstacles(state.row.time, 0.0)?;
        if let Err(error) = self.system.begin_step(&state.positions, &margins) {
            return Err(self.failed(&Failure::Linear(error), 0.0, 0));
        }
        match self.system.assemble(&start, &state.positions, &state.lambda) {
            Ok(forces) => {
                let half = forces.without_contact.iter().zip(&forces.contact).map(|(r, c)| r - c).collect();
                self.state.half_force = half;
                Ok(())
            }
            Err(AssemblyError::Load(error)) => Err(error),
            Err(error) => Err(self.failed(&error.into(), 0.0, 0)),
        }
    }

    /// The error that a user sees when a step failed for good; its report is kept.
    fn failed(&mut self, failure: &Failure, dt: f64, halvings: usize) -> StepError {
        let report = self.report(failure, dt, halvings);
        let smaller = if dt > 0.0 {
            format!("use a smaller step than dt = {}, or allow more `max_halvings`", self.options.dt)
        } else {
            "check supports and loads".into()
        };
        let (time, step) = (report.time, report.step);
        let (cause, cure) = (report.explanation(), report.cure(&smaller));
        self.failure = Some((report, self.trace.q_1.clone()));
        StepError::NotConverged { time, step, dt, halvings, cause, cure }
    }

    fn report(&self, failure: &Failure, dt: f64, halvings: usize) -> FailureReport {
        let contact_of = |row: usize| self.system.pairs.iter().find(|pair| pair.rows.contains(&row));
        let iterations: Vec<IterationReport> = self
            .trace
            .iterations
            .iter()
            .map(|iteration| {
                let (body, node) = self.system.owner(iteration.worst / D);
                IterationReport {
                    residual: iteration.residual,
                    target: iteration.target,
                    gap_violation: iteration.violation,
                    changes: iteration.changes,
                    active: iteration.active,
                    body: body.into(),
                    node,
                    contact: contact_of(iteration.worst_row).map(|pair| pair.name.clone()),
                }
            })
            .collect();
        let cause = match failure {
            Failure::Iterations => {
                let last = &self.trace.iterations[self.trace.iterations.len().saturating_sub(6)..];
                let cycling = last.iter().rev().skip(1).map(|iteration| iteration.changes).min().unwrap_or(0);
                match last.last().and_then(|iteration| contact_of(iteration.worst_row)) {
                    Some(pair) if cycling > 0 => {
                        FailureCause::CyclingContact { contact: pair.name.clone(), changing: cycling, nodes: pair.rows.len() }
                    }
                    _ => FailureCause::SlowConvergence,
                }
            }
            Failure::Inverted { body, inverted } => {
                let index = self.system.bodies.iter().position(|other| other.name == *body).unwrap_or(0);
                let mesh = &self.model.bodies[index].mesh;
                let corners = mesh.cell(inverted.cell);
                let mut center = [0.0; 3];
                for &node in corners {
                    for i in 0..3 {
                        center[i] += mesh.points[node as usize][i] / corners.len() as f64;
                    }
                }
                FailureCause::InvertedCell { body: body.clone(), cell: inverted.cell, determinant: inverted.determinant, center }
            }
            Failure::Linear(error) => FailureCause::SingularSystem { reason: self.system.explain(error) },
            Failure::Diverged => FailureCause::Divergence,
            Failure::BeyondSearch { pair } => FailureCause::TooFast { contact: pair.clone() },
            Failure::Fatal(error) => FailureCause::SingularSystem { reason: error.to_string() },
        };
        FailureReport { time: self.state.row.time, step: self.state.row.step + 1, dt, halvings, cause, iterations }
    }
}

/// One number for each node from its constraint rows: the row itself, or the length of the vector that several are.
fn per_node(values: &[f64], rows: usize) -> Vec<f64> {
    match rows {
        1 => values.to_vec(),
        _ => values.chunks_exact(rows).map(|vector| vector.iter().map(|x| x * x).sum::<f64>().sqrt()).collect(),
    }
}

/// Newton's method with its second try.
fn solve<const D: usize>(system: &mut System<D>, task: &Task, iterations: &mut usize, trace: &mut Trace) -> Result<Solution, Failure>
where
    Space<D>: Elements<D>,
{
    let before = system.factorizations;
    let mut outcome = newton::solve(system, task, Strategy::InnerLoop, trace);
    let retries = [(Strategy::InnerLoop, true), (Strategy::Backtracking, false), (Strategy::Backtracking, true)];
    for (strategy, shared) in retries {
        if system.multipliers == 0 || matches!(outcome, Ok(_) | Err(Failure::Fatal(_) | Failure::Inverted { .. })) {
            break;
        }
        system.share_corrections(shared);
        outcome = newton::solve(system, task, strategy, trace);
        system.share_corrections(false);
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

    fn state(&self) -> &State {
        &self.state
    }

    fn restore(&mut self, state: &State) {
        assert_eq!(
            (state.positions.len(), state.lambda.len()),
            (self.state.positions.len(), self.state.lambda.len()),
            "the state is of the same model"
        );
        self.state = state.clone();
        self.system.restore_search(&state.search, &state.positions);
    }

    fn step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError> {
        let outcome = self.nominal_step(end, accepted);
        if outcome.is_err() {
            // Nothing of the pieces that failed stays: the state alone decides how it goes on.
            self.system.restore_search(&self.state.search, &self.state.positions);
        }
        outcome
    }

    fn settle(&mut self) -> Result<SettleReport, StepError> {
        let before = self.state.clone();
        let mut outcome = self.settle_from_here();
        if self.options.integrator == Integrator::Trapezoidal && self.state.row.step > 0 {
            // The forces that the rule carries from step to step are those of the new equilibrium.
            outcome = outcome.and_then(|report| self.start_trapezoidal().map(|()| report));
        }
        if outcome.is_err() {
            self.system.restore_search(&before.search, &before.positions);
            self.state = before;
        }
        outcome
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
        let pair = self.system.pairs.iter().find(|pair| pair.name == name)?;
        let q = &self.state.positions;
        let rows = pair.kernel.rows_per_node();
        let (gaps, coverage) = (per_node(&pair.kernel.gap(q), rows), pair.kernel.coverage(q));
        let secondary = pair.kernel.secondary().nodes();
        let position = |node: u32| {
            let mut x = [0.0; 3];
            x[..D].copy_from_slice(&q[node as usize * D..(node as usize + 1) * D]);
            x
        };
        let mut force = [0.0; 3];
        let lambda = &self.state.lambda[pair.rows.clone()];
        let mut evaluation = Default::default();
        pair.kernel.evaluate(Integrator::Trapezoidal, q, lambda, &mut evaluation);
        let patches = pair.kernel.patches();
        for p in (0..patches.len()).filter(|&p| evaluation.live[p]) {
            let gradients = &evaluation.gradient_end[patches.gradient_range(p)];
            for (row, gradient) in patches.rows(p).iter().zip(gradients.chunks_exact(patches.unknowns(p))) {
                for (u, node) in patches.nodes(p).iter().enumerate() {
                    if secondary.binary_search(node).is_ok() {
                        for i in 0..D {
                            force[i] += lambda[*row as usize] * gradient[u * D + i];
                        }
                    }
                }
            }
        }
        Some(ContactFields {
            positions: secondary.iter().map(|&node| position(node)).collect(),
            pressure: per_node(lambda, rows),
            gap: (0..secondary.len())
                .map(|k| {
                    let (covered, weight) = (coverage[k * rows], pair.kernel.weights()[k * rows]);
                    if covered > tolerances::SLIVER { gaps[k] / (covered * weight) } else { f64::NAN }
                })
                .collect(),
            active: self.state.active[pair.rows.clone()].chunks_exact(rows).map(|rows| rows.contains(&true)).collect(),
            force,
        })
    }

    fn closed_nodes(&self) -> Vec<usize> {
        let count = |rows: std::ops::Range<usize>| self.state.active[rows].iter().filter(|active| **active).count();
        self.system.pairs.iter().map(|pair| count(pair.rows.clone())).collect()
    }

    fn statistics(&self) -> Statistics {
        Statistics { factorizations: self.system.factorizations, times: self.system.times, ..self.statistics }
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
        while done < all {
            if self.options.interrupted() {
                return Err(StepError::Interrupted { time: self.state.row.time });
            }
            match self.piece(dt / all as f64) {
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
                    self.state = state;
                    accepted(&self.state.row);
                }
                Err(Failure::Fatal(error)) => return Err(error),
                Err(failure) => {
                    if level >= self.options.max_halvings {
                        return Err(self.failed(&failure, dt / all as f64, level));
                    }
                    level += 1;
                    halvings += 1;
                    self.statistics.halvings += 1;
                    (done, all) = (2 * done, 2 * all);
                }
            }
        }
        Ok(())
    }

    fn fields_at(&self, q: &[f64]) -> Vec<BodyFields> {
        let v = &self.state.velocities;
        let nodes = self.system.nodes();
        let mut stress = vec![[0.0; 6]; nodes];
        let mut weight = vec![0.0; nodes];
        for body in &self.system.bodies {
            body.elements.project_stress(q, &mut stress, &mut weight);
        }
        let (mut pressure, mut gap) = (vec![0.0; nodes], vec![f64::NAN; nodes]);
        for pair in self.system.pairs.iter().filter(|pair| pair.kind != PairKind::Tie) {
            let (gaps, coverage) = (pair.kernel.gap(q), pair.kernel.coverage(q));
            for (local, &node) in pair.kernel.secondary().nodes().iter().enumerate() {
                pressure[node as usize] += self.state.lambda[pair.rows.start + local];
                if coverage[local] > tolerances::SLIVER {
                    gap[node as usize] = gaps[local] / (coverage[local] * pair.kernel.weights()[local]);
                }
            }
        }
        let vector = |values: &[f64], node: usize| {
            let mut vector = [0.0; 3];
            vector[..D].copy_from_slice(&values[node * D..(node + 1) * D]);
            vector
        };
        let displacement: Vec<f64> = q.iter().zip(&self.system.reference).map(|(q, x)| q - x).collect();
        self.system
            .bodies
            .iter()
            .zip(&self.model.bodies)
            .map(|(body, definition)| BodyFields {
                name: body.name.clone(),
                mesh: definition.mesh.clone(),
                displacement: body.nodes.clone().map(|node| vector(&displacement, node)).collect(),
                velocity: body.nodes.clone().map(|node| vector(v, node)).collect(),
                stress: body.nodes.clone().map(|node| stress[node].map(|s| s / weight[node])).collect(),
                contact_pressure: pressure[body.nodes.clone()].to_vec(),
                contact_gap: gap[body.nodes.clone()].to_vec(),
            })
            .collect()
    }

    fn settle_from_here(&mut self) -> Result<SettleReport, StepError> {
        let iterations_before = self.statistics.newton_iterations;
        let zero = vec![0.0; self.state.positions.len()];
        // Slowest elastic motion: wave speed over the largest extent.
        let density = self.model.bodies.iter().map(|body| body.material.density()).fold(f64::INFINITY, f64::min);
        let frequency_squared = self.system.modulus / density / self.system.extent.powi(2);
        let mut steps = 0;
        loop {
            let positions = self.state.positions.clone();
            let margins: Vec<f64> = self.system.pairs.iter().map(|pair| 3.0 * pair.kernel.facet_size()).collect();
            self.system.move_obstacles(self.state.row.time, 0.0)?;
            if let Err(error) = self.system.begin_step(&positions, &margins) {
                return Err(self.failed(&Failure::Linear(error), 0.0, 0));
            }
            let (displacement, _) = self.system.prescribed_motion(self.state.row.time)?;
            let mut predicted = positions.clone();
            predictor::follow_prescribed(&self.system, &positions, &displacement, &mut predicted);
            let start = StepStart {
                integrator: Integrator::Trapezoidal,
                time: self.state.row.time,
                dt: 0.0,
                q_0: &positions,
                v_0: &zero,
                half_force: &zero,
                prescribed_v_1: &[],
                damping: Some(SETTLE_DAMPING * frequency_squared),
            };
            let floor = tolerances::FORCE_FLOOR * self.system.modulus * self.system.extent.powi(D as i32);
            let energy = self.system.strain_energy(&positions).max(floor);
            let options = &self.options;
            // At rest every rule closes the gaps.
            let count = self.system.multipliers;
            let conditions = Conditions { gap_n: vec![0.0; count], targets: vec![0.0; count], members: vec![true; count], end_point: true };
            let task = Task {
                start: &start,
                predicted: &predicted,
                lambda: &self.state.lambda,
                conditions: &conditions,
                energy,
                tolerance: options.tolerance,
                interrupted: &|| options.interrupted(),
            };
            let outcome = solve(&mut self.system, &task, &mut self.statistics.newton_iterations, &mut self.trace);
            let solution = match outcome {
                Ok(solution) => solution,
                Err(Failure::Fatal(error)) => return Err(error),
                Err(failure) => return Err(self.failed(&failure, 0.0, 0)),
            };
            self.check_reach(&solution, &margins).map_err(|failure| self.failed(&failure, 0.0, 0))?;
            steps += 1;
            let strain = self.system.strain_energy(&solution.q_1);
            // What the damping did in this step: nothing, at equilibrium.
            let motion: Vec<f64> = solution.q_1.iter().zip(&positions).map(|(a, b)| a - b).collect();
            let dissipated = 2.0 * SETTLE_DAMPING * frequency_squared * self.system.kinetic_energy(&motion);
            self.state.positions = solution.q_1;
            self.state.lambda = solution.lambda;
            self.state.active = solution.active;
            self.state.search = self.system.search();
            if dissipated <= 1e-14 * strain.max(floor) {
                break;
            }
            if steps == MAX_SETTLE_STEPS {
                let cause =
                    format!("after {steps} damped steps the bodies still move (dissipated energy {dissipated:.1e} in the last one)");
                let cure =
                    "hold every body against the loads on it with `fix` or by contact; rigid motion under a load has no equilibrium".into();
                return Err(StepError::NotConverged {
                    time: self.state.row.time,
                    step: self.state.row.step,
                    dt: 0.0,
                    halvings: 0,
                    cause,
                    cure,
                });
            }
        }
        let (q, v) = (&self.state.positions, &self.state.velocities);
        let row = &mut self.state.row;
        row.strain = self.system.strain_energy(q);
        let gaps: Vec<f64> = self.system.pairs.iter().flat_map(|pair| pair.kernel.gap(q)).collect();
        row.potential = self.system.potential_energy(q) + self.system.penalty_energy(&gaps);
        (row.momentum, row.angular_momentum) = self.system.momenta(q, v);
        row.active = self.system.touching(&self.state.active);
        Ok(SettleReport {
            steps,
            newton_iterations: self.statistics.newton_iterations - iterations_before,
            strain: row.strain,
            active: row.active,
        })
    }
}
