//! Contact of a surface in space with a rigid obstacle (`obstacle.rs`): the gap of a secondary node is its signed distance.
//!
//! `Phi_A = w_A g(x_A - u(t))` with the tributary area `w_A` and the obstacle's translation `u`. The contact forces do the work
//! `sum lambda_A (Phi_A(1) - Phi_A(0))`; a moving obstacle does the further work `sum lambda_A Gbar_A.(u_1 - u_0)`, which the ledger counts
//! as work of loads. An obstacle of revolution may rotate about its axis, which affects friction only.
//!
//! A node has one constraint, or three for obstacles with pockets: for the side nearest at the start of the step, and for up to two sides
//! that adjoin it across re-entrant edges. The shape of each constraint is fixed within a step.

use std::sync::Arc;

use nalgebra::Vector3;

use super::facets::Distance;
use super::obstacle::{ObstacleInSpace, Shape, StepGradient};
use super::second_order::ProxySurfacesInSpace;
use super::slip::{self, Carrier, Group, SlipsInSpace};
use super::vectors::Vec3;
use super::vertices::NODES;
use crate::contact::edge_plane::{self, ACROSS_EDGE, AtEdge};
use crate::contact::faces;
use crate::contact::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use crate::contact::numbers::Number;
use crate::contact::patches::Evaluation;
use crate::contact::slip::SlipStep;
use crate::contact::surface::{Sides, Surface};
use crate::integrators::{Configuration, Derivative};
use crate::math::tolerances::CROSSING;

/// Largest number of constraints of a node for an obstacle with pockets: three sides meet in a corner.
const SLOTS: usize = 3;

/// Distance from a sharp edge of an obstacle, in smallest facets, within which a node has the plane of one face as obstacle in a step.
const AT_EDGE: f64 = 0.02;

/// Distance from a further side of an obstacle, in smallest facets, within which a node has a constraint against this side.
const IN_POCKET: f64 = 1.0;

/// Contact of a surface in space with a rigid obstacle.
#[derive(Clone, Debug)]
pub struct RigidInSpace {
    sides: Sides,
    shape: Shape,
    slots: usize,
    /// Height of the curve over each node or point `[length]`.
    heights: Vec<f64>,
    translations: [[f64; 3]; 3],
    /// Displacement `[length]` and rotation angle `[rad]` of the obstacle's surface in the step, relative to which slip is measured.
    carried: ([f64; 3], f64),
    start: Vec<Vector3<f64>>,
    /// Nodes connected to each node by an edge.
    neighbors: Vec<Vec<usize>>,
    /// True if sharp edges of the obstacle have constraints of their own against the facets.
    is_beside_corners: bool,
    /// True for nodes or points without constraints: those inside of round parts of a rigid body, which `contact/rolling.rs` constrains
    /// instead.
    is_hidden: Vec<bool>,
    /// Shape from which the gap of each constraint is measured in this step; `None` for absent constraints.
    obstacle_sides: Vec<Option<Shape>>,
}

impl RigidInSpace {
    /// Contact of a surface with height profiles with an obstacle, sized in the reference positions.
    pub fn of_curve(surfaces: &ProxySurfacesInSpace, obstacle: &ObstacleInSpace) -> Self {
        RigidInSpace { heights: surfaces.heights(0), ..Self::new(surfaces.secondary.clone(), obstacle, &surfaces.reference) }
    }

    /// Contact of a surface whose nodes lie on the curve with an obstacle, sized in the reference positions.
    pub fn new(secondary: Surface, obstacle: &ObstacleInSpace, reference: &[f64]) -> Self {
        let shape = Shape::new(obstacle);
        let slots = match &shape {
            Shape::Facets(facets) if facets.has_pockets() => SLOTS,
            _ => 1,
        };
        let mut sides = Sides::of(secondary, Surface::in_space([]), reference);
        sides.weights = sides.weights.iter().flat_map(|&weight| std::iter::repeat_n(weight, slots)).collect();
        // Every node is opposite the obstacle, so that the list of contact elements never changes.
        for (index, &node) in (0u32..).zip(sides.secondary.nodes()) {
            let rows: Vec<u32> = (0..slots as u32).map(|slot| slots as u32 * index + slot).collect();
            sides.patches.push(&[node], &rows);
        }
        sides.list_slips();
        let start = sides.secondary.nodes().iter().map(|&node| faces::at(node, reference)).collect();
        let mut neighbors = vec![Vec::new(); sides.secondary.nodes().len()];
        for [a, b] in sides.secondary.edges().iter().map(|edge| edge.nodes) {
            if let (Some(a), Some(b)) = (sides.secondary.index(a), sides.secondary.index(b)) {
                neighbors[a].push(b);
                neighbors[b].push(a);
            }
        }
        let mut contact = RigidInSpace {
            heights: vec![0.0; sides.secondary.nodes().len()],
            is_beside_corners: false,
            is_hidden: vec![false; sides.secondary.nodes().len()],
            sides,
            shape,
            slots,
            translations: [[0.0; 3]; 3],
            carried: ([0.0; 3], 0.0),
            start,
            neighbors,
            obstacle_sides: Vec::new(),
        };
        contact.select_obstacle_sides();
        contact
    }

    /// Removes the constraints of nodes or points; `is_hidden` is indexed like the secondary nodes.
    pub fn without(mut self, is_hidden: Vec<bool>) -> Self {
        self.is_hidden = is_hidden;
        self.select_obstacle_sides();
        self
    }

    /// Selects the shape from which the gap of each constraint is measured, at the start of the step.
    fn select_obstacle_sides(&mut self) {
        let (size, shift) = (self.sides.facet_size, Vector3::from(self.translations[0]));
        let mut obstacle_sides = vec![None; self.sides.weights.len()];
        let has_edges = matches!(self.shape, Shape::Facets(_));
        let positions: Vec<f64> = self.start.iter().filter(|_| has_edges).flatten().copied().collect();
        for (index, of_node) in obstacle_sides.chunks_exact_mut(self.slots).enumerate().filter(|(index, _)| !self.is_hidden[*index]) {
            let x = self.start[index] - shift;
            of_node[0] = Some(self.shape.clone());
            let Shape::Facets(facets) = &self.shape else { continue };
            let (nearest, rising) = if facets.has_pockets() { facets.around(x, IN_POCKET * size) } else { (0, Vec::new()) };
            if !rising.is_empty() {
                // Sides are in an order independent of their distances, so that multipliers stay with their sides.
                let mut sides: Vec<usize> = std::iter::once(nearest).chain(rising).take(SLOTS).collect();
                sides.sort_unstable();
                of_node
                    .iter_mut()
                    .zip(sides)
                    .for_each(|(obstacle_side, side)| *obstacle_side = Some(Shape::Side(Arc::clone(facets), side)));
                continue;
            }
            of_node[0] = self.plane_at_edge(index, &positions, facets.at_edge(x, ACROSS_EDGE * size)).or(of_node[0].take());
        }
        self.obstacle_sides = obstacle_sides;
    }

    /// Plane of one face, or through the edge, in place of an obstacle near whose sharp edge a node starts the step. Otherwise the step may
    /// have no solution: one face pushes the node past the edge, and without this force the node returns. `None` if the surface next to the
    /// node recedes behind all faces and overlaps the edge by more than it may: the node is in front of the edge, which remains its
    /// obstacle. `positions`: those of the surface's nodes at the start of the step.
    fn plane_at_edge(&self, index: usize, positions: &[f64], at: Option<AtEdge<3>>) -> Option<Shape> {
        let (at, size) = (at?, self.sides.facet_size);
        let around = || self.neighbors[index].iter().map(|&other| self.start[other] - self.start[index]);
        let mut planes = at.points.iter().zip(&at.normals).map(|(point, normal)| [*point, *normal]);
        let of_face = planes.find(|[_, normal]| at.distance <= AT_EDGE * size && edge_plane::is_in_front(*normal, around()));
        let through_edge = || {
            let adjacent = self.sides.secondary.adjacent_facets(index).iter();
            let corners = |facet: u32| self.sides.secondary.local_facet(facet as usize);
            let facing = adjacent.map(|&facet| -faces::area_vector(corners(facet), positions));
            edge_plane::plane_through(&at, around(), facing, self.begins(index), size)
        };
        let is_across = self.is_beside_corners && at.distance > AT_EDGE * size;
        of_face.or_else(|| through_edge().filter(|_| is_across)).map(|[point, normal]| Shape::Plane { point, normal })
    }

    /// Position of a node relative to the obstacle displaced by `translation`.
    fn position(&self, index: usize, q: &[f64], translation: [f64; 3]) -> Vector3<f64> {
        faces::at(self.sides.secondary.nodes()[index], q) - Vector3::from(translation)
    }

    /// Position of a node relative to the obstacle at the start of the step.
    fn begins(&self, index: usize) -> Vector3<f64> {
        self.start[index] - Vector3::from(self.translations[0])
    }

    /// Algorithmic gradient of a step, and its derivative, for a node and `shape`, without weight.
    fn step_gradient(&self, shape: &Shape, derivative: Derivative, index: usize, q_1: &[f64]) -> StepGradient {
        let [_, middle, end] = self.translations;
        let plain = |x: Vector3<f64>, at: Configuration| {
            let Distance { normal, curvature, .. } = shape.distance(x);
            StepGradient { bar: normal, tangent: curvature * at.share() }
        };
        match derivative {
            Derivative::DiscreteGradient => shape.step_gradient(self.begins(index), self.position(index, q_1, end), self.sides.facet_size),
            Derivative::Gradient(at @ Configuration::Middle) => {
                plain(0.5 * (self.start[index] + self.position(index, q_1, [0.0; 3])) - Vector3::from(middle), at)
            }
            Derivative::Gradient(at @ Configuration::End) => plain(self.position(index, q_1, end), at),
        }
    }

    /// Present constraints: index, index of the node, shape.
    fn present_constraints(&self) -> impl Iterator<Item = (usize, usize, &Shape)> {
        let slots = self.slots;
        self.obstacle_sides.iter().enumerate().filter_map(move |(row, obstacle_side)| Some((row, row / slots, obstacle_side.as_ref()?)))
    }

    /// Signed distance from the whole obstacle at the end of the step for nodes at `q`, with the index of each node that has constraints.
    fn distances(&self, q: &[f64]) -> impl Iterator<Item = (usize, Distance)> {
        let end = self.translations[2];
        let shown = (0..self.start.len()).filter(|&index| !self.is_hidden[index]);
        shown.map(move |index| (index, self.shape.distance(self.position(index, q, end))))
    }
}

impl PatchFunctions for RigidInSpace {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn rows_per_node(&self) -> usize {
        self.slots
    }

    fn is_nodal(&self) -> bool {
        true
    }

    fn stand_beside_corners(&mut self) {
        self.is_beside_corners = true;
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.start = (0..self.sides.patches.len()).map(|index| self.position(index, q_0, [0.0; 3])).collect();
        self.select_obstacle_sides();
    }

    fn start_gap(&self) -> Vec<f64> {
        let mut gaps = vec![0.0; self.sides.weights.len()];
        for (row, index, shape) in self.present_constraints() {
            gaps[row] = self.sides.weights[row] * (shape.distance(self.begins(index)).gap - self.heights[index]);
        }
        gaps
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        out.prepare(&self.sides.patches, self.sides.weights.len());
        (0..self.sides.patches.len()).for_each(|p| out.clear_patch(&self.sides.patches, p));
        for (row, index, shape) in self.present_constraints() {
            let weight = self.sides.weights[row];
            let end = shape.distance(self.position(index, q_1, self.translations[2]));
            let step = self.step_gradient(shape, derivative, index, q_1);
            out.live[index] = true;
            (out.gap[row], out.coverage[row]) = (weight * (end.gap - self.heights[index]), f64::from(u8::from(end.covered)));
            let pressure = weight * lambda[row];
            for i in 0..3 {
                out.gradient_end[3 * row + i] = weight * end.normal[i];
                out.gradient_bar[3 * row + i] = weight * step.bar[i];
                for k in 0..3 {
                    out.tangent[9 * index + 3 * i + k] += pressure * step.tangent[(i, k)];
                }
            }
        }
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.sides, step, lambda, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        let mut gaps = vec![0.0; self.sides.weights.len()];
        // The first constraint of a node represents the whole obstacle at positions outside of the step.
        for (index, distance) in self.distances(q) {
            let row = self.slots * index;
            gaps[row] = self.sides.weights[row] * (distance.gap - self.heights[index]);
        }
        gaps
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        let mut coverage = vec![0.0; self.sides.weights.len()];
        for (index, distance) in self.distances(q) {
            coverage[self.slots * index] = f64::from(u8::from(distance.covered));
        }
        coverage
    }
}

/// Slip of a node relative to the translating and rotating obstacle.
impl SlipsInSpace for RigidInSpace {
    fn groups<T: Number>(&self, p: usize, z: &[Vec3<T>]) -> Vec<Group<T>> {
        let x = Vector3::from(z[0].map(|x| x.re())) - Vector3::from(self.translations[1]);
        let group = |(place, obstacle_side): (usize, &Option<Shape>)| {
            let shape = obstacle_side.as_ref()?;
            let Distance { normal, curvature, covered, .. } = shape.distance(x);
            let axis = slip::farthest_axis(shape.distance(self.begins(p)).normal.into());
            let normal = std::array::from_fn(|i| slip::linear(normal[i], &[0, 1, 2].map(|k| curvature[(i, k)]), z));
            let mut weights = [T::from(0.0); NODES];
            weights[0] = T::from(self.sides.weights[self.slots * p + place]);
            covered.then(|| Group { place, weights, tangents: slip::tangents(normal, axis), covered: 1.0 })
        };
        self.obstacle_sides[self.slots * p..self.slots * (p + 1)].iter().enumerate().filter_map(group).collect()
    }

    fn carrier(&self) -> Option<Carrier> {
        Some(self.shape.carrier(self.carried, self.translations[2]))
    }
}

impl CandidateSearch for RigidInSpace {
    fn deepest(&self, q: &[f64]) -> f64 {
        let depths = self.distances(q).filter(|(_, distance)| distance.covered);
        depths.map(|(index, distance)| self.heights[index] - distance.gap).fold(0.0, f64::max)
    }
}

impl RigidObstacle for RigidInSpace {
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
        let (end, size) = (self.translations[2], self.sides.facet_size);
        let (mut direction_change, mut crossing) = (0.0f64, 0.0f64);
        for index in (0..self.start.len()).filter(|&index| !self.is_hidden[index]) {
            let (x_0, x_1) = (self.begins(index), self.position(index, q_1, end));
            let near = size.max(self.sides.weights[self.slots * index].sqrt());
            let moved = (x_1 - x_0).norm();
            direction_change = direction_change.max(self.shape.direction_change(x_0, x_1, near) / near);
            if moved > crossing.max(CROSSING * size) && self.shape.is_crossed(x_0, x_1, near) {
                crossing = moved;
            }
        }
        [direction_change, crossing / size]
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let [start, _, end] = self.translations.map(Vector3::from);
        let mut work = 0.0;
        for (row, index, shape) in self.present_constraints().filter(|&(row, ..)| before[row] != 0.0 || lambda[row] != 0.0) {
            let node = 3 * self.sides.secondary.nodes()[index] as usize;
            let of_step = self.step_gradient(shape, derivative, index, q_1).bar * lambda[row];
            let of_start = shape.distance(self.begins(index)).normal * before[row];
            let f = (of_step + of_start) * self.sides.weights[row];
            (0..3).for_each(|i| force[node + i] += f[i]);
            work += f.dot(&(end - start));
        }
        work
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::super::facets::Facets;
    use super::*;
    use crate::contact::PredictedMotion;
    use crate::contact::fixtures::{difference, evaluated, product};

    fn obstacles() -> Vec<ObstacleInSpace> {
        let (center, axis) = ([0.1, -0.2, 0.3], [1.0, 2.0, -1.0]);
        let mut all = vec![
            ObstacleInSpace::Plane { point: center, normal: axis },
            ObstacleInSpace::FiniteCylinder { center, axis, radius: 0.7, length: 1.1, edge: 0.1 },
        ];
        for is_hollow in [false, true] {
            all.extend([
                ObstacleInSpace::Sphere { center, radius: 0.7, axis: [0.0, 0.0, 1.0], is_hollow },
                ObstacleInSpace::Cylinder { point: center, axis, radius: 0.7, is_hollow },
                ObstacleInSpace::Cone { tip: center, axis, angle: 0.6, is_hollow },
                ObstacleInSpace::Torus { center, axis, radius: 1.2, tube: 0.4, is_hollow },
            ]);
        }
        let cube = Facets::cuboid([-0.8, -0.5, -0.4], [0.3, 0.6, 0.7]).and_then(|cube| cube.turned([0.0; 3], axis, 0.4));
        all.extend([cube.expect("it has a volume"), tray()].map(|facets| ObstacleInSpace::Facets(facets.into())));
        all
    }

    /// Three faces of a corner that is open towards positive coordinates.
    fn tray() -> Facets {
        let points = [[0.0; 3], [3.0, 0.0, 0.0], [3.0, 3.0, 0.0], [0.0, 3.0, 0.0], [0.0, 3.0, 3.0], [0.0, 0.0, 3.0], [3.0, 0.0, 3.0]];
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6], [0, 6, 1]];
        Facets::new(&points, &triangles).expect("it is a surface")
    }

    /// Contact of one facet with a moving obstacle.
    fn contact(obstacle: &ObstacleInSpace, q_0: &[f64], translations: &[[f64; 3]; 3]) -> RigidInSpace {
        let mut kernel = RigidInSpace::new(Surface::in_space([&[0, 1, 2][..]]), obstacle, q_0);
        kernel.move_obstacle(translations);
        assert!(!kernel.update_candidates(&PredictedMotion::within(q_0, 1.0)));
        kernel.begin_step(q_0);
        kernel
    }

    fn multipliers(kernel: &RigidInSpace) -> Vec<f64> {
        (0..kernel.rows()).map(|row| 1.5 - 0.7 * row as f64).collect()
    }

    fn step() -> impl Strategy<Value = ([f64; 9], [f64; 9], [[f64; 3]; 3])> {
        let places = prop::collection::vec(-1.5..1.5f64, 9).prop_map(|all| std::array::from_fn(|i| all[i]));
        let motion = prop::collection::vec(-1.0..1.0f64, 9);
        let size = prop::sample::select(vec![1e-9, 1e-3, 0.1, 1.0]);
        let translations = prop::array::uniform3(prop::array::uniform3(-0.3..0.3f64));
        (places, motion, translations, size).prop_map(|(q_0, motion, translations, size): ([f64; 9], Vec<f64>, _, f64)| {
            (q_0, std::array::from_fn(|i| q_0[i] + size * motion[i]), translations)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 500, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        /// The work of the forces equals multipliers times changes of the gaps plus the work of the obstacle's motion.
        #[test]
        fn work_is_what_the_gaps_and_the_motion_say((q_0, q_1, translations) in step()) {
            for obstacle in obstacles() {
                let kernel = contact(&obstacle, &q_0, &translations);
                let lambda = multipliers(&kernel);
                let out = evaluated(&kernel, Derivative::DiscreteGradient, &q_1, &lambda);
                let (mut force, none) = (vec![0.0; 9], vec![0.0; lambda.len()]);
                let by_motion = kernel.obstacle_force_into(Derivative::DiscreteGradient, &q_1, &none, &lambda, &mut force);
                let by_gaps = product(&lambda, &difference(&out.gap, &kernel.start_gap()));
                let work = product(&force, &difference(&q_1, &q_0));
                let size: f64 = 1.0 + force.iter().map(|f| f.abs()).sum::<f64>();
                prop_assert!((work - by_gaps - by_motion).abs() < 4e-14 * size, "{obstacle:?}: {work} {by_gaps} {by_motion}");
                for row in kernel.present_constraints().map(|(row, ..)| row) {
                    let node = row / kernel.slots;
                    for i in 0..3 {
                        force[3 * node + i] -= lambda[row] * out.gradient_bar[3 * row + i];
                    }
                }
                prop_assert!(force.iter().all(|f| f.abs() < 1e-14 * size), "{force:?}");
            }
        }

        /// Conservation by symmetry of the obstacle: momentum along a plane, angular momentum about a center and about an axis.
        #[test]
        fn symmetries_of_the_obstacle_are_kept((q_0, q_1, _) in step()) {
            for obstacle in obstacles() {
                let kernel = contact(&obstacle, &q_0, &[[0.0; 3]; 3]);
                let lambda = multipliers(&kernel);
                let (mut force, none) = (vec![0.0; 9], vec![0.0; lambda.len()]);
                kernel.obstacle_force_into(Derivative::DiscreteGradient, &q_1, &none, &lambda, &mut force);
                for node in 0..3 {
                    let at = |q: &[f64]| Vector3::from_column_slice(&q[3 * node..3 * node + 3]);
                    let (f, middle) = (at(&force), 0.5 * (at(&q_0) + at(&q_1)));
                    match &kernel.shape {
                        Shape::Plane { normal, .. } => prop_assert!(normal.cross(&f).norm() < 1e-14),
                        Shape::Sphere { center, .. } => prop_assert!((middle - center).cross(&f).norm() < 1e-14),
                        Shape::Revolved { origin, axis, .. } => {
                            prop_assert!(axis.dot(&(middle - origin).cross(&f)).abs() < 1e-13, "{obstacle:?}");
                        }
                        _ => {}
                    }
                }
            }
        }

        #[test]
        fn tangents_agree_with_differences((q_0, q_1, translations) in step()) {
            let step = 1e-5;
            for obstacle in obstacles() {
                let kernel = contact(&obstacle, &q_0, &translations);
                let lambda = multipliers(&kernel);
                for derivative in Derivative::ALL {
                    let out = evaluated(&kernel, derivative, &q_1, &lambda);
                    for node in 0..3 {
                        let short = (0..3).map(|i| (q_1[3 * node + i] - q_0[3 * node + i]).powi(2)).sum::<f64>() < 0.0025;
                        if short {
                            continue;
                        }
                        for k in 0..3 {
                            let at = |shift: f64| -> [f64; 3] {
                                let mut moved = q_1;
                                moved[3 * node + k] += shift;
                                let bar = evaluated(&kernel, derivative, &moved, &lambda).gradient_bar;
                                let rows = kernel.slots * node..kernel.slots * (node + 1);
                                std::array::from_fn(|i| rows.clone().map(|row| lambda[row] * bar[3 * row + i]).sum())
                            };
                            let [fine, coarse] = [step, 2.0 * step].map(|h| {
                                let (high, low) = (at(h), at(-h));
                                [0, 1, 2].map(|i| (high[i] - low[i]) / (2.0 * h))
                            });
                            for i in 0..3 {
                                // At kinks (edges, tips, axes) difference quotients of different widths disagree.
                                if (fine[i] - coarse[i]).abs() < 1e-7 {
                                    let ours = out.tangent[9 * node + 3 * i + k];
                                    prop_assert!((ours - fine[i]).abs() < 1e-6, "{obstacle:?} {derivative:?}: {ours} {}", fine[i]);
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    fn gap(obstacle: ObstacleInSpace, x: [f64; 3]) -> f64 {
        Shape::new(&obstacle).distance(Vector3::from(x)).gap
    }

    /// Closed forms of the signed distances.
    #[test]
    fn distances() {
        let (origin, up) = ([0.0; 3], [0.0, 0.0, 2.0]);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        near(gap(ObstacleInSpace::Plane { point: [5.0, 5.0, 1.0], normal: up }, [7.0, 0.0, 1.5]), 0.5);
        near(gap(ObstacleInSpace::Sphere { center: origin, radius: 3.0, axis: [0.0, 0.0, 1.0], is_hollow: false }, [2.0, 3.0, 6.0]), 4.0);
        near(gap(ObstacleInSpace::Sphere { center: origin, radius: 3.0, axis: [0.0, 0.0, 1.0], is_hollow: true }, [0.0, 1.0, 0.0]), 2.0);
        near(gap(ObstacleInSpace::Cylinder { point: origin, axis: up, radius: 3.0, is_hollow: false }, [3.0, 4.0, 9.0]), 2.0);
        let cylinder = ObstacleInSpace::FiniteCylinder { center: origin, axis: up, radius: 3.0, length: 4.0, edge: 1.0 };
        near(gap(cylinder.clone(), [3.0, 4.0, 0.5]), 2.0);
        near(gap(cylinder.clone(), [1.0, 0.0, -5.0]), 3.0);
        near(gap(cylinder.clone(), [5.0, 0.0, 5.0]), 4.0);
        near(gap(cylinder, [0.0, 0.5, 1.5]), -0.5);
        let cone = |is_hollow| ObstacleInSpace::Cone { tip: origin, axis: up, angle: std::f64::consts::FRAC_PI_4, is_hollow };
        near(gap(cone(false), [2.0, 0.0, 0.0]), 2f64.sqrt());
        near(gap(cone(false), [0.0, 0.0, -2.0]), 2.0);
        near(gap(cone(true), [0.0, 0.0, 2.0]), 2f64.sqrt());
        let torus = |is_hollow| ObstacleInSpace::Torus { center: origin, axis: up, radius: 3.0, tube: 1.0, is_hollow };
        near(gap(torus(false), [0.0, 3.0, 2.0]), 1.0);
        near(gap(torus(false), [0.0, 0.0, 0.0]), 2.0);
        near(gap(torus(true), [0.0, -3.5, 0.0]), 0.5);
    }

    /// Closed form of the distance from the faces, edges and vertices of a box.
    #[test]
    fn a_box_is_as_far_as_its_closed_form_says() {
        let half = [0.5, 1.0, 1.5];
        let cube = Facets::cuboid(half.map(|x| -x), half).expect("it has a volume");
        let cube = ObstacleInSpace::Facets(cube.into());
        let mut seed = 1.0f64;
        for _ in 0..500 {
            let x: [f64; 3] = std::array::from_fn(|_| {
                seed = (seed * 16807.0) % 2147483647.0;
                5.0 * (seed / 2147483647.0) - 2.5
            });
            let beyond = [0, 1, 2].map(|i| x[i].abs() - half[i]);
            let outside = beyond.map(|x| x.max(0.0)).iter().map(|x| x * x).sum::<f64>().sqrt();
            let expected = outside + beyond.into_iter().fold(f64::NEG_INFINITY, f64::max).min(0.0);
            let ours = gap(cube.clone(), x);
            assert!((ours - expected).abs() < 1e-14, "{x:?}: {ours} {expected}");
        }
    }

    /// In a corner of a tray a node has one constraint per side, away from it one for the nearest side.
    #[test]
    fn a_pocket_has_a_row_for_each_side() {
        let obstacle = ObstacleInSpace::Facets(tray().into());
        let gaps_at = |x: [f64; 3]| {
            let q: Vec<f64> = [x, [x[0] + 1.0, x[1], x[2]], [x[0], x[1] + 1.0, x[2]]].concat();
            let kernel = contact(&obstacle, &q, &[[0.0; 3]; 3]);
            let gaps: Vec<f64> =
                kernel.present_constraints().filter(|&(_, node, _)| node == 0).map(|(row, ..)| kernel.start_gap()[row]).collect();
            gaps.into_iter().map(|gap| gap / kernel.weights()[0]).collect::<Vec<f64>>()
        };
        let mut three = gaps_at([0.1, 0.2, 0.3]);
        three.sort_by(f64::total_cmp);
        assert!(three.iter().zip([0.1, 0.2, 0.3]).all(|(a, b)| (a - b).abs() < 1e-15) && three.len() == 3, "{three:?}");
        assert_eq!(gaps_at([2.5, 2.5, 0.25]).len(), 1);
        // A node outside of two sides penetrates both.
        let out = gaps_at([-0.05, 1.0, -0.1]);
        assert!(out.len() == 2 && out.iter().all(|gap| *gap < 0.0), "{out:?}");
    }

    #[test]
    fn triangles_that_look_to_opposite_sides_are_refused() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        assert!(Facets::new(&points, &[[0, 1, 2], [1, 3, 2]]).is_ok());
        assert!(Facets::new(&points, &[[0, 1, 2], [1, 2, 3]]).is_err());
        assert!(Facets::new(&points, &[[0, 1, 1]]).is_err());
    }

    #[test]
    fn a_node_that_comes_through_a_thin_plate_is_told() {
        let plate = Facets::cuboid([-1.0, -1.0, -0.01], [1.0, 1.0, 0.01]).expect("it has a volume");
        let q_0 = [0.1, 0.1, 0.3, 0.6, 0.1, 0.3, 0.1, 0.6, 0.3];
        let kernel = contact(&ObstacleInSpace::Facets(plate.into()), &q_0, &[[0.0; 3]; 3]);
        let at = |z: f64| q_0.iter().enumerate().map(|(i, x)| if i % 3 == 2 { z } else { *x }).collect::<Vec<f64>>();
        assert!(kernel.passage(&at(-0.3))[1] > 0.0 && kernel.passage(&at(0.02))[1] == 0.0);
    }
}
