//! Statics as an integrator: a step leads to the equilibrium at its end, as `settle` does; time is the parameter of the loads.

use super::backward_euler::BACKWARD_EULER;
use super::scheme::{ConservedQuantities, LeadingError, Scheme, StepKind};

/// Statics: equilibria along the loads. The coefficients are those of backward Euler and are unused.
pub static STATICS: Scheme = Scheme {
    name: "statics",
    summary: "statics, each step to the equilibrium at its end, without inertia; loads, prescribed motions and obstacles follow their \
              functions of time, and friction depends on this path; viscosity, dampers and drag have no effect",
    step: StepKind::Equilibria,
    promises: ConservedQuantities { energy: false, momentum: false, angular_momentum: false, order: 1 },
    error: LeadingError { first: 0.0, second: 0.0 },
    ..BACKWARD_EULER
};
