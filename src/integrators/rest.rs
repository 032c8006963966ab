//! Statics as a scheme: constant time, damping in place of inertia, unchanged velocities.

use super::derivative::Derivative;
use super::scheme::{ConservedQuantities, Dissipation, LagWeights, LeadingError, Parameters, Scheme, StepKind, UpdateCoefficients};

/// Equilibrium by damped steps; not a time integrator, and not in the catalogue.
pub static REST: Scheme = Scheme {
    name: "rest",
    summary: "statics: forces in balance at the end of a damped step",
    derivative: Derivative::AT_END,
    remembers: &[],
    velocity: UpdateCoefficients { moved: 0.0, velocity: 1.0, acceleration: 0.0 },
    acceleration: UpdateCoefficients::NONE,
    weight: 0.5,
    lag: LagWeights::once(1.0),
    step: StepKind::Whole,
    dissipation: Dissipation::NONE,
    averages_stress: false,
    parameters: Parameters::NONE,
    promises: ConservedQuantities { energy: false, momentum: false, angular_momentum: false, order: 1 },
    error: LeadingError { first: 0.0, second: 0.0 },
};
