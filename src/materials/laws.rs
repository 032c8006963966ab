//! Laws of one material as called by the element loop, and their strain measure.

use std::sync::Arc;

use super::batched::BatchedLaw;
use super::law::Law;
use super::split::{Split, VolumetricLaw};

/// Laws of one material as called by the element loop: plane strain, stretched third direction, space.
#[derive(Clone)]
pub(crate) struct Laws {
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

    /// Returns the laws with their split into `W_d` (`rest`) and `U(J)` (`volumetric`).
    pub(super) fn split_into<L: Law + Clone, U: VolumetricLaw + 'static>(self, rest: L, volumetric: U) -> Self {
        let Laws { plane, axisymmetric, space, .. } = Laws::new(rest);
        Laws { split: Some(Split { plane, axisymmetric, space, volumetric: Arc::new(volumetric) }), ..self }
    }
}

/// Strain measure of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kinematics {
    /// Green-Lagrange strain `E = (F^T F - I)/2`; stresses are of the second Piola-Kirchhoff kind.
    GreenLagrange,
    /// Strain `sym(grad u)` of small displacements; equilibrium is written in the undeformed state. Not invariant under rotations.
    Linear,
}
