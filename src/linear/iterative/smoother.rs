//! Smoother: Chebyshev polynomials of the matrix scaled by its diagonal blocks.
//!
//! Unlike Gauss-Seidel it consists of matrix-vector products only, so that its result does not depend on the number of threads (Adams,
//! Brezina, Hu and Tuminaro, J. Comput. Phys. 188, 2003).

use super::blocks::{Block, BlockMatrix, TOGETHER, inverse, times};
use crate::math::workers::Workers;

/// Degree of the polynomial.
const DEGREE: usize = 2;

/// Ratio of the largest to the smallest eigenvalue that the smoother damps; coarse levels reduce error components with smaller eigenvalues.
const RATIO: f64 = 10.0;

/// Number of power iterations for the largest eigenvalue.
const POWERS: usize = 12;
/// Factor that compensates the underestimation of the largest eigenvalue by power iterations.
const SAFETY: f64 = 1.1;

/// Number of terms of a sum that one thread adds.
const PART: usize = 4096;

/// Initial vector of a smoothing.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum InitialGuess {
    /// Zero vector, whose residual is the right-hand side.
    Zero,
    /// Approximate solution.
    Solution,
}

/// Smoother of one level.
pub(super) struct Smoother<const N: usize> {
    /// Inverse diagonal blocks `D^-1`, zero for rows that are not smoothed.
    pub inverse: Vec<Block<N, N>>,
    /// Largest eigenvalue of `D^-1 A`, estimated.
    pub largest: f64,
}

impl<const N: usize> Smoother<N> {
    /// Smoother of the leading `free` rows of a matrix; the others are left as they are.
    pub fn new(matrix: &BlockMatrix<N, N>, free: usize, workers: &Workers) -> Self {
        let row = |i: usize| if i < free { inverse(&matrix.diagonal(i)) } else { [[0.0; N]; N] };
        let inverse: Vec<Block<N, N>> = (0..matrix.rows()).map(row).collect();
        let mut smoother = Smoother { inverse, largest: 1.0 };
        let rows = matrix.rows();
        let zero = vec![[0.0; N]; rows];
        // Initial vector with components in all directions.
        let mut x: Vec<[f64; N]> = (0..rows).map(|i| std::array::from_fn(|k| 0.5 + ((N * i + k) as f64 * 1.7).sin())).collect();
        let mut image = zero.clone();
        for _ in 0..POWERS {
            let length = dot(&x, &x, workers).sqrt();
            if length == 0.0 || !length.is_finite() {
                break;
            }
            x.iter_mut().flatten().for_each(|x| *x /= length);
            matrix.multiply(1.0, &x, &zero, &mut image, workers);
            smoother.scale(&mut image, workers);
            smoother.largest = dot(&image, &image, workers).sqrt();
            std::mem::swap(&mut x, &mut image);
        }
        smoother.largest *= SAFETY;
        smoother
    }

    /// `x := D^-1 x`.
    pub fn scale(&self, x: &mut [[f64; N]], workers: &Workers) {
        let mut parts: Vec<&mut [[f64; N]]> = x.chunks_mut(TOGETHER).collect();
        workers.for_each(&mut parts, 1, |part, x| {
            x.iter_mut().zip(&self.inverse[part * TOGETHER..]).for_each(|(x, inverse)| *x = times(inverse, x));
        });
    }

    /// Smooths the approximate solution `x` for the right-hand side `b`; with [`InitialGuess::Zero`], `x` is zero. `r` and `d` are scratch
    /// vectors.
    pub fn smooth(
        &self,
        matrix: &BlockMatrix<N, N>,
        b: &[[f64; N]],
        x: &mut [[f64; N]],
        [r, d]: [&mut Vec<[f64; N]>; 2],
        start: InitialGuess,
        workers: &Workers,
    ) {
        let (middle, half) = (0.5 * self.largest * (1.0 + 1.0 / RATIO), 0.5 * self.largest * (1.0 - 1.0 / RATIO));
        let sigma = middle / half;
        let mut rho = 1.0 / sigma;
        for step in 0..DEGREE {
            if step == 0 && start == InitialGuess::Zero {
                r.copy_from_slice(b);
            } else {
                matrix.multiply(-1.0, x, b, r, workers);
            }
            let (keep, take) = if step == 0 {
                (0.0, 1.0 / middle)
            } else {
                let next = 1.0 / (2.0 * sigma - rho);
                let factors = (next * rho, 2.0 * next / half);
                rho = next;
                factors
            };
            let mut parts: Vec<_> = x.chunks_mut(TOGETHER).zip(d.chunks_mut(TOGETHER)).zip(r.chunks(TOGETHER)).collect();
            workers.for_each(&mut parts, 1, |part, ((x, d), r)| {
                for (k, inverse) in self.inverse[part * TOGETHER..].iter().take(x.len()).enumerate() {
                    let scaled = times(inverse, &r[k]);
                    for i in 0..N {
                        d[k][i] = keep * d[k][i] + take * scaled[i];
                        x[k][i] += d[k][i];
                    }
                }
            });
        }
    }
}

/// Scalar product by partial sums of fixed length, so that the result does not depend on the number of threads.
pub(super) fn dot<const N: usize>(x: &[[f64; N]], y: &[[f64; N]], workers: &Workers) -> f64 {
    let mut sums = vec![0.0; x.len().div_ceil(PART)];
    workers.for_each(&mut sums, 1, |part, sum| {
        let range = part * PART..(part * PART + PART).min(x.len());
        *sum = x[range.clone()].iter().flatten().zip(y[range].iter().flatten()).map(|(x, y)| x * y).sum();
    });
    sums.iter().sum()
}
