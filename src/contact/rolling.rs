//! Contact of round parts of a rigid body (disk, ball, rounded edge, rim of a cylinder) with a rigid obstacle: parts roll on their exact
//! circles instead of facets.
//!
//! A part of radius `R` about the body point `C` has the gap of `C` minus `R`. `C` is a combination of the positions `z_k` of the body's
//! masters (`bodies/rigid.rs`). With the obstacle's signed distance `g`, normal `n` and translation `u`
//!
//! ```text
//! Phi = w (g(C - u) - R),    C = sum_k c_k z_k,    dPhi/dz_k = w c_k n
//! ```
//!
//! Cylinders touch at their rims. The point of a circle about `C` with the unit axis `a` that is nearest to a plane is nearer than `C` by
//! `R h`,
//!
//! ```text
//! Phi = w (g(C - u) - R h(n.a)),    h(s) = sqrt(1 - s^2),    a = sum_k a_k z_k
//! ```
//!
//! with the normal `n` at the start of the step; the discrete derivative of `h` is `-(s_0 + s_1)/(h_0 + h_1)`. Planes, facets and parallel
//! cylinders are obstacles of rims; for other obstacles, and for rims that lie flat, the nodes have constraints.
//!
//! The discrete gradient is that of the distance between the centers, with the same conservation properties as for nodes. The force acts at
//! the contact point `x = C - R n`, because its line of action contains both. Friction depends on the slip of this material point, `x =
//! sum_k a_k z_k` with the coefficients `a_k` at mid-step.
//!
//! Two round rigid bodies touch likewise: with the center of the other body as the origin, the other body is a round obstacle, and its
//! masters enter with negative coefficients,
//!
//! ```text
//! Phi = w (g(C - C') - R),    C - C' = sum_k c_k z_k - sum_l c'_l z'_l
//! ```
//!
//! The contact point is one material point of each body at `x = C - R n`, so that friction forces have no resulting moment either.
//!
//! A constraint is present in a step if the part faces the obstacle at its start, or the other body is near. Nodes inside of a part have no
//! constraints: they are never nearer than its circle. Each part has as many constraints as sides of the obstacle can touch it
//! simultaneously.

use std::ops::Range;

use nalgebra::SVector;

use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use super::numbers::Number;
use super::obstacle_side::{Distance, ObstacleSide, StepGradient};
use super::patches::Evaluation;
use super::rollers::{MASTERS, Roller, RoundBody};
use super::round_parts::{Curvature, RoundPart};
use super::slip::{SlipStep, Slips};
use super::surface::{Sides, Surface};
use super::tilt::Tilt;
use super::window::PredictedMotion;
use crate::integrators::Derivative;
use crate::math::tolerances::CROSSING;

/// Distance between two round bodies, relative to the smaller radius, up to which their constraint is part of the equations, in addition to
/// the distance that they approach in a step.
const NEAR: f64 = 0.25;

/// Contact of the round parts of a rigid body with a rigid obstacle, or with other round rigid bodies.
#[derive(Clone, Debug)]
pub(super) struct RollingContact<const D: usize, S> {
    sides: Sides,
    rollers: Vec<Roller<S>>,
    /// Number of constraints of each part.
    count: usize,
    /// True for each part whose constraints are in the equations.
    is_near: Vec<bool>,
    pub(super) translations: [[f64; 3]; 3],
    /// Displacement `[length]` and rotation angle `[rad]` of the obstacle's surface in the step, relative to which slip is measured.
    pub(super) carried: ([f64; 3], f64),
    /// Centers at the start of the step.
    start: Vec<SVector<f64, D>>,
    /// Tilt of the part of each constraint at the start of the step.
    at_start: Vec<Tilt>,
    /// Side of the obstacle for each constraint in this step, with its normal at the start; `None` for absent constraints.
    obstacle_sides: Vec<Option<(S, SVector<f64, D>)>>,
}

impl<const D: usize, S: ObstacleSide<D>> RollingContact<D, S> {
    pub fn new(
        surface: Surface,
        parts: Vec<RoundPart>,
        shape: S,
        shares_of: &dyn Fn([f64; 3]) -> Vec<(u32, f64)>,
        reference: &[f64],
    ) -> Self {
        let rollers = parts.into_iter().map(|part| Roller::on_obstacle(part, shape.clone(), shares_of)).collect();
        RollingContact::of_rollers(surface, rollers, shape.sides(), reference)
    }

    /// Contact of a round rigid body with others; at least one of two bodies is convex. `shape_of` is the obstacle with this border about
    /// the origin.
    pub fn between(
        surface: Surface,
        secondary: &RoundBody,
        primary: Vec<RoundBody>,
        shape_of: &dyn Fn(f64, Curvature) -> S,
        reference: &[f64],
    ) -> Self {
        let rollers = primary.into_iter().map(|other| Roller::between(secondary, other, shape_of)).collect();
        RollingContact::of_rollers(surface, rollers, 1, reference)
    }

    fn of_rollers(surface: Surface, rollers: Vec<Roller<S>>, count: usize, reference: &[f64]) -> Self {
        let mut sides = Sides::of(surface, if D == 2 { Surface::new(&[]) } else { Surface::in_space([]) }, reference);
        sides.weights = vec![sides.facet_size.powi(D as i32 - 1); count * rollers.len()];
        let obstacle_sides = vec![None; sides.weights.len()];
        let at_start = vec![Tilt::of(0.0); sides.weights.len()];
        let start = vec![SVector::zeros(); rollers.len()];
        let is_near = vec![true; rollers.len()];
        let mut contact = RollingContact {
            sides,
            rollers,
            count,
            is_near,
            translations: [[0.0; 3]; 3],
            carried: Default::default(),
            start,
            at_start,
            obstacle_sides,
        };
        contact.list_elements();
        contact
    }

    /// Lists one contact element for each part; that of a part that is not near is empty.
    fn list_elements(&mut self) {
        self.sides.patches.clear();
        for (p, roller) in self.rollers.iter().enumerate() {
            let rows: Vec<u32> = self.rows_of(p).map(|row| row as u32).collect();
            let nodes: Vec<u32> = roller.masters.iter().map(|(node, _)| *node).collect();
            if self.is_near[p] {
                self.sides.patches.push(&nodes, &rows);
            } else {
                self.sides.patches.push(&[], &[]);
            }
        }
        if D == 3 {
            self.sides.list_slips();
        }
    }

    /// True if the other side is an obstacle.
    pub(super) fn is_on_obstacle(&self) -> bool {
        self.rollers.first().is_some_and(|roller| roller.other.is_none())
    }

    /// Shape of the obstacle, or of the first of the other bodies.
    pub(super) fn shape(&self) -> Option<&S> {
        self.rollers.first().map(|roller| &roller.shape)
    }

    /// Distance between two round bodies at the positions `q` `[length]`; `None` for an obstacle.
    fn distance_to_other(&self, roller: usize, q: &[f64]) -> Option<f64> {
        let Roller { other, shape, part, .. } = &self.rollers[roller];
        other.as_ref().map(|_| shape.at(self.center(roller, q, 0)).gap - part.radius)
    }

    pub(super) fn own_sides(&self) -> &Sides {
        &self.sides
    }

    fn moved(&self, time: usize) -> SVector<f64, D> {
        SVector::from_fn(|i, _| self.translations[time][i])
    }

    /// Center of a part relative to the obstacle at the start (0), in the middle (1) or at the end (2) of the step.
    fn center(&self, roller: usize, q: &[f64], time: usize) -> SVector<f64, D> {
        self.rollers[roller].center::<D>(q) - self.moved(time)
    }

    /// Nodes of the secondary and of the primary side nearest to the contact point of a part.
    fn nearest(&self, roller: usize, q: &[f64]) -> [u32; 2] {
        let normal = self.rollers[roller].shape.at(self.center(roller, q, 2)).normal;
        self.rollers[roller].nearest(q, normal)
    }

    /// Tilt of a part's axis relative to a normal for the masters at `q`; zero for arcs and spheres.
    fn nearer(&self, roller: usize, normal: SVector<f64, D>, q: &[f64]) -> Tilt {
        self.rollers[roller].axis::<D>(q).map_or(Tilt::of(0.0), |axis| Tilt::of(axis.dot(&normal)))
    }

    /// Algorithmic gradient of a step, and its derivative, for the center of a part, without weight.
    fn step_gradient(&self, obstacle_side: &S, derivative: Derivative, roller: usize, q_1: &[f64]) -> StepGradient<D> {
        let end = self.center(roller, q_1, 2);
        let middle = 0.5 * (self.start[roller] + end + self.moved(2)) - self.moved(1);
        obstacle_side.gradient_of(derivative, [self.begins(roller), middle, end], self.sides.facet_size)
    }

    pub(super) fn rows_of(&self, roller: usize) -> Range<usize> {
        self.count * roller..self.count * (roller + 1)
    }

    /// Constraints that are present in this step: index, part, side of the obstacle, and normal at the start of the step.
    fn present_constraints(&self) -> impl Iterator<Item = (usize, usize, &S, SVector<f64, D>)> {
        let count = self.count;
        self.obstacle_sides.iter().enumerate().filter_map(move |(row, obstacle_side)| {
            obstacle_side.as_ref().map(|(obstacle_side, normal)| (row, row / count, obstacle_side, *normal))
        })
    }

    /// Distance from the whole obstacle at the end of the step, for each part that faces it.
    fn distances(&self, q: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        (0..self.rollers.len()).filter_map(move |roller| {
            let shape = &self.rollers[roller].shape;
            let local = shape.at(self.center(roller, q, 2));
            let tilt = self.nearer(roller, local.normal, q);
            let is_there = self.touches(roller, shape, &local, tilt, q);
            is_there.then(|| (roller, local.gap - self.rollers[roller].part.radius * tilt.height))
        })
    }

    /// True if a part faces a side of the obstacle so that it may touch it.
    fn touches(&self, roller: usize, obstacle_side: &S, local: &Distance<D>, tilt: Tilt, q: &[f64]) -> bool {
        let is_rim = self.rollers[roller].axis.is_some();
        local.covered && (!is_rim || obstacle_side.takes_rims() && !tilt.is_flat()) && self.rollers[roller].facing(q, -local.normal).1
    }

    /// Coefficients of the masters in the slip of a part on the side `obstacle_side`, for the masters at `z` in mid-step, and the normal.
    pub(super) fn touching<T: Number>(&self, roller: usize, obstacle_side: &S, z: &[[T; D]]) -> ([T; MASTERS], [T; D]) {
        self.rollers[roller].touching(obstacle_side, self.moved(1), z)
    }

    pub(super) fn weight(&self, row: usize) -> f64 {
        self.sides.weights[row]
    }

    /// Sides of the obstacle for the constraints of a part in this step.
    pub(super) fn sides_near(&self, roller: usize) -> &[Option<(S, SVector<f64, D>)>] {
        &self.obstacle_sides[self.rows_of(roller)]
    }

    /// Center of a part at the start of the step, relative to the obstacle.
    pub(super) fn begins(&self, roller: usize) -> SVector<f64, D> {
        self.start[roller] - self.moved(0)
    }
}

impl<const D: usize, S: ObstacleSide<D>> PatchFunctions for RollingContact<D, S>
where
    Self: Slips,
{
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn rows_per_node(&self) -> usize {
        self.count
    }

    fn row_nodes(&self) -> &[u32] {
        // Constraints belong to round parts, not to nodes.
        &[]
    }

    fn shown_at(&self, row: usize, q: &[f64]) -> Option<u32> {
        Some(self.nearest(row / self.count, q)[0])
    }

    fn shown_on_primary(&self, row: usize, q: &[f64]) -> Option<u32> {
        let roller = row / self.count;
        self.rollers[roller].other.as_ref().map(|_| self.nearest(roller, q)[1])
    }

    fn carriers(&self, row: usize) -> &[u32] {
        self.sides.patches.nodes(row / self.count)
    }

    fn owns(&self, p: usize, node: u32) -> bool {
        self.rollers[p].is_on_secondary(node, D)
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        let from = self.moved(0);
        self.start = (0..self.rollers.len()).map(|roller| self.center(roller, q_0, 0) + from).collect();
        for roller in 0..self.rollers.len() {
            let (x, radius, spare) = (self.begins(roller), self.rollers[roller].part.radius, self.sides.facet_size);
            let shape = &self.rollers[roller].shape;
            let Distance { normal, .. } = shape.at(x);
            let near = if self.is_near[roller] { shape.near(x, radius, spare) } else { Vec::new() };
            let of_side = |side: S| {
                let local = side.at(x);
                let tilt = self.nearer(roller, local.normal, q_0);
                self.touches(roller, &side, &local, tilt, q_0).then_some((side, local.normal))
            };
            let found: Vec<Option<(S, SVector<f64, D>)>> = near.into_iter().map(of_side).collect();
            for (place, row) in self.rows_of(roller).enumerate() {
                self.obstacle_sides[row] = found.get(place).cloned().flatten();
                let normal = self.obstacle_sides[row].as_ref().map_or(normal, |(_, normal)| *normal);
                self.at_start[row] = self.nearer(roller, normal, q_0);
            }
        }
    }

    fn start_gap(&self) -> Vec<f64> {
        let nearer = |row: usize, roller: usize| self.rollers[roller].part.radius * self.at_start[row].height;
        let gaps = self.present_constraints().map(|(row, roller, side, _)| (row, side.at(self.begins(roller)).gap - nearer(row, roller)));
        self.sides.weighted(gaps)
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        let patches = &self.sides.patches;
        out.prepare(patches, self.sides.weights.len());
        (0..patches.len()).for_each(|p| out.clear_patch(patches, p));
        for (row, p, obstacle_side, normal) in self.present_constraints() {
            let (weight, Roller { masters, part, axis, .. }) = (self.sides.weights[row], &self.rollers[p]);
            let end = obstacle_side.at(self.center(p, q_1, 2));
            let StepGradient { bar, tangent } = self.step_gradient(obstacle_side, derivative, p, q_1);
            let tilt = self.nearer(p, normal, q_1);
            let [of_step, bend] = self.at_start[row].to(tilt, derivative).map(|x| x * part.radius);
            out.live[p] = true;
            let gap = weight * (end.gap - part.radius * tilt.height);
            (out.gap[row], out.coverage[row]) = (gap, f64::from(u8::from(end.covered)));
            let turn = |k: usize| axis.as_ref().map_or(0.0, |axis| axis[k]);
            let width = patches.unknowns(p);
            let first = patches.gradient_range(p).start + (row - self.rows_of(p).start) * width;
            let block = patches.tangent_range(p).start;
            for (k, (_, share)) in masters.iter().enumerate() {
                for i in 0..D {
                    let [at_end, mean] = [part.radius * tilt.slope, of_step].map(|slope| turn(k) * slope * normal[i]);
                    out.gradient_end[first + D * k + i] = weight * (share * end.normal[i] - at_end);
                    out.gradient_bar[first + D * k + i] = weight * (share * bar[i] - mean);
                    for (l, (_, other)) in masters.iter().enumerate() {
                        for j in 0..D {
                            let turned = turn(k) * turn(l) * bend * normal[i] * normal[j];
                            out.tangent[block + (D * k + i) * width + D * l + j] +=
                                lambda[row] * weight * (share * other * tangent[(i, j)] - turned);
                        }
                    }
                }
            }
        }
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        self.slips(step, lambda, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        // The first constraint of a part represents the whole obstacle.
        self.sides.weighted(self.distances(q).map(|(roller, gap)| (self.rows_of(roller).start, gap)))
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        self.sides.per_row(self.distances(q).map(|(roller, _)| (self.rows_of(roller).start, 1.0)))
    }
}

impl<const D: usize, S: ObstacleSide<D>> CandidateSearch for RollingContact<D, S>
where
    Self: Slips,
{
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        let is_near: Vec<bool> = (0..self.rollers.len())
            .map(|roller| {
                let Roller { part, other, masters, .. } = &self.rollers[roller];
                let (Some(other), Some(distance)) = (other, self.distance_to_other(roller, predicted_motion.q)) else { return true };
                let nodes: Vec<u32> = masters.iter().map(|(node, _)| *node).collect();
                let (own, others) = nodes.split_at(self.rollers[roller].own(D));
                let approach = predicted_motion.reach * predicted_motion.motion_bound::<D>(own, others);
                distance < 2.0 * approach + predicted_motion.depth + NEAR * part.radius.min(other.part.radius)
            })
            .collect();
        let is_changed = self.is_near != is_near;
        if is_changed {
            self.is_near = is_near;
            self.list_elements();
        }
        is_changed
    }

    fn margin(&self, _predicted_motion: &PredictedMotion) -> f64 {
        // Bodies that approach from outside of the search horizon are found by `overlooks`.
        f64::INFINITY
    }

    fn overlooks(&self, _q_0: &[f64], q_1: &[f64], tolerance: f64) -> bool {
        let is_deep = |roller| self.distance_to_other(roller, q_1).is_some_and(|distance| distance < -tolerance);
        (0..self.rollers.len()).any(|roller| !self.is_near[roller] && is_deep(roller))
    }

    fn deepest(&self, q: &[f64]) -> f64 {
        self.distances(q).map(|(_, gap)| -gap).fold(0.0, f64::max)
    }
}

impl<const D: usize, S: ObstacleSide<D>> RigidObstacle for RollingContact<D, S>
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
        let (mut direction_change, mut crossing) = (0.0f64, 0.0f64);
        for roller in 0..self.rollers.len() {
            let near = self.rollers[roller].part.radius.max(self.sides.facet_size);
            let (x_0, x_1) = (self.begins(roller), self.center(roller, q_1, 2));
            let shape = &self.rollers[roller].shape;
            direction_change = direction_change.max(shape.direction_change(x_0, x_1, near) / near);
            if shape.is_crossed(x_0, x_1, near) {
                crossing = crossing.max((x_1 - x_0).norm());
            }
        }
        let crossing = crossing / self.sides.facet_size;
        [direction_change, if crossing > CROSSING { crossing } else { 0.0 }]
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        if !self.is_on_obstacle() {
            return 0.0;
        }
        let way = self.moved(2) - self.moved(0);
        let mut work = 0.0;
        for (row, roller, obstacle_side, normal) in self.present_constraints().filter(|&(row, ..)| before[row] != 0.0 || lambda[row] != 0.0)
        {
            let (weight, Roller { masters, part, axis, .. }) = (self.sides.weights[row], &self.rollers[roller]);
            let of_step = self.step_gradient(obstacle_side, derivative, roller, q_1).bar * lambda[row];
            let f = (of_step + obstacle_side.at(self.begins(roller)).normal * before[row]) * weight;
            let [slope, _] = self.at_start[row].to(self.nearer(roller, normal, q_1), derivative);
            let couple = normal * (-weight * part.radius * (slope * lambda[row] + self.at_start[row].slope * before[row]));
            for (k, (node, share)) in masters.iter().enumerate() {
                let turn = axis.as_ref().map_or(0.0, |axis| axis[k]);
                (0..D).for_each(|i| force[D * *node as usize + i] += share * f[i] + turn * couple[i]);
            }
            work += f.dot(&way);
        }
        work
    }
}
