//! Contact of the nodes of a surface with a rigid obstacle (`rigid_shape.rs`, `space/obstacle.rs`), in the plane and in space.
//!
//! The gap of a node is its signed distance `g` from the obstacle, `Phi_A = w_A g(x_A - u(t))` with the obstacle's translation `u`. With
//! `r_k = x_k - u_k` the discrete gradient satisfies `Gbar.(r_1 - r_0) = g(r_1) - g(r_0)`, see the shapes. The contact forces do the work
//! `sum lambda_A (Phi_A(1) - Phi_A(0))`; a moving obstacle does the further work `sum lambda_A Gbar_A.(u_1 - u_0)`, which the ledger counts
//! as work of loads. A round obstacle may rotate about its axis, which affects friction only; obstacles that turn: `turning.rs`.
//!
//! A node has one constraint, or three for obstacles with pockets: for the side nearest at the start of the step, and for up to two sides
//! that adjoin it across re-entrant edges. The shape of each constraint is fixed within a step: a plane replaces the obstacle for nodes
//! that start at a sharp edge (`edge_plane.rs`). Otherwise the step may have no solution: one side pushes the node past the edge, and
//! without this force the node returns. On convex curves in the plane the nearest point of an arc touches in place of the node
//! (`node_arcs.rs`).

use nalgebra::{SMatrix, SVector};

use super::edge_plane::{ACROSS_EDGE, NodeAtEdge};
use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle, Setting};
use super::obstacle_side::{Distance, ObstacleSide, StepGradient};
use super::patches::Evaluation;
use super::slip::{SlipStep, Slips};
use super::surface::{Sides, Surface};
use crate::integrators::{Configuration, Derivative};
use crate::math::tolerances::CROSSING;

/// Distance from a further side of an obstacle, in smallest facets, within which a node has a constraint against this side.
const IN_POCKET: f64 = 1.0;

/// Largest number of unknowns of a constraint: positions of the three nodes of an arc in the plane.
const UNKNOWNS: usize = 6;

/// Gradient of a constraint with respect to the positions of its nodes; zero beyond their unknowns.
pub(super) type Row = SVector<f64, UNKNOWNS>;

/// Algorithmic gradient of a constraint, and its derivative with respect to the end positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowGradient {
    pub bar: Row,
    pub tangent: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
}

/// Curve of a surface about a node, whose point nearest to an obstacle of the shape `S` touches it in place of the node. Positions `z` are
/// those of [`NodeCurve::nodes`], relative to the obstacle.
pub(super) trait NodeCurve<const D: usize, S>: Clone + Send + Sync {
    /// Indices of the nodes on whose positions the curve depends, first that of its own node.
    fn nodes(&self) -> &[usize];
    /// Distance of the nearest point, and its gradient with respect to the positions of the nodes.
    fn nearest_to(&self, obstacle: &S, z: &[SVector<f64, D>]) -> (Distance<D>, Row);
    /// Gradient at one configuration, and `share` times its derivative.
    fn plain(&self, obstacle: &S, z: &[SVector<f64, D>], share: f64) -> RowGradient;
    /// Discrete gradient of a step between two configurations; `size` is the facet size `[length]`.
    fn between(&self, obstacle: &S, z_0: &[SVector<f64, D>], z_1: &[SVector<f64, D>], size: f64) -> RowGradient;
}

/// Points of a surface in the plane that touch obstacles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum TouchingPoints {
    /// The nodes.
    #[default]
    Nodes,
    /// On convex curves the nearest points of arcs; `radius` is that of the exact shape of the surface, if it is known.
    Arcs {
        /// Radius `[length]`.
        radius: Option<f64>,
    },
}

/// Properties of the nodes of a surface in contact with an obstacle.
#[derive(Clone, Debug, Default)]
pub struct NodesOnObstacle {
    /// True for nodes without constraints: those inside of round parts of a rigid body, which `rolling.rs` constrains instead. Empty: none.
    pub is_hidden: Vec<bool>,
    /// Tributary measures of the nodes in place of those of the facets, in ascending node order `[length^(D-1)]`.
    pub weights: Option<Vec<f64>>,
    /// Height of the curved surface in space over each node `[length]`. Empty: zero.
    pub heights: Vec<f64>,
    /// Points that touch.
    pub points: TouchingPoints,
}

/// Contact of the nodes of a surface with a rigid obstacle of the shape `S`; `C` is the type of curves that touch in place of nodes.
#[derive(Clone, Debug)]
pub(super) struct RigidContact<const D: usize, S, C> {
    pub sides: Sides,
    pub shape: S,
    /// Number of constraints of each node.
    slots: usize,
    heights: Vec<f64>,
    is_hidden: Vec<bool>,
    curves: Vec<Option<C>>,
    /// Nodes connected to each node by an edge.
    neighbors: Vec<Vec<usize>>,
    /// True if sharp edges of the obstacle have constraints of their own against the facets.
    is_beside_corners: bool,
    pub translations: [[f64; 3]; 3],
    /// Displacement `[length]` and rotation angle `[rad]` of the obstacle's surface in the step, relative to which slip is measured.
    pub carried: ([f64; 3], f64),
    start: Vec<SVector<f64, D>>,
    /// Shape from which the gap of each constraint is measured in this step; `None` for absent constraints.
    obstacle_sides: Vec<Option<S>>,
}

impl<const D: usize, S: ObstacleSide<D>, C: NodeCurve<D, S>> RigidContact<D, S, C> {
    /// Contact of a surface with an obstacle, sized in the reference positions; `curves` are those of nodes, empty if no node has one.
    pub fn new(surface: Surface, shape: S, reference: &[f64], nodes: NodesOnObstacle, curves: Vec<Option<C>>) -> Self {
        let (slots, count) = (shape.sides_of_node(), surface.nodes().len());
        let mut sides = Sides::of(surface, if D == 2 { Surface::new(&[]) } else { Surface::in_space([]) }, reference);
        let weights = nodes.weights.as_ref().unwrap_or(&sides.weights);
        sides.weights = weights.iter().flat_map(|&weight| std::iter::repeat_n(weight, slots)).collect();
        let mut neighbors = vec![Vec::new(); count];
        for [a, b] in sides.secondary.edges().iter().map(|edge| edge.nodes) {
            if let (Some(a), Some(b)) = (sides.secondary.index(a), sides.secondary.index(b)) {
                neighbors[a].push(b);
                neighbors[b].push(a);
            }
        }
        let mut contact = RigidContact {
            sides,
            shape,
            slots,
            heights: if nodes.heights.is_empty() { vec![0.0; count] } else { nodes.heights },
            is_hidden: if nodes.is_hidden.is_empty() { vec![false; count] } else { nodes.is_hidden },
            curves,
            neighbors,
            is_beside_corners: false,
            translations: [[0.0; 3]; 3],
            carried: ([0.0; 3], 0.0),
            start: Vec::new(),
            obstacle_sides: Vec::new(),
        };
        // Every node is opposite the obstacle, so that the list of contact elements never changes.
        for index in 0..count {
            let rows: Vec<u32> = (slots * index..slots * (index + 1)).map(|row| row as u32).collect();
            let nodes: Vec<u32> = match contact.curve(index) {
                Some(curve) => curve.nodes().iter().map(|&node| contact.sides.secondary.nodes()[node]).collect(),
                None => vec![contact.sides.secondary.nodes()[index]],
            };
            contact.sides.patches.push(&nodes, &rows);
        }
        if D == 3 {
            contact.sides.list_slips();
        }
        contact.begin(reference);
        contact
    }

    /// Curve that touches in place of a node.
    pub fn curve(&self, index: usize) -> Option<&C> {
        self.curves.get(index)?.as_ref().filter(|_| !self.is_hidden[index])
    }

    /// Nodes with constraints.
    fn nodes_there(&self) -> impl Iterator<Item = usize> {
        (0..self.start.len()).filter(|&index| !self.is_hidden[index])
    }

    /// Begins a step at the positions `q_0`: selects the shape from which the gap of each constraint is measured.
    fn begin(&mut self, q_0: &[f64]) {
        self.start = (0..self.sides.patches.len()).map(|index| self.position(index, q_0)).collect();
        let mut obstacle_sides = vec![None; self.sides.weights.len()];
        for index in self.nodes_there() {
            let of_node = &mut obstacle_sides[self.slots * index..self.slots * (index + 1)];
            let pocket = self.shape.pocket(self.begins(index), IN_POCKET * self.sides.facet_size);
            if pocket.is_empty() {
                of_node[0] = Some(self.plane_at_edge(index, q_0).unwrap_or_else(|| self.shape.clone()));
            }
            of_node.iter_mut().zip(pocket).for_each(|(obstacle_side, side)| *obstacle_side = Some(side));
        }
        self.obstacle_sides = obstacle_sides;
    }

    /// Plane in place of an obstacle near whose sharp edge a node starts the step.
    fn plane_at_edge(&self, index: usize, q_0: &[f64]) -> Option<S> {
        let (surface, size, x) = (&self.sides.secondary, self.sides.facet_size, self.begins(index));
        let at = self.shape.at_edge(x, ACROSS_EDGE * size)?;
        let around = self.neighbors[index].iter().map(|&other| self.start[other] - self.start[index]).collect();
        let facets = surface.adjacent_facets(index).iter();
        let facing = facets.map(|&facet| -SVector::from_column_slice(&surface.outward(facet as usize, q_0))).collect();
        self.shape.plane_at_edge(&NodeAtEdge { at, x, around, facing, size, is_beside_corners: self.is_beside_corners })
    }

    /// Translation of the obstacle at the start (0), in the middle (1) or at the end (2) of the step.
    pub fn moved(&self, time: usize) -> SVector<f64, D> {
        SVector::from_column_slice(&self.translations[time][..D])
    }

    /// Position of a node.
    fn position(&self, index: usize, q: &[f64]) -> SVector<f64, D> {
        SVector::from_column_slice(&q[D * self.sides.secondary.nodes()[index] as usize..][..D])
    }

    /// Position of a node relative to the obstacle at the start of the step.
    pub fn begins(&self, index: usize) -> SVector<f64, D> {
        self.start[index] - self.moved(0)
    }

    /// Position of a node relative to the obstacle at the end of the step.
    fn ends(&self, index: usize, q_1: &[f64]) -> SVector<f64, D> {
        self.position(index, q_1) - self.moved(2)
    }

    /// Distance of a node or its curve from `shape`, and its gradient, for nodes at the places `at` relative to the obstacle.
    fn nearest(&self, index: usize, shape: &S, at: impl Fn(usize) -> SVector<f64, D>) -> (Distance<D>, Row) {
        if let Some(curve) = self.curve(index) {
            return curve.nearest_to(shape, &places(curve.nodes(), at));
        }
        let found = shape.at(at(index));
        (found, row_of(found.normal))
    }

    /// Algorithmic gradient of a step for a node or its curve and `shape`, without weight.
    fn step_gradient(&self, shape: &S, derivative: Derivative, index: usize, q_1: &[f64]) -> RowGradient {
        let (begins, ends, size) = (|index| self.begins(index), |index| self.ends(index, q_1), self.sides.facet_size);
        let middle = |index: usize| 0.5 * (self.start[index] + self.position(index, q_1)) - self.moved(1);
        if let Some(curve) = self.curve(index) {
            let nodes = curve.nodes();
            return match derivative {
                Derivative::DiscreteGradient => curve.between(shape, &places(nodes, begins), &places(nodes, ends), size),
                Derivative::Gradient(at @ Configuration::Middle) => curve.plain(shape, &places(nodes, middle), at.share()),
                Derivative::Gradient(at @ Configuration::End) => curve.plain(shape, &places(nodes, ends), at.share()),
            };
        }
        let StepGradient { bar, tangent } = shape.gradient_of(derivative, [begins(index), middle(index), ends(index)], size);
        RowGradient { bar: row_of(bar), tangent: SMatrix::from_fn(|i, k| if i < D && k < D { tangent[(i, k)] } else { 0.0 }) }
    }

    /// Present constraints: index, index of the node, shape.
    pub fn present_constraints(&self) -> impl Iterator<Item = (usize, usize, &S)> {
        let slots = self.slots;
        self.obstacle_sides.iter().enumerate().filter_map(move |(row, obstacle_side)| Some((row, row / slots, obstacle_side.as_ref()?)))
    }

    /// Shapes from which the gaps of a node are measured in this step.
    pub fn sides_near(&self, index: usize) -> &[Option<S>] {
        &self.obstacle_sides[self.slots * index..self.slots * (index + 1)]
    }

    /// Signed distance from the whole obstacle at the end of the step for nodes at `q`, with the index of each node that has constraints.
    fn distances(&self, q: &[f64]) -> impl Iterator<Item = (usize, Distance<D>)> {
        self.nodes_there().map(move |index| (index, self.nearest(index, &self.shape, |index| self.ends(index, q)).0))
    }

    /// Weight of each constraint of a node.
    pub fn weight(&self, index: usize) -> f64 {
        self.sides.weights[self.slots * index]
    }
}

/// Positions of nodes.
fn places<const D: usize>(nodes: &[usize], at: impl Fn(usize) -> SVector<f64, D>) -> Vec<SVector<f64, D>> {
    nodes.iter().map(|&node| at(node)).collect()
}

/// Gradient with respect to the position of a single node.
fn row_of<const D: usize>(vector: SVector<f64, D>) -> Row {
    Row::from_fn(|i, _| vector.get(i).copied().unwrap_or(0.0))
}

impl<const D: usize, S: ObstacleSide<D>, C: NodeCurve<D, S>> PatchFunctions for RigidContact<D, S, C>
where
    Self: Slips,
{
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn rows_per_node(&self) -> usize {
        self.slots
    }

    fn is_nodal(&self) -> bool {
        true
    }

    fn set(&mut self, setting: Setting) {
        self.is_beside_corners |= matches!(setting, Setting::BesideCorners);
    }

    fn owns(&self, _p: usize, _node: u32) -> bool {
        // All nodes of a curve belong to the surface.
        true
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.begin(q_0);
    }

    fn start_gap(&self) -> Vec<f64> {
        let gap = |index: usize, shape: &S| self.nearest(index, shape, |index| self.begins(index)).0.gap - self.heights[index];
        self.sides.weighted(self.present_constraints().map(|(row, index, shape)| (row, gap(index, shape))))
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        let patches = &self.sides.patches;
        out.prepare(patches, self.sides.weights.len());
        (0..patches.len()).for_each(|p| out.clear_patch(patches, p));
        for (row, index, shape) in self.present_constraints() {
            let weight = self.sides.weights[row];
            let (end, gradient) = self.nearest(index, shape, |index| self.ends(index, q_1));
            let of_step = self.step_gradient(shape, derivative, index, q_1);
            out.live[index] = true;
            (out.gap[row], out.coverage[row]) = (weight * (end.gap - self.heights[index]), f64::from(u8::from(end.covered)));
            let (pressure, width) = (weight * lambda[row], patches.unknowns(index));
            let first = patches.gradient_range(index).start + row % self.slots * width;
            let block = patches.tangent_range(index).start;
            for i in 0..width {
                out.gradient_end[first + i] = weight * gradient[i];
                out.gradient_bar[first + i] = weight * of_step.bar[i];
                (0..width).for_each(|k| out.tangent[block + width * i + k] += pressure * of_step.tangent[(i, k)]);
            }
        }
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        self.slips(step, lambda, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        // The first constraint of a node represents the whole obstacle at positions outside of the step.
        self.sides.weighted(self.distances(q).map(|(index, at)| (self.slots * index, at.gap - self.heights[index])))
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        self.sides.per_row(self.distances(q).map(|(index, at)| (self.slots * index, f64::from(u8::from(at.covered)))))
    }
}

impl<const D: usize, S: ObstacleSide<D>, C: NodeCurve<D, S>> CandidateSearch for RigidContact<D, S, C>
where
    Self: Slips,
{
    fn deepest(&self, q: &[f64]) -> f64 {
        let depths = self.distances(q).filter(|(_, distance)| distance.covered);
        depths.map(|(index, distance)| self.heights[index] - distance.gap).fold(0.0, f64::max)
    }
}

impl<const D: usize, S: ObstacleSide<D>, C: NodeCurve<D, S>> RigidObstacle for RigidContact<D, S, C>
where
    Self: Slips,
{
    fn move_obstacle(&mut self, translations: &[[f64; 3]; 3]) {
        self.translations = *translations;
    }

    fn carry(&mut self, shift: [f64; 3], angle: f64) {
        self.carried = (shift, angle);
    }

    fn obstacle_translation(&self) -> [f64; 3] {
        self.translations[2]
    }

    fn passage(&self, q_1: &[f64]) -> [f64; 2] {
        let size = self.sides.facet_size;
        let (mut direction_change, mut crossing) = (0.0f64, 0.0f64);
        for index in self.nodes_there() {
            let (x_0, x_1, weight) = (self.begins(index), self.ends(index, q_1), self.weight(index));
            let near = size.max(if D == 2 { weight } else { weight.sqrt() });
            let moved = (x_1 - x_0).norm();
            direction_change = direction_change.max(self.shape.direction_change(x_0, x_1, near) / near);
            if moved > crossing.max(CROSSING * size) && self.shape.is_crossed(x_0, x_1, near) {
                crossing = moved;
            }
        }
        [direction_change, crossing / size]
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let way = self.moved(2) - self.moved(0);
        let mut work = 0.0;
        for (row, index, shape) in self.present_constraints().filter(|&(row, ..)| before[row] != 0.0 || lambda[row] != 0.0) {
            let of_step = self.step_gradient(shape, derivative, index, q_1).bar * lambda[row];
            let of_start = self.nearest(index, shape, |index| self.begins(index)).1 * before[row];
            let f = (of_step + of_start) * self.sides.weights[row];
            for (k, &node) in self.sides.patches.nodes(index).iter().enumerate() {
                let on_node = f.fixed_rows::<D>(D * k);
                (0..D).for_each(|i| force[D * node as usize + i] += on_node[i]);
                work += on_node.dot(&way);
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
    use super::super::rigid_contact::RigidInPlane;
    use super::super::rigid_shape::{Obstacle, PlaneOutline};
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
    fn contact(obstacle: &Obstacle, q_0: &[f64], translations: &[[f64; 2]; 3]) -> RigidInPlane {
        let mut kernel = RigidInPlane::new(Surface::new(&[[0, 1]]), PlaneOutline::new(obstacle), q_0, Default::default(), Vec::new());
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
                let ends = |index: usize| kernel.ends(index, &q_1);
                for (row, index, shape) in kernel.present_constraints() {
                    prop_assert_eq!(out.gap[row], kernel.weight(index) * kernel.nearest(index, shape, ends).0.gap);
                }
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
                let near_kink = |x: [f64; 2]| match (&kernel.shape, kernel.shape.distance(x.into())) {
                    (PlaneOutline::Circle { center, .. }, _) => (x[0] - center[0]).hypot(x[1] - center[1]) < 0.2,
                    (PlaneOutline::Polyline { .. }, Some(distance)) => {
                        let around = [[1e-3, 0.0], [-1e-3, 0.0], [0.0, 1e-3], [0.0, -1e-3]].map(|d| [x[0] + d[0], x[1] + d[1]]);
                        around.iter().any(|x| kernel.shape.distance((*x).into()).is_none_or(|other| other.normal != distance.normal))
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
