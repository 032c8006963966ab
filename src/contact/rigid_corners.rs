//! Contact of points of a rigid obstacle with the facets of a surface, for penetration between the nodes of the surface.
//!
//! In space these points are sharp vertices and edges (`space/corners.rs`) or the center of a small sphere, in the plane corners of a
//! polyline or the center of a disk. They are additional nodes that move with the obstacle. The gap of a corner is that of node-to-segment
//! contact with exchanged sides, the gap of a disk that of `round.rs`. Their discrete gradients satisfy `Gbar_nodes.dq + Gbar_point.du =
//! Phi(1) - Phi(0)`, so that a moving obstacle does the further work `-lambda Gbar_point.du`.

use super::node_to_segment::NodeToSegment;
use super::patches::{Evaluation, Patches};
use super::rigid_shape::Obstacle;
use super::round::RoundContact;
use super::slip::SlipStep;
use super::space::{CornersInSpace, ObstacleInSpace};
use super::surface::{Sides, Surface};
use super::window::PredictedMotion;
use super::{CandidateSearch, Candidates, ContactKernel, PatchFunctions, RigidObstacle};
use crate::integrators::Derivative;

/// Radius of a disk, in shortest facets, below which its constraints have less slack than those of corners.
const ROUND: f64 = 10.0;

/// Ratio of disk radius to longest facet above which a disk has no constraints against facets. Between two nodes on such a disk even a
/// facet stretched by half penetrates by less than a tenth of its length, and further constraints would depend linearly on those of the
/// nodes.
const LARGE: f64 = 3.0;

/// Contact of characteristic points of a rigid obstacle with a surface.
pub struct RigidCorners {
    /// Contact kernel with the points as nodes after those of the model.
    inner: Box<dyn ContactKernel>,
    /// The surface, with contact elements from which the points are removed.
    sides: Sides,
    /// Coordinates of the obstacle's points at its undisplaced position.
    points: Vec<f64>,
    dimension: usize,
    /// Number of position components of the model, before those of the obstacle's points.
    components: usize,
    translations: [[f64; 3]; 3],
    /// Displacement of the obstacle's surface in the step, relative to which slip is measured.
    shift: [f64; 3],
    /// Positions of nodes and points at the start of the step.
    start: Vec<f64>,
}

impl RigidCorners {
    /// Contact of the obstacle's points with a surface: corners of a polyline, the center of a disk with a radius up to `LARGE`, sharp
    /// vertices and edges in space, the center of a small sphere, the tip of a cone; `None` without any. The points of the surface are at
    /// `reference`, in space without the rise that represents faces of second order at `curve`. `facet_size` is that of the whole contact.
    pub fn new(surface: &Surface, obstacle: &Obstacle, [reference, curve]: [&[f64]; 2], facet_size: f64) -> Option<Self> {
        let dimension = surface.dimension();
        let first = (reference.len() / dimension) as u32;
        let with = |points: &[f64]| -> Vec<f64> { reference.iter().chain(points).copied().collect() };
        let (points, inner): (Vec<f64>, Box<dyn ContactKernel>) = match obstacle {
            Obstacle::Polyline { points } => {
                let last = points.len().checked_sub(1)?;
                let is_closed = last > 2 && points[0] == points[last];
                let node = |k: usize| first + if is_closed && k == last { 0 } else { k as u32 };
                let facets: Vec<[u32; 2]> = (0..last).map(|k| [node(k), node(k + 1)]).collect();
                let points = points[..points.len() - usize::from(is_closed)].as_flattened().to_vec();
                let inner = NodeToSegment::of_points(&facets, surface.facets(), &with(&points), facet_size);
                (points, Box::new(inner))
            }
            Obstacle::Disk { center, radius } => {
                let longest = (0..surface.count()).map(|facet| surface.facet_measure(facet, reference)).fold(0.0, f64::max);
                if *radius > LARGE * longest * longest / facet_size {
                    return None;
                }
                (center.to_vec(), Box::new(RoundContact::new(first, *radius, surface.facets(), &with(center), facet_size)))
            }
            Obstacle::InSpace(shape) => {
                let ball = |center: &[f64; 3], radius: f64| {
                    (center.to_vec(), CornersInSpace::of_ball(surface.clone(), (first, radius), &with(center), curve, facet_size))
                };
                let is_small = || shape.is_small(surface, reference, facet_size);
                match shape {
                    ObstacleInSpace::Facets(facets) => {
                        let triangles: Vec<[u32; 3]> = facets.triangles().iter().map(|nodes| nodes.map(|node| first + node)).collect();
                        let of_obstacle = Surface::in_space(triangles.iter().map(|nodes| &nodes[..]));
                        let points = facets.points().as_flattened().to_vec();
                        let inner = CornersInSpace::of_obstacle(surface.clone(), of_obstacle, &with(&points), curve, facet_size)?;
                        (points, inner)
                    }
                    ObstacleInSpace::Sphere { center, radius, .. } if is_small() => ball(center, *radius),
                    ObstacleInSpace::Cone { tip, .. } if is_small() => ball(tip, 0.0),
                    _ => return None,
                }
            }
            Obstacle::HalfPlane { .. } | Obstacle::Ring { .. } => return None,
        };
        let (start, weights) = (with(&points), inner.weights().to_vec());
        let sides = Sides::of(surface.clone(), if dimension == 2 { Surface::new(&[]) } else { Surface::in_space([]) }, reference);
        let sides = Sides { facet_size, weights, ..sides };
        let (translations, shift) = ([[0.0; 3]; 3], [0.0; 3]);
        Some(RigidCorners { inner, sides, points, dimension, components: reference.len(), translations, shift, start })
    }

    /// Slack of the constraints of an obstacle's points relative to that of corners. On a small disk nodes and facets touch alternately,
    /// and a larger slack would cause a noticeable ripple of the motion.
    pub fn slack(obstacle: &Obstacle, facet_size: f64) -> f64 {
        match obstacle {
            Obstacle::Disk { radius, .. } => (radius / (ROUND * facet_size)).min(1.0),
            _ => 1.0,
        }
    }

    /// Vector of the model extended by the obstacle's points; `place` maps a coordinate of a point and its component index to the appended
    /// value.
    fn extended(&self, q: &[f64], place: impl Fn(f64, usize) -> f64) -> Vec<f64> {
        let points = self.points.iter().enumerate().map(|(k, &x)| place(x, k % self.dimension));
        q.iter().copied().chain(points).collect()
    }

    /// Positions of nodes and points for the obstacle at the start (0), in the middle (1) or at the end (2) of the step.
    fn positions(&self, q: &[f64], time: usize) -> Vec<f64> {
        let by = self.translations[time];
        self.extended(q, |x, i| x + by[i])
    }

    /// Lists the contact elements of the inner kernel without the obstacle's points.
    fn list_patches(&mut self) {
        let inner = self.inner.patches();
        self.sides.patches = Patches::new(self.dimension);
        for p in 0..inner.len() {
            let nodes: Vec<u32> = inner.nodes(p).iter().copied().filter(|&node| self.is_of_model(node)).collect();
            self.sides.patches.push(&nodes, inner.rows(p));
        }
        if self.dimension == 3 {
            self.sides.list_slips();
        }
    }

    fn is_of_model(&self, node: u32) -> bool {
        (node as usize) < self.components / self.dimension
    }

    /// Copies an evaluation without the unknowns of the points; `inner` and `outer` are the contact elements with and without points.
    fn without_points(&self, [inner, outer]: [&Patches; 2], all: &Evaluation, out: &mut Evaluation) {
        out.prepare(outer, all.gap.len());
        out.gap.copy_from_slice(&all.gap);
        out.coverage.copy_from_slice(&all.coverage);
        for p in 0..outer.len() {
            if !all.live[p] {
                out.clear_patch(outer, p);
                continue;
            }
            out.live[p] = true;
            let (width, left, d) = (inner.unknowns(p), outer.unknowns(p), self.dimension);
            let kept: Vec<usize> = (0..width).filter(|k| self.is_of_model(inner.nodes(p)[k / d])).collect();
            let pick = |from: &[f64], to: &mut [f64]| to.iter_mut().zip(&kept).for_each(|(to, &k)| *to = from[k]);
            for (from, to) in [(&all.gradient_end, &mut out.gradient_end), (&all.gradient_bar, &mut out.gradient_bar)] {
                let rows = to[outer.gradient_range(p)].chunks_exact_mut(left).zip(from[all.gradient_range(inner, p)].chunks_exact(width));
                rows.for_each(|(to, from)| pick(from, to));
            }
            let rows = out.tangent[outer.tangent_range(p)].chunks_exact_mut(left);
            let from = &all.tangent[all.tangent_range(inner, p)];
            if from.is_empty() {
                rows.for_each(|row| row.fill(0.0));
            } else {
                rows.zip(&kept).for_each(|(to, &k)| pick(&from[k * width..(k + 1) * width], to));
            }
        }
    }
}

impl PatchFunctions for RigidCorners {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn rows_per_node(&self) -> usize {
        self.inner.rows_per_node()
    }

    fn row_nodes(&self) -> &[u32] {
        // The obstacle's points are not nodes of the model.
        &[]
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
        self.without_points([self.inner.patches(), &self.sides.patches], &all, out);
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        let mut all = Evaluation::default();
        let (q_0, q_1) = (self.positions(step.q_0, 0), self.positions(step.q_1, 2));
        let moved = self.extended(step.moved, |_, i| self.shift[i]);
        self.inner.evaluate_slips(SlipStep { q_0: &q_0, q_1: &q_1, moved: &moved, ..step }, lambda, &mut all);
        self.without_points([self.inner.slip_patches(), self.sides.slip_patches()], &all, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.inner.gap(&self.positions(q, 2))
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        self.inner.coverage(&self.positions(q, 2))
    }
}

impl CandidateSearch for RigidCorners {
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        let ([from, _, to], points) = (self.translations, self.points.len() / self.dimension);
        let bounds = |sizes: &[f64]| sizes.iter().copied().chain(std::iter::repeat_n(0.0, points)).collect();
        let moved = |u: &[f64]| self.extended(u, |_, i| to[i] - from[i]);
        let motion = predicted_motion.mapped(self.positions(predicted_motion.q, 0), bounds, moved);
        let changed = self.inner.update_candidates(&motion.of_points());
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

    fn deepest(&self, q: &[f64]) -> f64 {
        self.inner.deepest(&self.positions(q, 2))
    }
}

impl RigidObstacle for RigidCorners {
    fn move_obstacle(&mut self, translations: &[[f64; 3]; 3]) {
        self.translations = *translations;
    }

    fn carry(&mut self, shift: [f64; 3], angle: f64) {
        self.shift = shift;
        self.inner.carry(shift, angle);
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
                let gradients = all.gradient_bar[all.gradient_range(patches, p)].chunks_exact(patches.unknowns(p));
                for (&row, gradient) in patches.rows(p).iter().zip(gradients) {
                    for (u, &node) in patches.nodes(p).iter().enumerate() {
                        let (at, first) = (self.dimension * node as usize, self.dimension * u);
                        (0..self.dimension).for_each(|i| sum[at + i] += lambda[row as usize] * gradient[first + i]);
                    }
                }
            }
        };
        add(derivative, &self.positions(q_1, 2), lambda);
        add(Derivative::AT_END, &self.start, before);
        let (nodes, corners) = sum.split_at(self.components);
        force.iter_mut().zip(nodes).for_each(|(force, f)| *force += f);
        let [from, _, to] = self.translations;
        let of_point = |f: &[f64]| f.iter().zip(from.iter().zip(&to)).map(|(f, (from, to))| f * (to - from)).sum::<f64>();
        -corners.chunks_exact(self.dimension).map(of_point).sum::<f64>()
    }
}
