//! Tie of two surfaces with nonmatching meshes: the mortar average of the gap vector vanishes (pairs in space: `space/tied.rs`).
//!
//! Integrals are evaluated once, in the reference positions, so that the constraints are linear. For each facet pair that overlaps there,
//! and each of its secondary nodes `A`,
//!
//! ```text
//! Phi_A = int N_A (sum_B N_B x_B - sum_C M_C y_C) ds - (alpha_A I + beta_A J) (y_2 - y_1)          [length^2], a vector
//! ```
//!
//! with the primary shape functions `M_C` at the opposite point along the secondary facet's normal. The second term is the reference value
//! of the first one (two polygons on one curve), expressed in the frame of the primary facet: `J` is a rotation by a right angle, so that a
//! rotation `R` of all positions gives `R Phi_A`. Hence the forces have zero resultant, and zero moment while `Phi = 0`: linear constraints
//! that hold at both ends of a step hold at mid-step, where the moment is taken. Energy, linear and angular momentum are exact for every
//! evaluation point of a scheme.
//!
//! Each secondary node has one constraint per direction. Nodes with (nearly) no overlap are not tied. In space three directions need a node
//! inside of the primary body, see `space/tied.rs`.

use super::pair::{invariants, offsets, overlaps};
use super::patches::Evaluation;
use super::search::Candidates;
use super::surface::Sides;
use super::{CandidateSearch, PatchFunctions, PredictedMotion, RigidObstacle};
use crate::integrators::Derivative;
use crate::math::tolerances::SLIVER;

/// Two tied surfaces.
#[derive(Clone, Debug)]
pub struct Tie {
    sides: Sides,
    pairs: Vec<TiedPair>,
    coverage: Vec<f64>,
    start_gap: Vec<f64>,
}

/// Constant data of a tied pair of facets.
#[derive(Clone, Debug)]
pub(super) struct TiedPair {
    /// Model node numbers, secondary nodes first.
    pub nodes: Vec<u32>,
    /// Indices of the secondary nodes.
    pub secondary: Vec<u32>,
    /// Constant gradient: one row per secondary node and direction, over the coordinates of the nodes.
    pub gradient: Vec<f64>,
    /// Covered measure of each secondary node `[length^(D-1)]`.
    pub covered: Vec<f64>,
}

impl Tie {
    /// Ties points within `reach` `[length]` of each other in the reference positions; surfaces by their facets (model node numbers, the
    /// body on the left).
    pub fn new(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64], reach: f64) -> Self {
        let sides = Sides::new(secondary, primary, reference);
        let (secondary, primary) = (&sides.secondary, &sides.primary);
        let mut candidates = Candidates::new(0.0);
        candidates.update(secondary, primary, reference, reach);
        let tied = |&[own, other]: &[u32; 2]| {
            let (x, y) = (secondary.facets()[own as usize], primary.facets()[other as usize]);
            let nodes = [x[0], x[1], y[0], y[1]];
            let (gradient, lengths) = pair_gradient(nodes, reference, reach)?;
            let rows = secondary.local_facets()[own as usize];
            Some(TiedPair {
                nodes: nodes.to_vec(),
                secondary: rows.to_vec(),
                gradient: gradient.as_flattened().to_vec(),
                covered: lengths.to_vec(),
            })
        };
        let pairs = candidates.pairs().iter().filter_map(tied).collect();
        Tie::of(sides, pairs)
    }

    /// Tie of the two surfaces `sides` by the given facet pairs.
    pub(super) fn of(mut sides: Sides, pairs: Vec<TiedPair>) -> Self {
        let (nodal, rows) = (&sides.weights, sides.secondary.dimension());
        let mut covered = vec![0.0; nodal.len()];
        for pair in &pairs {
            pair.secondary.iter().zip(&pair.covered).for_each(|(&node, part)| covered[node as usize] += part);
        }
        let share = |node: usize| if covered[node] > SLIVER * nodal[node] { covered[node] / nodal[node] } else { 0.0 };
        let coverage = (0..rows * nodal.len()).map(|row| share(row / rows)).collect();
        let start_gap = vec![0.0; rows * nodal.len()];
        sides.weights = (0..rows * nodal.len()).map(|row| nodal[row / rows]).collect();
        Tie { sides, pairs, coverage, start_gap }
    }

    /// Model numbers of secondary nodes without an opposite point within reach.
    pub fn untied(&self) -> Vec<u32> {
        let nodes = self.sides.secondary.nodes().iter().zip(self.coverage.iter().step_by(self.rows_per_node()));
        nodes.filter(|(_, coverage)| **coverage == 0.0).map(|(&node, _)| node).collect()
    }
}

/// Gradient of a pair's four constraints, and covered length of each secondary node; `None` without opposite points within reach.
fn pair_gradient(nodes: [u32; 4], reference: &[f64], reach: f64) -> Option<([[f64; 8]; 4], [f64; 2])> {
    let z: [f64; 8] = std::array::from_fn(|i| reference[2 * nodes[i / 2] as usize + i % 2]);
    let at = |node: usize| [z[2 * node], z[2 * node + 1]];
    let pi = invariants(&offsets(at(0), at(1), at(2), at(3)));
    if !overlaps(&pi) {
        return None;
    }
    let (s_1, s_2, length) = (pi[1] / pi[0], pi[2] / pi[0], pi[0].sqrt());
    let (a, b) = (s_2.max(0.0), s_1.min(1.0));
    // Integrals of N_A N_B and N_A M_C, quadratic in s, so that two Gauss points are exact.
    let mut sums = [[0.0; 4]; 2];
    let mut lengths = [0.0; 2];
    for sign in [-1.0, 1.0] {
        let s = 0.5 * (a + b) + sign * (b - a) / 12f64.sqrt();
        let eta = (s_1 - s) / (s_1 - s_2);
        let shape = [1.0 - s, s, eta - 1.0, -eta];
        let gap: [f64; 2] = std::array::from_fn(|i| (0..4).map(|node| shape[node] * z[2 * node + i]).sum());
        if gap[0].hypot(gap[1]) > reach {
            return None;
        }
        for (row, n) in [1.0 - s, s].into_iter().enumerate() {
            let weight = 0.5 * (b - a) * length * n;
            lengths[row] += weight;
            for (sum, shape) in sums[row].iter_mut().zip(shape) {
                *sum += weight * shape;
            }
        }
    }
    let t = [z[6] - z[4], z[7] - z[5]];
    let square = t[0] * t[0] + t[1] * t[1];
    let mut gradient = [[0.0; 8]; 4];
    for row in 0..2 {
        let offset: [f64; 2] = std::array::from_fn(|i| (0..4).map(|node| sums[row][node] * z[2 * node + i]).sum());
        let alpha = (offset[0] * t[0] + offset[1] * t[1]) / square;
        let beta = (offset[1] * t[0] - offset[0] * t[1]) / square;
        for i in 0..2 {
            let line = &mut gradient[2 * row + i];
            for node in 0..4 {
                line[2 * node + i] = sums[row][node];
            }
            // Subtracts alpha (y_2 - y_1)_i + beta (J (y_2 - y_1))_i with J (a, b) = (-b, a).
            line[4 + i] += alpha;
            line[6 + i] -= alpha;
            let turned = if i == 0 { beta } else { -beta };
            line[5 - i] -= turned;
            line[7 - i] += turned;
        }
    }
    Some((gradient, lengths))
}

impl PatchFunctions for Tie {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn rows_per_node(&self) -> usize {
        self.sides.secondary.dimension()
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.start_gap = self.gap(q_0);
    }

    fn start_gap(&self) -> Vec<f64> {
        self.start_gap.clone()
    }

    fn evaluate(&self, _derivative: Derivative, q_1: &[f64], _lambda: &[f64], out: &mut Evaluation) {
        out.prepare(&self.sides.patches, self.sides.weights.len());
        for (p, pair) in self.pairs.iter().enumerate().take(self.sides.patches.len()) {
            out.live[p] = true;
            out.gradient_end[self.sides.patches.gradient_range(p)].copy_from_slice(&pair.gradient);
            out.gradient_bar[self.sides.patches.gradient_range(p)].copy_from_slice(&pair.gradient);
        }
        out.gap = self.gap(q_1);
        out.coverage.copy_from_slice(&self.coverage);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        let mut gaps = vec![0.0; self.sides.weights.len()];
        let (rows, mut z) = (self.rows_per_node(), Vec::<f64>::new());
        for pair in &self.pairs {
            z.clear();
            z.extend(pair.nodes.iter().flat_map(|&node| &q[rows * node as usize..rows * (node as usize + 1)]));
            for (k, line) in pair.gradient.chunks_exact(z.len()).enumerate() {
                let row = rows * pair.secondary[k / rows] as usize + k % rows;
                gaps[row] += line.iter().zip(&z).map(|(g, z)| g * z).sum::<f64>();
            }
        }
        gaps
    }

    fn coverage(&self, _q: &[f64]) -> Vec<f64> {
        self.coverage.clone()
    }
}

impl CandidateSearch for Tie {
    fn update_candidates(&mut self, _outlook: &PredictedMotion) -> bool {
        let first = self.sides.patches.is_empty() && !self.pairs.is_empty();
        if first {
            let count = self.rows_per_node() as u32;
            for pair in &self.pairs {
                let rows: Vec<u32> = pair.secondary.iter().flat_map(|&node| (0..count).map(move |i| count * node + i)).collect();
                self.sides.patches.push(&pair.nodes, &rows);
            }
        }
        first
    }
}

impl RigidObstacle for Tie {}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{Rings, dense_rows, difference, evaluated, product, rings, turned, unbalance};
    use super::*;

    fn largest(values: &[f64]) -> f64 {
        values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
    }

    /// Two tied polygons with 40 and 48 corners on one circle, which differ by the sagittas of their chords.
    fn tied_rings() -> (Tie, Vec<f64>) {
        let Rings { inner, outer, q } = rings(40, 48, 0.0);
        let mut tie = Tie::new(&inner, &outer, &q, 0.05);
        let predicted_motion = PredictedMotion::within(&q, 0.0);
        assert!(tie.update_candidates(&predicted_motion) && !tie.update_candidates(&predicted_motion));
        tie.begin_step(&q);
        (tie, q)
    }

    #[test]
    fn polygons_through_one_circle_are_tied_all_around_and_fit_at_rest() {
        let (tie, q) = tied_rings();
        assert!(tie.untied().is_empty());
        // Round-off of integrals of about 0.16 times positions of about 1.
        assert!(largest(&tie.gap(&q)) < 1e-16 && tie.coverage.iter().all(|share| (share - 1.0).abs() < 1e-13));
    }

    /// Rigid motions and uniform stretches of all nodes keep the constraints: the offsets rotate and stretch with the facets.
    #[test]
    fn similarities_keep_the_constraints() {
        let (tie, q) = tied_rings();
        for factor in [1.0, 1.3] {
            let mut moved = turned(&q, usize::MAX, 0.7, 0.0);
            moved.iter_mut().for_each(|x| *x = factor * *x + 5.0);
            assert!(largest(&tie.gap(&moved)) < 1e-15);
        }
        // A rotation of one body by 0.1 opens a gap of weight times the displacement 2 r sin(0.05), r = 1.
        let gaps = tie.gap(&turned(&q, 40, 0.1, 0.0));
        let expected = tie.sides.weights[0] * 2.0 * 0.05f64.sin();
        for gap in gaps.chunks_exact(2) {
            assert!((gap[0].hypot(gap[1]) / expected - 1.0).abs() < 5e-3, "{gap:?} {expected}");
        }
    }

    /// The moment of the forces is multiplier times gap and vanishes where the constraints hold; the resultant always vanishes.
    #[test]
    fn forces_have_no_resultant_and_no_moment_where_the_constraints_hold() {
        let (tie, q) = tied_rings();
        let turned_both = turned(&q, usize::MAX, 0.4, 0.0);
        let out = evaluated(&tie, Derivative::DiscreteGradient, &turned_both, &[1.0; 80]);
        assert!(unbalance(&dense_rows(&tie, &out.gradient_bar, q.len()), &turned_both) < 1e-15);
        let torn = turned(&q, 40, 0.1, 0.01);
        let rows = dense_rows(&tie, &out.gradient_bar, q.len());
        for (row, gap) in rows.chunks_exact(2).zip(tie.gap(&torn).chunks_exact(2)) {
            let moment =
                |row: &[f64]| -> f64 { row.chunks_exact(2).zip(torn.chunks_exact(2)).map(|(f, x)| x[0] * f[1] - x[1] * f[0]).sum() };
            assert!((moment(&row[0]) + gap[1]).abs() < 1e-15 && (moment(&row[1]) - gap[0]).abs() < 1e-15);
        }
    }

    /// Linear constraints are directional without correction.
    #[test]
    fn the_gradient_is_directional() {
        let (mut tie, q) = tied_rings();
        tie.begin_step(&q);
        let q_1 = turned(&q, 40, 0.2, 0.05);
        let out = evaluated(&tie, Derivative::DiscreteGradient, &q_1, &[1.0; 80]);
        let (start, moved) = (tie.start_gap(), difference(&q_1, &q));
        for (k, row) in dense_rows(&tie, &out.gradient_bar, q.len()).iter().enumerate() {
            assert!((product(row, &moved) - (out.gap[k] - start[k])).abs() < 1e-15);
        }
    }

    /// Closed form: three facets over two matching ones; weights are integrals of hat functions, the overhanging part is not tied.
    #[test]
    fn only_what_lies_opposite_is_tied() {
        let q = [0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 3.0, 0.0, 1.9, 0.0, 0.9, 0.0, -0.1, 0.0];
        let tie = Tie::new(&[[0, 1], [1, 2], [2, 3]], &[[4, 5], [5, 6]], &q, 0.1);
        assert_eq!(tie.untied(), [3]);
        let share = |node: usize| tie.coverage[2 * node];
        assert!((share(0) - 1.0).abs() < 1e-15 && (share(1) - (1.0 - 0.1 * 0.05)).abs() < 1e-15);
        // Distant surfaces are not tied.
        assert_eq!(Tie::new(&[[0, 1]], &[[4, 5]], &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.9, 0.0, 0.9, 0.0], 0.1).untied(), [0, 1]);
    }
}
