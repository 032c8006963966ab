//! Implicit midpoint rule: the forces of the mean configuration. Its energy may grow without bound in stiff, large motions.

use super::derivative::{Configuration, Derivative};
use super::scheme::{ConservedQuantities, Dissipation, LagWeights, LeadingError, Parameters, Scheme, StepKind, UpdateCoefficients};

/// Midpoint rule: conserves linear and angular momentum exactly, but not energy.
pub static MIDPOINT: Scheme = Scheme {
    name: "midpoint",
    summary: "implicit midpoint rule: conserves linear and angular momentum, but not the energy",
    derivative: Derivative::Gradient(Configuration::Middle),
    remembers: &[],
    velocity: UpdateCoefficients { moved: 2.0, velocity: -1.0, acceleration: 0.0 },
    acceleration: UpdateCoefficients::NONE,
    weight: 1.0,
    lag: LagWeights::once(1.0),
    step: StepKind::Whole,
    dissipation: Dissipation::NONE,
    averages_stress: false,
    parameters: Parameters::NONE,
    promises: ConservedQuantities { energy: false, momentum: true, angular_momentum: true, order: 2 },
    error: LeadingError::TRAPEZOIDAL,
};
