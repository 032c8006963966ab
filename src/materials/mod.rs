//! Floor 1 of `ARCHITECTURE.md`: stored-energy laws on the Green-Lagrange strain; formulas only, one file each.
//!
//! A law is written once on [`Tensor`](crate::math::tensor::Tensor), for plane strain, a stretched third direction and space, or it is
//! an energy as text (`energy/`); [`BatchedLaw`] puts it behind a virtual call per batch of points. A new law is one file and one row of
//! [`CATALOGUE`].

mod arruda_boyce;
mod batched;
mod energy;
mod fit;
mod free_thickness;
mod gent;
mod hencky;
mod history;
mod holzapfel_gasser_ogden;
mod homogeneous;
mod law;
mod laws;
mod linear_elasticity;
mod material;
mod mean_value;
mod mooney_rivlin;
mod neo_hookean;
mod ogden;
mod plane_stress;
mod plasticity;
mod row;
mod saint_venant_kirchhoff;
mod soundness;
mod split;
mod viscosity;
mod volume;
mod yeoh;

pub use batched::{BatchedLaw, Components, IncrementResponse, Response};
pub use energy::{EnergyError, EnergyText, Jet, ScalarText, StoredEnergy, functions_of_energies, quantities_of_energies};
pub use fit::{Fit, FitError, Measured, fit, incompressible_stress};
pub use free_thickness::FreeThickness;
pub use history::{Heat, HistoryLaw, HistoryLaws, PointHistory, StrainStep, StressOf};
pub use homogeneous::{Homogeneous, HomogeneousTest, path};
pub use law::{Increment, Law};
pub use laws::Kinematics;
pub use linear_elasticity::LinearElasticity;
pub use material::{ELASTIC_PLASTIC, HYPERELASTIC, Material, MaterialError};
pub use mean_value::MeanValue;
pub use neo_hookean::NeoHookean;
pub use plane_stress::PlaneStress;
pub use plasticity::{BackStress, ElasticPlastic, Hardening, PlasticityError, RateDependence};
pub use row::{MaterialRow, VolumetricForm};
pub use saint_venant_kirchhoff::SaintVenantKirchhoff;
pub use soundness::Weakness;
pub use split::{Split, VolumetricLaw};
pub use viscosity::{Branch, Viscosity};

/// Laws of small displacements, in which rotations cause strain; not in [`CATALOGUE`], whose laws are invariant under rotations.
pub static LINEAR: &[MaterialRow] = &[linear_elasticity::ROW];

/// Catalogue of materials; laws with several forms have one row per form, the default first.
pub static CATALOGUE: &[MaterialRow] = &[
    neo_hookean::ROW,
    neo_hookean::POWER_ROW,
    saint_venant_kirchhoff::ROW,
    hencky::ROW,
    mooney_rivlin::ROW,
    yeoh::ROW,
    gent::ROW,
    arruda_boyce::ROW,
    ogden::ROW,
    holzapfel_gasser_ogden::ROW,
];
