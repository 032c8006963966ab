//! Gear constraint: the coordinates `s_1`, `s_2` of two joints, angles or displacements, change in a fixed ratio.
//!
//! ```text
//! Phi = a_1 s_1 + a_2 s_2        [length]
//! ```
//!
//! An angle `s` is the polar angle of `z = (x, y)`, its cosine and sine, both products of directions; whole turns are counted. In a step
//! from `z_0` to `z_1` the angle increment is `d = atan2(c, z_0.z_1)`, `c = x_0 y_1 - y_0 x_1`, and with the mean `(x, y)` of `z_0` and
//! `z_1`
//!
//! ```text
//! (d / c) (-y, x) . (z_1 - z_0) = d
//! ```
//!
//! so `d / c (-y, x)` is the discrete gradient with respect to `z`. The discrete gradients of `z` are those of [`PointConstraints`]:
//! products of directions are invariant under rigid motions of both ends, so that energy and momenta are conserved to round-off (O.
//! Gonzalez, *Time integration and discrete Hamiltonian systems*, J. Nonlinear Science 6, 1996).

use std::f64::consts::TAU;
use std::sync::{Mutex, PoisonError};

use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use super::patches::Evaluation;
use super::points::PointConstraints;
use super::surface::{Sides, Surface};
use super::window::PredictedMotion;
use crate::integrators::Derivative;

/// Tangent of the angle increment of a step below which its functions are summed as series of seven terms, accurate to round-off.
const SMALL_TURN: f64 = 0.05;

/// Kind of a joint coordinate, which follows from functions that are quadratic in points and directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoordinateKind {
    /// Angle with two functions, cosine and sine.
    Angle,
    /// Displacement, given by one function: the displacement itself.
    Travel,
    /// Distance, given by one function: the squared distance.
    Distance,
}

/// Joint coordinate that takes part in a gear.
#[derive(Clone, Debug)]
struct Term {
    kind: CoordinateKind,
    /// Index of the first function.
    first: usize,
    /// Coefficient `a_i`: a length for an angle, a pure number for a displacement.
    factor: f64,
    /// Whole turns at the start of the step.
    turns: f64,
    /// Angle beyond the whole turns at the start of the step `[rad]`.
    rest: f64,
}

impl Term {
    fn is_angle(&self) -> bool {
        self.kind == CoordinateKind::Angle
    }

    fn rows(&self) -> std::ops::Range<usize> {
        self.first..self.first + if self.is_angle() { 2 } else { 1 }
    }
}

/// Signed angle from `z_0` to `z_1`, between -pi and pi.
fn turned(z_0: [f64; 2], z_1: [f64; 2]) -> f64 {
    (z_0[0] * z_1[1] - z_0[1] * z_1[0]).atan2(z_0[0] * z_1[0] + z_0[1] * z_1[1])
}

/// `atan2(c, d) / c` and its derivatives with respect to `c` and `d`, by series for small angles.
fn arctangent_over(c: f64, d: f64) -> (f64, [f64; 2]) {
    let by_d = -1.0 / (c * c + d * d);
    if d <= 0.0 || c.abs() > SMALL_TURN * d {
        let by = c.atan2(d) / c;
        return (by, [(-d * by_d - by) / c, by_d]);
    }
    let square = (c / d) * (c / d);
    let series = |of: fn(f64) -> f64| (0..7).rev().fold(0.0, |sum, k| of(f64::from(k)) - square * sum);
    // Series of `atan(t) / t = 1 - t^2/3 + t^4/5 - ...`, and of its derivative.
    let by = series(|k| 1.0 / (2.0 * k + 1.0)) / d;
    let by_c = -(c / d) / (d * d) * series(|k| 2.0 * (k + 1.0) / (2.0 * k + 3.0));
    (by, [by_c, by_d])
}

/// Discrete gradient of an angle from `z_0` to `z_1`, and its derivative with respect to `z_1`.
fn gradient_between(z_0: [f64; 2], z_1: [f64; 2]) -> ([f64; 2], [[f64; 2]; 2]) {
    let (c, d) = (z_0[0] * z_1[1] - z_0[1] * z_1[0], z_0[0] * z_1[0] + z_0[1] * z_1[1]);
    let (by, [by_c, by_d]) = arctangent_over(c, d);
    let across = [-0.5 * (z_0[1] + z_1[1]), 0.5 * (z_0[0] + z_1[0])];
    let bend = [[0.0, -0.5], [0.5, 0.0]];
    let slope = [by_d * z_0[0] - by_c * z_0[1], by_d * z_0[1] + by_c * z_0[0]];
    (across.map(|x| by * x), std::array::from_fn(|k| std::array::from_fn(|l| across[k] * slope[l] + by * bend[k][l])))
}

/// Gradient of an angle at `z`, and the derivative of the gradient.
fn gradient_at([x, y]: [f64; 2]) -> ([f64; 2], [[f64; 2]; 2]) {
    let square = x * x + y * y;
    let (mixed, other) = (2.0 * x * y / (square * square), (y * y - x * x) / (square * square));
    ([-y / square, x / square], [[mixed, other], [other, -mixed]])
}

/// Constraint between two joint coordinates.
pub struct Geared {
    /// Functions of the joint coordinates: cosines and sines of angles, displacements, squared distances.
    inner: PointConstraints,
    sides: Sides,
    terms: Vec<Term>,
    /// Values of the inner functions at the start of the step.
    z_0: Vec<f64>,
    scratch: Mutex<Evaluation>,
}

impl Geared {
    /// Gear between coordinates that are functions of one group of `inner`, given by their kinds and coefficients. `size` is the size of
    /// the joined parts `[length]`.
    pub fn new(inner: PointConstraints, dimension: usize, coordinates: Vec<(CoordinateKind, f64)>, size: f64) -> Self {
        let mut terms: Vec<Term> = Vec::new();
        for (kind, factor) in coordinates {
            let first = terms.last().map_or(0, |term| term.rows().end);
            terms.push(Term { kind, first, factor, turns: 0.0, rest: 0.0 });
        }
        let surface = || if dimension == 2 { Surface::new(&[]) } else { Surface::in_space(std::iter::empty()) };
        let mut sides = Sides::of(surface(), surface(), &[]);
        (sides.facet_size, sides.weights) = (size, vec![1.0]);
        Geared { inner, sides, terms, z_0: Vec::new(), scratch: Mutex::default() }
    }

    /// Constraint function for the values `z`.
    fn value(&self, z: &[f64]) -> f64 {
        let rest = |term: &Term| match (term.kind, self.z_0.is_empty()) {
            (CoordinateKind::Travel, _) => z[term.first],
            (CoordinateKind::Distance, _) => z[term.first].sqrt(),
            (CoordinateKind::Angle, true) => z[term.first + 1].atan2(z[term.first]),
            (CoordinateKind::Angle, false) => term.rest + turned(pair(&self.z_0, term), pair(z, term)),
        };
        let sum = |of: &dyn Fn(&Term) -> f64| self.terms.iter().map(|term| term.factor * of(term)).sum::<f64>();
        // Whole turns are summed separately, so that the remaining angle keeps its digits.
        sum(&rest) + TAU * sum(&|term| term.turns)
    }

    /// Change of the constraint function from `q_0` to `q_1`, without whole turns, accurate relative to the change of the coordinates.
    pub fn change(&self, q_0: &[f64], q_1: &[f64]) -> f64 {
        let [z_0, z_1] = [q_0, q_1].map(|q| self.inner.gap(q));
        let of = |term: &Term| match (term.kind, z_0[term.first], z_1[term.first]) {
            (CoordinateKind::Angle, ..) => turned(pair(&z_0, term), pair(&z_1, term)),
            (CoordinateKind::Travel, before, after) => after - before,
            (CoordinateKind::Distance, before, after) => (after - before) / (after.sqrt() + before.sqrt()),
        };
        self.terms.iter().map(|term| term.factor * of(term)).sum()
    }

    /// Weight of each function in the gradient of a step that ends at `z`, and derivatives of the weight.
    fn weights(&self, is_mean: bool, z: &[f64]) -> Vec<(f64, [f64; 2])> {
        let of = |term: &Term| -> Vec<(f64, [f64; 2])> {
            if term.kind == CoordinateKind::Travel {
                return vec![(term.factor, [0.0; 2])];
            }
            if term.kind == CoordinateKind::Distance {
                // Discrete gradient of the distance `s` with respect to `s^2`: `(s_1 - s_0)/(s_1^2 - s_0^2)`; at one configuration `1/(2
                // s)`.
                let after = z[term.first].sqrt();
                let by = 1.0 / (after + if is_mean { self.z_0[term.first].sqrt() } else { after });
                let slope = if is_mean { -0.5 * by * by / after } else { -by * by / after };
                return vec![(term.factor * by, [term.factor * slope, 0.0])];
            }
            let (w, slope) = if is_mean { gradient_between(pair(&self.z_0, term), pair(z, term)) } else { gradient_at(pair(z, term)) };
            w.into_iter().zip(slope).map(|(w, slope)| (term.factor * w, slope.map(|s| term.factor * s))).collect()
        };
        self.terms.iter().flat_map(of).collect()
    }

    /// True for a discrete gradient, which depends on the values at the start of the step.
    fn is_mean(&self, derivative: Derivative) -> bool {
        derivative.placement().share < 1.0 && !self.z_0.is_empty()
    }
}

/// Cosine and sine of the angle of a term.
fn pair(z: &[f64], term: &Term) -> [f64; 2] {
    [z[term.first], z[term.first + 1]]
}

impl PatchFunctions for Geared {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn row_nodes(&self) -> &[u32] {
        &[]
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.inner.begin_step(q_0);
        let z_0 = self.inner.start_gap();
        for term in self.terms.iter_mut().filter(|term| term.is_angle()) {
            let [x, y] = pair(&z_0, term);
            let (rest, before) = (y.atan2(x), term.rest);
            (term.turns, term.rest) = (term.turns + ((before - rest) / TAU).round(), rest);
        }
        self.z_0 = z_0;
    }

    fn start_gap(&self) -> Vec<f64> {
        if self.z_0.is_empty() { vec![0.0] } else { vec![self.value(&self.z_0)] }
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        let (patches, z) = (&self.sides.patches, self.inner.gap(q_1));
        out.prepare(patches, 1);
        out.coverage.fill(1.0);
        out.gap[0] = self.value(&z);
        if patches.is_empty() {
            return;
        }
        out.clear_patch(patches, 0);
        out.live[0] = true;
        let (tested, at_end) = (self.weights(self.is_mean(derivative), &z), self.weights(false, &z));
        let mut inner = self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        let pressures: Vec<f64> = tested.iter().map(|(w, _)| w * lambda[0]).collect();
        self.inner.evaluate(derivative, q_1, &pressures, &mut inner);
        out.tangent.copy_from_slice(&inner.tangent);
        let count = patches.unknowns(0);
        let block = |row: usize| row * count..(row + 1) * count;
        for (row, ((by, _), (by_end, _))) in tested.iter().zip(&at_end).enumerate() {
            for (k, entry) in block(row).enumerate() {
                out.gradient_bar[k] += by * inner.gradient_bar[entry];
                out.gradient_end[k] += by_end * inner.gradient_end[entry];
            }
        }
        for term in self.terms.iter().filter(|term| term.kind != CoordinateKind::Travel) {
            for row in term.rows() {
                for (l, slope) in term.rows().zip(tested[row].1) {
                    for (i, force) in inner.gradient_bar[block(row)].iter().enumerate() {
                        let of_row = &mut out.tangent[i * count..(i + 1) * count];
                        of_row.iter_mut().zip(&inner.gradient_end[block(l)]).for_each(|(to, g)| *to += lambda[0] * slope * force * g);
                    }
                }
            }
        }
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        vec![self.value(&self.inner.gap(q))]
    }
}

impl CandidateSearch for Geared {
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        let is_first = self.inner.update_candidates(predicted_motion);
        if is_first {
            self.sides.patches.push(self.inner.patches().nodes(0), &[0]);
        }
        is_first
    }
}

impl RigidObstacle for Geared {
    fn count_from(&mut self, coordinates: [f64; 2]) {
        for (term, value) in self.terms.iter_mut().zip(coordinates) {
            if term.is_angle() {
                term.turns = (value / TAU).round();
                term.rest = value - TAU * term.turns;
            }
        }
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let weights = self.weights(self.is_mean(derivative), &self.inner.gap(q_1));
        let by = |multiplier: f64| weights.iter().map(|(w, _)| w * multiplier).collect::<Vec<f64>>();
        self.inner.obstacle_force_into(derivative, q_1, &by(before[0]), &by(lambda[0]), force)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{PointFunction, PointVector};

    /// Gear between an angle and a displacement of three points in the plane.
    fn gear() -> Geared {
        let vector = |parts: &[(u32, f64)], offset: [f64; 3]| PointVector { parts: parts.to_vec(), offset };
        let vectors = vec![
            vector(&[(0, 1.0), (1, -1.0)], [0.0; 3]),
            vector(&[(2, 1.0), (1, -1.0)], [0.0; 3]),
            vector(&[], [0.3, 1.0, 0.0]),
            vector(&[(3, 1.0)], [0.0; 3]),
        ];
        let product = |a: usize, b: usize| PointFunction { products: vec![(a, b, 1.0)], ..PointFunction::default() };
        let mut inner = PointConstraints::new(2, 1.0);
        inner.add(vectors, vec![product(0, 1), product(0, 2), product(3, 2)], None, true);
        Geared::new(inner, 2, vec![(CoordinateKind::Angle, 0.7), (CoordinateKind::Travel, -1.3)], 1.0)
    }

    #[test]
    fn its_gradient_is_discrete_and_its_tangent_a_derivative() {
        for far in [1.0, 1e-2, 1e-9] {
            let mut kernel = gear();
            let q_0: Vec<f64> = (0..8).map(|k| (1.7 * f64::from(k)).sin()).collect();
            let q_1: Vec<f64> = q_0.iter().zip(0..).map(|(q, k)| q + far * (1.9 * f64::from(k)).cos()).collect();
            kernel.update_candidates(&PredictedMotion::within(&q_0, 0.0));
            kernel.count_from([40.0, 0.0]);
            kernel.begin_step(&q_0);
            let evaluated = |derivative, q: &[f64]| {
                let mut out = Evaluation::default();
                kernel.evaluate(derivative, q, &[0.8], &mut out);
                out
            };
            let at = evaluated(Derivative::DiscreteGradient, &q_1);
            let work: f64 = at.gradient_bar.iter().zip(q_1.iter().zip(&q_0)).map(|(g, (a, b))| g * (a - b)).sum();
            assert!((work - (at.gap[0] - kernel.start_gap()[0])).abs() < 1e-13, "{far}");
            for derivative in Derivative::ALL {
                let at = evaluated(derivative, &q_1);
                for k in 0..8 {
                    let [up, down] = [1e-6, -1e-6].map(|step| {
                        let mut q = q_1.clone();
                        q[k] += step;
                        evaluated(derivative, &q)
                    });
                    assert!(((up.gap[0] - down.gap[0]) / 2e-6 - at.gradient_end[k]).abs() < 1e-7, "{far}");
                    for i in 0..8 {
                        let slope = 0.8 * (up.gradient_bar[i] - down.gradient_bar[i]) / 2e-6;
                        assert!((slope - at.tangent[8 * i + k]).abs() < 1e-6, "{far} {derivative:?} {slope} {}", at.tangent[8 * i + k]);
                    }
                }
            }
        }
    }

    #[test]
    fn it_counts_whole_turns() {
        let mut kernel = gear();
        let q: Vec<f64> = (0..8).map(|k| (1.7 * f64::from(k)).sin()).collect();
        kernel.update_candidates(&PredictedMotion::within(&q, 0.0));
        kernel.begin_step(&q);
        let once = kernel.start_gap()[0];
        kernel.count_from([1000.0 * TAU, 0.0]);
        kernel.begin_step(&q);
        assert!((kernel.start_gap()[0] - once - 0.7 * 1000.0 * TAU).abs() < 1e-11);
    }
}
