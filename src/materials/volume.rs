//! Change of volume and cofactor of `C = I + 2 E`, from the strain without differences of near-equal numbers; purely volumetric energies.

use super::split::VolumetricLaw;
use crate::math::lanes::{Lanes, Real};
use crate::math::tensor::Tensor;

/// Change of the squared volume ratio, `det C - 1`.
#[inline(always)]
pub(super) fn growth<T: Tensor>(strain: &T) -> T::Scalar {
    let plane = strain.second_invariant().mul_add(T::Scalar::splat(4.0), strain.trace() * 2.0);
    if T::PLANE { plane } else { plane + strain.determinant() * 8.0 }
}

/// Cofactor `cof C = I + 2 (tr E I - E) + 4 cof E`.
#[inline(always)]
pub(super) fn cofactor_of_c<T: Tensor>(strain: &T) -> T {
    let plane = (*strain * -2.0).plus_identity(strain.trace() * 2.0 + 1.0);
    if T::PLANE { plane } else { plane + strain.cofactor() * 4.0 }
}

/// Volumetric energy `U(J) = lambda/2 (ln J)^2`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Logarithmic {
    /// Lame's first constant `[stress]`.
    pub(super) lambda: f64,
}

impl VolumetricLaw for Logarithmic {
    fn energies_into(&self, change: &[Lanes<false>], energy: &mut [Lanes<false>]) {
        for (change, energy) in change.iter().zip(energy) {
            let log = change.ln_1p();
            *energy = log * log * (0.5 * self.lambda);
        }
    }

    fn responses_into(&self, change: &[Lanes<false>], responses: &mut [[Lanes<false>; 2]]) {
        for (change, response) in change.iter().zip(responses) {
            let (log, inverse) = (change.ln_1p(), Lanes::splat(1.0) / (*change + 1.0));
            let slope = inverse * self.lambda;
            *response = [slope * log, slope * inverse * (-log + 1.0)];
        }
    }
}

/// Volumetric energy `U(J) = lambda/4 (J^2 - 1 - 2 ln J)` of laws with a bulk modulus (`VOLUMETRIC` in `row.rs`).
#[derive(Clone, Copy, Debug)]
pub(super) struct Power {
    /// Lame's first constant `[stress]`.
    pub(super) lambda: f64,
}

impl VolumetricLaw for Power {
    fn energies_into(&self, change: &[Lanes<false>], energy: &mut [Lanes<false>]) {
        for (&change, energy) in change.iter().zip(energy) {
            // J^2 - 1 - 2 ln J = c^2 + 2 (c - ln(1 + c)) of c = J - 1.
            *energy = (change * change + excess(change) * 2.0) * (0.25 * self.lambda);
        }
    }

    fn responses_into(&self, change: &[Lanes<false>], responses: &mut [[Lanes<false>; 2]]) {
        for (&change, response) in change.iter().zip(responses) {
            let inverse = Lanes::splat(1.0) / (change + 1.0);
            *response = [change * (change + 2.0) * inverse * (0.5 * self.lambda), (inverse * inverse + 1.0) * (0.5 * self.lambda)];
        }
    }
}

/// `x - ln(1 + x)` with relative accuracy.
#[inline(always)]
pub(super) fn excess<R: Real>(x: R) -> R {
    let y = x / (x + 2.0);
    x * y - y.atanh_excess() * 2.0
}
