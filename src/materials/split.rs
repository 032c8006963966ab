//! Stored energy as the sum `W(E) = W_d(E) + U(J)`, for elements with a mean `J`.
//!
//! `W_d` is the remainder without `U`; it need not be free of pressure. `U` is evaluated from `J - 1`, accurate for small volume changes.

use std::sync::Arc;

use super::batched::BatchedLaw;
use crate::math::lanes::Lanes;

/// Energy `U(J)` of the volume ratio `J = det F`, evaluated by one virtual call per batch.
pub trait VolumetricLaw: Send + Sync {
    /// `U` for each `J - 1` `[energy/volume]`, with relative accuracy at small change.
    fn energies_into(&self, change: &[Lanes<false>], energy: &mut [Lanes<false>]);
    /// `U'` and `U''` for each `J - 1` `[stress]`.
    fn responses_into(&self, change: &[Lanes<false>], responses: &mut [[Lanes<false>; 2]]);
    /// True if `U''` may jump, so that no quadrature over a step is exact.
    fn has_kinks(&self) -> bool {
        false
    }
}

/// The two parts of an energy.
#[derive(Clone)]
pub struct Split {
    /// `W_d` in plane strain.
    pub plane: Arc<dyn BatchedLaw<3>>,
    /// `W_d` with a stretched, unsheared third direction.
    pub axisymmetric: Arc<dyn BatchedLaw<4>>,
    /// `W_d` in space.
    pub space: Arc<dyn BatchedLaw<6>>,
    /// Volumetric part `U` of the energy.
    pub volumetric: Arc<dyn VolumetricLaw>,
}
