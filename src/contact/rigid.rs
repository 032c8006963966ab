//! Contact of a surface in the plane with a rigid obstacle (half plane, disk, ring, polyline): one multiplier per secondary node.
//!
//! The gap of a node is its signed distance `g` from the obstacle, `Phi_A = w_A g(x_A - u(t))` with the obstacle's translation `u`. With
//! `r_k = x_k - u_k` the discrete gradient satisfies `Gbar.(r_1 - r_0) = g(r_1) - g(r_0)`:
//!
//! ```text
//! half plane   n                                      the force on a plane has one direction: momentum along it is kept
//! disk, ring   +-(r_0 + r_1)/(|r_0| + |r_1|)          through the invariant r.r: parallel to r_mid, the moment about the center is zero
//! polyline     n_mid + (g_1 - g_0 - n_mid.dr)/dr.dr dr
//! ```
//!
//! (Gonzalez, CMAME 190, 2000). The contact forces do the work `sum lambda_A (Phi_A(1) - Phi_A(0))`; a moving obstacle does the further
//! work `sum lambda_A Gbar_A.(u_1 - u_0)`, which the ledger counts as work of loads. Obstacles that turn: `turning.rs`.

use nalgebra::Vector2;

use super::edge_plane::{self, ACROSS_EDGE};
use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use super::node_arcs::{ArcGradient, Nearest, NodeArc, Nodes, node_arcs};
use super::numbers::Number;
use super::patches::Evaluation;
use super::rigid_shape::{Distance, Obstacle, PlaneOutline, StepGradient};
use super::slip::{self, Carrier, SlipRows, SlipStep};
use super::surface::Sides;
use crate::integrators::{Configuration, Derivative};
use crate::math::tolerances::CROSSING;

/// Distance from a convex corner of a polyline, in shortest facets, within which a node keeps to one side in a step.
const AT_CORNER: f64 = 0.02;

/// Unknowns of an arc: positions of three nodes.
const UNKNOWNS: usize = 6;

/// Contact of a surface with a rigid obstacle.
#[derive(Clone, Debug)]
pub struct RigidContact {
    sides: Sides,
    shape: PlaneOutline,
    translations: [[f64; 2]; 3],
    /// Displacement `[length]` and rotation angle `[rad]` of the obstacle's surface in the step, relative to which slip is measured.
    carried: ([f64; 2], f64),
    start: Vec<[f64; 2]>,
    /// Arcs of the nodes on convex curves, which touch instead of the nodes.
    arcs: Vec<Option<NodeArc>>,
    /// True if the corners of a polyline have constraints of their own against the facets.
    is_beside_corners: bool,
    /// True for nodes without constraints: those inside of round parts of a rigid body, which `rolling.rs` constrains instead.
    is_hidden: Vec<bool>,
    /// For nodes that start at a convex corner of a polyline: the straight line of their side, or one through the corner (`edge_plane.rs`),
    /// which replaces the obstacle in this step. Otherwise the step may have no solution: one side pushes the node past the corner, and
    /// without this force the node returns.
    lines: Vec<Option<PlaneOutline>>,
}

impl RigidContact {
    /// Contact of a surface (facets in model node numbers, the body on the left) with an obstacle, sized in the reference positions.
    pub fn new(secondary: &[[u32; 2]], obstacle: &Obstacle, reference: &[f64]) -> Self {
        let mut sides = Sides::new(secondary, &[], reference);
        // Every node is opposite the obstacle, so that the list of contact elements never changes.
        for (row, &node) in (0u32..).zip(sides.secondary.nodes()) {
            sides.patches.push(&[node], &[row]);
        }
        let nodes = sides.secondary.nodes().iter();
        let start = nodes.map(|&node| [reference[2 * node as usize], reference[2 * node as usize + 1]]).collect();
        let lines = vec![None; sides.weights.len()];
        let sides_count = sides.weights.len();
        let is_hidden = vec![false; sides_count];
        RigidContact {
            sides,
            shape: PlaneOutline::new(obstacle),
            translations: [[0.0; 2]; 3],
            carried: Default::default(),
            start,
            arcs: vec![None; sides_count],
            is_beside_corners: false,
            is_hidden,
            lines,
        }
    }

    /// Lets nodes on convex curves touch with the nearest point of their arc; `radius` is that of the exact shape of the surface, if it is
    /// known.
    pub fn of_curve(mut self, reference: &[f64], radius: Option<f64>) -> Self {
        let surface = &self.sides.secondary;
        self.arcs = node_arcs(surface, reference, radius, &self.shape);
        self.sides.patches.clear();
        for (index, arc) in self.arcs.iter().enumerate() {
            let nodes: Vec<u32> = match arc {
                Some(arc) if !self.is_hidden[index] => arc.nodes.iter().map(|&node| surface.nodes()[node]).collect(),
                _ => vec![surface.nodes()[index]],
            };
            self.sides.patches.push(&nodes, &[index as u32]);
        }
        self
    }

    /// Outline from which the gap of constraint `row` is measured in this step.
    fn obstacle_side(&self, row: usize) -> &PlaneOutline {
        self.lines[row].as_ref().unwrap_or(&self.shape)
    }

    /// Half plane in place of the obstacle for a node that starts the step at a convex corner.
    fn line_at_corner(&self, row: usize, q_0: &[f64]) -> Option<PlaneOutline> {
        let (surface, size) = (&self.sides.secondary, self.sides.facet_size);
        let x = self.position(row, q_0, self.translations[0]);
        let at = self.shape.at_corner(x, ACROSS_EDGE * size)?;
        let adjacent = surface.adjacent_facets(row).iter().map(|&facet| facet as usize);
        let others =
            adjacent.clone().flat_map(|facet| surface.local_facets()[facet]).map(|other| other as usize).filter(|&other| other != row);
        let around = others.map(|other| Vector2::from(self.position(other, q_0, self.translations[0])) - Vector2::from(x));
        let facing = adjacent.map(|facet| -Vector2::from_column_slice(&surface.outward(facet, q_0)));
        let through_corner = edge_plane::plane_through(&at, around, facing, x.into(), size).filter(|_| self.is_beside_corners);
        let plane = through_corner.or_else(|| (at.distance <= AT_CORNER * size).then(|| [at.points[0], at.normals[0]]));
        plane.map(|[point, normal]| PlaneOutline::HalfPlane { point: point.into(), normal: normal.into() })
    }

    /// Removes the constraints of the given nodes (model numbers).
    pub fn without(mut self, nodes: &[u32]) -> Self {
        nodes.iter().filter_map(|&node| self.sides.secondary.index(node)).for_each(|row| self.is_hidden[row] = true);
        self
    }

    /// Indices of the nodes with constraints.
    fn rows_there(&self) -> impl Iterator<Item = usize> {
        (0..self.sides.patches.len()).filter(|&row| !self.is_hidden[row])
    }

    /// Replaces the tributary lengths of the nodes, in ascending node order `[length]`.
    pub fn with_weights(mut self, weights: Vec<f64>) -> Self {
        self.sides.weights = weights;
        self
    }

    /// Position of node `row` relative to the obstacle displaced by `translation`.
    fn position(&self, row: usize, q: &[f64], translation: [f64; 2]) -> [f64; 2] {
        let node = 2 * self.sides.secondary.nodes()[row] as usize;
        [q[node] - translation[0], q[node + 1] - translation[1]]
    }

    /// Algorithmic gradient of a step, and its derivative, for node `row`, without weight.
    fn step_gradient(&self, derivative: Derivative, row: usize, q_1: &[f64]) -> StepGradient {
        let [start, middle, end] = self.translations;
        match derivative {
            Derivative::DiscreteGradient => {
                let x_0 = [self.start[row][0] - start[0], self.start[row][1] - start[1]];
                self.obstacle_side(row).step_gradient(x_0, self.position(row, q_1, end), self.sides.facet_size)
            }
            Derivative::Gradient(at @ Configuration::Middle) => {
                let x_1 = self.position(row, q_1, [0.0; 2]);
                self.plain(row, std::array::from_fn(|i| 0.5 * (self.start[row][i] + x_1[i]) - middle[i]), at)
            }
            Derivative::Gradient(at @ Configuration::End) => self.plain(row, self.position(row, q_1, end), at),
        }
    }

    /// Gradient and its derivative for node `row` at the point `x` of a configuration of the step.
    fn plain(&self, row: usize, x: [f64; 2], at: Configuration) -> StepGradient {
        StepGradient {
            bar: self.obstacle_side(row).distance(x).map_or([0.0; 2], |distance| distance.normal),
            tangent: self.obstacle_side(row).curvature(x).map(|row| row.map(|h| at.share() * h)),
        }
    }

    /// Arc of a constraint, with the positions of its nodes relative to the obstacle displaced by `translation`.
    fn arc(&self, row: usize, translation: [f64; 2], position: impl Fn(usize) -> [f64; 2]) -> Option<(&NodeArc, Nodes)> {
        let arc = self.arcs[row].as_ref()?;
        Some((arc, arc.nodes.map(|index| Vector2::from(position(index)) - Vector2::from(translation))))
    }

    /// Signed distance of the node or arc of a constraint from `shape` displaced by `translation`, for nodes at `position`.
    fn distance(&self, row: usize, shape: &PlaneOutline, translation: [f64; 2], position: impl Fn(usize) -> [f64; 2]) -> Option<Distance> {
        if let Some((arc, z)) = self.arc(row, translation, &position) {
            let Nearest { local, .. } = arc.nearest(shape, &z);
            return Some(Distance { gap: local.gap, normal: local.normal.into(), covered: local.covered });
        }
        let x = position(row);
        shape.distance([x[0] - translation[0], x[1] - translation[1]])
    }

    /// Weighted signed distances from `shape(row)` for the obstacle displaced by `translation`.
    fn gaps<'a>(&self, shape: impl Fn(usize) -> &'a PlaneOutline, translation: [f64; 2], position: impl Fn(usize) -> [f64; 2]) -> Vec<f64> {
        let mut gaps = vec![0.0; self.sides.weights.len()];
        for row in self.rows_there() {
            let distance = self.distance(row, shape(row), translation, &position);
            gaps[row] = self.sides.weights[row] * distance.map_or(0.0, |distance| distance.gap);
        }
        gaps
    }

    /// Gradient of the gap of an arc at the end of the step, and its algorithmic gradient, without weight; `None` for nodes.
    fn arc_gradients(&self, derivative: Derivative, row: usize, q_1: &[f64]) -> Option<(Nearest, ArcGradient)> {
        let [start, middle, end] = self.translations;
        let at_end = |index: usize| self.position(index, q_1, [0.0; 2]);
        let half = |index: usize| {
            let (x_0, x_1) = (self.start[index], at_end(index));
            std::array::from_fn(|i| 0.5 * (x_0[i] + x_1[i]))
        };
        let (arc, z_1) = self.arc(row, end, at_end)?;
        let of_step = match derivative {
            Derivative::DiscreteGradient => {
                arc.between(&self.shape, &self.arc(row, start, |index| self.start[index])?.1, &z_1, self.sides.facet_size)
            }
            Derivative::Gradient(at @ Configuration::Middle) => arc.plain(&self.shape, &self.arc(row, middle, half)?.1, at.share()),
            Derivative::Gradient(at @ Configuration::End) => arc.plain(&self.shape, &z_1, at.share()),
        };
        Some((arc.nearest(&self.shape, &z_1), of_step))
    }

    /// Evaluates the constraint of an arc; false for nodes.
    fn evaluate_arc(&self, derivative: Derivative, row: usize, q_1: &[f64], lambda: f64, out: &mut Evaluation) -> bool {
        let Some((end, of_step)) = self.arc_gradients(derivative, row, q_1) else { return false };
        let weight = self.sides.weights[row];
        let (gradient, tangent) = (self.sides.patches.gradient_range(row).start, self.sides.patches.tangent_range(row).start);
        out.live[row] = true;
        (out.gap[row], out.coverage[row]) = (weight * end.local.gap, f64::from(u8::from(end.local.covered)));
        for i in 0..UNKNOWNS {
            out.gradient_end[gradient + i] = weight * end.gradient[i];
            out.gradient_bar[gradient + i] = weight * of_step.bar[i];
            for k in 0..UNKNOWNS {
                out.tangent[tangent + UNKNOWNS * i + k] = lambda * weight * of_step.tangent[(i, k)];
            }
        }
        true
    }
}

impl PatchFunctions for RigidContact {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn is_nodal(&self) -> bool {
        true
    }

    fn owns(&self, _p: usize, _node: u32) -> bool {
        // All nodes of an arc belong to the surface.
        true
    }

    fn stand_beside_corners(&mut self) {
        self.is_beside_corners = true;
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.start = (0..self.sides.patches.len()).map(|row| self.position(row, q_0, [0.0; 2])).collect();
        self.lines = (0..self.start.len()).map(|row| self.line_at_corner(row, q_0)).collect();
    }

    fn start_gap(&self) -> Vec<f64> {
        self.gaps(|row| self.obstacle_side(row), self.translations[0], |row| self.start[row])
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        assert_eq!(self.start.len(), self.sides.patches.len(), "begin_step follows a change of the candidates");
        out.prepare(&self.sides.patches, self.sides.secondary.nodes().len());
        for row in 0..self.sides.patches.len() {
            if self.is_hidden[row] {
                out.clear_patch(&self.sides.patches, row);
                continue;
            }
            if self.evaluate_arc(derivative, row, q_1, lambda[row], out) {
                continue;
            }
            let weight = self.sides.weights[row];
            let (gradient, tangent) = (self.sides.patches.gradient_range(row).start, self.sides.patches.tangent_range(row).start);
            let (end, step) =
                (self.obstacle_side(row).distance(self.position(row, q_1, self.translations[2])), self.step_gradient(derivative, row, q_1));
            out.live[row] = true;
            let normal = end.map_or([0.0; 2], |end| end.normal);
            for i in 0..2 {
                out.gradient_end[gradient + i] = weight * normal[i];
                out.gradient_bar[gradient + i] = weight * step.bar[i];
                for k in 0..2 {
                    out.tangent[tangent + 2 * i + k] = lambda[row] * weight * step.tangent[i][k];
                }
            }
            if let Some(Distance { gap, covered, .. }) = end {
                out.gap[row] = weight * gap;
                out.coverage[row] = f64::from(u8::from(covered));
            }
        }
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.sides.patches, step, lambda, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.gaps(|_| &self.shape, self.translations[2], |row| self.position(row, q, [0.0; 2]))
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        let covered = |row: usize| {
            let distance = self.distance(row, &self.shape, self.translations[2], |index| self.position(index, q, [0.0; 2]));
            let distance = distance.filter(|_| !self.is_hidden[row]);
            f64::from(u8::from(distance.is_some_and(|distance| distance.covered)))
        };
        (0..self.sides.weights.len()).map(covered).collect()
    }
}

/// Slip of nodes relative to the translating obstacle.
impl SlipRows for RigidContact {
    fn places(&self, p: usize, _z: &[f64], places: &mut Vec<usize>) -> bool {
        places.extend(0..self.sides.patches.nodes(p).len());
        !self.is_hidden[p]
    }

    fn rows<T: Number>(&self, p: usize, z: &[T], rows: &mut [T], covered: &mut [f64]) -> bool {
        let relative = |k: usize| [0, 1].map(|i| z[2 * k + i] - self.translations[1][i]);
        let shape = self.obstacle_side(p);
        let touching = self.arcs[p].as_ref().map(|arc| {
            let z = [0, 1, 2].map(relative);
            let shares = arc.shares_at(shape, &z);
            (shares, NodeArc::combined(&shares, &z))
        });
        let x = touching.map_or_else(|| relative(0), |(_, x)| x);
        let Some(Distance { normal, covered: true, .. }) = shape.distance(x.map(|x| x.re())) else { return false };
        let normal = if let PlaneOutline::Circle { center, sign, .. } = shape {
            let r: [T; 2] = std::array::from_fn(|i| x[i] - center[i]);
            let inverse = (r[0] * r[0] + r[1] * r[1]).sqrt().recip() * *sign;
            r.map(|r| r * inverse)
        } else {
            normal.map(T::from)
        };
        let along = [normal[1] * self.sides.weights[p], -normal[0] * self.sides.weights[p]];
        covered[0] = 1.0;
        let Some((shares, _)) = touching else {
            rows.copy_from_slice(&along);
            return true;
        };
        for (row, [a, b]) in rows.chunks_exact_mut(2).zip(shares) {
            (row[0], row[1]) = (a * along[0] + b * along[1], a * along[1] - b * along[0]);
        }
        true
    }

    fn is_relative(&self, _p: usize) -> bool {
        false
    }

    fn other_side(&self) -> Carrier {
        self.shape.carrier(self.carried, self.translations[1])
    }
}

impl CandidateSearch for RigidContact {
    fn deepest(&self, q: &[f64]) -> f64 {
        let depth = |row: usize| {
            let distance = self.distance(row, &self.shape, self.translations[2], |index| self.position(index, q, [0.0; 2]));
            distance.filter(|distance| distance.covered).map_or(0.0, |distance| -distance.gap)
        };
        self.rows_there().map(depth).fold(0.0, f64::max)
    }
}

impl RigidObstacle for RigidContact {
    fn move_obstacle(&mut self, translations: &[[f64; 3]; 3]) {
        self.translations = translations.map(|[x, y, _]| [x, y]);
    }

    fn carry(&mut self, shift: [f64; 3], angle: f64) {
        self.carried = ([shift[0], shift[1]], angle);
    }

    fn obstacle_translation(&self) -> [f64; 3] {
        let [x, y] = self.translations[2];
        [x, y, 0.0]
    }

    fn passage(&self, q_1: &[f64]) -> [f64; 2] {
        if matches!(self.shape, PlaneOutline::HalfPlane { .. } | PlaneOutline::Circle { sign: -1.0, .. }) {
            // A half plane or the complement of a disk has no far side to which a node could cross.
            return [0.0; 2];
        }
        let ([start, _, end], size) = (self.translations, self.sides.facet_size);
        let (mut direction_change, mut crossing) = (0.0f64, 0.0f64);
        for row in self.rows_there() {
            let x_0 = [self.start[row][0] - start[0], self.start[row][1] - start[1]];
            let x_1 = self.position(row, q_1, end);
            let near = size.max(self.sides.weights[row]);
            let moved = (x_1[0] - x_0[0]).hypot(x_1[1] - x_0[1]);
            direction_change = direction_change.max(self.shape.direction_change(x_0, x_1, near) / near);
            if moved > crossing.max(CROSSING * size) && self.shape.is_crossed(x_0, x_1) {
                crossing = moved;
            }
        }
        [direction_change, crossing / size]
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let [start, _, end] = self.translations;
        let mut work = 0.0;
        for row in self.rows_there() {
            if let Some((_, of_step)) = self.arc_gradients(derivative, row, q_1) {
                let at_start = self.arc(row, start, |index| self.start[index]).map(|(arc, z)| arc.nearest(&self.shape, &z).gradient);
                let f = (of_step.bar * lambda[row] + at_start.unwrap_or_default() * before[row]) * self.sides.weights[row];
                for (k, &node) in self.sides.patches.nodes(row).iter().enumerate() {
                    for i in 0..2 {
                        force[2 * node as usize + i] += f[2 * k + i];
                        work += f[2 * k + i] * (end[i] - start[i]);
                    }
                }
                continue;
            }
            let node = 2 * self.sides.secondary.nodes()[row] as usize;
            let step = self.step_gradient(derivative, row, q_1);
            let at_start = if before[row] == 0.0 {
                [0.0; 2]
            } else {
                let distance = self.obstacle_side(row).distance([self.start[row][0] - start[0], self.start[row][1] - start[1]]);
                distance.map_or([0.0; 2], |distance| distance.normal)
            };
            for i in 0..2 {
                let f = self.sides.weights[row] * (lambda[row] * step.bar[i] + before[row] * at_start[i]);
                force[node + i] += f;
                work += f * (end[i] - start[i]);
            }
        }
        work
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::super::PredictedMotion;
    use super::super::fixtures::{difference, evaluated, product};
    use super::*;

    fn obstacles() -> Vec<Obstacle> {
        vec![
            Obstacle::HalfPlane { point: [0.2, 0.1], normal: [1.0, 2.0] },
            Obstacle::Disk { center: [0.1, -0.2], radius: 0.7 },
            Obstacle::Ring { center: [-0.1, 0.1], radius: 1.3 },
            // Triangle with a notch: convex and concave corners.
            Obstacle::Polyline { points: vec![[-1.0, -1.0], [1.0, -0.8], [0.2, 0.1], [0.1, 1.0], [-1.0, -1.0]] },
        ]
    }

    /// Facet between nodes 0 and 1, each with half its length as weight, and a moving obstacle.
    fn contact(obstacle: &Obstacle, q_0: &[f64], translations: &[[f64; 2]; 3]) -> RigidContact {
        let mut kernel = RigidContact::new(&[[0, 1]], obstacle, q_0);
        kernel.move_obstacle(&translations.map(|[x, y]| [x, y, 0.0]));
        assert!(!kernel.update_candidates(&PredictedMotion::within(q_0, 1.0)));
        kernel.begin_step(q_0);
        kernel
    }

    fn step() -> impl Strategy<Value = ([f64; 4], [f64; 4], [[f64; 2]; 3])> {
        let size = prop::sample::select(vec![1e-3, 0.1, 1.0]);
        (
            prop::array::uniform4(-1.5..1.5f64),
            prop::array::uniform4(-1.0..1.0f64),
            prop::array::uniform3(prop::array::uniform2(-0.3..0.3f64)),
            size,
        )
            .prop_map(|(q_0, motion, translations, size)| (q_0, std::array::from_fn(|i| q_0[i] + size * motion[i]), translations))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 1000, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        /// The work of the forces equals multipliers times changes of the gaps plus the work of the obstacle's motion.
        #[test]
        fn work_is_what_the_gaps_and_the_motion_say((q_0, q_1, translations) in step()) {
            for obstacle in obstacles() {
                let kernel = contact(&obstacle, &q_0, &translations);
                let lambda = [1.5, -0.5];
                let out = evaluated(&kernel, Derivative::DiscreteGradient, &q_1, &lambda);
                let gaps = kernel.gaps(|row| kernel.obstacle_side(row), kernel.translations[2], |row| kernel.position(row, &q_1, [0.0; 2]));
                prop_assert_eq!(&out.gap, &gaps);
                let mut force = vec![0.0; 4];
                let by_motion = kernel.obstacle_force_into(Derivative::DiscreteGradient, &q_1, &[0.0; 2], &lambda, &mut force);
                let start = kernel.start_gap();
                let by_gaps: f64 = (0..2).map(|k| lambda[k] * (out.gap[k] - start[k])).sum();
                let work = product(&force, &difference(&q_1, &q_0));
                let size: f64 = 1.0 + force.iter().map(|f| f.abs()).sum::<f64>();
                prop_assert!((work - by_gaps - by_motion).abs() < 1e-14 * size, "{obstacle:?}: {work} {by_gaps} {by_motion}");
                for (k, row) in force.chunks_exact(2).enumerate() {
                    for i in 0..2 {
                        prop_assert!((row[i] - lambda[k] * out.gradient_bar[2 * k + i]).abs() < 1e-15 * size);
                    }
                }
            }
        }

        /// Forces of a disk or ring at rest have no moment about the center, those of a plane no tangential component.
        #[test]
        fn symmetries_of_the_obstacle_are_kept((q_0, q_1, _) in step()) {
            let obstacles = obstacles();
            let force = |obstacle: &Obstacle| {
                let mut force = vec![0.0; 4];
                let kernel = contact(obstacle, &q_0, &[[0.0; 2]; 3]);
                kernel.obstacle_force_into(Derivative::DiscreteGradient, &q_1, &[0.0; 2], &[1.0; 2], &mut force);
                force
            };
            for obstacle in &obstacles[1..3] {
                let (Obstacle::Disk { center, .. } | Obstacle::Ring { center, .. }) = obstacle else { unreachable!() };
                for (k, f) in force(obstacle).chunks_exact(2).enumerate() {
                    let arm = [0.5 * (q_0[2 * k] + q_1[2 * k]) - center[0], 0.5 * (q_0[2 * k + 1] + q_1[2 * k + 1]) - center[1]];
                    prop_assert!((arm[0] * f[1] - arm[1] * f[0]).abs() < 1e-15);
                }
            }
            prop_assert!(force(&obstacles[0]).chunks_exact(2).all(|f| (2.0 * f[0] - f[1]).abs() < 1e-15));
        }

        #[test]
        fn tangents_agree_with_differences((q_0, q_1, translations) in step()) {
            let step = 1e-5;
            for obstacle in obstacles() {
                let kernel = contact(&obstacle, &q_0, &translations);
                let lambda = [1.5, -0.5];
                // Corners of the polyline and centers of circles are kinks, near which difference quotients are inaccurate.
                let near_kink = |x: [f64; 2]| match (&kernel.shape, kernel.shape.distance(x)) {
                    (PlaneOutline::Circle { center, .. }, _) => (x[0] - center[0]).hypot(x[1] - center[1]) < 0.2,
                    (PlaneOutline::Polyline { .. }, Some(distance)) => {
                        let around = [[1e-3, 0.0], [-1e-3, 0.0], [0.0, 1e-3], [0.0, -1e-3]].map(|d| [x[0] + d[0], x[1] + d[1]]);
                        around.iter().any(|x| kernel.shape.distance(*x).is_none_or(|other| other.normal != distance.normal))
                    }
                    _ => false,
                };
                for derivative in Derivative::ALL {
                    let out = evaluated(&kernel, derivative, &q_1, &lambda);
                    for row in 0..2 {
                        let [start, middle, end] = translations;
                        let x_0 = [q_0[2 * row] - start[0], q_0[2 * row + 1] - start[1]];
                        let x_1 = [q_1[2 * row] - end[0], q_1[2 * row + 1] - end[1]];
                        let halfway = [0, 1].map(|i| 0.5 * (q_0[2 * row + i] + q_1[2 * row + i]) - middle[i]);
                        let mean = [0, 1].map(|i| 0.5 * (x_0[i] + x_1[i]));
                        let tiny = (x_1[0] - x_0[0]).hypot(x_1[1] - x_0[1]) < 0.05;
                        if tiny || [x_0, x_1, mean, halfway].into_iter().any(near_kink) {
                            continue;
                        }
                        for k in 0..2 {
                            let at = |shift: f64| {
                                let mut moved = q_1;
                                moved[2 * row + k] += shift;
                                evaluated(&kernel, derivative, &moved, &lambda).gradient_bar[2 * row..2 * row + 2].to_vec()
                            };
                            let (high, low) = (at(step), at(-step));
                            for i in 0..2 {
                                let expected = lambda[row] * (high[i] - low[i]) / (2.0 * step);
                                let ours = out.tangent[4 * row + 2 * i + k];
                                // Second order in 1e-5 with third derivatives below 1e4 (distances of at least 0.05); round-off 1e-16/1e-5.
                                prop_assert!((ours - expected).abs() < 1e-5, "{obstacle:?} {derivative:?}: {ours} {expected}");
                            }
                        }
                    }
                }
            }
        }
    }

    /// Closed forms of the signed distances.
    #[test]
    fn distances() {
        let gaps = |obstacle: Obstacle, x: [f64; 2]| {
            // Facet of length 2: weights 1.
            let q = [x[0], x[1], x[0] + 2.0, x[1]];
            contact(&obstacle, &q, &[[0.0; 2], [0.0; 2], [0.25, 0.0]]).gap(&q)[0]
        };
        assert_eq!(gaps(Obstacle::HalfPlane { point: [0.0, 1.0], normal: [0.0, 3.0] }, [7.0, 1.5]), 0.5);
        assert_eq!(gaps(Obstacle::Disk { center: [0.0, 0.0], radius: 3.0 }, [3.25, 4.0]), 2.0);
        assert_eq!(gaps(Obstacle::Ring { center: [0.0, 0.0], radius: 3.0 }, [3.25, 4.0]), -2.0);
        // Translation by 1/4 moves the wall x = 0 to 1/4.
        let wall = vec![[0.0, -5.0], [0.0, 5.0]];
        assert_eq!(gaps(Obstacle::Polyline { points: wall }, [1.0, 0.0]), 0.75);
    }

    #[test]
    fn beyond_the_ends_of_an_open_polyline_nothing_is_covered() {
        let q = [-0.5, 0.1, 0.5, 0.1];
        let kernel = contact(&Obstacle::Polyline { points: vec![[2.0, 0.0], [0.0, 0.0]] }, &q, &[[0.0; 2]; 3]);
        assert_eq!(kernel.coverage(&q), [0.0, 1.0]);
    }
}
