//! Floor 1: stored-energy laws on the Green-Lagrange strain; formulas only, one file each.
//!
//! A law is written once on [`Tensor`](crate::math::tensor::Tensor), for plane strain, a stretched third direction and space; [`BatchedLaw`] puts it behind a
//! virtual call per batch of points. A new law is one file and one row of [`CATALOGUE`].

mod batched;
mod law;
mod linear_elasticity;
mod material;
mod neo_hookean;
mod row;
mod saint_venant_kirchhoff;
mod split;
#[cfg(test)]
mod tests;

pub use batched::{BatchedLaw, Components, IncrementResponse, Response};
pub use law::{Increment, Law};
pub use linear_elasticity::LinearElasticity;
pub use material::{Material, MaterialError};
pub use neo_hookean::NeoHookean;
pub use row::{Kinematics, MaterialRow};
pub use saint_venant_kirchhoff::SaintVenantKirchhoff;
pub use split::{Split, VolumetricLaw};

/// The catalogue of materials.
pub static CATALOGUE: &[MaterialRow] = &[neo_hookean::ROW, saint_venant_kirchhoff::ROW];
