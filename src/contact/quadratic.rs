//! Contact of edges of second order: each is two straight facets, through its ends and a point beside its middle node that keeps the area.
//!
//! A parabola with the sagitta `h` over a chord of length `l` holds the area `2/3 h l`, the two sides of a triangle of height `4/3 h` the
//! same. So contact sees the middle node at
//!
//! ```text
//! y = 4/3 x_middle - 1/6 (x_from + x_to),      on a straight even edge the middle node itself
//! ```
//!
//! and a constant pressure on the straight facets, 1/4 1/2 1/4 of its resultant on their nodes, goes to the edge's nodes by the transpose
//! as 1/6, 2/3, 1/6: the consistent forces of a quadratic edge. So contact methods for straight facets pass their patch tests on curved
//! ones.
//! The coefficients sum to one, so positions move with rigid motions, and momenta and energy are kept as without.
//! (Facets of two nodes on quadratic edges: Puso, Laursen and Solberg, CMAME 197, 2008; the point that keeps the area is ours.)

use std::sync::{Mutex, PoisonError};

use super::kernel::{ContactKernel, Correction};
use super::patches::{Evaluation, Patches};
use super::search::{Candidates, PairSearch};
use super::surface::Sides;
use super::window::Outlook;
use crate::integrators::Derivative;

/// Shares of the middle node and of each end in the point that contact sees.
const SHARES: [f64; 3] = [4.0 / 3.0, -1.0 / 6.0, -1.0 / 6.0];

/// Middle nodes with the ends of their edges, `[middle, from, to]`, in ascending order.
#[derive(Clone, Debug, Default)]
pub struct Middles(Vec<[u32; 3]>);

impl Middles {
    /// Of edges given by their ends and their middle.
    pub fn new(edges: impl Iterator<Item = [u32; 3]>) -> Self {
        let mut middles: Vec<[u32; 3]> = edges.map(|[from, to, middle]| [middle, from, to]).collect();
        middles.sort_unstable();
        Middles(middles)
    }

    /// Where contact sees the nodes `[length]`, in the plane.
    pub fn seen(&self, q: &[f64]) -> Vec<f64> {
        let mut seen = q.to_vec();
        for edge in &self.0 {
            for i in 0..2 {
                seen[2 * edge[0] as usize + i] = edge.iter().zip(SHARES).map(|(&node, share)| share * q[2 * node as usize + i]).sum();
            }
        }
        seen
    }

    /// Nodes and shares that make up what contact sees as a node.
    fn parts(&self, node: u32) -> Vec<(u32, f64)> {
        match self.0.binary_search_by_key(&node, |edge| edge[0]) {
            Ok(found) => self.0[found].into_iter().zip(SHARES).collect(),
            Err(_) => vec![(node, 1.0)],
        }
    }

    /// A contact method on edges of second order: as it is where none of its nodes is in their middle.
    pub fn under(&self, kernel: Box<dyn ContactKernel>) -> Box<dyn ContactKernel> {
        let is_middle = |node: &u32| self.0.binary_search_by_key(node, |edge| edge[0]).is_ok();
        if kernel.secondary().nodes().iter().chain(kernel.primary().nodes()).any(is_middle) {
            let mut curved = OnCurves {
                sides: kernel.sides().clone(),
                inner: kernel,
                middles: self.clone(),
                parts: Vec::new(),
                scratch: Mutex::default(),
            };
            curved.list();
            Box::new(curved)
        } else {
            kernel
        }
    }
}

/// A contact method whose facets follow curved edges.
struct OnCurves {
    inner: Box<dyn ContactKernel>,
    middles: Middles,
    /// Those of the method, with patches that couple the nodes of the edges.
    sides: Sides,
    /// Per patch and node of the method: indices among the nodes of the patch here, and their shares.
    parts: Vec<Vec<Vec<(usize, f64)>>>,
    scratch: Mutex<Evaluation>,
}

impl OnCurves {
    /// Makes the patches of the method's.
    fn list(&mut self) {
        let inner = self.inner.patches();
        self.sides.patches = Patches::new(inner.dimension());
        self.parts.clear();
        for p in 0..inner.len() {
            let mut nodes: Vec<u32> = Vec::new();
            let mut place = |node: u32| match nodes.iter().position(|&other| other == node) {
                Some(index) => index,
                None => {
                    nodes.push(node);
                    nodes.len() - 1
                }
            };
            let parts = inner.nodes(p).iter().map(|&node| {
                let parts = self.middles.parts(node).into_iter();
                parts.map(|(node, share)| (place(node), share)).collect::<Vec<_>>()
            });
            self.parts.push(parts.collect());
            self.sides.patches.push(&nodes, inner.rows(p));
        }
    }

    /// Forces on the nodes from those on what contact sees, added.
    fn pull_back(&self, seen: &[f64], force: &mut [f64]) {
        for (k, value) in seen.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            for (node, share) in self.middles.parts((k / 2) as u32) {
                force[2 * node as usize + k % 2] += share * value;
            }
        }
    }

    /// The blocks of a patch from the method's.
    fn patch_into(&self, p: usize, inner: &Evaluation, out: &mut Evaluation) {
        let (patches, of) = (self.inner.patches(), &self.sides.patches);
        let (few, many) = (patches.unknowns(p), of.unknowns(p));
        for (from, to) in [(&inner.gradient_end, &mut out.gradient_end), (&inner.gradient_bar, &mut out.gradient_bar)] {
            let (from, to) = (&from[patches.gradient_range(p)], &mut to[of.gradient_range(p)]);
            for row in 0..patches.rows(p).len() {
                for (node, parts) in self.parts[p].iter().enumerate() {
                    for &(place, share) in parts {
                        (0..2).for_each(|i| to[row * many + 2 * place + i] += share * from[row * few + 2 * node + i]);
                    }
                }
            }
        }
        let (from, to) = (&inner.tangent[patches.tangent_range(p)], &mut out.tangent[of.tangent_range(p)]);
        for (u, rows) in self.parts[p].iter().enumerate() {
            for (v, columns) in self.parts[p].iter().enumerate() {
                for (&(row, a), &(column, b)) in rows.iter().flat_map(|row| columns.iter().map(move |column| (row, column))) {
                    for i in 0..2 {
                        for k in 0..2 {
                            to[(2 * row + i) * many + 2 * column + k] += a * b * from[(2 * u + i) * few + 2 * v + k];
                        }
                    }
                }
            }
        }
    }
}

impl ContactKernel for OnCurves {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn rows_per_node(&self) -> usize {
        self.inner.rows_per_node()
    }

    fn is_nodal(&self) -> bool {
        self.inner.is_nodal()
    }

    fn row_nodes(&self) -> &[u32] {
        self.inner.row_nodes()
    }

    fn rows(&self) -> usize {
        self.inner.rows()
    }

    fn weights(&self) -> &[f64] {
        self.inner.weights()
    }

    fn owns(&self, p: usize, node: u32) -> bool {
        let owners = self.inner.patches().nodes(p).iter().filter(|&&owner| self.inner.owns(p, owner));
        owners.into_iter().any(|&owner| self.middles.parts(owner).iter().any(|&(part, _)| part == node))
    }

    fn facet_size(&self) -> f64 {
        self.inner.facet_size()
    }

    fn update_candidates(&mut self, outlook: &Outlook) -> bool {
        let seen = self.middles.seen(outlook.q);
        let changed = self.inner.update_candidates(&Outlook { q: &seen, ..*outlook });
        if changed {
            self.list();
        }
        changed
    }

    fn margin(&self, outlook: &Outlook) -> f64 {
        self.inner.margin(outlook)
    }

    fn overlooks(&self, q_0: &[f64], q_1: &[f64], tolerance: f64) -> bool {
        self.inner.overlooks(&self.middles.seen(q_0), &self.middles.seen(q_1), tolerance)
    }

    fn for_each_participant(&self, p: usize, tell: &mut dyn FnMut(u32)) {
        self.inner.for_each_participant(p, &mut |node| self.middles.parts(node).into_iter().for_each(|(node, _)| tell(node)));
    }

    fn candidates(&self) -> Option<&Candidates> {
        self.inner.candidates()
    }

    fn restore_candidates(&mut self, candidates: &Candidates, q: &[f64]) {
        self.inner.restore_candidates(candidates, &self.middles.seen(q));
        self.list();
    }

    fn search(&self) -> Option<&PairSearch> {
        self.inner.search()
    }

    fn move_obstacle(&mut self, translations: &[[f64; 2]; 3]) {
        self.inner.move_obstacle(translations);
    }

    fn obstacle_translation(&self) -> [f64; 2] {
        self.inner.obstacle_translation()
    }

    fn passage(&self, q_1: &[f64]) -> [f64; 2] {
        self.inner.passage(&self.middles.seen(q_1))
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.inner.begin_step(&self.middles.seen(q_0));
    }

    fn start_gap(&self) -> Vec<f64> {
        self.inner.start_gap()
    }

    fn set_correction(&mut self, correction: Correction) {
        self.inner.set_correction(correction);
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        let mut inner = self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        self.inner.evaluate(derivative, &self.middles.seen(q_1), lambda, &mut inner);
        out.prepare(&self.sides.patches, self.rows());
        out.gap.copy_from_slice(&inner.gap);
        out.coverage.copy_from_slice(&inner.coverage);
        for p in 0..self.sides.patches.len() {
            out.clear_patch(&self.sides.patches, p);
            if inner.live[p] {
                out.live[p] = true;
                self.patch_into(p, &inner, out);
            }
        }
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let mut seen = vec![0.0; force.len()];
        let work = self.inner.obstacle_force_into(derivative, &self.middles.seen(q_1), before, lambda, &mut seen);
        self.pull_back(&seen, force);
        work
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.inner.gap(&self.middles.seen(q))
    }

    fn deepest(&self, q: &[f64]) -> f64 {
        self.inner.deepest(&self.middles.seen(q))
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        self.inner.coverage(&self.middles.seen(q))
    }
}
