//! Energies given as text at small strains.
//!
//! The terms of first order of an energy cancel, as in `I1 - 3 - 2 ln J`, and leave round-off of `1e-16/|E|` of the energy. Stresses are
//! accurate relative to their own size, so that below [`SMALL_STRAIN`] the energy and its change are integrals of the stress.

use crate::materials::batched::Components;
use crate::math::lanes::{Lanes, Real};
use crate::math::tolerances::SMALL_STRAIN;

/// Squares of strains; infinite for energies whose slope jumps at a small strain, to which no quadrature applies.
pub(super) struct Sizes<const N: usize>([Lanes<false>; N]);

impl<const N: usize> Sizes<N> {
    pub(super) fn of<const S: usize, const K: usize>(strains: [&[Components<S>; N]; K], has_kinks_near_rest: bool) -> Self {
        if has_kinks_near_rest {
            return Sizes([Lanes::splat(f64::INFINITY); N]);
        }
        let square =
            |n: usize| strains.map(|strains| work(&strains[n], &strains[n])).into_iter().fold(Lanes::ZERO, |sum, square| sum + square);
        Sizes(std::array::from_fn(square))
    }

    /// True if at least one strain is above the limit, or not a number.
    pub(super) fn has_large(&self) -> bool {
        self.0.iter().flat_map(|squares| squares.0).any(|square| square.is_nan() || square > SMALL_STRAIN * SMALL_STRAIN)
    }

    pub(super) fn has_small(&self) -> bool {
        self.0.iter().flat_map(|squares| squares.0).any(|square| square <= SMALL_STRAIN * SMALL_STRAIN)
    }

    /// Value for strains up to the limit, or that above it.
    pub(super) fn select(&self, n: usize, small: Lanes<false>, large: Lanes<false>) -> Lanes<false> {
        small + self.0[n].if_above(SMALL_STRAIN * SMALL_STRAIN, large - small)
    }
}

/// Sum of products of Mandel components: work of a stress along a strain.
pub(super) fn work<const S: usize>(stress: &Components<S>, strain: &Components<S>) -> Lanes<false> {
    stress.iter().zip(strain).fold(Lanes::ZERO, |sum, (stress, strain)| sum + *stress * *strain)
}

/// Mean of a function by Simpson's rule, from its values at start, middle and end.
pub(super) fn simpson([start, middle, end]: [Lanes<false>; 3]) -> Lanes<false> {
    (start + middle * 4.0 + end) * (1.0 / 6.0)
}
