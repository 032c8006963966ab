//! Static step to the equilibrium at its end, with its row of the ledger.
//!
//! Works follow the trapezoidal rule: the mean of the forces at both ends times the displacement. This is exact for proportional load and
//! displacement; the error, the `energy_defect` of the row, decreases with the square of the step. In a jump to a distant equilibrium it is
//! the released energy.

use std::sync::Arc;

use super::engine::Engine;
use super::state::State;
use crate::bodies::{Elements, Space};
use crate::contact::{MotionBound, PredictedMotion};
use crate::dynamics::parts::contact_pair::PairKind;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::start::{StepKind, StepStart};

/// Nodal forces in an equilibrium `[force]`.
struct Balanced {
    /// Loads, and reactions of moving supports.
    outside: Vec<f64>,
    /// Contact forces, including those of ties and joints.
    contact: Vec<f64>,
    /// Contact forces between bodies.
    between: Vec<f64>,
    /// Energy stored by penalties `[energy]`.
    kept: f64,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// State in the equilibrium at the end of a static step, found by [`Self::settle_at`].
    pub(super) fn static_piece(&mut self, dt: f64) -> Result<State, Failure> {
        let before = self.state.clone();
        let begun = self.balanced()?;
        Arc::make_mut(&mut self.state).velocities.fill(0.0);
        let settled = self.settle_at(before.row.time + dt).map_err(Failure::Fatal).and_then(|_| self.balanced());
        let reached = std::mem::replace(&mut self.state, before.clone());
        let ended = match settled {
            Ok(ended) => ended,
            Err(failure) => {
                self.restore_search();
                return Err(failure);
            }
        };
        let mut state = Arc::unwrap_or_clone(reached);
        let moved: Vec<f64> = state.displacements.iter().zip(&before.displacements).map(|(now, then)| now - then).collect();
        let work = |forces: fn(&Balanced) -> &Vec<f64>| -> f64 {
            let ends = forces(&begun).iter().zip(forces(&ended));
            ends.zip(&moved).map(|((first, last), moved)| 0.5 * (first + last) * moved).sum()
        };
        // Velocities are zero in an equilibrium, also those of prescribed motions.
        state.velocities.fill(0.0);
        let row = &mut state.row;
        row.dt = dt;
        row.kinetic = 0.0;
        row.contact_work = work(|forces| &forces.between) + 0.0;
        // Work of obstacles and drives: work of all contact forces less contact work and friction work, plus the change of the penalty
        // energy.
        let driven = work(|forces| &forces.contact) - row.contact_work - row.friction_work + (ended.kept - begun.kept);
        row.load_work = work(|forces| &forces.outside) + driven + 0.0;
        row.energy_defect = row.total() - before.row.total() - row.load_work - row.contact_work - row.friction_work + row.dissipation;
        state.drift = before.drift + state.row.energy_defect;
        state.loads_ended = state.row.time;
        Ok(state)
    }

    /// Forces at the present state, which is at rest.
    fn balanced(&mut self) -> Result<Balanced, Failure> {
        let state = self.state.clone();
        let still = vec![0.0; self.system.nodes.count()];
        let motion_bound = MotionBound::Each { sizes: &still, besides: 0.0, is_continued: false };
        let predicted_motion = PredictedMotion { q: &state.positions, motion_bound, reach: self.options.reach, depth: 0.0 };
        self.begin_at_rest(&predicted_motion, &[]).map_err(Failure::Fatal)?;
        let undamped = vec![0.0; self.system.bodies.len()];
        let kind = StepKind::Rest { damping: &undamped, velocities: None };
        let (q_0, u_0) = (&state.positions[..], &state.displacements[..]);
        let start = StepStart { time: state.row.time, q_0, u_0, memory: &state.memory, kind };
        let at = self.system.linearize(&start, q_0, &vec![0.0; q_0.len()], &state.lambda)?;
        let forces = &at.forces;
        let whole = |forces_of: &[f64]| -> Vec<f64> { forces_of.iter().map(|force| forces.whole(*force)).collect() };
        let mut outside = whole(&forces.load);
        for one in &self.system.supports.prescribed {
            outside[one.unknown] += forces.whole(forces.residual(one.unknown));
        }
        let between = self.system.pressed(&at.pairs, &state.lambda, |pair| pair.kind == PairKind::Surfaces && pair.has_multipliers());
        let kept = self.system.penalty_energy(&state.penalty_gap);
        let balanced = Balanced { outside, contact: whole(&forces.contact), between, kept };
        self.system.recycle(at);
        Ok(balanced)
    }
}
