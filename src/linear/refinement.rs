//! Solution with the factors of a matrix: iterative refinement, checks, and the fallback to partial pivoting.

use super::error::LinearError;
use super::factorization::Factorization;
use super::partial_pivoting::PartialPivoting;
use super::scaling::largest;
use crate::math::tolerances;

/// Largest number of iterative refinements. One restores full accuracy unless the factors are useless.
pub(super) const REFINEMENTS: usize = 2;

impl Factorization {
    /// Solves with refinement. `first`: the substituted right-hand side and the product of the matrix with it, if known.
    pub(super) fn solve_from(&mut self, values: &[f64], right: &mut [f64], first: Option<(&[f64], &[f64])>) -> Result<f64, LinearError> {
        let size = self.scaled_size(right);
        if size == 0.0 {
            return Ok(0.0);
        }
        if !size.is_finite() {
            return Err(LinearError::NotFinite);
        }
        let mut error = f64::NAN;
        if !self.fallen_back {
            if !self.multifrontal.replaced().is_empty() {
                self.refuse_singular(values)?;
            } else {
                error = self.refined(values, right, size, first);
            }
        }
        if error.is_nan() || error > tolerances::LINEAR_FALLBACK {
            self.fall_back(values)?;
            error = self.refined(values, right, size, None);
        }
        if error.is_nan() {
            // A pivot of exactly zero.
            return Err(LinearError::Singular { vertex: None });
        }
        let residual = self.scaled_size(&self.residual) / size;
        if error > tolerances::LINEAR_RESIDUAL || residual > tolerances::LINEAR_UNSOLVED {
            return Err(LinearError::Inaccurate { residual });
        }
        right.copy_from_slice(&self.solution);
        Ok(error)
    }

    fn scaled_size(&self, vector: &[f64]) -> f64 {
        largest(vector.iter().zip(&self.scale).map(|(x, scale)| x * scale))
    }

    /// Factors the last matrix by the sparse LU with partial pivoting.
    fn fall_back(&mut self, values: &[f64]) -> Result<(), LinearError> {
        if !self.fallen_back {
            if self.fallback.is_none() {
                let restricted = self.pattern.restricted(&self.order.kept);
                self.fallback = Some(Box::new(PartialPivoting::new(&restricted)?));
            }
            if let Some(fallback) = &mut self.fallback {
                fallback.factorize(values, &self.scale)?;
            }
            self.fallen_back = true;
        }
        Ok(())
    }

    /// `x := A^-1 x` with the factors in use, without refinement and checks.
    fn substitute(&mut self) {
        match &mut self.fallback {
            Some(fallback) if self.fallen_back => fallback.solve(&self.scale, &mut self.residual),
            _ => self.multifrontal.solve(&self.symbolic, &self.scale, &mut self.residual, &self.workers),
        }
    }

    /// Solves into `solution` with iterative refinement until the backward error is at round-off; returns the backward error. `first` is
    /// the substituted right-hand side and the product of the matrix with it, if they are known.
    fn refined(&mut self, values: &[f64], right: &[f64], size: f64, mut first: Option<(&[f64], &[f64])>) -> f64 {
        self.solution.fill(0.0);
        self.residual.copy_from_slice(right);
        let mut error = 1.0;
        for _ in 0..=REFINEMENTS {
            if let Some((first, image)) = first.take() {
                self.solution.copy_from_slice(first);
                self.residual.copy_from_slice(image);
            } else {
                self.substitute();
                self.solution.iter_mut().zip(&self.residual).for_each(|(x, d)| *x += d);
                self.pattern.multiply_into(values, &self.solution, &mut self.residual);
            }
            self.residual.iter_mut().zip(right).for_each(|(r, b)| *r = b - *r);
            let solution = largest(self.solution.iter().zip(&self.scale).map(|(x, scale)| x / scale));
            error = self.scaled_size(&self.residual) / (solution + size);
            if error.is_nan() || error <= tolerances::LINEAR_REFINED {
                break;
            }
        }
        if error > tolerances::LINEAR_FALLBACK { self.error_by_rows(values, right) } else { error }
    }

    /// Backward error of `solution`: largest residual of a row relative to the sum of the magnitudes of its terms, or to `|x|` if larger.
    pub(super) fn error_by_rows(&self, values: &[f64], right: &[f64]) -> f64 {
        let mut terms = vec![0.0; right.len()];
        self.pattern.multiply_sizes_into(values, &self.solution, &mut terms);
        let least = largest(self.solution.iter().zip(&self.scale).map(|(x, scale)| x / scale));
        let rows = self.residual.iter().zip(&terms).zip(right.iter().zip(&self.scale));
        largest(rows.map(|((r, terms), (b, scale))| r * scale / ((terms + b.abs()) * scale).max(least)))
    }

    /// Refuses a singular matrix `A`, as opposed to an unsuitable order, by the factors of `M`, the matrix with replaced pivots.
    ///
    /// `M - A` is the product of the direction in which `A` lacks a pivot and a small row. If `A` has a null vector, the iteration `z :=
    /// M^-1 (M - A) z = z - M^-1 A z` converges to it.
    fn refuse_singular(&mut self, values: &[f64]) -> Result<(), LinearError> {
        // Start vector with components in all directions.
        for (k, (x, scale)) in self.residual.iter_mut().zip(&self.scale).enumerate() {
            *x = (0.1 + (k as f64).sin().abs()) / scale;
        }
        self.solution.fill(0.0);
        let mut image = f64::INFINITY;
        loop {
            self.multifrontal.solve(&self.symbolic, &self.scale, &mut self.residual, &self.workers);
            for (z, x) in self.solution.iter_mut().zip(&self.residual) {
                *z -= x;
            }
            let size = largest(self.solution.iter().zip(&self.scale).map(|(z, scale)| z / scale));
            if !size.is_finite() || size == 0.0 {
                return Ok(());
            }
            self.solution.iter_mut().for_each(|z| *z /= size);
            self.pattern.multiply_into(values, &self.solution, &mut self.residual);
            let last = std::mem::replace(&mut image, self.scaled_size(&self.residual));
            if image <= tolerances::LINEAR_SINGULAR {
                break;
            }
            // Power iteration: converges linearly, because the replaced pivot made the factors grow; without a null vector it diverges.
            if image.is_nan() || image > 0.5 * last {
                return Ok(());
            }
        }
        let place = (0..self.solution.len()).max_by(|&i, &k| {
            let size = |k: usize| (self.solution[k] / self.scale[k]).abs();
            size(i).total_cmp(&size(k))
        });
        self.null_vector = Some(self.solution.clone());
        Err(LinearError::Singular { vertex: place.map(|unknown| self.pattern.vertex_of(unknown) as u32) })
    }
}
