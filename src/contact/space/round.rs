//! Contact of a small round obstacle in space with the edges of a surface, for penetration that the distances of the nodes do not detect.
//!
//! Cylinders, cones and tori touch facets along lines that cross their edges, spheres touch sharp edges. Each edge has a constraint, the
//! signed distance of its deepest point `x`, with the shape functions `N_k` of its ends at that point:
//!
//! ```text
//! Phi = w min g(x - u),   x = sum N_k x_k,   dPhi/dx_k = w N_k n(x - u)
//! ```
//!
//! because the minimum is stationary in the edge coordinate. The discrete gradient is `G_mid + (dPhi - G_mid.d)/p.p p` with the increment
//! `d` of the ends relative to the obstacle, and its part `p` orthogonal to the symmetries (rotations, translations) of the obstacle at
//! mid-step, which conserves the moment about a center or an axis (Gonzalez, J. Nonlinear Sci. 6, 1996). A constraint is present in a step
//! if its deepest point is not a node, which has its own constraint. Inside of a cylinder's rim the distance has a kink (`Kink`).

use nalgebra::{Matrix3, RowSVector, SMatrix, SVector, Vector3};

use super::features::Features;
use super::obstacle::{ObstacleInSpace, Shape, Symmetries};
use super::slip::{self, Carrier, Group, SlipsInSpace};
use super::vectors::Vec3;
use super::vertices::NODES;
use crate::contact::faces;
use crate::contact::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use crate::contact::numbers::Number;
use crate::contact::obstacle_side::{Distance, ObstacleSide};
use crate::contact::patches::Evaluation;
use crate::contact::slip::SlipStep;
use crate::contact::surface::{Sides, Surface};
use crate::contact::window::PredictedMotion;
use crate::integrators::{Configuration, Derivative};
use crate::math::tolerances::{LIES_ALONG, PROJECTED_INCREMENT, REMAINDER};

/// Penetration, in smallest facets, beyond which an edge has no constraint: larger initial overlaps are resolved by nodal constraints.
const OVERLAP_OF_SURFACES: f64 = 0.55;

/// Opening in smallest facets, in addition to the motion bound, up to which an edge has a constraint.
const OPEN: f64 = 0.25;

/// Distance of the deepest point from each end, in the edge coordinate, within which the edge has no constraint but its node has.
const AT_END: f64 = 0.02;

/// Jump of the slope along an edge, relative to the edge length, that counts as a kink; smaller jumps are round-off of a smooth shape.
const KINK: f64 = 0.01;

/// Bisections in the search for the deepest point of an edge.
const HALVINGS: usize = 60;

type Six = SVector<f64, 6>;
type SixBySix = SMatrix<f64, 6, 6>;
type Ends = [Vector3<f64>; 2];

/// Contact of a round obstacle with the edges of a surface.
#[derive(Clone, Debug)]
pub struct RoundInSpace {
    sides: Sides,
    shape: Shape,
    translations: [[f64; 3]; 3],
    /// Displacement `[length]` and rotation angle `[rad]` of the obstacle's surface in the step, relative to which slip is measured.
    carried: ([f64; 3], f64),
    /// True if edges have constraints at the rim of a finite cylinder only, because its side is too large to penetrate between nodes.
    only_at_rim: bool,
    /// True for each constraint that is present in this step.
    is_there: Vec<bool>,
    /// Searched segment of the edge of each constraint.
    stretches: Vec<Stretch>,
    /// Ends of the edges at the start of the step, relative to the obstacle.
    start: Vec<Ends>,
}

/// Segment of an edge that is searched for its deepest point. An edge across the hole of a torus has two segments with one constraint each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stretch {
    Whole,
    BeforeHole,
    AfterHole,
}

/// Deepest point of an edge at a configuration.
struct Deepest {
    at: Distance<3>,
    share: f64,
    gradient: Six,
    kink: Option<Kink>,
}

/// Kink of the distance inside of a sharp edge of the obstacle, where the deepest point has the same depth below both sides. The gradient
/// is the convex combination of both normals without component along the surface's edge (Danskin, SIAM J. Appl. Math. 14, 1966); `jump` is
/// the component of the normals' `difference` along this edge.
struct Kink {
    normal: Vector3<f64>,
    curvature: Matrix3<f64>,
    difference: Vector3<f64>,
    jump: f64,
}

impl Kink {
    /// Kink from the distances on both sides of a point of an edge; `None` for a smooth distance.
    fn between([a, b]: [Distance<3>; 2], along: Vector3<f64>) -> Option<Self> {
        let difference = b.normal - a.normal;
        let jump = difference.dot(&along);
        // Coefficient of the first side's normal in the convex combination.
        let share = b.normal.dot(&along) / jump;
        (jump > KINK * along.norm()).then(|| Kink {
            normal: b.normal - difference * share,
            curvature: a.curvature * share + b.curvature * (1.0 - share),
            difference,
            jump,
        })
    }
}

impl Deepest {
    fn new(shape: &Shape, [a, b]: Ends, stretch: Stretch) -> Self {
        let along = b - a;
        let slope = |share: f64| shape.at(a + along * share).normal.dot(&along);
        let (share, beside) = if stretch != Stretch::AfterHole && slope(0.0) >= 0.0 {
            (0.0, None)
        } else if stretch != Stretch::BeforeHole && slope(1.0) <= 0.0 {
            (1.0, None)
        } else {
            let (mut low, mut high) = match stretch {
                Stretch::Whole => (0.0, 1.0),
                Stretch::BeforeHole => (0.0, shape.nearest_to_axis([a, b])),
                Stretch::AfterHole => (shape.nearest_to_axis([a, b]), 1.0),
            };
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if slope(middle) < 0.0 { low = middle } else { high = middle }
            }
            (0.5 * (low + high), Some([low, high]))
        };
        let mut at = shape.at(a + along * share);
        let sides = beside.filter(|_| shape.has_edges()).map(|shares| shares.map(|share| shape.at(a + along * share)));
        let kink = sides.and_then(|sides| Kink::between(sides, along));
        let mut normal = at.normal;
        if let Some(kink) = &kink {
            normal = kink.normal;
            (at.normal, at.curvature) = (normal.try_normalize(0.0).unwrap_or(at.normal), kink.curvature);
        }
        let mut gradient = Six::zeros();
        gradient.fixed_rows_mut::<3>(0).copy_from(&(normal * (1.0 - share)));
        gradient.fixed_rows_mut::<3>(3).copy_from(&(normal * share));
        Deepest { at, share, gradient, kink }
    }

    /// Derivatives of the distance's slope along the edge: with respect to the ends, and to the edge coordinate (0 if this is fixed).
    fn turning(&self, [a, b]: Ends) -> (Six, f64) {
        let Deepest { ref at, share, ref kink, .. } = *self;
        let (along, shares) = (b - a, [1.0 - share, share]);
        let normal = kink.as_ref().map_or(at.normal, |kink| kink.normal);
        let bent = at.curvature * along;
        let bend = along.dot(&bent);
        let mut coupling = Six::zeros();
        for (k, sign) in [-1.0, 1.0].into_iter().enumerate() {
            coupling.fixed_rows_mut::<3>(3 * k).copy_from(&(normal * sign + bent * shares[k]));
        }
        let is_free = 0.0 < share && share < 1.0 && bend > LIES_ALONG * along.norm();
        (coupling, if is_free { bend } else { 0.0 })
    }

    /// Derivative of the edge coordinate of the deepest point with respect to the ends.
    fn slide(&self, ends: Ends) -> Six {
        if let Some(kink) = &self.kink {
            return self.apart(kink) / -kink.jump;
        }
        let (coupling, bend) = self.turning(ends);
        if bend > 0.0 { coupling / -bend } else { Six::zeros() }
    }

    /// Derivative of the difference of the distances from both sides at a kink with respect to the ends.
    fn apart(&self, kink: &Kink) -> Six {
        let mut apart = Six::zeros();
        apart.fixed_rows_mut::<3>(0).copy_from(&(kink.difference * (1.0 - self.share)));
        apart.fixed_rows_mut::<3>(3).copy_from(&(kink.difference * self.share));
        apart
    }

    /// Hessian of the least distance: the Hessian at fixed edge coordinate, reduced by the motion of the deepest point along the edge.
    fn hessian(&self, ends: Ends) -> SixBySix {
        let Deepest { ref at, share, .. } = *self;
        let shares = [1.0 - share, share];
        let mut hessian = SixBySix::zeros();
        for k in 0..2 {
            for l in 0..2 {
                hessian.fixed_view_mut::<3, 3>(3 * k, 3 * l).copy_from(&(at.curvature * (shares[k] * shares[l])));
            }
        }
        let (coupling, bend) = self.turning(ends);
        if let Some(kink) = &self.kink {
            // At a kink, the point keeps equal distances from both sides, and the combined normal keeps a zero component along the edge.
            let (apart, along) = (self.apart(kink), ends[1] - ends[0]);
            hessian -= (coupling * apart.transpose() + apart * coupling.transpose()) / kink.jump;
            hessian += apart * apart.transpose() * (along.dot(&(at.curvature * along)) / kink.jump.powi(2));
        } else if bend > 0.0 {
            hessian -= coupling * coupling.transpose() / bend;
        }
        hessian
    }
}

impl RoundInSpace {
    /// Constraints of a small round obstacle; `None` for other obstacles. `facet_size` is that of the whole contact.
    pub fn new(surface: &Surface, obstacle: &ObstacleInSpace, reference: &[f64], facet_size: f64) -> Option<Self> {
        let shape = Shape::new(obstacle);
        if !obstacle.is_small(surface, reference, facet_size) {
            return None;
        }
        let only_at_rim = match *obstacle {
            ObstacleInSpace::FiniteCylinder { center: point, axis, radius, .. } => {
                !ObstacleInSpace::Cylinder { point, axis, radius, is_hollow: false }.is_small(surface, reference, facet_size)
            }
            _ => false,
        };
        let edges: Vec<[u32; 2]> = match shape {
            // In smooth regions a sphere touches facets rather than edges, so that only sharp edges need constraints.
            Shape::Sphere { .. } => Features::new(surface, reference).edges.iter().map(|edge| edge.nodes).collect(),
            _ => surface.edges().iter().map(|edge| edge.nodes).collect(),
        };
        let edges: Vec<[u32; 2]> = edges.into_iter().flat_map(|nodes| std::iter::repeat_n(nodes, shape.rows_per_edge())).collect();
        let mut sides = Sides { facet_size, ..Sides::of(surface.clone(), Surface::in_space([]), reference) };
        sides.weights = vec![facet_size * facet_size; edges.len()];
        edges.iter().zip(0..).for_each(|(nodes, row)| sides.patches.push(nodes, &[row]));
        sides.list_slips();
        let (is_there, start) = (vec![false; edges.len()], vec![Default::default(); edges.len()]);
        (!edges.is_empty()).then_some(RoundInSpace {
            sides,
            shape,
            translations: [[0.0; 3]; 3],
            carried: ([0.0; 3], 0.0),
            only_at_rim,
            is_there,
            stretches: vec![Stretch::Whole; edges.len()],
            start,
        })
    }

    /// Deepest point in the segment of a constraint.
    fn deepest_of(&self, row: usize, ends: Ends) -> Deepest {
        Deepest::new(&self.shape, ends, self.stretches[row])
    }

    /// Segment of a constraint in a step that starts at `q`; `None` for the second constraint of an edge that is not across a hole.
    fn stretch(&self, row: usize, q: &[f64]) -> Option<Stretch> {
        match (row % self.shape.rows_per_edge(), self.shape.is_across_hole(self.ends(row, q, 0))) {
            (0, false) => Some(Stretch::Whole),
            (0, true) => Some(Stretch::BeforeHole),
            (_, is_across) => is_across.then_some(Stretch::AfterHole),
        }
    }

    /// Ends of an edge relative to the obstacle at the start (0), in the middle (1) or at the end (2) of the step.
    fn ends(&self, row: usize, q: &[f64], time: usize) -> Ends {
        let nodes = self.sides.patches.nodes(row);
        [nodes[0], nodes[1]].map(|node| faces::at(node, q) - Vector3::from(self.translations[time]))
    }

    fn rows_there(&self) -> impl Iterator<Item = usize> {
        (0..self.is_there.len()).filter(|&row| self.is_there[row])
    }

    fn is_near(&self, row: usize, q: &[f64], time: usize, predicted_motion: &PredictedMotion) -> bool {
        let (ends, size) = (self.ends(row, q, time), self.sides.facet_size);
        let length = (ends[1] - ends[0]).norm();
        let motion_bound = predicted_motion.motion_bound::<3>(self.sides.patches.nodes(row), &[]) + self.moved();
        let reach = OPEN * size + motion_bound;
        if ends.iter().all(|&end| self.shape.at(end).gap > reach + length) {
            return false;
        }
        let Deepest { at, share, kink, .. } = self.deepest_of(row, ends);
        // If the segment's end over the hole is its deepest point, this is no local minimum of the distance along the edge.
        if self.stretches[row] != Stretch::Whole && (share - self.shape.nearest_to_axis(ends)).abs() < AT_END {
            return false;
        }
        if self.only_at_rim && kink.is_none() && !self.shape.is_at_rim(ends[0].lerp(&ends[1], share)) {
            return false;
        }
        (AT_END..=1.0 - AT_END).contains(&share) && at.gap < reach && at.gap > -OVERLAP_OF_SURFACES * size
    }

    /// Distance that the obstacle moves in the step.
    fn moved(&self) -> f64 {
        let [from, _, to] = self.translations.map(Vector3::from);
        (to - from).norm()
    }

    /// Algorithmic gradient of a step, and its derivative, without weight.
    fn step_gradient(&self, derivative: Derivative, row: usize, q_1: &[f64], end: &Deepest) -> (Six, SixBySix) {
        let (start, ends) = (self.start[row], self.ends(row, q_1, 2));
        let plain = |ends: Ends, at: Configuration| {
            let found = self.deepest_of(row, ends);
            (found.gradient, found.hessian(ends) * at.share())
        };
        match derivative {
            Derivative::DiscreteGradient => {}
            Derivative::Gradient(at @ Configuration::End) => return plain(ends, at),
            Derivative::Gradient(at @ Configuration::Middle) => {
                let [from, middle, to] = self.translations.map(Vector3::from);
                return plain([0, 1].map(|k| 0.5 * (start[k] + from + ends[k] + to) - middle), at);
            }
        }
        let middle = [0, 1].map(|k| 0.5 * (start[k] + ends[k]));
        let [a, b] = [0, 1].map(|k| ends[k] - start[k]);
        let d = Six::from_iterator(a.iter().chain(b.iter()).copied());
        let found = self.deepest_of(row, middle);
        let hessian = found.hessian(middle);
        let (mut bar, mut tangent) = (found.gradient, hessian * 0.5);
        let (p, of_p) = beside(&self.shape.symmetries(), middle, d);
        let square = p.norm_squared();
        let remainder = end.at.gap - self.deepest_of(row, start).at.gap - found.gradient.dot(&d);
        let size = self.sides.facet_size;
        if square > 0.0 && (square > (PROJECTED_INCREMENT * size).powi(2) || remainder.abs() > REMAINDER * size) {
            let e = remainder / square;
            let of_e = (end.gradient - found.gradient - hessian * d * 0.5).transpose() - p.transpose() * of_p * (2.0 * e);
            bar += p * e;
            tangent += p * of_e / square + of_p * e;
        }
        (bar, tangent)
    }
}

/// Part of an increment that is orthogonal to the symmetries of an obstacle for the ends at mid-step, and its derivative with respect to
/// the ends at the end of the step.
fn beside(symmetries: &Symmetries, middle: Ends, d: Six) -> (Six, SixBySix) {
    let stacked = |vectors: Ends| Six::from_iterator(vectors[0].iter().chain(vectors[1].iter()).copied());
    // Symmetry motions r_j of the ends, and their derivatives.
    let mut motions: Vec<(Six, SixBySix)> = Vec::new();
    for axis in &symmetries.rotations {
        let half = axis.cross_matrix() * 0.5;
        let mut of_motion = SixBySix::zeros();
        (0..2).for_each(|k| of_motion.fixed_view_mut::<3, 3>(3 * k, 3 * k).copy_from(&half));
        motions.push((stacked(middle.map(|x| axis.cross(&(x - symmetries.center)))), of_motion));
    }
    motions.extend(symmetries.translations.iter().map(|&along| (stacked([along; 2]), SixBySix::zeros())));
    let mut products = Matrix3::identity();
    for (j, (one, _)) in motions.iter().enumerate() {
        for (l, (other, _)) in motions.iter().enumerate() {
            products[(j, l)] = one.dot(other);
        }
    }
    let Some(inverse) = products.try_inverse() else { return (d, SixBySix::identity()) };
    let mut right = Vector3::zeros();
    motions.iter().enumerate().for_each(|(j, (motion, _))| right[j] = motion.dot(&d));
    let shares = inverse * right;
    let mut rows = SMatrix::<f64, 3, 6>::zeros();
    for (j, (one, of_one)) in motions.iter().enumerate() {
        let mut row: RowSVector<f64, 6> = d.transpose() * of_one + one.transpose();
        for (l, (other, of_other)) in motions.iter().enumerate() {
            row -= (other.transpose() * of_one + one.transpose() * of_other) * shares[l];
        }
        rows.set_row(j, &row);
    }
    let of_shares = inverse * rows;
    let (mut p, mut of_p) = (d, SixBySix::identity());
    for (j, (motion, of_motion)) in motions.iter().enumerate() {
        p -= motion * shares[j];
        of_p -= of_motion * shares[j] + motion * of_shares.row(j);
    }
    (p, of_p)
}

impl PatchFunctions for RoundInSpace {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn is_nodal(&self) -> bool {
        true
    }

    fn row_nodes(&self) -> &[u32] {
        // Constraints belong to edges, not to nodes.
        &[]
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.start = (0..self.start.len()).map(|row| self.ends(row, q_0, 0)).collect();
    }

    fn start_gap(&self) -> Vec<f64> {
        self.sides.weighted(self.rows_there().map(|row| (row, self.deepest_of(row, self.start[row]).at.gap)))
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        out.prepare(&self.sides.patches, self.sides.weights.len());
        for row in 0..self.is_there.len() {
            out.clear_patch(&self.sides.patches, row);
            if !self.is_there[row] {
                continue;
            }
            let weight = self.sides.weights[row];
            let end = self.deepest_of(row, self.ends(row, q_1, 2));
            let (bar, tangent) = self.step_gradient(derivative, row, q_1, &end);
            out.live[row] = true;
            (out.gap[row], out.coverage[row]) = (weight * end.at.gap, 1.0);
            out.gradient_end[6 * row..6 * (row + 1)].copy_from_slice((end.gradient * weight).as_slice());
            out.gradient_bar[6 * row..6 * (row + 1)].copy_from_slice((bar * weight).as_slice());
            // Column-major storage of the transposed matrix is row-major storage of the matrix.
            let block = tangent.transpose() * (weight * lambda[row]);
            out.tangent[36 * row..36 * (row + 1)].copy_from_slice(block.as_slice());
        }
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.sides, step, lambda, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.sides.weighted(self.rows_there().map(|row| (row, self.deepest_of(row, self.ends(row, q, 2)).at.gap)))
    }

    fn coverage(&self, _q: &[f64]) -> Vec<f64> {
        self.is_there.iter().map(|&is_there| f64::from(u8::from(is_there))).collect()
    }
}

/// Slip of the deepest point of an edge relative to the moving obstacle.
impl SlipsInSpace for RoundInSpace {
    fn groups<T: Number>(&self, p: usize, z: &[Vec3<T>]) -> Vec<Group<T>> {
        if !self.is_there[p] {
            return Vec::new();
        }
        let ends = [z[0], z[1]].map(|end| Vector3::from(end.map(|x| x.re())) - Vector3::from(self.translations[1]));
        let found = self.deepest_of(p, ends);
        let axis = slip::farthest_axis(self.deepest_of(p, self.start[p]).at.normal.into());
        let share = slip::linear(found.share, found.slide(ends).as_slice(), z);
        let weight = self.sides.weights[p];
        let mut weights = [T::from(0.0); NODES];
        (weights[0], weights[1]) = ((-share + 1.0) * weight, share * weight);
        let x: [Vec3<T>; 1] = [std::array::from_fn(|i| z[0][i] + (z[1][i] - z[0][i]) * share)];
        let bend = found.at.curvature;
        let normal = std::array::from_fn(|i| slip::linear(found.at.normal[i], &[0, 1, 2].map(|k| bend[(i, k)]), &x));
        vec![Group { place: 0, weights, tangents: slip::tangents(normal, axis), covered: 1.0, normal: None }]
    }

    fn carrier(&self) -> Option<Carrier> {
        Some(self.shape.carrier(self.carried, self.translations[2]))
    }
}

impl CandidateSearch for RoundInSpace {
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        let q = predicted_motion.q;
        let end = predicted_motion.end();
        let stretches: Vec<Option<Stretch>> = (0..self.is_there.len()).map(|row| self.stretch(row, q)).collect();
        self.stretches = stretches.iter().map(|stretch| stretch.unwrap_or(Stretch::Whole)).collect();
        let is_near = |row: usize, q: &[f64], time: usize| self.is_near(row, q, time, predicted_motion);
        let is_there = |row: usize| is_near(row, q, 0) || end.as_ref().is_some_and(|end| is_near(row, end, 2));
        self.is_there = stretches.iter().enumerate().map(|(row, stretch)| stretch.is_some() && is_there(row)).collect();
        // The list of contact elements never changes.
        false
    }

    fn for_each_participant(&self, p: usize, visit: &mut dyn FnMut(u32)) {
        if self.is_there[p] {
            self.sides.patches.nodes(p).iter().copied().for_each(visit);
        }
    }

    fn deepest(&self, q: &[f64]) -> f64 {
        self.gap(q).iter().zip(&self.sides.weights).map(|(gap, weight)| -gap / weight).fold(0.0, f64::max)
    }
}

impl RigidObstacle for RoundInSpace {
    fn move_obstacle(&mut self, translations: &[[f64; 3]; 3]) {
        self.translations = *translations;
    }

    fn carry(&mut self, shift: [f64; 3], angle: f64) {
        self.carried = (shift, angle);
    }

    fn obstacle_translation(&self) -> [f64; 3] {
        self.translations[2]
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let [start, _, end] = self.translations.map(Vector3::from);
        let mut work = 0.0;
        for row in self.rows_there().filter(|&row| before[row] != 0.0 || lambda[row] != 0.0) {
            let at_end = self.deepest_of(row, self.ends(row, q_1, 2));
            let of_step = self.step_gradient(derivative, row, q_1, &at_end).0 * lambda[row];
            let of_start = self.deepest_of(row, self.start[row]).gradient * before[row];
            let f = (of_step + of_start) * self.sides.weights[row];
            for (k, &node) in self.sides.patches.nodes(row).iter().enumerate() {
                let on_node = f.fixed_rows::<3>(3 * k);
                (0..3).for_each(|i| force[3 * node as usize + i] += on_node[i]);
                work += on_node.dot(&(end - start));
            }
        }
        work
    }
}
