//! Trapezoidal rule: the mean of the forces at both ends, which is Newmark's method with beta = 1/4, gamma = 1/2 (Newmark, J. Eng. Mech.
//! Div. ASCE 85, 1959).

use super::derivative::{Configuration, Derivative};
use super::scheme::{
    ConservedQuantities, Dissipation, History, LagWeights, LeadingError, Parameters, Scheme, StepKind, UpdateCoefficients,
};

/// Trapezoidal rule: conserves linear momentum exactly, energy and angular momentum in small motions only.
pub static TRAPEZOIDAL: Scheme = Scheme {
    name: "trapezoidal",
    summary: "trapezoidal rule (Newmark, beta = 1/4, gamma = 1/2): keeps neither the energy nor the angular momentum in large motions",
    derivative: Derivative::Gradient(Configuration::End),
    remembers: &[History::Force],
    velocity: UpdateCoefficients { moved: 2.0, velocity: -1.0, acceleration: 0.0 },
    acceleration: UpdateCoefficients::NONE,
    weight: 0.5,
    lag: LagWeights::once(0.5),
    step: StepKind::Whole,
    dissipation: Dissipation::NONE,
    averages_stress: false,
    parameters: Parameters::NONE,
    promises: ConservedQuantities { energy: false, momentum: true, angular_momentum: false, order: 2 },
    error: LeadingError::TRAPEZOIDAL,
};
