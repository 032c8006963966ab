//! Energy-momentum scheme: discrete gradients, and velocities whose mean moves the positions (Hesch and Betsch, PAMM 2007; Simo and Tarnow,
//! ZAMP 43, 1992; Gonzalez, CMAME 190, 2000).

use super::derivative::Derivative;
use super::scheme::{ConservedQuantities, Dissipation, LagWeights, LeadingError, Parameters, Scheme, StepKind, UpdateCoefficients};

/// Energy-momentum scheme: conserves energy, linear and angular momentum exactly.
pub static ENERGY_MOMENTUM: Scheme = ROW;

/// Row of the energy-momentum scheme as a value, from which variants are made.
pub(super) const ROW: Scheme = Scheme {
    name: "energy_momentum",
    summary: "energy-momentum scheme: discrete gradients conserve energy, linear and angular momentum exactly, for every step size",
    derivative: Derivative::DiscreteGradient,
    remembers: &[],
    velocity: UpdateCoefficients { moved: 2.0, velocity: -1.0, acceleration: 0.0 },
    acceleration: UpdateCoefficients::NONE,
    weight: 1.0,
    lag: LagWeights::once(1.0),
    step: StepKind::Whole,
    dissipation: Dissipation::NONE,
    averages_stress: false,
    parameters: Parameters::NONE,
    promises: ConservedQuantities { energy: true, momentum: true, angular_momentum: true, order: 2 },
    error: LeadingError::TRAPEZOIDAL,
};
