//! Laws of friction: how large the shear stress between two surfaces is. One file each.

mod coulomb;
mod law;

pub use coulomb::{Coulomb, ROUGH};
pub use law::{FrictionLaw, Limit, Sliding};
