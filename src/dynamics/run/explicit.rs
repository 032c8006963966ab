//! Explicit step: positions by the forces at its start, contact by multipliers at its start that satisfy the gap conditions at its end,
//! forces at its end, velocities by both.
//!
//! ```text
//! v_h = v_0 - dt/2 m^-1 f_0 + dt m^-1 G_0^T (lambda - lambda_0),    q_1 = q_0 + dt v_h,    v_1 = v_h - dt/2 m^-1 f_1
//! ```
//!
//! Static forces `f` include contact forces, `f_1` with the multipliers of this step: velocities and forces belong to the positions, and
//! the next step corrects the difference to its own multipliers.

use std::sync::Arc;

use super::engine::Engine;
use super::state::State;
use crate::bodies::{Elements, Inverted, Space};
use crate::contact::{Evaluation, MotionBound, PredictedMotion};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::PairKind;
use crate::dynamics::step::contact_impulses::push;
use crate::dynamics::step::explicit::PartForces;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::iterate::Linearization;
use crate::dynamics::step::scheme_history::{ForceHistory, SchemeHistory};
use crate::dynamics::step::start::{Motion, StepKind, StepStart};
use crate::integrators::Derivative;
use crate::math::digits::three_digits;
use crate::math::tolerances;

/// Number of corrections of a motion until the gaps meet their targets: gaps are nearly linear within a step.
const PASSES: usize = 4;

/// An explicit step in progress.
pub(super) struct ExplicitStep {
    /// Size of the step.
    pub dt: f64,
    /// Static forces at the start, including weights and contact.
    pub f_0: Vec<f64>,
    /// Multipliers at the end of the step before, and of this step.
    pub lambda: [Vec<f64>; 2],
    /// Motion in the step with unchanged multipliers.
    pub unpushed: Vec<f64>,
    /// Force change at the start of the step by the new multipliers, and the force of the earlier multipliers; empty without multipliers.
    pub kick: Vec<f64>,
    pub pressed_0: Vec<f64>,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Takes one explicit step from the present state.
    pub(super) fn explicit_piece(&mut self, dt: f64) -> Result<State, Failure> {
        let outcome = self.leap(dt);
        outcome.map_err(|failure| match failure.or_end(self.state.row.time) {
            Failure::Fatal(error) => Failure::Fatal(error),
            Failure::Inverted { body, inverted: Inverted { cell, .. } } => {
                self.ran_away(dt, format!("cell {cell} of body \"{body}\" is inside out"))
            }
            failure => self.ran_away(dt, failure.name().into()),
        })
    }

    fn leap(&mut self, dt: f64) -> Result<State, Failure> {
        let (state, scheme) = (self.state.clone(), self.options.integrator);
        let time = state.row.time;
        self.check_turns(dt).map_err(Failure::Fatal)?;
        let (displacement, rates) = self.system.supports.prescribed_motion(time + dt).map_err(Failure::Fatal)?;
        let motion = Motion { scheme: &scheme, dt, v_0: &state.velocities, scheme_history: &state.scheme_history, prescribed_v_1: &rates };
        let (q_0, u_0) = (&state.positions[..], &state.displacements[..]);
        let start = StepStart { time, q_0, u_0, memory: &state.memory, kind: StepKind::Motion(motion) };
        let (mut at, _) = self.system.spare.next();
        let f_0: Vec<f64> = state.scheme_history.force.left.iter().map(|half| half / (1.0 - scheme.weight)).collect();
        at.moved.clear();
        at.moved.extend((0..q_0.len()).map(|k| {
            let mobility = self.system.mobility(k);
            if mobility == 0.0 { 0.0 } else { dt * (state.velocities[k] - 0.5 * dt * mobility * f_0[k]) }
        }));
        for (one, displacement) in self.system.supports.prescribed.iter().zip(&displacement) {
            at.moved[one.unknown] = displacement - u_0[one.unknown];
        }
        self.system.place_after(&start, &mut at);
        let lambda = [state.lambda.clone(), state.lambda.clone()];
        let mut leap = ExplicitStep { dt, f_0, lambda, unpushed: Vec::new(), kick: Vec::new(), pressed_0: Vec::new() };
        if !self.system.pairs.is_empty() {
            self.push_by_multipliers(&start, &mut leap, &mut at)?;
        }
        let forces = self.system.part_forces(&start, &at)?;
        let landed = self.land(&start, &motion, leap, at, forces)?;
        self.check_energy(dt, &landed)?;
        Ok(landed)
    }

    /// Computes the multipliers of a step and their effect on its motion.
    fn push_by_multipliers(&mut self, start: &StepStart, leap: &mut ExplicitStep, at: &mut Linearization) -> Result<(), Failure> {
        let (system, dt) = (&mut self.system, leap.dt);
        system.equations.move_obstacles(start.time, dt).map_err(Failure::Fatal)?;
        let motion_bound = MotionBound::Guessed { displacements: [&at.moved, &at.moved], factor: 1.0 };
        let predicted_motion = PredictedMotion { q: start.q_0, motion_bound, reach: self.options.reach, depth: 0.0 };
        system.begin_explicit_step(&predicted_motion).map_err(Failure::Linear)?;
        system.evaluate_pairs(&at.q_1, &mut at.pairs);
        let mobility: Vec<f64> = (0..start.q_0.len()).map(|k| system.mobility(k)).collect();
        let (targets, mut begun) = (system.explicit_targets(), None);
        for _ in 0..PASSES {
            let gaps: Vec<f64> = at.pairs.iter().flat_map(|pair| pair.gap.iter()).zip(&targets).map(|(gap, target)| gap - target).collect();
            let (wanted, is_met) = system.wanted(&at.pairs, &gaps, &leap.lambda[1], begun.is_some());
            if is_met {
                break;
            }
            if begun.is_none() {
                let mut there = Vec::new();
                system.equations.move_obstacles(start.time, 0.0).map_err(Failure::Fatal)?;
                system.evaluate_pairs(start.q_0, &mut there);
                system.equations.move_obstacles(start.time, dt).map_err(Failure::Fatal)?;
                leap.unpushed.clone_from(&at.moved);
                begun = Some(there);
            }
            let rows = system.pushed_rows(begun.as_deref().unwrap_or_default(), &wanted, &mobility);
            let of_rows = |all: &[f64]| -> Vec<f64> { rows.iter().map(|row| all[row.row]).collect() };
            let least: Vec<f64> = of_rows(&leap.lambda[1]).iter().map(|lambda| -lambda * dt * dt).collect();
            let changes = push(&rows, &of_rows(&gaps), &least, &mobility, &mut at.moved);
            rows.iter().zip(changes).for_each(|(row, p)| leap.lambda[1][row.row] = (leap.lambda[1][row.row] + p / (dt * dt)).max(0.0));
            system.zero_immobile_multipliers(&wanted, &rows, &mut leap.lambda[1]);
            system.place_after(start, at);
            system.evaluate_pairs(&at.q_1, &mut at.pairs);
        }
        if let Some(there) = begun {
            let [before, now] = &leap.lambda;
            let change: Vec<f64> = now.iter().zip(before).map(|(now, before)| now - before).collect();
            leap.kick = system.pressed(&there, &change, |pair| pair.has_multipliers());
            leap.pressed_0 = system.pressed(&there, before, |pair| pair.has_multipliers());
        }
        system.press_by_penalties(&at.pairs, &mut leap.lambda[1]);
        at.lambda.clone_from(&leap.lambda[1]);
        Ok(())
    }

    /// Initializes the history variables of the explicit scheme with the forces at the present state.
    pub(super) fn remember_explicit(&mut self) -> Result<(), StepError> {
        let (state, scheme) = (self.state.clone(), self.options.integrator);
        let undamped = vec![0.0; self.system.bodies.len()];
        let (q_0, u_0) = (&state.positions[..], &state.displacements[..]);
        let kind = StepKind::Rest { damping: &undamped, velocities: Some(&state.velocities) };
        let start = StepStart { time: state.row.time, q_0, u_0, memory: &state.memory, kind };
        let mut at = Linearization::default();
        (at.moved, at.q_1, at.u_1) = (vec![0.0; q_0.len()], q_0.to_vec(), u_0.to_vec());
        let mut lambda = state.lambda.clone();
        let forces = self.forces_at_rest(&start, &mut at, &mut lambda).map_err(|failure| self.error_of(failure))?;
        let static_forces = self.static_forces(&forces, &at.pairs, &lambda);
        let row = &state.row;
        let mut scheme_history =
            SchemeHistory { of: scheme.describe(), exchanged: row.kinetic + row.strain.abs(), ..SchemeHistory::default() };
        let mut obstacles = vec![0.0; q_0.len()];
        for pair in self.system.pairs.iter().filter(|pair| pair.kind == PairKind::Obstacle) {
            let half: Vec<f64> = lambda[pair.rows.clone()].iter().map(|lambda| 0.5 * lambda).collect();
            pair.kernel.obstacle_force_into(Derivative::AT_END, q_0, &vec![0.0; half.len()], &half, &mut obstacles);
        }
        scheme_history.keep(&scheme, &static_forces, forces, &obstacles);
        let state = Arc::make_mut(&mut self.state);
        (state.scheme_history, state.lambda) = (Arc::new(scheme_history), lambda);
        state.search = self.system.search();
        Ok(())
    }

    fn forces_at_rest(&mut self, start: &StepStart, at: &mut Linearization, lambda: &mut [f64]) -> Result<PartForces, Failure> {
        if !self.system.pairs.is_empty() {
            self.system.equations.move_obstacles(start.time, 0.0).map_err(Failure::Fatal)?;
            self.system.begin_explicit_step(&PredictedMotion::within(start.q_0, 0.0)).map_err(Failure::Linear)?;
            self.system.evaluate_pairs(start.q_0, &mut at.pairs);
            self.system.press_by_penalties(&at.pairs, lambda);
        }
        self.system.part_forces(start, at)
    }

    /// Static forces `[force]`: internal forces minus loads, weights and contact forces.
    pub(super) fn static_forces(&self, forces: &PartForces, pairs: &[Evaluation], lambda: &[f64]) -> Vec<f64> {
        let weight = &self.system.nodes.weight;
        let mut sum: Vec<f64> = (0..weight.len()).map(|k| forces.internal[k] - forces.load[k] - weight[k]).collect();
        if !pairs.is_empty() {
            sum.iter_mut().zip(self.system.pressed(pairs, lambda, |_| true)).for_each(|(sum, pressed)| *sum -= pressed);
        }
        sum
    }

    /// Stops a run whose unexplained energy grows beyond [`tolerances::RAN_AWAY`] times the known energy.
    fn check_energy(&mut self, dt: f64, landed: &State) -> Result<(), Failure> {
        let nodes = &self.system.nodes;
        let floor = tolerances::FORCE_FLOOR * nodes.stiffness() * nodes.extent.powi(2);
        let known = landed.scheme_history.exchanged.max(floor);
        if landed.drift.abs() <= tolerances::RAN_AWAY * known && landed.drift.is_finite() {
            return Ok(());
        }
        let size = three_digits(landed.drift.abs() / known);
        Err(self.ran_away(dt, format!("the energy that nothing explains has grown to {size} times all that there was and that came in")))
    }

    fn ran_away(&mut self, dt: f64, cause: String) -> Failure {
        let stable = self.stable_step().ok().map(|found| found.dt);
        Failure::Fatal(StepError::RanAway { time: self.state.row.time, dt, cause, stable })
    }
}

impl SchemeHistory {
    /// Stores forces for the start of the next step. `obstacles` is half the force of obstacles `[force]`.
    pub(super) fn keep(&mut self, scheme: &crate::integrators::Scheme, static_forces: &[f64], forces: PartForces, obstacles: &[f64]) {
        let left =
            |force: &[f64]| ForceHistory { left: force.iter().map(|force| scheme.lag.force * force).collect(), answered: Vec::new() };
        self.force = left(static_forces);
        self.outside = [left(&forces.load), left(&forces.ground)];
        if obstacles.iter().any(|force| *force != 0.0) {
            // Sign of internal forces: opposite to the motion that the forces drive.
            let ground = &mut self.outside[1].left;
            ground.resize(obstacles.len(), 0.0);
            ground.iter_mut().zip(obstacles).for_each(|(ground, obstacle)| *ground -= obstacle);
        }
    }
}
