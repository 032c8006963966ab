//! One substep: from a state to a new one, or a failure. The present state is not changed here.

use std::sync::Arc;

use super::engine::Engine;
use super::options::Options;
use super::state::State;
use crate::bodies::{Elements, Space};
use crate::contact::{MotionBound, PredictedMotion};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::PairKind;
use crate::dynamics::step::conditions::Conditions;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::newton::{Solution, solve};
use crate::dynamics::step::predictor::{displacements_to, follow_prescribed, rigid_motion};
use crate::dynamics::step::start::{Motion, StepKind, StepStart};
use crate::dynamics::step::task::Task;
use crate::integrators::Scheme;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// Halvings of a step of given size from which on friction that depends on the speed may have the coefficients of the start of a substep.
const MOST_IMPLICIT: usize = 3;

/// Factor of the search horizon over the predicted motion: impacts add elastic motion. After an overlooked contact, a second attempt
/// expects this motion.
const MORE_MOTION: f64 = 3.0;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Takes one substep, of a step that was halved `level` times, from the present state.
    pub fn piece(&mut self, dt: f64, level: usize) -> Result<State, Failure> {
        let integrator = self.options.integrator;
        if integrator.lumping().is_some() {
            return self.explicit_piece(dt);
        }
        if integrator.is_static() {
            return self.static_piece(dt);
        }
        let stages = integrator.stages();
        if stages.is_empty() {
            return self.stage(&integrator.after(self.state.scheme_history.dt, dt), dt, level);
        }
        let before = self.state.clone();
        let end = stages.iter().try_fold(before.clone(), |_, (share, stage)| {
            let mut state = self.stage(stage, share * dt, level)?;
            state.row.time = self.state.row.time + share * dt;
            state.slips_until = state.row.time;
            state.row.join(&self.state.row, before.row.step, share * dt, dt);
            self.state = Arc::new(state);
            Ok(self.state.clone())
        });
        self.state = before;
        if end.is_err() {
            self.restore_search();
        }
        end.map(Arc::unwrap_or_clone)
    }

    /// Takes one stage of a substep, or the whole substep.
    fn stage(&mut self, scheme: &Scheme, dt: f64, level: usize) -> Result<State, Failure> {
        match self.piece_within(scheme, dt, 1.0, level) {
            Err(Failure::Overlooked { .. }) => self.piece_within(scheme, dt, MORE_MOTION, level),
            outcome => outcome,
        }
    }

    /// Checks that boundaries rotate by less than a quarter of a turn in a step; beyond that the end of the step does not determine number
    /// and direction of turns.
    pub(super) fn check_turns(&self, dt: f64) -> Result<(), StepError> {
        let time = self.state.row.time;
        let (angle, boundary) = self.system.supports.turned(time, time + dt)?;
        if angle <= 2.0 * tolerances::EIGHTH_TURN {
            return Ok(());
        }
        Err(StepError::TurnsFar { boundary: boundary.into(), time, dt, angle })
    }

    /// Eases the conditions of a substep without a solution in the next way that applies; false if none is left.
    fn ease(&self, conditions: &mut Conditions, level: usize) -> bool {
        // A slip that may stop within the step can leave the step without a solution.
        if conditions.stops.contains(&true) {
            conditions.stops.fill(false);
            return true;
        }
        let may_lag = self.options.control.is_some() || level >= MOST_IMPLICIT;
        if !may_lag || !conditions.lagged_speeds.is_empty() {
            return false;
        }
        // Where friction falls with the speed fast enough, as in impacts, a step has several solutions or none, however short it is: the
        // coefficients are then those of the slips at its start. Automatic steps are of the size that their tolerance demands; steps of a
        // given size are halved first, since these coefficients are of first order in the size.
        conditions.lagged_speeds = self.system.slip_speeds(&self.state.positions, &self.state.velocities);
        !conditions.lagged_speeds.is_empty()
    }

    /// Takes a stage like [`Self::stage`], with the predicted motion times `factor` as motion bound. A substep that may be halved is
    /// refused without an attempt if its predicted motion is too large.
    fn piece_within(&mut self, scheme: &Scheme, dt: f64, factor: f64, level: usize) -> Result<State, Failure> {
        let may_be_halved = level < self.options.max_halvings;
        let (state, reach) = (self.state.clone(), self.options.reach);
        let time = state.row.time;
        self.check_turns(dt).map_err(Failure::Fatal)?;
        let (displacement, prescribed_v_1) = self.system.supports.prescribed_motion(time + dt).map_err(Failure::Fatal)?;
        let mut predicted = rigid_motion(&self.system, &state.positions, &state.velocities, dt);
        follow_prescribed(&self.system, &state.positions, &displacement, &mut predicted);
        // Motion bound of the nodes: the larger of the predicted rigid motion and the motion by the velocities.
        let rigid = displacements_to(&self.system, state.pose(), &displacement, &predicted);
        let elastic: Vec<f64> = state.velocities.iter().map(|v| dt * v).collect();
        let predicted_motion = PredictedMotion {
            q: &state.positions,
            motion_bound: MotionBound::Guessed { displacements: [&rigid, &elastic], factor },
            reach,
            depth: 0.0,
        };
        self.system.equations.move_obstacles(time, dt).map_err(Failure::Fatal)?;
        self.count_turns();
        self.system.begin_step(&predicted_motion).map_err(Failure::Linear)?;
        self.system.equations.begin_friction(time + 0.5 * dt, &state.positions).map_err(Failure::Fatal)?;

        let (v_0, scheme_history, prescribed_v_1) = (&state.velocities[..], &*state.scheme_history, &prescribed_v_1[..]);
        let motion = Motion { scheme, dt, v_0, scheme_history, prescribed_v_1 };
        let start =
            StepStart { time, q_0: &state.positions, u_0: &state.displacements, memory: &state.memory, kind: StepKind::Motion(motion) };
        let mut conditions = self.system.conditions(&start, &state.penalty_gap, &state.active);
        if let Some(motion) = self.system.foreseen(&state.positions, &predicted, &conditions, &state.active) {
            if may_be_halved {
                return Err(Failure::Foreseen(motion));
            }
            self.halvings.refuse(motion, dt, &state.row);
        }
        let energy = self.energy_scale(&motion, time, &predicted);
        let options = &self.options;
        let (is_exact, before) = (self.has_drifted(energy), self.system.counters);
        // Defects of the stages of a step add up.
        let tolerance = options.tolerance / options.integrator.stages().len().max(1) as f64;
        let solution = loop {
            let task = Task {
                start: &start,
                predicted: &predicted,
                moved: &rigid,
                lambda: &state.lambda,
                conditions: &conditions,
                energy,
                tolerance,
                is_still: self.state.row.kinetic + self.state.row.strain.abs() <= tolerances::HARDLY_MOVED * energy,
                is_exact,
                at_least: 0,
                is_patient: !may_be_halved,
                preferred: state.preferred,
                interrupted: &|| options.interrupted(),
            };
            let outcome = solve(&mut self.system, &task, &mut self.statistics.newton_iterations, &mut self.trace);
            if matches!(outcome, Ok(_) | Err(Failure::Fatal(_))) || !self.ease(&mut conditions, level) {
                break outcome?;
            }
        };
        let taken_back = match self.check_search(&predicted_motion, MORE_MOTION, &solution) {
            Ok(()) if may_be_halved => {
                self.system.penetration_after_step(&state.positions, &solution.at, &conditions).map(Failure::Foreseen)
            }
            outcome => outcome.err(),
        };
        if let Some(failure) = taken_back {
            // Factorizations of failed attempts are already counted as discarded; those since then are added.
            let counters = &mut self.system.counters;
            counters.discarded = before.discarded + (counters.factorizations - before.factorizations);
            return Err(failure);
        }
        let jump = self.velocity_correction(&motion, &solution, &conditions)?;
        self.accept(&start, &motion, solution, &conditions, jump).map_err(Failure::Fatal)
    }

    /// True if the accumulated energy defect of earlier steps exceeds the tolerance of a single step: without contact the defect has the
    /// same sign in every step.
    fn has_drifted(&self, energy: f64) -> bool {
        let Options { tolerance, integrator, .. } = self.options;
        integrator.promises.energy && self.state.drift.abs() > tolerances::DEFECT * tolerance * energy
    }

    /// Energy scale of defects: energy of the state, or the kinetic energy that loads give to nodes at rest; and at least that whose
    /// tolerance is the work of round-off of the forces of earlier stages: after an impact in one of them the body may be at rest.
    fn energy_scale(&self, motion: &Motion, time: f64, predicted: &[f64]) -> f64 {
        let (row, nodes, dt) = (&self.state.row, &self.system.nodes, motion.dt);
        // Round-off of positions if forces depend on them, otherwise of displacements.
        let reach = match self.system.depends_on_positions() {
            true => nodes.extent,
            false => {
                let moved = predicted.iter().zip(&self.state.positions).map(|(x_1, x_0)| (x_1 - x_0).abs());
                moved.fold(largest_size(&self.state.displacements), f64::max)
            }
        };
        let floor = nodes.stiffness() * (tolerances::FORCE_FLOOR * reach).powi(2);
        let mut load = vec![0.0; predicted.len()];
        if self.system.loads_into(predicted, time + 0.5 * dt, &mut load).is_err() {
            load.fill(0.0);
        } else {
            load.iter_mut().zip(&nodes.weight).for_each(|(force, weight)| *force += weight);
        }
        let given = |(k, force): (usize, &f64)| force.powi(2) * dt * dt / nodes.lumped_mass[k / D];
        let given_by = |forces: Vec<f64>| forces.iter().enumerate().filter(|(_, force)| **force != 0.0).map(given).sum::<f64>();
        let scale = (row.kinetic + row.strain.abs()).max(given_by(load)).max(floor);
        let before = given_by(motion.remembered_force().collect());
        scale.max(tolerances::STOPPED * (scale * before).sqrt())
    }

    /// Checks that bodies moved no farther than a multiple of the admission distance of facet pairs, and not into a facet that was not
    /// admitted. The search horizon has no influence.
    pub fn check_search(&self, predicted_motion: &PredictedMotion, multiple: f64, solution: &Solution) -> Result<(), Failure> {
        let q_1 = &solution.at.q_1;
        for pair in self.system.pairs.iter().filter(|pair| pair.kind == PairKind::Surfaces && !pair.only_measures()) {
            let moved = |nodes: &[u32]| {
                nodes.iter().fold(0.0f64, |largest, &node| {
                    let range = node as usize * D..(node as usize + 1) * D;
                    largest.max(range.map(|k| (q_1[k] - self.state.positions[k]).powi(2)).sum::<f64>().sqrt())
                })
            };
            if moved(pair.kernel.secondary().nodes()) + moved(pair.kernel.primary().nodes())
                > multiple * pair.kernel.margin(predicted_motion)
            {
                return Err(Failure::BeyondSearch { pair: pair.name.clone() });
            }
            if pair.kernel.overlooks(predicted_motion.q, q_1, tolerances::EXCLUDED_OVERLAP * pair.kernel.facet_size()) {
                return Err(Failure::Overlooked { pair: pair.name.clone() });
            }
        }
        Ok(())
    }
}
