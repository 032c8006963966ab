//! Interface of stored-energy laws: energy, stress, tangent, and the increment response for a discrete gradient.

use crate::math::lanes::Real;
use crate::math::tensor::Tensor;
use crate::math::tolerances::STRAIN_QUOTIENT;

/// A stored-energy function `W(E)` of the Green-Lagrange strain, per reference volume `[energy/volume]`.
pub trait Law: Send + Sync + 'static {
    /// `W(E)`, with relative accuracy at small strain.
    fn energy<T: Tensor>(&self, strain: &T) -> T::Scalar;
    /// Second Piola-Kirchhoff stress `S = dW/dE` `[stress]`.
    fn stress<T: Tensor>(&self, strain: &T) -> T;
    /// Stress and tangent `d2W/dE2` `[stress]`.
    fn stress_tangent<T: Tensor>(&self, strain: &T) -> (T, T::Tangent);
    /// `W(E1) - W(E0) - S((E0 + E1)/2):(E1 - E0)`, without cancellation.
    ///
    /// The default is a five-point Lobatto rule for the line integral of `S - S_mid` below `|dE| = 5e-3` and the plain difference above.
    /// One decision for all lanes of a batch, by its largest increment.
    #[inline(always)]
    fn remainder<T: Tensor>(&self, strain_n: &T, strain_n1: &T) -> T::Scalar {
        let (mid, d) = ((*strain_n + *strain_n1) * 0.5, *strain_n1 - *strain_n);
        let stress_mid = self.stress(&mid);
        let difference = self.energy(strain_n1) - self.energy(strain_n) - stress_mid.dot(&d);
        let slope = |s: f64| (self.stress(&(mid + d * s)) - stress_mid).dot(&d);
        let s = lobatto_place();
        let line = lobatto([slope(-0.5), slope(-s), slope(s), slope(0.5)]);
        let square = d.dot(&d);
        let limit = STRAIN_QUOTIENT * STRAIN_QUOTIENT;
        line + square.if_above(limit, difference - line)
    }
    /// Returns the increment response for a discrete gradient; laws override this if values can be shared.
    #[inline(always)]
    fn increment<T: Tensor>(&self, strain_n: &T, strain_n1: &T) -> Increment<T> {
        let (stress, tangent) = self.stress_tangent(&((*strain_n + *strain_n1) * 0.5));
        Increment { stress, tangent, stress_end: self.stress(strain_n1), remainder: self.remainder(strain_n, strain_n1) }
    }
}

/// Positive inner point of the five-point Lobatto rule on [-1/2, 1/2]; the other inner points are 0 and its negative.
#[inline(always)]
pub(super) fn lobatto_place() -> f64 {
    0.5 * (3.0f64 / 7.0).sqrt()
}

/// Five-point Lobatto integral of a function that vanishes in the middle, from its values at start, inner points and end.
#[inline(always)]
pub(super) fn lobatto<R: Real>([start, before, after, end]: [R; 4]) -> R {
    (start + end) * 0.05 + (before + after) * (49.0 / 180.0)
}

/// Response of a law to a strain increment, for a discrete gradient.
#[derive(Clone, Copy, Debug)]
pub struct Increment<T: Tensor> {
    /// Stress at the mean of the two strains `[stress]`.
    pub stress: T,
    /// Tangent at the mean of the two strains `[stress]`.
    pub tangent: T::Tangent,
    /// Stress at the end `[stress]`.
    pub stress_end: T,
    /// Remainder of the discrete gradient, see [`Law::remainder`].
    pub remainder: T::Scalar,
}
