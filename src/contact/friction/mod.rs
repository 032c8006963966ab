//! Laws of friction: how large the shear stress between two surfaces is. One file each.

mod coulomb;
mod curve;
mod law;

pub use coulomb::{Coulomb, ROUGH};
pub use curve::FrictionCurve;
pub use law::{FrictionLaw, Limit, Sliding};
