//! GMRES with right preconditioning (Saad and Schultz 1986), restarted from the true residual.

use crate::math::workers::Workers;

/// Number of basis vectors between restarts.
pub(super) const RESTART: usize = 50;

/// Number of terms of a sum that one thread adds.
const PART: usize = 8192;

/// Linear system of an iteration: products with the matrix, and the preconditioner.
pub(super) trait System {
    /// `y := A x`.
    fn multiply(&mut self, x: &[f64], y: &mut [f64]);

    /// `y := M^-1 x`.
    fn precondition(&mut self, x: &[f64], y: &mut [f64]);

    /// True if the iteration was interrupted by the user.
    fn is_interrupted(&self) -> bool;
}

/// Vectors of the iteration, reused by successive cycles.
#[derive(Default)]
pub(super) struct Krylov {
    basis: Vec<Vec<f64>>,
}

impl Krylov {
    /// One restart cycle: adds the correction to `x` that minimizes the residual, given the residual `r`, until its Euclidean norm is at
    /// most `goal`, or after [`RESTART`] or `most` vectors. Returns the number of vectors. `r` is overwritten.
    pub fn cycle(&mut self, system: &mut impl System, r: &mut [f64], x: &mut [f64], goal: f64, most: usize, workers: &Workers) -> usize {
        let unknowns = r.len();
        let size = dot(r, r, workers).sqrt();
        if size == 0.0 || !size.is_finite() {
            return 0;
        }
        let vector = |basis: &mut Vec<Vec<f64>>, k: usize| {
            if basis.len() <= k {
                basis.push(vec![0.0; unknowns]);
            }
            basis[k].resize(unknowns, 0.0);
        };
        vector(&mut self.basis, 0);
        self.basis[0].iter_mut().zip(&*r).for_each(|(v, r)| *v = r / size);
        // Columns of the triangular factor, Givens rotations that produced it, and rotated right-hand side.
        let (mut columns, mut rotations, mut right): (Vec<Vec<f64>>, Vec<[f64; 2]>, Vec<f64>) = (Vec::new(), Vec::new(), vec![size]);
        let mut preconditioned = vec![0.0; unknowns];
        for k in 0..RESTART.min(most) {
            system.precondition(&self.basis[k], &mut preconditioned);
            vector(&mut self.basis, k + 1);
            let (earlier, last) = self.basis.split_at_mut(k + 1);
            let next = &mut last[0];
            system.multiply(&preconditioned, next);
            let mut column: Vec<f64> = Vec::with_capacity(k + 2);
            for v in earlier.iter() {
                let product = dot(v, next, workers);
                add(-product, v, next, workers);
                column.push(product);
            }
            let length = dot(next, next, workers).sqrt();
            for (j, [c, s]) in rotations.iter().enumerate() {
                let (a, b) = (column[j], column[j + 1]);
                (column[j], column[j + 1]) = (c * a + s * b, c * b - s * a);
            }
            let top = column[k];
            let hypotenuse = top.hypot(length);
            if hypotenuse == 0.0 || !hypotenuse.is_finite() {
                break;
            }
            let [c, s] = [top / hypotenuse, length / hypotenuse];
            column[k] = hypotenuse;
            rotations.push([c, s]);
            columns.push(column);
            right.push(-s * right[k]);
            right[k] *= c;
            if right[k + 1].abs() <= goal || length == 0.0 || system.is_interrupted() {
                break;
            }
            next.iter_mut().for_each(|v| *v /= length);
        }
        let count = columns.len();
        let mut weights = right[..count].to_vec();
        for k in (0..count).rev() {
            weights[k] /= columns[k][k];
            let weight = weights[k];
            (0..k).for_each(|j| weights[j] -= columns[k][j] * weight);
        }
        r.fill(0.0);
        weights.iter().zip(&self.basis).for_each(|(weight, v)| add(*weight, v, r, workers));
        system.precondition(r, &mut preconditioned);
        add(1.0, &preconditioned, x, workers);
        count
    }

    /// Bytes of the vectors.
    pub fn bytes(&self) -> usize {
        self.basis.iter().map(|v| size_of_val(&v[..])).sum()
    }

    /// Frees the vectors.
    pub fn clear(&mut self) {
        self.basis = Vec::new();
    }
}

/// `y += factor x`.
fn add(factor: f64, x: &[f64], y: &mut [f64], workers: &Workers) {
    workers.for_each_part(y, PART, |part, y| y.iter_mut().zip(&x[part * PART..]).for_each(|(y, x)| *y += factor * x));
}

/// Scalar product; parts of fixed length are summed by eight accumulators each, so that the result does not depend on the number of
/// threads.
pub(super) fn dot(x: &[f64], y: &[f64], workers: &Workers) -> f64 {
    let mut sums = vec![0.0; x.len().div_ceil(PART)];
    workers.for_each(&mut sums, 1, |part, sum| {
        let range = part * PART..(part * PART + PART).min(x.len());
        let (xs, x) = x[range.clone()].as_chunks::<8>();
        let (ys, y) = y[range].as_chunks::<8>();
        let mut eight = [0.0; 8];
        for (x, y) in xs.iter().zip(ys) {
            (0..8).for_each(|i| eight[i] += x[i] * y[i]);
        }
        *sum = eight.iter().sum::<f64>() + x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    });
    sums.iter().sum()
}
