//! Slip of a joint: the change of its free coordinate in a step, an angle or a displacement, as a tangential constraint.
//!
//! ```text
//! u = s(q_1) - s(q_0),    s = h phi or r.t        [length]
//! ```
//!
//! The gradient of `u` is the discrete gradient of `s` (`geared.rs`): a force `tau` along it does the work `tau u`, and has neither
//! resultant nor moment between two bodies. Each tangential constraint needs a normal constraint; for a joint this is a placeholder without
//! a function of the nodes, whose multiplier is set to the magnitude of the joint's reaction.

use super::geared::Geared;
use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use super::patches::{Evaluation, Patches};
use super::slip::SlipStep;
use super::surface::Sides;
use super::window::PredictedMotion;
use crate::integrators::{Configuration, Derivative};

/// Tangential constraint of the free coordinate of a joint.
pub struct JointSlip {
    coordinate: Geared,
}

impl JointSlip {
    /// Slip of one joint coordinate.
    pub fn new(coordinate: Geared) -> Self {
        JointSlip { coordinate }
    }
}

impl PatchFunctions for JointSlip {
    fn sides(&self) -> &Sides {
        self.coordinate.sides()
    }

    fn row_nodes(&self) -> &[u32] {
        &[]
    }

    fn slip_patches(&self) -> &Patches {
        self.coordinate.patches()
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.coordinate.begin_step(q_0);
    }

    fn start_gap(&self) -> Vec<f64> {
        vec![0.0]
    }

    fn evaluate(&self, _derivative: Derivative, _q_1: &[f64], _lambda: &[f64], out: &mut Evaluation) {
        out.prepare_without_force(self.patches());
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        let derivative = match step.test {
            Configuration::Middle => Derivative::DiscreteGradient,
            at => Derivative::Gradient(at),
        };
        self.coordinate.evaluate(derivative, step.q_1, lambda, out);
        out.gap[0] = self.coordinate.change(step.q_0, step.q_1);
    }

    fn gap(&self, _q: &[f64]) -> Vec<f64> {
        vec![0.0]
    }
}

impl CandidateSearch for JointSlip {
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        self.coordinate.update_candidates(predicted_motion)
    }
}

impl RigidObstacle for JointSlip {}
