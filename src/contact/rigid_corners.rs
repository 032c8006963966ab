//! Contact of the corners of a rigid polyline with the facets of a surface: what the distances of the surface's nodes do not see.
//!
//! A corner is a point of its own that the obstacle's motion moves, and its gap to the surface that of node-to-segment contact with the
//! sides exchanged: one continuous function of all positions, the corner's among them. Its discrete gradient satisfies
//! `Gbar_nodes.dq + Gbar_corner.du = Phi(1) - Phi(0)`, so that an obstacle that moves does the work `-lambda Gbar_corner.du` besides.

use super::node_to_segment::NodeToSegment;
use super::patches::{Evaluation, Patches};
use super::rigid::Obstacle;
use super::surface::Sides;
use super::window::{Outlook, Travel};
use super::{Candidates, ContactKernel};
use crate::integrators::Derivative;

/// Contact of an obstacle's corners with a surface.
#[derive(Clone, Debug)]
pub struct RigidCorners {
    /// The contact with the corners as nodes behind those of the model.
    inner: NodeToSegment,
    /// The surface alone, with the patches that are left without the corners.
    sides: Sides,
    points: Vec<[f64; 2]>,
    /// Components of the model's positions.
    components: usize,
    translations: [[f64; 2]; 3],
    /// All positions at the start of the step.
    start: Vec<f64>,
}

impl RigidCorners {
    /// Contact of the obstacle's corners with a surface (facets in node numbers of the model, the body on the left); `None` where it has
    /// none. `facet_size` is that of the whole contact.
    pub fn new(surface: &[[u32; 2]], obstacle: &Obstacle, reference: &[f64], facet_size: f64) -> Option<Self> {
        let Obstacle::Polyline { points } = obstacle else { return None };
        let first = (reference.len() / 2) as u32;
        let last = points.len().checked_sub(1)?;
        let is_closed = last > 2 && points[0] == points[last];
        let node = |k: usize| first + if is_closed && k == last { 0 } else { k as u32 };
        let facets: Vec<[u32; 2]> = (0..last).map(|k| [node(k), node(k + 1)]).collect();
        let points = points[..points.len() - usize::from(is_closed)].to_vec();
        let start: Vec<f64> = reference.iter().chain(points.as_flattened()).copied().collect();
        let inner = NodeToSegment::of_corners(&facets, surface, &start, facet_size)?;
        let sides = Sides { weights: inner.weights().to_vec(), facet_size, ..Sides::new(surface, &[], reference) };
        Some(RigidCorners { inner, sides, points, components: reference.len(), translations: [[0.0; 2]; 3], start })
    }

    /// Positions or displacements with those of the corners behind them.
    fn extended(&self, q: &[f64], corner: impl Fn([f64; 2]) -> [f64; 2]) -> Vec<f64> {
        q.iter().copied().chain(self.points.iter().flat_map(|&point| corner(point))).collect()
    }

    /// All positions at `q`, the obstacle where it is at the start, in the middle or at the end of the step.
    fn positions(&self, q: &[f64], time: usize) -> Vec<f64> {
        let by = self.translations[time];
        self.extended(q, |point| [point[0] + by[0], point[1] + by[1]])
    }

    /// The patches without the corners.
    fn list_patches(&mut self) {
        self.sides.patches = Patches::new(2);
        for p in 0..self.inner.patches().len() {
            self.sides.patches.push(&self.inner.patches().nodes(p)[1..], self.inner.patches().rows(p));
        }
    }
}

impl ContactKernel for RigidCorners {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn rows_per_node(&self) -> usize {
        self.inner.rows_per_node()
    }

    fn row_nodes(&self) -> &[u32] {
        // The corners are no nodes of the model.
        &[]
    }

    fn update_candidates(&mut self, outlook: &Outlook) -> bool {
        let q = self.positions(outlook.q, 0);
        let changed = match outlook.travel {
            Travel::UpTo(_) => self.inner.update_candidates(&Outlook { q: &q, ..*outlook }),
            Travel::Each { sizes, besides } => {
                let sizes: Vec<f64> = sizes.iter().copied().chain(self.points.iter().map(|_| 0.0)).collect();
                self.inner.update_candidates(&Outlook { q: &q, travel: Travel::Each { sizes: &sizes, besides }, ..*outlook })
            }
            Travel::Guessed { displacements, factor } => {
                let [from, _, to] = self.translations;
                let [a, b] = displacements.map(|u| self.extended(u, |_| [to[0] - from[0], to[1] - from[1]]));
                let travel = Travel::Guessed { displacements: [&a, &b], factor };
                self.inner.update_candidates(&Outlook { q: &q, travel, ..*outlook })
            }
        };
        if changed {
            self.list_patches();
        }
        changed
    }

    fn candidates(&self) -> Option<&Candidates> {
        self.inner.candidates()
    }

    fn restore_candidates(&mut self, candidates: &Candidates, q: &[f64]) {
        self.start = self.positions(q, 0);
        self.inner.restore_candidates(candidates, &self.start);
        self.list_patches();
    }

    fn move_obstacle(&mut self, translations: &[[f64; 2]; 3]) {
        self.translations = *translations;
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.start = self.positions(q_0, 0);
        self.inner.begin_step(&self.start);
    }

    fn start_gap(&self) -> Vec<f64> {
        self.inner.start_gap()
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        let mut all = Evaluation::default();
        self.inner.evaluate(derivative, &self.positions(q_1, 2), lambda, &mut all);
        out.prepare(&self.sides.patches, self.sides.weights.len());
        out.gap.copy_from_slice(&all.gap);
        out.coverage.copy_from_slice(&all.coverage);
        let (inner, outer) = (self.inner.patches(), &self.sides.patches);
        for p in 0..outer.len() {
            if !all.live[p] {
                out.clear_patch(outer, p);
                continue;
            }
            out.live[p] = true;
            // The corner is the first node of a patch.
            let width = inner.unknowns(p);
            for (from, to) in [(&all.gradient_end, &mut out.gradient_end), (&all.gradient_bar, &mut out.gradient_bar)] {
                let rows = to[outer.gradient_range(p)].chunks_exact_mut(width - 2).zip(from[inner.gradient_range(p)].chunks_exact(width));
                rows.for_each(|(to, from)| to.copy_from_slice(&from[2..]));
            }
            let rows = out.tangent[outer.tangent_range(p)].chunks_exact_mut(width - 2);
            let from = all.tangent[inner.tangent_range(p)].chunks_exact(width).skip(2);
            rows.zip(from).for_each(|(to, from)| to.copy_from_slice(&from[2..]));
        }
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let mut sum = vec![0.0; self.start.len()];
        let mut add = |derivative: Derivative, q: &[f64], lambda: &[f64]| {
            if lambda.iter().all(|lambda| *lambda == 0.0) {
                return;
            }
            let mut all = Evaluation::default();
            self.inner.evaluate(derivative, q, lambda, &mut all);
            let patches = self.inner.patches();
            for p in (0..patches.len()).filter(|&p| all.live[p]) {
                let gradients = all.gradient_bar[patches.gradient_range(p)].chunks_exact(patches.unknowns(p));
                for (&row, gradient) in patches.rows(p).iter().zip(gradients) {
                    for (u, &node) in patches.nodes(p).iter().enumerate() {
                        (0..2).for_each(|i| sum[2 * node as usize + i] += lambda[row as usize] * gradient[2 * u + i]);
                    }
                }
            }
        };
        add(derivative, &self.positions(q_1, 2), lambda);
        add(Derivative::AT_END, &self.start, before);
        let (nodes, corners) = sum.split_at(self.components);
        force.iter_mut().zip(nodes).for_each(|(force, f)| *force += f);
        let [from, _, to] = self.translations;
        -corners.chunks_exact(2).map(|f| f[0] * (to[0] - from[0]) + f[1] * (to[1] - from[1])).sum::<f64>()
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.inner.gap(&self.positions(q, 2))
    }

    fn deepest(&self, q: &[f64]) -> f64 {
        self.inner.deepest(&self.positions(q, 2))
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        self.inner.coverage(&self.positions(q, 2))
    }
}
