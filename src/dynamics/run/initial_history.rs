//! History variables of a time integrator at a state that none of its own steps has reached: at the start, after `settle`, or after steps
//! of another integrator.

use std::sync::Arc;

use super::engine::Engine;
use crate::bodies::{Elements, Space};
use crate::contact::PredictedMotion;
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::iterate::Linearization;
use crate::dynamics::step::scheme_history::{ForceHistory, SchemeHistory};
use crate::dynamics::step::start::{StepKind, StepStart};
use crate::integrators::{Derivative, History};

/// Fraction of a step over which the acceleration of a prescribed node is differenced, so that a kink at the start does not count.
const SOON: f64 = 0.125;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Computes the history variables of the time integrator from the forces at the present state, including forces that depend on
    /// velocities.
    pub(super) fn remember(&mut self) -> Result<(), StepError> {
        let state = self.state.clone();
        if self.options.integrator.remembers.is_empty() {
            Arc::make_mut(&mut self.state).scheme_history = Arc::default();
            return Ok(());
        }
        if self.options.integrator.lumping().is_some() {
            return self.remember_explicit();
        }
        let undamped = vec![0.0; self.system.bodies.len()];
        let (q_0, u_0) = (&state.positions[..], &state.displacements[..]);
        let kind = StepKind::Rest { damping: &undamped, velocities: Some(&state.velocities) };
        let start = StepStart { time: state.row.time, q_0, u_0, memory: &state.memory, kind };
        self.system.equations.move_obstacles(state.row.time, 0.0)?;
        self.count_turns();
        let begun = self.system.begin_step(&PredictedMotion::within(&state.positions, 0.0)).map_err(Failure::Linear);
        let at = begun.and_then(|()| self.system.linearize(&start, q_0, &vec![0.0; q_0.len()], &state.lambda));
        let scheme_history = at.and_then(|at| self.memory_at(&start, &at).map(|memory| (at, memory)));
        let (at, scheme_history) = scheme_history.map_err(|failure| self.error_of(failure))?;
        Arc::make_mut(&mut self.state).scheme_history = Arc::new(scheme_history);
        self.system.recycle(at);
        Ok(())
    }

    /// History variables of the time integrator for the forces at an iterate at rest.
    fn memory_at(&mut self, start: &StepStart, at: &Linearization) -> Result<SchemeHistory, Failure> {
        let scheme = self.options.integrator;
        let (forces, mut scheme_history) = (&at.forces, SchemeHistory { of: scheme.describe(), ..SchemeHistory::default() });
        // Forces of unilateral contacts and of friction enter only their own step.
        let mut lagging: Vec<f64> = (0..at.q_1.len()).map(|k| forces.residual(k)).collect();
        self.system.alone_into(start, at, &mut lagging);
        let residual = |factor: f64| lagging.iter().map(|force| factor * force).collect();
        if scheme.remembers(History::Force) {
            scheme_history.force.left = residual(forces.whole(scheme.left()));
        }
        if scheme.remembers(History::Answered) {
            scheme_history.force.answered = residual(forces.whole(1.0));
        }
        let mut multipliers = at.lambda.clone();
        if scheme.remembers(History::Acceleration) {
            let given = self.prescribed_accelerations(at.q_1.len()).map_err(Failure::Fatal)?;
            let accelerations = self.system.accelerations(at, given)?;
            // The elimination order may have changed.
            Arc::make_mut(&mut self.state).search = self.system.search();
            scheme_history.force.left.iter_mut().zip(&accelerations.ties).for_each(|(force, tie)| *force -= scheme.left() * tie);
            scheme_history.force.answered.iter_mut().zip(&accelerations.ties).for_each(|(force, tie)| *force -= tie);
            scheme_history.acceleration = accelerations.nodes;
            multipliers.iter_mut().zip(&accelerations.lambda).for_each(|(sum, tie)| *sum += tie);
        }
        if scheme.remembers(History::Force) {
            let outside = self.outside_at(start, at, &multipliers).map_err(Failure::Fatal)?;
            scheme_history.outside = outside.map(|force| ForceHistory::steady(&scheme, &force));
        }
        Ok(scheme_history)
    }

    /// Loads, and forces of obstacles and of the ground, at an iterate at rest with the multipliers `lambda`.
    ///
    /// # Errors
    /// A time function failed.
    fn outside_at(&self, start: &StepStart, at: &Linearization, lambda: &[f64]) -> Result<[Vec<f64>; 2], StepError> {
        let (none, mut obstacles) = (vec![0.0; self.system.multipliers], vec![0.0; at.q_1.len()]);
        for pair in self.system.pairs.iter().filter(|pair| !pair.forces_stay_in_step()) {
            let rows = pair.rows.clone();
            pair.kernel.obstacle_force_into(Derivative::AT_END, &at.q_1, &none[rows.clone()], &lambda[rows], &mut obstacles);
        }
        if let Some([internal, _]) = self.system.outside_of(start, [start.q_0, start.u_0, &vec![0.0; start.q_0.len()]])? {
            obstacles.iter_mut().zip(internal).for_each(|(sum, force)| *sum -= force);
        }
        let whole = at.forces.whole(1.0);
        Ok([at.forces.load.iter().map(|load| whole * load).collect(), obstacles])
    }

    /// Accelerations of prescribed nodes from the present time on, 0 for all other unknowns.
    fn prescribed_accelerations(&self, unknowns: usize) -> Result<Vec<f64>, StepError> {
        let (supports, mut accelerations) = (&self.system.supports, vec![0.0; unknowns]);
        if !supports.prescribed.is_empty() {
            let (now, soon) = (self.state.row.time, SOON * self.options.dt);
            let (rates, later) = (supports.prescribed_motion(now + soon)?.1, supports.prescribed_motion(now + 2.0 * soon)?.1);
            for (prescribed, (rate, later)) in supports.prescribed.iter().zip(rates.iter().zip(later)) {
                accelerations[prescribed.unknown] = (later - rate) / soon;
            }
        }
        Ok(accelerations)
    }
}
