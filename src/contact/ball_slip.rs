//! Slip of a ball joint: the rotation of one end relative to the other in a step, as three tangential constraints.
//!
//! With the directions `a_i` of the first end, and those `b_j` of the second end that coincide with them at the start of the step, the
//! products `D_ij = a_i . b_j` are the rotation of the step, and
//!
//! ```text
//! u = 2 h tan(theta/2) n = f w,    w_k = h/2 e_kij D_ji,    f = 4 / (1 + tr D)        [length]
//! ```
//!
//! with the rotation angle `theta`, its axis `n` in the directions of the first end, and the length `h` that converts angles. `w` and
//! `tr D` are quadratic in directions, so that the forces `tau f grad w(q_mid)` do the work `tau . u`, and are invariant: they have no
//! resultant and no moment between two bodies. About a fixed axis their moment is `h tau`. The rotation is that of the midpoint rule
//! (Cayley), by which the angular momentum changes by moment times step size.

use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use super::patches::{Evaluation, Patches};
use super::points::{PointConstraints, PointFunction, PointVector};
use super::slip::SlipStep;
use super::surface::{Sides, Surface};
use super::window::{MotionBound, PredictedMotion};
use crate::integrators::{Configuration, Derivative};

/// Least value of `1 + tr D`: beyond a rotation of 151 degrees in a step the factor `f` is constant.
const LEAST_TRACE: f64 = 0.25;

/// Tangential constraints of the rotation of a ball joint.
pub struct BallSlip {
    /// Directions of both ends, which coincide with the coordinate axes in the reference positions.
    vectors: Vec<PointVector>,
    size: f64,
    sides: Sides,
    slips: Patches,
}

/// Empty predicted motion, for contact elements that are always present and need no search.
const NOWHERE: PredictedMotion = PredictedMotion { q: &[], motion_bound: MotionBound::UpTo(0.0), reach: 0.0, depth: 0.0 };

/// Products `a_i . b_j`.
type Rotation = [[f64; 3]; 3];

impl BallSlip {
    /// Slip of a ball joint between ends with the directions `first` and `second`; `size` is the length that converts angles.
    pub fn new(first: [PointVector; 3], second: [PointVector; 3], size: f64) -> Self {
        let surface = || Surface::in_space(std::iter::empty());
        let mut sides = Sides::of(surface(), surface(), &[]);
        (sides.facet_size, sides.weights) = (size, vec![1.0]);
        BallSlip { vectors: first.into_iter().chain(second).collect(), size, sides, slips: Patches::new(3) }
    }

    fn rotation(&self, q: &[f64]) -> Rotation {
        let y: Vec<[f64; 3]> = self.vectors.iter().map(|vector| vector.at(3, q)).collect();
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        std::array::from_fn(|i| std::array::from_fn(|j| dot(y[i], y[3 + j])))
    }

    /// Functions `w` and `tr D` relative to the rotation `start`.
    fn functions(&self, start: &Rotation) -> PointConstraints {
        // D_ij = sum_k start_jk a_i . beta_k with the directions beta of the second end.
        let entry = |i: usize, j: usize, by: f64| (0..3).map(move |k| (i, 3 + k, by * start[j][k]));
        let turn = |k: usize| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            entry(j, i, 0.5 * self.size).chain(entry(i, j, -0.5 * self.size)).collect()
        };
        let trace = (0..3).flat_map(|i| entry(i, i, 1.0)).collect();
        let functions = [turn(0), turn(1), turn(2), trace];
        let functions = functions.map(|products| PointFunction { products, ..PointFunction::default() });
        let mut inner = PointConstraints::new(3, self.size);
        inner.add(self.vectors.clone(), functions.into(), None, false);
        inner.update_candidates(&NOWHERE);
        inner
    }
}

impl PatchFunctions for BallSlip {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn row_nodes(&self) -> &[u32] {
        &[]
    }

    fn slip_patches(&self) -> &Patches {
        &self.slips
    }

    fn begin_step(&mut self, _q_0: &[f64]) {}

    fn start_gap(&self) -> Vec<f64> {
        vec![0.0]
    }

    fn evaluate(&self, _derivative: Derivative, _q_1: &[f64], _lambda: &[f64], out: &mut Evaluation) {
        out.prepare_without_force(self.patches());
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        out.prepare(&self.slips, 3);
        out.coverage.fill(1.0);
        if self.slips.is_empty() {
            return;
        }
        let (derivative, is_mean) = match step.test {
            Configuration::Middle => (Derivative::DiscreteGradient, true),
            at => (Derivative::Gradient(at), Derivative::Gradient(at).placement().share < 1.0),
        };
        let start = self.rotation(step.q_0);
        let (mut moved, mut acting) = (Evaluation::default(), Evaluation::default());
        let functions = self.functions(&start);
        let values = functions.gap(step.q_1);
        let (trace, is_bounded) = ((1.0 + values[3]).max(LEAST_TRACE), 1.0 + values[3] < LEAST_TRACE);
        let factor = 4.0 / trace;
        let slope = if is_bounded { 0.0 } else { -factor / trace };
        let loaded = |by: f64| [by * lambda[0], by * lambda[1], by * lambda[2], 0.0];
        functions.evaluate_from(step.q_0, derivative, step.q_1, &loaded(factor), &mut moved);
        // Forces of the end-point rule use the rotation at the end of the step as reference; the derivative of this reference is omitted.
        let by = if is_mean { factor } else { 1.0 };
        if !is_mean {
            self.functions(&self.rotation(step.q_1)).evaluate_from(step.q_0, derivative, step.q_1, &loaded(1.0), &mut acting);
        }
        let forces = if is_mean { &moved } else { &acting };
        out.clear_patch(&self.slips, 0);
        out.live[0] = true;
        let count = self.slips.unknowns(0);
        let row = |k: usize| k * count..(k + 1) * count;
        for k in 0..3 {
            out.gap[k] = factor * values[k];
            let (ends, traces) = (&moved.gradient_end[row(k)], &moved.gradient_end[row(3)]);
            let of_end = ends.iter().zip(traces).map(|(end, trace)| factor * end + slope * values[k] * trace);
            out.gradient_end[row(k)].iter_mut().zip(of_end).for_each(|(to, value)| *to = value);
            let of_bar = forces.gradient_bar[row(k)].iter().map(|force| by * force);
            out.gradient_bar[row(k)].iter_mut().zip(of_bar).for_each(|(to, value)| *to = value);
        }
        out.tangent.copy_from_slice(&forces.tangent);
        if is_mean {
            for (i, to) in out.tangent.chunks_exact_mut(count).enumerate() {
                let force: f64 = (0..3).map(|k| lambda[k] * moved.gradient_bar[k * count + i]).sum();
                to.iter_mut().zip(&moved.gradient_end[row(3)]).for_each(|(to, trace)| *to += slope * force * trace);
            }
        }
    }

    fn gap(&self, _q: &[f64]) -> Vec<f64> {
        vec![0.0]
    }
}

impl CandidateSearch for BallSlip {
    fn update_candidates(&mut self, _outlook: &PredictedMotion) -> bool {
        let is_first = self.slips.is_empty();
        if is_first {
            let mut nodes: Vec<u32> = self.vectors.iter().flat_map(|vector| vector.parts.iter().map(|(node, _)| *node)).collect();
            nodes.sort_unstable();
            nodes.dedup();
            self.sides.patches.push(&nodes, &[0]);
            self.slips.push(&nodes, &[0, 1, 2]);
        }
        is_first
    }
}

impl RigidObstacle for BallSlip {}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ball joint between the ground and the directions given by the nodes 0, 1, 2.
    fn slip() -> BallSlip {
        let fixed = |k: usize| PointVector { parts: Vec::new(), offset: std::array::from_fn(|i| f64::from(u8::from(i == k))) };
        let node = |k: usize| PointVector { parts: vec![(k as u32, 1.0)], offset: [0.0; 3] };
        let mut slip = BallSlip::new([0, 1, 2].map(fixed), [0, 1, 2].map(node), 2.0);
        slip.update_candidates(&NOWHERE);
        slip
    }

    /// Positions of the nodes after a rotation by `angle` about the unit vector `n`.
    fn turned(n: [f64; 3], angle: f64) -> Vec<f64> {
        let (s, c) = angle.sin_cos();
        let cross = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
        };
        let of = |k: usize| {
            let e: [f64; 3] = std::array::from_fn(|i| f64::from(u8::from(i == k)));
            let (along, side) = (n[k], cross(n, e));
            (0..3).map(move |i| c * e[i] + s * side[i] + (1.0 - c) * along * n[i])
        };
        (0..3).flat_map(of).collect()
    }

    fn evaluated(slip: &BallSlip, q_0: &[f64], q_1: &[f64], lambda: &[f64]) -> Evaluation {
        let moved: Vec<f64> = q_1.iter().zip(q_0).map(|(a, b)| a - b).collect();
        let mut out = Evaluation::default();
        slip.evaluate_slips(
            SlipStep { q_0, q_1, moved: &moved, test: Configuration::Middle, live: &[true], wants_tangent: true },
            lambda,
            &mut out,
        );
        out
    }

    #[test]
    fn slip_is_the_rotation_and_forces_do_its_work() {
        let (slip, n) = (slip(), [0.6, 0.0, 0.8]);
        for angle in [1e-3, 0.1, 1.0] {
            // The slip is relative to the start: two rotations about the same axis.
            let (q_0, q_1) = (turned(n, 0.7), turned(n, 0.7 + angle));
            let out = evaluated(&slip, &q_0, &q_1, &[0.3, -0.2, 0.5]);
            for k in 0..3 {
                assert!((out.gap[k] - 4.0 * (0.5 * angle).tan() * n[k]).abs() < 1e-14, "{angle}: {:?}", out.gap);
                let work: f64 = (0..9).map(|i| out.gradient_bar[9 * k + i] * (q_1[i] - q_0[i])).sum();
                assert!((work - out.gap[k]).abs() < 1e-14);
            }
            // Moment of the forces for the multipliers `lambda = n`, about the axis, with the directions at mid-step as arms.
            let force: Vec<f64> = (0..9).map(|i| (0..3).map(|k| n[k] * out.gradient_bar[9 * k + i]).sum()).collect();
            let at: Vec<f64> = q_0.iter().zip(&q_1).map(|(a, b)| 0.5 * (a + b)).collect();
            let moment =
                |i: usize, j: usize| (0..3).map(|k| at[3 * k + i] * force[3 * k + j] - at[3 * k + j] * force[3 * k + i]).sum::<f64>();
            let along = n[0] * moment(1, 2) + n[1] * moment(2, 0) + n[2] * moment(0, 1);
            assert!((along - 2.0).abs() < 1e-14, "{angle}: {along}");
        }
    }

    #[test]
    fn gradients_and_tangent_are_derivatives() {
        let (slip, lambda, h) = (slip(), [0.3, -0.2, 0.5], 1e-6);
        let (q_0, q_1) = (turned([0.0, 1.0, 0.0], 0.4), turned([0.6, 0.0, 0.8], 0.3));
        let out = evaluated(&slip, &q_0, &q_1, &lambda);
        for j in 0..9 {
            let at = |by: f64| {
                let mut q = q_1.clone();
                q[j] += by;
                evaluated(&slip, &q_0, &q, &lambda)
            };
            let (more, less) = (at(h), at(-h));
            for k in 0..3 {
                assert!(((more.gap[k] - less.gap[k]) / (2.0 * h) - out.gradient_end[9 * k + j]).abs() < 1e-8);
            }
            for i in 0..9 {
                let force = |of: &Evaluation| (0..3).map(|k| lambda[k] * of.gradient_bar[9 * k + i]).sum::<f64>();
                assert!(((force(&more) - force(&less)) / (2.0 * h) - out.tangent[9 * i + j]).abs() < 1e-8, "{i} {j}");
            }
        }
    }
}
