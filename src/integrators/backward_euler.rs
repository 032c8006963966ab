//! Backward Euler: forces and velocity at the end of the step. It dissipates energy of fast motion, and never adds energy to linear motion.

use super::derivative::Derivative;
use super::scheme::{ConservedQuantities, Dissipation, LagWeights, LeadingError, Parameters, Scheme, StepKind, UpdateCoefficients};

/// Backward Euler: conserves linear momentum exactly; energy and angular momentum decrease.
pub static BACKWARD_EULER: Scheme = Scheme {
    name: "backward_euler",
    summary: "backward Euler method, of first order: damps vibrations, the more the larger the step; conserves the linear momentum only",
    derivative: Derivative::AT_END,
    remembers: &[],
    velocity: UpdateCoefficients { moved: 1.0, velocity: 0.0, acceleration: 0.0 },
    acceleration: UpdateCoefficients::NONE,
    weight: 1.0,
    lag: LagWeights::once(1.0),
    step: StepKind::Whole,
    dissipation: Dissipation::NONE,
    averages_stress: false,
    parameters: Parameters::NONE,
    promises: ConservedQuantities { energy: false, momentum: true, angular_momentum: false, order: 1 },
    error: LeadingError { first: 0.5, second: 1.0 / 3.0 },
};
