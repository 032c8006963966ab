//! Backward Euler: forces and velocity at the end of the step. It dissipates energy of fast motion, and never adds energy to linear motion.

use super::derivative::Derivative;
use super::scheme::{Affine, Dissipation, Lag, LeadingError, Parameters, Promises, Scheme, StepKind};

/// The linear momentum exact; energy and angular momentum fade.
pub static BACKWARD_EULER: Scheme = Scheme {
    name: "backward_euler",
    summary: "backward Euler method, of first order: damps vibrations, the more the larger the step; keeps the linear momentum alone",
    derivative: Derivative::AT_END,
    remembers: &[],
    velocity: Affine { moved: 1.0, velocity: 0.0, acceleration: 0.0 },
    acceleration: Affine::NONE,
    weight: 1.0,
    lag: Lag::once(1.0),
    step: StepKind::Whole,
    dissipation: Dissipation::NONE,
    averages_stress: false,
    parameters: Parameters::NONE,
    promises: Promises { energy: false, momentum: true, angular_momentum: false, order: 1 },
    error: LeadingError { first: 0.5, second: 1.0 / 3.0 },
};
