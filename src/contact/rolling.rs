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
//! A constraint is present in a step if the part faces the obstacle at its start. Nodes inside of a part have no constraints: they are
//! never nearer than its circle. Each part has as many constraints as sides of the obstacle can touch it simultaneously.

use std::ops::Range;

use nalgebra::{SMatrix, SVector};

use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use super::numbers::Number;
use super::obstacle_side::{Local, ObstacleSide};
use super::patches::Evaluation;
use super::round_parts::RoundPart;
use super::slip::SlipStep;
use super::surface::{Sides, Surface};
use super::tilt::Tilt;
use crate::integrators::{Configuration, Derivative};
use crate::math::tolerances::CROSSING;

/// Round part and the masters of its body.
#[derive(Clone, Debug)]
struct Roller {
    part: RoundPart,
    /// Model node numbers of the masters, with their coefficients in the center.
    masters: Vec<(u32, f64)>,
    /// Coefficients of the axis vector of a rim as a linear combination of the masters' positions; `None` without an axis.
    axis: Option<Vec<f64>>,
}

/// Contact of the round parts of a rigid body with a rigid obstacle.
#[derive(Clone, Debug)]
pub(super) struct RollingContact<const D: usize, S> {
    sides: Sides,
    rollers: Vec<Roller>,
    pub(super) shape: S,
    pub(super) translations: [[f64; 3]; 3],
    /// Displacement `[length]` and rotation angle `[rad]` of the obstacle's surface in the step, relative to which slip is measured.
    pub(super) carried: ([f64; 3], f64),
    /// Centers at the start of the step.
    start: Vec<SVector<f64, D>>,
    /// Tilt of the part of each constraint at the start of the step.
    at_start: Vec<Tilt>,
    /// Node of each part nearest to the obstacle at the start of the step.
    nearest: Vec<u32>,
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
        let mut sides = Sides::of(surface, if D == 2 { Surface::new(&[]) } else { Surface::in_space([]) }, reference);
        let count = shape.sides();
        sides.weights = vec![sides.facet_size.powi(D as i32 - 1); count * parts.len()];
        let roller = |part: RoundPart| {
            let masters = shares_of(part.center.into());
            let to = part.axis.map(|axis| shares_of((part.center + axis).into()));
            let axis = to.map(|to| to.iter().zip(&masters).map(|(to, from)| to.1 - from.1).collect());
            Roller { masters, axis, part }
        };
        let rollers: Vec<Roller> = parts.into_iter().map(roller).collect();
        for (p, roller) in rollers.iter().enumerate() {
            let nodes: Vec<u32> = roller.masters.iter().map(|(node, _)| *node).collect();
            let rows: Vec<u32> = (count * p..count * (p + 1)).map(|row| row as u32).collect();
            sides.patches.push(&nodes, &rows);
        }
        if D == 3 {
            sides.list_slips();
        }
        let nearest = rollers.iter().map(|roller| roller.part.inside[0]).collect();
        let obstacle_sides = vec![None; sides.weights.len()];
        let at_start = vec![Tilt::of(0.0); sides.weights.len()];
        let start = vec![SVector::zeros(); rollers.len()];
        RollingContact {
            sides,
            rollers,
            shape,
            translations: [[0.0; 3]; 3],
            carried: Default::default(),
            start,
            at_start,
            nearest,
            obstacle_sides,
        }
    }

    pub(super) fn own_sides(&self) -> &Sides {
        &self.sides
    }

    fn moved(&self, time: usize) -> SVector<f64, D> {
        SVector::from_fn(|i, _| self.translations[time][i])
    }

    /// Center of a part relative to the obstacle at the start (0), in the middle (1) or at the end (2) of the step.
    fn center(&self, roller: usize, q: &[f64], time: usize) -> SVector<f64, D> {
        let shares = self.rollers[roller].masters.iter();
        shares.map(|&(node, share)| place::<D>(node, q) * share).sum::<SVector<f64, D>>() - self.moved(time)
    }

    /// Axis of a rim for the masters at `q`; `None` for arcs and spheres.
    fn axis(&self, roller: usize, q: &[f64]) -> Option<SVector<f64, D>> {
        let Roller { masters, axis, .. } = &self.rollers[roller];
        axis.as_ref().map(|axis| masters.iter().zip(axis).map(|((node, _), share)| place::<D>(*node, q) * *share).sum())
    }

    /// Tilt of a part's axis relative to a normal for the masters at `q`; zero for arcs and spheres.
    fn nearer(&self, roller: usize, normal: SVector<f64, D>, q: &[f64]) -> Tilt {
        self.axis(roller, q).map_or(Tilt::of(0.0), |axis| Tilt::of(axis.dot(&normal)))
    }

    /// Node of a part that is farthest from the center in the given direction (nearest to the obstacle), and true if the part faces that
    /// direction.
    fn facing(&self, roller: usize, q: &[f64], direction: SVector<f64, D>) -> (u32, bool) {
        let part = &self.rollers[roller].part;
        let along = |node: u32| place::<D>(node, q).dot(&direction);
        let farthest = |nodes: &mut dyn Iterator<Item = u32>| nodes.map(|node| (along(node), node)).max_by(|a, b| a.0.total_cmp(&b.0));
        let inside = farthest(&mut part.inside.iter().copied()).map_or((f64::NEG_INFINITY, part.inside[0]), |found| found);
        match farthest(&mut part.rim.iter().map(|(node, _)| *node)) {
            Some((most, node)) if most > inside.0 => {
                let beside = part.rim.iter().filter(|(other, _)| *other == node).flat_map(|(_, inner)| inner);
                let inward: SVector<f64, D> = beside.map(|&other| place::<D>(other, q) - place::<D>(node, q)).sum();
                let center: SVector<f64, D> = self.center(roller, q, 0) + self.moved(0);
                let out = (place::<D>(node, q) - center).normalize();
                // Component of the direction tangential to the circle at the rim node.
                (node, (direction - out * direction.dot(&out)).dot(&inward) > 0.0)
            }
            _ => (inside.1, true),
        }
    }

    /// Algorithmic gradient of a step, and its derivative, for the center of a part, without weight.
    fn step_gradient(
        &self,
        obstacle_side: &S,
        derivative: Derivative,
        roller: usize,
        q_1: &[f64],
    ) -> (SVector<f64, D>, SMatrix<f64, D, D>) {
        let plain = |x: SVector<f64, D>, at: Configuration| {
            let Local { normal, curvature, .. } = obstacle_side.at(x);
            (normal, curvature * at.share())
        };
        match derivative {
            Derivative::DiscreteGradient => {
                obstacle_side.between(self.start[roller] - self.moved(0), self.center(roller, q_1, 2), self.sides.facet_size)
            }
            Derivative::Gradient(at @ Configuration::Middle) => {
                plain(0.5 * (self.start[roller] + self.center(roller, q_1, 2) + self.moved(2)) - self.moved(1), at)
            }
            Derivative::Gradient(at @ Configuration::End) => plain(self.center(roller, q_1, 2), at),
        }
    }

    pub(super) fn rows_of(&self, roller: usize) -> Range<usize> {
        let count = self.shape.sides();
        count * roller..count * (roller + 1)
    }

    /// Constraints that are present in this step: index, part, side of the obstacle, and normal at the start of the step.
    fn present_constraints(&self) -> impl Iterator<Item = (usize, usize, &S, SVector<f64, D>)> {
        let count = self.shape.sides();
        self.obstacle_sides.iter().enumerate().filter_map(move |(row, obstacle_side)| {
            obstacle_side.as_ref().map(|(obstacle_side, normal)| (row, row / count, obstacle_side, *normal))
        })
    }

    /// Distance from the whole obstacle at the end of the step, for each part that faces it.
    fn distances(&self, q: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        (0..self.rollers.len()).filter_map(move |roller| {
            let local = self.shape.at(self.center(roller, q, 2));
            let tilt = self.nearer(roller, local.normal, q);
            let is_there = self.touches(roller, &self.shape, &local, tilt, q);
            is_there.then(|| (roller, local.gap - self.rollers[roller].part.radius * tilt.height))
        })
    }

    /// True if a part faces a side of the obstacle so that it may touch it.
    fn touches(&self, roller: usize, obstacle_side: &S, local: &Local<D>, tilt: Tilt, q: &[f64]) -> bool {
        let is_rim = self.rollers[roller].axis.is_some();
        local.covered && (!is_rim || obstacle_side.takes_rims() && !tilt.is_flat()) && self.facing(roller, q, -local.normal).1
    }

    /// Material point that touches the side `obstacle_side` at mid-step, as coefficients of the masters with positions `z`; and the normal
    /// there.
    pub(super) fn touching<T: Number>(&self, roller: usize, obstacle_side: &S, z: &[[T; D]]) -> ([T; 4], [T; D]) {
        let Roller { masters, part, axis } = &self.rollers[roller];
        let mut center = [T::from(0.0); D];
        for (&(_, share), z) in masters.iter().zip(z) {
            (0..D).for_each(|i| center[i] += z[i] * share);
        }
        let middle = self.moved(1);
        let Local { normal, curvature, .. } = obstacle_side.at(SVector::from_fn(|i, _| center[i].re() - middle[i]));
        let normal: [T; D] =
            std::array::from_fn(|i| (0..D).fold(T::from(normal[i]), |sum, k| sum + (center[k] - center[k].re()) * curvature[(i, k)]));
        // Vector from the center to the contact point, in the basis of the edges between masters.
        let edge = |k: usize| -> [T; D] { std::array::from_fn(|i| z[k][i] - z[0][i]) };
        let mut direction = normal;
        if let Some(shares) = axis {
            // Component perpendicular to the axis of a rim.
            let axis: [T; D] = std::array::from_fn(|i| shares.iter().zip(z).fold(T::from(0.0), |sum, (&share, z)| sum + z[i] * share));
            let dot = |a: &[T; D], b: &[T; D]| a.iter().zip(b).fold(T::from(0.0), |sum, (&a, &b)| sum + a * b);
            let along = dot(&normal, &axis) / dot(&axis, &axis);
            let across: [T; D] = std::array::from_fn(|i| normal[i] - axis[i] * along);
            let length = dot(&across, &across).sqrt().recip();
            direction = across.map(|x| x * length);
        }
        let arm = coordinates(&std::array::from_fn(|k| edge(k + 1)), direction.map(|n| n * -part.radius));
        let mut shares = [T::from(0.0); 4];
        for (k, (share, &(_, of_center))) in shares.iter_mut().zip(masters).enumerate() {
            *share = if k == 0 { arm.iter().fold(T::from(of_center), |sum, &a| sum - a) } else { arm[k - 1] + of_center };
        }
        (shares, normal)
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

fn place<const D: usize>(node: u32, q: &[f64]) -> SVector<f64, D> {
    SVector::from_fn(|i, _| q[D * node as usize + i])
}

/// Coordinates `b` of a vector in the basis `e_k`, `sum_k b_k e_k = r`, by Cramer's rule.
fn coordinates<T: Number, const D: usize>(e: &[[T; D]; D], r: [T; D]) -> [T; D] {
    let with = |k: usize| -> [[T; D]; D] { std::array::from_fn(|j| if j == k { r } else { e[j] }) };
    let inverse = determinant(e).recip();
    std::array::from_fn(|k| determinant(&with(k)) * inverse)
}

fn determinant<T: Number, const D: usize>(m: &[[T; D]; D]) -> T {
    let minor = |i: usize, k: usize| m[1][i] * m[D - 1][k] - m[1][k] * m[D - 1][i];
    match D {
        2 => m[0][0] * m[1][1] - m[0][1] * m[1][0],
        _ => m[0][0] * minor(1, 2) + m[0][1] * minor(2, 0) + m[0][2] * minor(0, 1),
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
        self.shape.sides()
    }

    fn row_nodes(&self) -> &[u32] {
        // Constraints belong to round parts, not to nodes.
        &[]
    }

    fn shown_at(&self, row: usize) -> Option<u32> {
        Some(self.nearest[row / self.shape.sides()])
    }

    fn carriers(&self, row: usize) -> &[u32] {
        self.sides.patches.nodes(row / self.shape.sides())
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        let from = self.moved(0);
        self.start = (0..self.rollers.len()).map(|roller| self.center(roller, q_0, 0) + from).collect();
        for roller in 0..self.rollers.len() {
            let (x, radius, spare) = (self.begins(roller), self.rollers[roller].part.radius, self.sides.facet_size);
            let Local { normal, .. } = self.shape.at(x);
            self.nearest[roller] = self.facing(roller, q_0, -normal).0;
            let near = self.shape.near(x, radius, spare);
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
        let mut gaps = vec![0.0; self.sides.weights.len()];
        for (row, roller, obstacle_side, _) in self.present_constraints() {
            let nearer = self.rollers[roller].part.radius * self.at_start[row].height;
            gaps[row] = self.sides.weights[row] * (obstacle_side.at(self.begins(roller)).gap - nearer);
        }
        gaps
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        let patches = &self.sides.patches;
        out.prepare(patches, self.sides.weights.len());
        (0..patches.len()).for_each(|p| out.clear_patch(patches, p));
        for (row, p, obstacle_side, normal) in self.present_constraints() {
            let (weight, Roller { masters, part, axis }) = (self.sides.weights[row], &self.rollers[p]);
            let end = obstacle_side.at(self.center(p, q_1, 2));
            let (bar, tangent) = self.step_gradient(obstacle_side, derivative, p, q_1);
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
        let mut gaps = vec![0.0; self.sides.weights.len()];
        // The first constraint of a part represents the whole obstacle.
        for (roller, gap) in self.distances(q) {
            let row = self.rows_of(roller).start;
            gaps[row] = self.sides.weights[row] * gap;
        }
        gaps
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        let mut coverage = vec![0.0; self.sides.weights.len()];
        self.distances(q).for_each(|(roller, _)| coverage[self.rows_of(roller).start] = 1.0);
        coverage
    }
}

/// Evaluation of the tangential slips, implemented separately for plane and space.
pub(super) trait Slips {
    /// Writes the slips of a step to `out`, as [`PatchFunctions::evaluate_slips`].
    fn slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation);
}

impl<const D: usize, S: ObstacleSide<D>> CandidateSearch for RollingContact<D, S>
where
    Self: Slips,
{
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
            let (changes, is_crossed) = self.shape.passage(x_0, x_1, near);
            direction_change = direction_change.max(changes / near);
            if is_crossed {
                crossing = crossing.max((x_1 - x_0).norm());
            }
        }
        let crossing = crossing / self.sides.facet_size;
        [direction_change, if crossing > CROSSING { crossing } else { 0.0 }]
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let way = self.moved(2) - self.moved(0);
        let mut work = 0.0;
        for (row, roller, obstacle_side, normal) in self.present_constraints().filter(|&(row, ..)| before[row] != 0.0 || lambda[row] != 0.0)
        {
            let (weight, Roller { masters, part, axis }) = (self.sides.weights[row], &self.rollers[roller]);
            let of_step = self.step_gradient(obstacle_side, derivative, roller, q_1).0 * lambda[row];
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
