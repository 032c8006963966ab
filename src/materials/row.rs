//! How a law describes itself: a row of the catalogue, and the constants that isotropic laws share.

use std::sync::Arc;

use super::batched::BatchedLaw;
use super::law::Law;
use super::split::{Split, VolumetricLaw};
use crate::math::catalogue::{Interval, Parameter};

/// A row of the catalogue of materials.
pub struct MaterialRow {
    /// Name as written in a script.
    pub name: &'static str,
    /// One sentence: what it is and where it holds.
    pub summary: &'static str,
    /// The formula and its source, for the reference.
    pub formula: &'static str,
    /// Parameters in the order in which [`super::Material::new`] takes their values; the density is the last.
    pub parameters: &'static [Parameter],
    /// Makes the law from the values of the parameters.
    pub(super) construct: fn(&[f64]) -> Laws,
}

impl std::fmt::Debug for MaterialRow {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}", self.name)
    }
}

pub(super) const YOUNGS_MODULUS: Parameter = Parameter {
    name: "youngs_modulus",
    summary: "Young's modulus at zero strain",
    dimension: "stress",
    range: Interval::Positive,
    default: None,
};
pub(super) const POISSON_RATIO: Parameter = Parameter {
    name: "poisson_ratio",
    summary: "Poisson's ratio at zero strain",
    dimension: "1",
    range: Interval::Open(-1.0, 0.5),
    default: None,
};
pub(super) const DENSITY: Parameter = Parameter {
    name: "density",
    summary: "mass per undeformed volume",
    dimension: "mass/volume",
    range: Interval::Positive,
    default: None,
};

/// Lame's constants `(lambda, mu)` from Young's modulus and Poisson's ratio.
pub(super) fn lame(youngs_modulus: f64, poisson_ratio: f64) -> (f64, f64) {
    let mu = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
    (2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio), mu)
}

/// One law as the kernels call it, in the plane, with a stretched third direction, and in space.
#[derive(Clone)]
pub(super) struct Laws {
    pub(super) plane: Arc<dyn BatchedLaw<3>>,
    pub(super) axisymmetric: Arc<dyn BatchedLaw<4>>,
    pub(super) space: Arc<dyn BatchedLaw<6>>,
    pub(super) split: Option<Split>,
    pub(super) kinematics: Kinematics,
}

impl Laws {
    pub(super) fn new<L: Law + Clone>(law: L) -> Self {
        Laws {
            plane: Arc::new(law.clone()),
            axisymmetric: Arc::new(law.clone()),
            space: Arc::new(law),
            split: None,
            kinematics: Kinematics::GreenLagrange,
        }
    }

    /// The same with its two parts, the rest `W_d` and `U(J)`.
    pub(super) fn split_into<L: Law + Clone, U: VolumetricLaw + 'static>(self, rest: L, volumetric: U) -> Self {
        let Laws { plane, axisymmetric, space, .. } = Laws::new(rest);
        Laws { split: Some(Split { plane, axisymmetric, space, volumetric: Arc::new(volumetric) }), ..self }
    }
}

/// The strain that a law takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kinematics {
    /// Green-Lagrange strain `E = (F^T F - I)/2`; stresses are of the second Piola-Kirchhoff kind.
    GreenLagrange,
    /// Strain `sym(grad u)` of small displacements; equilibrium is written in the undeformed state. Not invariant under rotations.
    Linear,
}
