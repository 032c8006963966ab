//! Trapezoidal rule: the mean of the forces at both ends, which is Newmark's method with beta = 1/4, gamma = 1/2 (Newmark, J. Eng. Mech.
//! Div. ASCE 85, 1959).

use super::derivative::{Configuration, Derivative};
use super::scheme::{Affine, Dissipation, History, Lag, LeadingError, Parameters, Promises, Scheme, StepKind};

/// Trapezoidal rule: conserves linear momentum exactly, energy and angular momentum in small motions only.
pub static TRAPEZOIDAL: Scheme = Scheme {
    name: "trapezoidal",
    summary: "trapezoidal rule (Newmark, beta = 1/4, gamma = 1/2): keeps neither the energy nor the angular momentum in large motions",
    derivative: Derivative::Gradient(Configuration::End),
    remembers: &[History::Force],
    velocity: Affine { moved: 2.0, velocity: -1.0, acceleration: 0.0 },
    acceleration: Affine::NONE,
    weight: 0.5,
    lag: Lag::once(0.5),
    step: StepKind::Whole,
    dissipation: Dissipation::NONE,
    averages_stress: false,
    parameters: Parameters::NONE,
    promises: Promises { energy: false, momentum: true, angular_momentum: false, order: 2 },
    error: LeadingError::TRAPEZOIDAL,
};
