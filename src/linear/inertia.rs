//! Number of negative eigenvalues of a symmetric matrix, from its factors.
//!
//! Fronts of a symmetric matrix are symmetric for any exchange of pivots, so the inertia of the matrix is the sum over the pivot blocks
//! (Haynsworth, Linear Algebra Appl. 1, 1968). The inertia of a block without row exchanges follows from the signs of its pivots
//! (Sylvester); a block with row exchanges is reassembled from its factors.

use nalgebra::DMatrix;

use super::multifrontal::Multifrontal;
use super::symbolic::Symbolic;

impl Multifrontal {
    /// Number of negative eigenvalues of the last matrix, which must be symmetric; `None` if pivots were replaced.
    pub(super) fn negative_eigenvalues(&self, symbolic: &Symbolic) -> Option<usize> {
        if !self.replaced().is_empty() {
            return None;
        }
        let (mut factors, mut swaps) = self.factors();
        let mut count = 0;
        for front in &symbolic.fronts {
            let (own, rest) = factors.split_at(front.length());
            let (exchanged, others) = swaps.split_at(front.pivots);
            (factors, swaps) = (rest, others);
            let is_in_place = exchanged.iter().enumerate().all(|(k, &row)| row as usize == k);
            count += if is_in_place {
                (0..front.pivots).filter(|k| own[k * front.p + k] < 0.0).count()
            } else {
                negative_of_block(own, front.p, exchanged)
            };
        }
        Some(count)
    }
}

/// Number of negative eigenvalues of a pivot block factored with row exchanges.
fn negative_of_block(factors: &[f64], p: usize, exchanged: &[u32]) -> usize {
    let size = exchanged.len();
    let lower = DMatrix::from_fn(size, size, |i, k| match i.cmp(&k) {
        std::cmp::Ordering::Less => 0.0,
        std::cmp::Ordering::Equal => 1.0,
        std::cmp::Ordering::Greater => factors[k * p + i],
    });
    // The factors contain the reciprocals of the pivots.
    let upper = DMatrix::from_fn(size, size, |i, k| match i.cmp(&k) {
        std::cmp::Ordering::Less => factors[k * p + i],
        std::cmp::Ordering::Equal => 1.0 / factors[k * p + i],
        std::cmp::Ordering::Greater => 0.0,
    });
    let mut block = lower * upper;
    for (k, &row) in exchanged.iter().enumerate().rev() {
        block.swap_rows(k, row as usize);
    }
    let symmetric = 0.5 * (&block + block.transpose());
    symmetric.symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count()
}
