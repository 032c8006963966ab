//! Floor 3: how a potential is differentiated across a step, and the time integrators; one file and one row of [`CATALOGUE`] each.
//!
//! A [`Scheme`] is data. Element loop and contact kernels are told its [`Derivative`], a step reads its coefficients and what it remembers,
//! tests read its promises. Functions of quadratic invariants have the [`discrete_gradient`]; functions of the positions of a patch without
//! such invariants have one of their own ([`Projection`]).

mod backward_euler;
mod derivative;
mod discrete_gradient;
mod energy_momentum;
mod midpoint;
mod newmark;
mod projected;
mod rest;
mod scheme;
mod trapezoidal;

pub use backward_euler::BACKWARD_EULER;
pub use derivative::{Configuration, Derivative, Placement};
pub use discrete_gradient::discrete_gradient;
pub use energy_momentum::ENERGY_MOMENTUM;
pub use midpoint::MIDPOINT;
pub use newmark::NEWMARK;
pub use projected::{PatchFunction, Projection};
pub use rest::REST;
pub use scheme::{Affine, History, Promises, Scheme};
pub use trapezoidal::TRAPEZOIDAL;

/// All time integrators, in the order of the reference.
pub static CATALOGUE: &[&Scheme] = &[&ENERGY_MOMENTUM, &MIDPOINT, &TRAPEZOIDAL, &BACKWARD_EULER, &NEWMARK];
