//! Tying of two surfaces whose meshes do not match: the mortar average of the whole gap vector is zero.
//!
//! The integrals are taken once, in the reference positions, so the constraints are linear: for each pair of facets that overlap there, and
//! each secondary node `A` of it,
//!
//! ```text
//! Phi_A = int N_A (sum_B N_B x_B - sum_C M_C y_C) ds - (alpha_A I + beta_A J) (y_2 - y_1)          [length^2], a vector
//! ```
//!
//! with the primary shape functions `M_C` at the point opposite along the secondary facet's normal. The second term is the part of the first
//! that does not vanish in the reference positions (two polygons through one curve), written in the frame of the primary facet: `J` turns by
//! a right angle, so a turn `R` of all positions gives `R Phi_A`. Hence the forces have no resultant, and no moment while `Phi = 0`:
//! linear constraints that hold at both ends of a step hold in its middle, where the moment is taken. Energy and both momenta are exact for
//! every integrator's own force placement, with nothing to correct.
//!
//! Each secondary node has two rows. Nodes with (nearly) no overlap are not tied. For the plane: in space the offset needs a facet's frame.

use super::ContactKernel;
use super::pair::{invariants, offsets, overlaps};
use super::patches::{Evaluation, Patches};
use super::search::Candidates;
use super::surface::Surface;
use crate::integrators::Integrator;
use crate::math::tolerances::SLIVER;

/// Rows of a secondary node.
const ROWS: usize = 2;

/// Tied surfaces.
#[derive(Clone, Debug)]
pub struct Tie {
    secondary: Surface,
    primary: Surface,
    pairs: Vec<TiedPair>,
    patches: Patches,
    /// Per constraint row.
    weights: Vec<f64>,
    coverage: Vec<f64>,
    facet_size: f64,
    start_gap: Vec<f64>,
}

/// The constant gradient of a pair: four rows over `(x_1, x_2, y_1, y_2)`.
#[derive(Clone, Debug)]
struct TiedPair {
    nodes: [u32; 4],
    secondary: [u32; 2],
    gradient: [[f64; 8]; 4],
}

impl Tie {
    /// Ties what lies within `reach` `[length]` of each other in the reference positions; surfaces by their facets (node numbers of the
    /// model, the body on the left).
    pub fn new(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64], reach: f64) -> Self {
        let (secondary, primary) = (Surface::new(secondary), Surface::new(primary));
        let nodal = secondary.weights(reference);
        let facet_size = secondary.shortest_facet(reference);
        let mut candidates = Candidates::new(0.0);
        candidates.update(&secondary, &primary, reference, reach);
        let mut pairs = Vec::new();
        let mut covered = vec![0.0; nodal.len()];
        for &[own, other] in candidates.pairs() {
            let (x, y) = (secondary.facets()[own as usize], primary.facets()[other as usize]);
            let nodes = [x[0], x[1], y[0], y[1]];
            if let Some((gradient, lengths)) = pair_gradient(nodes, reference, reach) {
                let rows = secondary.local_facets()[own as usize];
                for (row, length) in rows.into_iter().zip(lengths) {
                    covered[row as usize] += length;
                }
                pairs.push(TiedPair { nodes, secondary: rows, gradient });
            }
        }
        let share = |node: usize| if covered[node] > SLIVER * nodal[node] { covered[node] / nodal[node] } else { 0.0 };
        let coverage = (0..ROWS * nodal.len()).map(|row| share(row / ROWS)).collect();
        let weights = (0..ROWS * nodal.len()).map(|row| nodal[row / ROWS]).collect();
        let start_gap = vec![0.0; ROWS * nodal.len()];
        Tie { secondary, primary, pairs, patches: Patches::new(2), weights, coverage, facet_size, start_gap }
    }

    /// Secondary nodes (numbers in the model) that are not tied: nothing lies opposite within reach.
    pub fn untied(&self) -> Vec<u32> {
        let nodes = self.secondary.nodes().iter().enumerate();
        nodes.filter(|(index, _)| self.coverage[ROWS * index] == 0.0).map(|(_, &node)| node).collect()
    }

    fn positions(nodes: &[u32; 4], q: &[f64]) -> [f64; 8] {
        std::array::from_fn(|i| q[2 * nodes[i / 2] as usize + i % 2])
    }
}

/// Gradient of a pair's four rows and the covered length of each secondary node; `None` where nothing lies opposite within reach.
fn pair_gradient(nodes: [u32; 4], reference: &[f64], reach: f64) -> Option<([[f64; 8]; 4], [f64; 2])> {
    let z = Tie::positions(&nodes, reference);
    let at = |node: usize| [z[2 * node], z[2 * node + 1]];
    let pi = invariants(&offsets(at(0), at(1), at(2), at(3)));
    if !overlaps(&pi) {
        return None;
    }
    let (s_1, s_2, length) = (pi[1] / pi[0], pi[2] / pi[0], pi[0].sqrt());
    let (a, b) = (s_2.max(0.0), s_1.min(1.0));
    // Integrals of N_A N_B and N_A M_C: quadratic in s, exact by two Gauss points.
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
            // - alpha (y_2 - y_1)_i - beta (J (y_2 - y_1))_i, J (a, b) = (-b, a).
            line[4 + i] += alpha;
            line[6 + i] -= alpha;
            let turned = if i == 0 { beta } else { -beta };
            line[5 - i] -= turned;
            line[7 - i] += turned;
        }
    }
    Some((gradient, lengths))
}

impl ContactKernel for Tie {
    fn dimension(&self) -> usize {
        2
    }

    fn secondary(&self) -> &Surface {
        &self.secondary
    }

    fn primary(&self) -> &Surface {
        &self.primary
    }

    fn rows_per_node(&self) -> usize {
        ROWS
    }

    fn weights(&self) -> &[f64] {
        &self.weights
    }

    fn facet_size(&self) -> f64 {
        self.facet_size
    }

    fn update_candidates(&mut self, _q: &[f64], _margin: f64) -> bool {
        let first = self.patches.is_empty() && !self.pairs.is_empty();
        if first {
            for pair in &self.pairs {
                let [a, b] = pair.secondary.map(|node| ROWS as u32 * node);
                self.patches.push(&pair.nodes, &[a, a + 1, b, b + 1]);
            }
        }
        first
    }

    fn patches(&self) -> &Patches {
        &self.patches
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.start_gap = self.gap(q_0);
    }

    fn start_gap(&self) -> Vec<f64> {
        self.start_gap.clone()
    }

    fn evaluate(&self, integrator: Integrator, q_1: &[f64], _lambda: &[f64], out: &mut Evaluation) {
        let weight = integrator.placement().weight;
        out.prepare(&self.patches, self.weights.len());
        for (p, pair) in self.pairs.iter().enumerate().take(self.patches.len()) {
            out.live[p] = true;
            let rows = pair.gradient.as_flattened();
            out.gradient_end[self.patches.gradient_range(p)].copy_from_slice(rows);
            for (bar, g) in out.gradient_bar[self.patches.gradient_range(p)].iter_mut().zip(rows) {
                *bar = weight * g;
            }
        }
        out.gap = self.gap(q_1);
        out.coverage.copy_from_slice(&self.coverage);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        let mut gaps = vec![0.0; self.weights.len()];
        for pair in &self.pairs {
            let z = Tie::positions(&pair.nodes, q);
            for (k, line) in pair.gradient.iter().enumerate() {
                let row = ROWS * pair.secondary[k / ROWS] as usize + k % ROWS;
                gaps[row] += line.iter().zip(z).map(|(g, z)| g * z).sum::<f64>();
            }
        }
        gaps
    }

    fn coverage(&self, _q: &[f64]) -> Vec<f64> {
        self.coverage.clone()
    }
}
