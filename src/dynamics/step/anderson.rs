//! Anderson acceleration of a quasi-Newton method (Anderson, J. ACM 12, 1965; Walker and Ni, SIAM J. Numer. Anal. 49, 2011).
//!
//! The increments `f(x)` of a method with an incomplete tangent converge linearly. The differences `df_j` of the last increments and `dx_j`
//! of the last iterates estimate what the tangent lacks: the next iterate is `x + f - sum_j gamma_j (dx_j + df_j)`, where `gamma` minimizes
//! `|f - sum_j gamma_j df_j|`. Every iterate is an affine combination of earlier Newton iterates, so what these meet exactly (linear
//! constraints, prescribed displacements) the combination meets, too.

use crate::math::tolerances;

/// Number of differences that are stored.
const MOST: usize = 6;

/// Last iterates of a quasi-Newton method.
#[derive(Default)]
pub struct Anderson {
    /// Increment of the last iterate before acceleration, and the one that was applied.
    last: Option<[Vec<f64>; 2]>,
    /// Differences `[df_j, dx_j + df_j]`, the latest first.
    differences: Vec<[Vec<f64>; 2]>,
}

impl Anderson {
    /// Forgets all iterates: the next increment belongs to another linearization (active set, limit of increments).
    pub fn clear(&mut self) {
        *self = Anderson::default();
    }

    /// Accelerates an increment of positions and the new multipliers, which follow the positions, from the multipliers `lambda`.
    pub fn accelerate_with_multipliers(&mut self, lambda: &[f64], increment: &mut [f64], new_lambda: &mut [f64]) {
        let unknowns = increment.len();
        let changes = new_lambda.iter().zip(lambda).map(|(new, old)| new - old);
        let mut both: Vec<f64> = increment.iter().copied().chain(changes).collect();
        self.accelerate(&mut both, unknowns);
        increment.copy_from_slice(&both[..unknowns]);
        new_lambda.iter_mut().zip(lambda).zip(&both[unknowns..]).for_each(|((new, old), change)| *new = old + change);
    }

    /// Replaces an increment by the accelerated one. The first `measured` components are those of the norm; the others are combined with
    /// the same factors.
    fn accelerate(&mut self, increment: &mut [f64], measured: usize) {
        let plain = increment.to_vec();
        if let Some([last, applied]) = self.last.take() {
            let df: Vec<f64> = plain.iter().zip(&last).map(|(new, old)| new - old).collect();
            let sum = df.iter().zip(&applied).map(|(df, dx)| df + dx).collect();
            self.differences.insert(0, [df, sum]);
            self.differences.truncate(MOST);
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).take(measured).map(|(a, b)| a * b).sum::<f64>();
        let subtract = |from: &mut [f64], factor: f64, what: &[f64]| from.iter_mut().zip(what).for_each(|(x, y)| *x -= factor * y);
        let mut rest = plain.clone();
        let mut basis: Vec<[Vec<f64>; 2]> = Vec::new();
        for difference in &self.differences {
            let [mut df, mut sum] = difference.clone();
            let before = dot(&df, &df).sqrt();
            for [unit, its_sum] in &basis {
                let factor = dot(&df, unit);
                subtract(&mut df, factor, unit);
                subtract(&mut sum, factor, its_sum);
            }
            let norm = dot(&df, &df).sqrt();
            if norm <= tolerances::SAME_DIRECTION * before || norm == 0.0 {
                continue;
            }
            [&mut df, &mut sum].into_iter().for_each(|vector| vector.iter_mut().for_each(|x| *x /= norm));
            let factor = dot(&rest, &df);
            subtract(&mut rest, factor, &df);
            subtract(increment, factor, &sum);
            basis.push([df, sum]);
        }
        self.last = Some([plain, increment.to_vec()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear fixed point iteration `f(x) = A (s - x)` of contraction 0.9 in 3 of its directions and with exact increments in the others.
    #[test]
    fn a_linear_iteration_ends_after_one_step_more_than_its_inexact_directions() {
        let solution = [1.0, -2.0, 0.5, 3.0, 7.0];
        let factors = [0.1, 1.9, 0.3, 1.0, 1.0];
        let mut x = [0.0; 5];
        let mut anderson = Anderson::default();
        for _ in 0..5 {
            let mut increment: Vec<f64> = (0..5).map(|i| factors[i] * (solution[i] - x[i])).collect();
            anderson.accelerate(&mut increment, 4);
            x.iter_mut().zip(&increment).for_each(|(x, d)| *x += d);
        }
        let error = x.iter().zip(&solution).map(|(x, s)| (x - s).abs()).fold(0.0, f64::max);
        assert!(error < 1e-12, "{error:e}");
    }
}
