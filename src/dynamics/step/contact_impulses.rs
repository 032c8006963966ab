//! Contact multipliers of explicit steps: forward increments (Carpenter, Taylor and Katona, Int. J. Numer. Meth. Engng 32, 1991).
//!
//! Multipliers at the start of a step are determined so that gaps at its end are not negative,
//!
//! ```text
//! Phi(q_1) >= target,    q_1 = q* + m^-1 G_0^T p,    p the change of the multipliers times dt^2, lambda >= 0
//! ```
//!
//! With a lumped mass `G_0 m^-1 G_0^T` couples only constraints that share nodes. The system of the normal constraints is solved by the
//! Gauss-Seidel method with nonnegative multipliers (as by the authors), which also finds a solution where constraints depend on each
//! other.

use super::equations::Equations;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::math::tolerances;

/// Largest number of sweeps.
const SWEEPS: usize = 1000;

/// Constraint with an unknown multiplier.
pub struct PushedRow {
    /// Index of the constraint.
    pub row: usize,
    /// Gradient of the gap with respect to each unknown.
    gradient: Vec<(usize, f64)>,
    /// Change of the constraint's gap per unit of its own `p`.
    own: f64,
}

impl<const D: usize> Equations<D>
where
    Space<D>: Elements<D>,
{
    /// Inverse lumped mass of an unknown: its displacement per force and squared time; 0 at a support `[1/mass]`.
    pub fn mobility(&self, unknown: usize) -> f64 {
        if self.supports.fixed[unknown] { 0.0 } else { 1.0 / self.nodes.nodal_mass[unknown / D] }
    }

    /// Lower bounds of the gaps at the end of a step: an initial overlap is not separated.
    pub fn explicit_targets(&self) -> Vec<f64> {
        let held = self.closed_gaps();
        let of = |pair: &ContactPair| -> Vec<f64> {
            let gaps = pair.kernel.start_gap();
            gaps.iter().zip(&held[pair.rows.clone()]).map(|(&gap, &held)| if gap < held - pair.closed { gap } else { held }).collect()
        };
        self.pairs.iter().flat_map(of).collect()
    }

    /// Constraints that need multipliers, because they overlap or have one already, and true if their conditions are met. Before the first
    /// change of multipliers, conditions are met only if no constraint needs one.
    pub fn wanted(&self, pairs: &[Evaluation], gaps: &[f64], lambda: &[f64], was_pushed: bool) -> (Vec<bool>, bool) {
        let (mut wanted, mut is_met) = (vec![false; self.multipliers], true);
        for (pair, evaluation) in self.pairs.iter().zip(pairs).filter(|(pair, _)| pair.has_multipliers()) {
            for (row, coverage) in pair.rows.clone().zip(&evaluation.coverage).filter(|(row, _)| !self.redundant[*row]) {
                let overlaps = gaps[row] < -pair.gap_tolerance && *coverage > tolerances::SLIVER;
                wanted[row] = overlaps || lambda[row] > 0.0;
                is_met &= !wanted[row] || (was_pushed && !overlaps && gaps[row] <= pair.gap_tolerance);
            }
        }
        (wanted, is_met)
    }

    /// Zeroes the multipliers of constraints marked in `wanted` that move no unknown.
    pub fn zero_immobile_multipliers(&self, wanted: &[bool], rows: &[PushedRow], lambda: &mut [f64]) {
        let mut pushed = rows.iter().map(|row| row.row).peekable();
        for (row, lambda) in lambda.iter_mut().enumerate().filter(|(row, _)| wanted[*row]) {
            if pushed.next_if_eq(&row).is_none() {
                *lambda = 0.0;
            }
        }
    }

    /// Gradients of the constraints marked in `wanted`, except those that move no unknown.
    pub fn pushed_rows(&self, pairs: &[Evaluation], wanted: &[bool], mobility: &[f64]) -> Vec<PushedRow> {
        let mut entries: Vec<(usize, usize, f64)> = Vec::new();
        for (pair, evaluation) in self.pairs.iter().zip(pairs) {
            for row in pair.live_rows(evaluation).filter(|row| wanted[row.row]) {
                entries.extend(row.unknowns::<D>().map(|(k, entry)| (row.row, k, evaluation.gradient_end[entry])));
            }
        }
        entries.sort_by_key(|&(row, unknown, _)| (row, unknown));
        let mut rows: Vec<PushedRow> = Vec::new();
        for of_row in entries.chunk_by(|a, b| a.0 == b.0) {
            let sum = |entries: &[(usize, usize, f64)]| (entries[0].1, entries.iter().map(|entry| entry.2).sum::<f64>());
            let gradient: Vec<(usize, f64)> = of_row.chunk_by(|a, b| a.1 == b.1).map(sum).collect();
            let own: f64 = gradient.iter().map(|&(k, g)| g * g * mobility[k]).sum();
            if own > 0.0 {
                rows.push(PushedRow { row: of_row[0].0, gradient, own });
            }
        }
        rows
    }
}

/// Changes `p` of the multipliers, each at least `least`, such that no gap is negative after the displacement caused by `p`, which is added
/// to `moved`.
pub fn push(rows: &[PushedRow], gaps: &[f64], least: &[f64], mobility: &[f64], moved: &mut [f64]) -> Vec<f64> {
    let mut p = vec![0.0; rows.len()];
    // Displacements by the constraints are summed separately, accurate relative to their own size.
    let mut pushed = vec![0.0; moved.len()];
    let size = gaps.iter().fold(0.0f64, |size, gap| size.max(gap.abs()));
    for _ in 0..SWEEPS {
        let mut largest = 0.0f64;
        for (index, row) in rows.iter().enumerate() {
            let gap = gaps[index] + row.gradient.iter().map(|&(k, g)| g * pushed[k]).sum::<f64>();
            let change = (p[index] - gap / row.own).max(least[index]) - p[index];
            p[index] += change;
            row.gradient.iter().for_each(|&(k, g)| pushed[k] += change * g * mobility[k]);
            largest = largest.max((change * row.own).abs());
        }
        if largest <= tolerances::PUSHED * size {
            break;
        }
    }
    moved.iter_mut().zip(&pushed).for_each(|(moved, pushed)| *moved += pushed);
    p
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two nodes of unit mass between walls, pressed together by a third constraint: the closed form of two equations.
    #[test]
    fn rows_that_share_nodes_push_until_no_gap_is_negative() {
        let row = |row: usize, gradient: Vec<(usize, f64)>, mobility: &[f64]| {
            let own = gradient.iter().map(|&(k, g)| g * g * mobility[k]).sum();
            PushedRow { row, gradient, own }
        };
        let mobility = [1.0, 0.5, 0.0];
        let rows = [
            row(0, vec![(0, 1.0)], &mobility),
            row(1, vec![(0, -1.0), (1, 1.0)], &mobility),
            // A supported node is not displaced.
            row(2, vec![(1, 1.0), (2, -1.0)], &mobility),
        ];
        let (gaps, mut moved) = ([-0.1, -0.2, 0.4], vec![0.0; 3]);
        let p = push(&rows, &gaps, &[0.0; 3], &mobility, &mut moved);
        // x_0 = 0.1 and x_1 - x_0 = 0.2.
        assert!((moved[0] - 0.1).abs() < 1e-12 && (moved[1] - 0.3).abs() < 1e-12 && moved[2] == 0.0, "{moved:?}");
        assert!((p[1] - 0.6).abs() < 1e-11 && (p[0] - 0.7).abs() < 1e-11 && p[2] == 0.0, "{p:?}");
    }
}
