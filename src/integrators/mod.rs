//! Floor 2 of `ARCHITECTURE.md`: algorithmic gradients of potentials across a step, and the time integrators; one file and one row of
//! [`CATALOGUE`] each.
//!
//! A [`Scheme`] is data. Element loop and contact kernels receive its [`Derivative`], a step reads its coefficients and history variables,
//! tests read its promises. Functions of quadratic invariants have the [`discrete_gradient`]; functions of the positions of a contact
//! element without such invariants have a projected one ([`Projection`]).

mod backward_euler;
mod bdf2;
mod central_differences;
mod derivative;
mod discrete_gradient;
mod energy_decaying;
mod energy_momentum;
mod family;
mod generalized_alpha;
mod mean_value;
mod midpoint;
mod newmark;
mod projected;
mod rest;
mod scheme;
mod statics;
mod trapezoidal;
mod triple_jump;

pub use backward_euler::BACKWARD_EULER;
pub use bdf2::{BDF2, TR_BDF2};
pub use central_differences::{CENTRAL_DIFFERENCES, central_differences};
pub use derivative::{Configuration, Derivative, Placement};
pub use discrete_gradient::{LEAST_SQUARE, discrete_gradient};
pub use energy_decaying::{ENERGY_DECAYING, energy_decaying};
pub use energy_momentum::ENERGY_MOMENTUM;
pub use family::Family;
pub use generalized_alpha::{GENERALIZED_ALPHA, HHT, WBZ, generalized_alpha, hht, wbz};
pub use mean_value::MEAN_VALUE;
pub use midpoint::MIDPOINT;
pub use newmark::{NEWMARK, newmark};
pub use projected::{PatchFunction, Projection};
pub use rest::REST;
pub use scheme::{
    ConservedQuantities, Dissipation, History, LagWeights, LeadingError, Lumping, Parameters, Scheme, StepKind, UpdateCoefficients,
};
pub use statics::STATICS;
pub use trapezoidal::TRAPEZOIDAL;
pub use triple_jump::TRIPLE_JUMP;

/// All time integrators that solve equations, in the order of the reference: their steps may have any size.
pub static CATALOGUE: &[&Scheme] = &[
    &ENERGY_MOMENTUM,
    &MEAN_VALUE,
    &ENERGY_DECAYING,
    &MIDPOINT,
    &TRAPEZOIDAL,
    &BACKWARD_EULER,
    &NEWMARK,
    &HHT,
    &WBZ,
    &GENERALIZED_ALPHA,
    &BDF2,
    &TR_BDF2,
    &TRIPLE_JUMP,
];

/// Explicit time integrators, whose steps solve no equations.
pub static EXPLICIT: &[&Scheme] = &[&CENTRAL_DIFFERENCES];

/// Schemes without inertia.
pub static STATIC: &[&Scheme] = &[&STATICS];

/// Families of the catalogue: schemes with parameters.
pub static FAMILIES: &[&Family] = &[
    &energy_decaying::FAMILY,
    &newmark::FAMILY,
    &generalized_alpha::HHT_FAMILY,
    &generalized_alpha::WBZ_FAMILY,
    &generalized_alpha::GENERALIZED_ALPHA_FAMILY,
];
