//! Friction laws, one file each: largest shear stress as a function of pressure and slip speed.

mod coulomb;
mod curve;
mod law;

pub use coulomb::{Coulomb, ROUGH};
pub use curve::FrictionCurve;
pub use law::{FrictionLaw, Limit, SlipState};
