//! A torsional spring in the plane between the directions of two bodies, or of a body and the ground.
//!
//! The direction of a body leads from one of its nodes to another, at the angle `phi`. The spring stores `V(x)` of the angle
//! `x = phi_b - phi_a` relative to that in the undeformed bodies, counted over whole turns: the history variable is the angle at the end of
//! the previous step. `x` is invariant under rigid motions: the forces are the projected discrete gradient of
//! [`Projection`](crate::integrators::Projection), which conserves linear and angular momentum. With the ground as one end only energy is
//! conserved, and the correction is along the increment (Gonzalez 1996).

use std::f64::consts::TAU;
use std::sync::Arc;

use super::force_laws::SpringLaw;
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, PartPlace, PartStepResult, Pose, Refusal, Sums};
use crate::dynamics::model::quantity::Quantity;
use crate::dynamics::model::step_error::StepError;
use crate::integrators::{Derivative, PatchFunction, Projection};
use crate::linear::{Block, Pattern};
use crate::math::tolerances::PROJECTED_INCREMENT;

/// A torsional spring.
#[derive(Clone, Debug, PartialEq)]
pub struct TorsionDefinition {
    /// Name, unique among the parts.
    pub name: String,
    /// Directions, each given by a body and two of its nodes; a single one acts against the ground.
    pub directions: Vec<(usize, [u32; 2])>,
    /// Moment as a function of the angle in radians `[force * length]` (per thickness).
    pub law: SpringLaw,
}

impl PartDefinition for TorsionDefinition {
    fn name(&self) -> &str {
        &self.name
    }

    fn bodies(&self) -> Vec<usize> {
        let mut bodies: Vec<usize> = self.directions.iter().map(|(body, _)| *body).collect();
        bodies.dedup();
        bodies
    }

    fn is_grounded(&self) -> bool {
        self.directions.len() == 1
    }

    fn readings(&self) -> &'static [Quantity] {
        const READINGS: &[Quantity] =
            &[Quantity::new("angle", "rad"), Quantity::new("moment", "force * length"), Quantity::new("energy", "energy")];
        READINGS
    }

    fn check(&self, point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        let has_none = |(body, [a, b]): &(usize, [u32; 2])| point(*body, *a) == point(*body, *b);
        match self.directions.iter().any(has_none) {
            true => Err(ModelError::SpringOfNoLength { spring: self.name.clone() }),
            false => Ok(()),
        }
    }

    fn places(&self) -> Vec<PartPlace> {
        self.directions.iter().map(|&(body, [first, _])| PartPlace::Nodes(body, vec![(first, 1.0)])).take(1).collect()
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        let node = |body: usize, node: u32| numbering.first[body] as u32 + node;
        let nodes = self.directions.iter().flat_map(|&(body, [a, b])| [node(body, a), node(body, b)]).collect();
        let (law, is_outside) = (self.law.clone(), self.is_grounded());
        let mut torsion = Torsion { nodes, law, is_outside, rest: 0.0, places: Vec::new() };
        torsion.rest = torsion.raw(&torsion.own(numbering.reference));
        Box::new(torsion)
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let moment = change.energy();
        Arc::new(TorsionDefinition { law: self.law.changed([1.0, moment, moment]), ..self.clone() })
    }

    fn describe(&self) -> String {
        format!("torsional spring \"{}\": {}", self.name, self.law.describe())
    }
}

/// A torsional spring in global node numbers.
struct Torsion {
    /// Two nodes of each direction.
    nodes: Vec<u32>,
    law: SpringLaw,
    is_outside: bool,
    /// Angle in the undeformed bodies.
    rest: f64,
    places: Vec<Block>,
}

/// Gradient and Hessian (row by row) of the angle with respect to the nodes.
struct Angle {
    gradient: Vec<f64>,
    hessian: Vec<f64>,
}

impl Torsion {
    fn own(&self, q: &[f64]) -> Vec<f64> {
        self.nodes.iter().flat_map(|&node| [q[2 * node as usize], q[2 * node as usize + 1]]).collect()
    }

    /// For each direction the start index of its coordinates, and the sign of its angle: negative for the first of two, else positive.
    fn signs(&self) -> impl Iterator<Item = (usize, f64)> {
        let both = self.nodes.len() == 4;
        (0..self.nodes.len() / 2).map(move |k| (4 * k, if both && k == 0 { -1.0 } else { 1.0 }))
    }

    /// Angle between the directions, up to whole turns.
    fn raw(&self, x: &[f64]) -> f64 {
        self.signs().map(|(k, sign)| sign * (x[k + 3] - x[k + 1]).atan2(x[k + 2] - x[k])).sum()
    }

    /// Angle in the turn nearest to the angle `before`.
    fn angle(&self, x: &[f64], before: f64) -> f64 {
        let angle = self.raw(x) - self.rest;
        angle + TAU * ((before - angle) / TAU).round()
    }

    /// Change of the angle between two configurations, accurate relative to its own size; each direction turns by less than half a turn.
    fn turned(&self, x_0: &[f64], x_1: &[f64]) -> f64 {
        let turn = |(k, sign): (usize, f64)| {
            let ([ax, ay], [bx, by]) = ([0, 1].map(|i| x_0[k + 2 + i] - x_0[k + i]), [0, 1].map(|i| x_1[k + 2 + i] - x_1[k + i]));
            sign * (ax * (by - ay) - ay * (bx - ax)).atan2(ax * bx + ay * by)
        };
        self.signs().map(turn).sum()
    }

    fn derivatives(&self, x: &[f64]) -> Angle {
        let count = x.len();
        let mut angle = Angle { gradient: vec![0.0; count], hessian: vec![0.0; count * count] };
        for (k, sign) in self.signs() {
            let (dx, dy) = (x[k + 2] - x[k], x[k + 3] - x[k + 1]);
            let square = dx * dx + dy * dy;
            let (slope, twice) = ([-dy / square, dx / square], square * square);
            let bend = [[2.0 * dx * dy / twice, (dy * dy - dx * dx) / twice], [(dy * dy - dx * dx) / twice, -2.0 * dx * dy / twice]];
            for (a, of_a) in [(k, -sign), (k + 2, sign)] {
                for i in 0..2 {
                    angle.gradient[a + i] += of_a * slope[i];
                    for (b, of_b) in [(k, -1.0), (k + 2, 1.0)] {
                        (0..2).for_each(|j| angle.hessian[(a + i) * count + b + j] += of_a * of_b * bend[i][j]);
                    }
                }
            }
        }
        angle
    }

    /// Gradient of `V` and its derivative at an angle.
    fn potential(&self, x: &[f64], at: f64) -> (Vec<f64>, Vec<f64>) {
        let ((moment, slope), Angle { gradient, mut hessian }) = (self.law.force(at), self.derivatives(x));
        let count = x.len();
        for (k, h) in hessian.iter_mut().enumerate() {
            *h = moment * *h + slope * gradient[k / count] * gradient[k % count];
        }
        (gradient.iter().map(|g| moment * g).collect(), hessian)
    }

    /// Forces of a step, and their derivative with respect to its end positions.
    fn forces(&self, at: &Iterate, before: f64) -> (Vec<f64>, Vec<f64>) {
        let (x_0, x_1) = (self.own(at.q_0), self.own(at.q_1));
        let middle: Vec<f64> = x_0.iter().zip(&x_1).map(|(a, b)| 0.5 * (a + b)).collect();
        let start = self.angle(&x_0, before);
        let turned = self.turned(&x_0, &x_1);
        let (half, end) = (start + self.turned(&x_0, &middle), start + turned);
        let count = x_1.len();
        match at.derivative {
            Derivative::DiscreteGradient => {
                let (gradient_mid, hessian_mid) = self.potential(&middle, half);
                let gradient_end = self.potential(&x_1, end).0;
                let change = self.law.mean(start, end).0 * turned;
                let (mut force, mut slope) = (vec![0.0; count], vec![0.0; count * count]);
                let function =
                    PatchFunction { gradient_mid: &gradient_mid, gradient_end: &gradient_end, hessian_mid: &hessian_mid, change };
                if self.is_outside {
                    along_increment(&x_0, &x_1, &function, &mut force, &mut slope);
                } else {
                    let mut projection = Projection::<2>::default();
                    projection.set(&x_0, &x_1);
                    projection.gradient_into(&gradient_mid, change, &mut force);
                    projection.tangent_into(1.0, &function, &mut slope);
                }
                (force, slope)
            }
            Derivative::Gradient(configuration) => {
                let share = configuration.share();
                let (x, angle) = if share == 1.0 { (&x_1, end) } else { (&middle, half) };
                let (force, slope) = self.potential(x, angle);
                (force, slope.iter().map(|slope| share * slope).collect())
            }
        }
    }
}

/// Discrete gradient of a function with a correction along the increment, and its derivative.
fn along_increment(x_0: &[f64], x_1: &[f64], function: &PatchFunction, force: &mut [f64], slope: &mut [f64]) {
    let PatchFunction { gradient_mid, gradient_end, hessian_mid, change } = *function;
    let (count, moved): (usize, Vec<f64>) = (x_1.len(), x_0.iter().zip(x_1).map(|(a, b)| b - a).collect());
    let along = |g: &[f64]| g.iter().zip(&moved).map(|(g, d)| g * d).sum::<f64>();
    let (square, size) = (along(&moved), (x_1[2] - x_1[0]).powi(2) + (x_1[3] - x_1[1]).powi(2));
    let is_round_off = square <= PROJECTED_INCREMENT * PROJECTED_INCREMENT * size;
    let e = if is_round_off { 0.0 } else { (change - along(gradient_mid)) / square };
    (0..count).for_each(|k| force[k] = gradient_mid[k] + e * moved[k]);
    for (k, slope) in slope.iter_mut().enumerate() {
        let (row, column) = (k / count, k % count);
        *slope = 0.5 * hessian_mid[k] + if row == column { e } else { 0.0 };
        if !is_round_off {
            let bend = along(&hessian_mid[column * count..(column + 1) * count]);
            let de = gradient_end[column] - gradient_mid[column] - 0.5 * bend - 2.0 * e * moved[column];
            *slope += moved[row] * de / square;
        }
    }
}

impl Part for Torsion {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&self.nodes);
    }

    fn place(&mut self, pattern: &Pattern) {
        let nodes = &self.nodes;
        self.places = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| pattern.block(a, b))).collect();
    }

    fn linearize(&self, at: &Iterate, memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let (force, slope) = self.forces(at, memory[0]);
        for (&node, force) in self.nodes.iter().zip(force.chunks_exact(2)) {
            (0..2).for_each(|i| sums.internal[2 * node as usize + i] += at.weight * force[i]);
        }
        let Some(values) = sums.tangent.as_deref_mut() else { return Ok(()) };
        let count = self.nodes.len();
        for (k, block) in self.places.iter().enumerate() {
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                values[block.at(i, j)] += at.weight * slope[(2 * (k / count) + i) * 2 * count + 2 * (k % count) + j];
            }
        }
        Ok(())
    }

    fn energy(&self, at: Pose, memory: &[f64]) -> f64 {
        self.law.energy(self.angle(&self.own(at.q), memory[0]))
    }

    fn is_outside(&self) -> bool {
        self.is_outside
    }

    fn readings(&self, at: Pose, _velocity: &[f64], memory: &[f64]) -> Vec<f64> {
        let angle = self.angle(&self.own(at.q), memory[0]);
        vec![angle, self.law.force(angle).0, self.law.energy(angle)]
    }

    fn memory(&self) -> Vec<f64> {
        vec![0.0]
    }

    fn after_step(&self, at: &Iterate, memory: &[f64]) -> Result<PartStepResult, StepError> {
        let (x_0, x_1) = (self.own(at.q_0), self.own(at.q_1));
        let end = self.angle(&x_0, memory[0]) + self.turned(&x_0, &x_1);
        Ok(PartStepResult { memory: vec![self.angle(&x_1, end)], ..PartStepResult::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::parts::force_laws::{Elastic, Sides};

    #[test]
    fn its_moments_do_the_work_of_the_potential_over_whole_turns() {
        let table = Elastic::Table(Arc::new(vec![(-1.0, -2.0), (0.0, 0.0), (7.0, 10.0)]));
        for (bodies, turn) in [(2, 0.4f64), (1, 0.4), (2, 1e-3), (1, 2.0)] {
            let law = SpringLaw { elastic: table.clone(), sides: Sides::Both };
            let directions = (0..bodies).map(|body| (body, [0, 1])).collect();
            let definition = TorsionDefinition { name: "t".into(), directions, law };
            let q_0 = [0.0, 0.1, 1.0, 0.3, 1.0, 1.0, 0.2, 1.4];
            let first = [0, 2];
            let numbering = Numbering { dimension: 2, first: &first, reference: &q_0[..4 * bodies] };
            let mut torsion = {
                let nodes = (0..2 * bodies as u32).collect();
                let mut torsion = Torsion { nodes, law: definition.law.clone(), is_outside: bodies == 1, rest: 0.0, places: Vec::new() };
                torsion.rest = torsion.raw(numbering.reference) - 6.2;
                torsion
            };
            torsion.nodes.truncate(2 * bodies);
            let q_0 = &q_0[..4 * bodies];
            // The last direction rotates about its first node.
            let mut q_1 = q_0.to_vec();
            let k = 4 * (bodies - 1);
            let (dx, dy) = (q_0[k + 2] - q_0[k], q_0[k + 3] - q_0[k + 1]);
            q_1[k + 2] = q_0[k] + dx * turn.cos() - dy * turn.sin();
            q_1[k + 3] = q_0[k + 1] + dx * turn.sin() + dy * turn.cos();
            q_1[0] += 0.01;
            let forces = |q_1: &[f64]| {
                let at = Iterate::between(Derivative::DiscreteGradient, q_0, q_1);
                (torsion.forces(&at, 6.2), torsion.after_step(&at, &[6.2]).unwrap().memory)
            };
            let ((force, slope), memory) = forces(&q_1);
            let work: f64 = force.iter().zip(q_1.iter().zip(q_0)).map(|(f, (b, a))| f * (b - a)).sum();
            let energy = |q: &[f64], memory: f64| torsion.energy(Pose { q, u: q }, &[memory]);
            assert!((work - energy(&q_1, memory[0]) + energy(q_0, 6.2)).abs() < 1e-14, "{bodies} {turn}");
            assert!((memory[0] - 6.2 - turn).abs() < 0.02, "{memory:?}");
            let count = q_0.len();
            for column in 0..count {
                let moved = |h: f64| {
                    let mut q = q_1.clone();
                    q[column] += h;
                    forces(&q).0.0
                };
                let (up, down) = (moved(1e-6), moved(-1e-6));
                for row in 0..count {
                    let difference = (up[row] - down[row]) / 2e-6;
                    assert!((difference - slope[row * count + column]).abs() < 1e-5, "{bodies} {turn} [{row}][{column}] {difference}");
                }
            }
        }
    }
}
