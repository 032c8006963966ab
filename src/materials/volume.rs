//! Change of volume and cofactor of `C = I + 2 E`, from the strain without differences of near-equal numbers.

use crate::math::lanes::Real;
use crate::math::tensor::Tensor;

/// `det C - 1`.
#[inline(always)]
pub(super) fn growth<T: Tensor>(strain: &T) -> T::Scalar {
    let plane = strain.second_invariant().mul_add(T::Scalar::splat(4.0), strain.trace() * 2.0);
    if T::PLANE { plane } else { plane + strain.determinant() * 8.0 }
}

/// `cof C = I + 2 (tr E I - E) + 4 cof E`.
#[inline(always)]
pub(super) fn cofactor_of_c<T: Tensor>(strain: &T) -> T {
    let plane = (*strain * -2.0).plus_identity(strain.trace() * 2.0 + 1.0);
    if T::PLANE { plane } else { plane + strain.cofactor() * 4.0 }
}
