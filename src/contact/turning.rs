//! Contact with a rigid obstacle that turns about an axis: the kernel of the obstacle at rest, evaluated in the obstacle's frame.
//!
//! With the pivot `c`, the translation `u`, and the rotation `R` by the angle `theta` about the unit axis `a`, a point `x` is at
//!
//! ```text
//! X = c + Y,    Y = R^T (x - c - u)
//! ```
//!
//! in that frame. The inner kernel has the gap `Phi(X)` and the discrete gradient `g` with `g.(Y_1 - Y_0) = Phi_1 - Phi_0`. Let `R_m` be
//! the rotation halfway in the step and `d` half of the angle of the step. The force
//!
//! ```text
//! F = R_m (cos d (1 - a a^T) + a a^T) g lambda
//! ```
//!
//! does the work `F.(x_1 - x_0) = lambda (Phi_1 - Phi_0) + F.(u_1 - u_0) + 2 tan(d) M`, where `M` is the moment of `F` about the axis with
//! the arm in mid-step, which enters the balance of angular momentum. The last two terms are the work of the drive: for the angle of the
//! step, `2 tan(d)` is what the chord is for an arc. The same holds for the slip of a tangential constraint, so that energy and angular
//! momentum close to round-off with and without friction.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::kernel::{CandidateSearch, ContactKernel, PatchFunctions, RigidObstacle};
use super::patches::{Evaluation, Patches};
use super::placement::{ObstaclePlacement, TurningAxis};
use super::search::Candidates;
use super::slip::SlipStep;
use super::surface::Sides;
use super::window::{MappedMotion, PredictedMotion};
use crate::integrators::{Configuration, Derivative};

/// Contact with an obstacle that turns about an axis.
pub struct TurningContact {
    /// Contact with the obstacle at rest.
    inner: Box<dyn ContactKernel>,
    axis: TurningAxis,
    dimension: usize,
    /// Translations of the obstacle at the start and at the end of the step `[length]`.
    translations: [[f64; 3]; 2],
    /// Angles of the obstacle at the start and at the end of the step `[rad]`.
    angles: [f64; 2],
    /// Displacement and angle by which the obstacle carries sticking points.
    carried: ([f64; 3], f64),
    /// Positions at the start of the step.
    start: Vec<f64>,
}

/// Index of the start of the step.
const START: usize = 0;
/// Index of the end of the step.
const END: usize = 1;

impl TurningContact {
    /// Contact with an obstacle that turns, from the contact with the obstacle at rest.
    pub fn new(inner: Box<dyn ContactKernel>, axis: TurningAxis, reference: &[f64]) -> Self {
        let dimension = inner.patches().dimension();
        let (translations, carried) = ([[0.0; 3]; 2], ([0.0; 3], 0.0));
        TurningContact { inner, axis, dimension, translations, angles: [0.0; 2], carried, start: reference.to_vec() }
    }

    fn rotation(&self, time: usize) -> Rotation3<f64> {
        self.axis.rotation(self.angles[time])
    }

    /// Half of the angle of the step.
    fn half_angle(&self) -> f64 {
        0.5 * (self.angles[END] - self.angles[START])
    }

    /// Position of the pivot at the start or at the end of the step.
    fn pivot(&self, time: usize) -> Vector3<f64> {
        Vector3::from(self.axis.center) + Vector3::from(self.translations[time])
    }

    /// Applies a function to the vector of each node.
    fn each_node(&self, q: &[f64], of: impl Fn(usize, Vector3<f64>) -> Vector3<f64>) -> Vec<f64> {
        let d = self.dimension;
        let mut out = Vec::with_capacity(q.len());
        for (node, x) in q.chunks_exact(d).enumerate() {
            let vector = of(node, Vector3::from_fn(|i, _| if i < d { x[i] } else { 0.0 }));
            out.extend_from_slice(&vector.as_slice()[..d]);
        }
        out
    }

    /// Positions in the frame of the obstacle at the start or at the end of the step.
    fn in_frame(&self, q: &[f64], time: usize) -> Vec<f64> {
        let (inverse, pivot, center) = (self.rotation(time).inverse(), self.pivot(time), Vector3::from(self.axis.center));
        self.each_node(q, |_, x| center + inverse * (x - pivot))
    }

    /// Displacements in the frame for nodes that move by `moved` to the end of the step, while the obstacle moves by `shift` and turns by
    /// `angle`; `begin` are the positions before. Accurate relative to the size of the displacements.
    fn moved_in_frame(&self, begin: impl Fn(usize) -> Vector3<f64>, moved: &[f64], (shift, angle): ([f64; 3], f64)) -> Vec<f64> {
        let (inverse, shift, axis) = (self.rotation(END).inverse(), Vector3::from(shift), Vector3::from(self.axis.direction));
        let (pivot, half) = (self.pivot(END) - shift, 0.5 * angle);
        self.each_node(moved, |node, moved| {
            // (1 - R) v = -sin(angle) a x v - 2 sin(angle/2)^2 a x (a x v)
            let across = axis.cross(&(inverse * (begin(node) - pivot)));
            inverse * (moved - shift) - across * angle.sin() - axis.cross(&across) * (2.0 * half.sin().powi(2))
        })
    }

    fn node(&self, q: &[f64], node: usize) -> Vector3<f64> {
        Vector3::from_fn(|i, _| if i < self.dimension { q[self.dimension * node + i] } else { 0.0 })
    }

    /// Matrix from forces in the frame to forces in space, for forces of mid-step or of the end of the step.
    fn of_forces(&self, at: Configuration) -> Matrix3<f64> {
        if at == Configuration::End {
            return self.rotation(END).into_inner();
        }
        let (axis, half) = (Vector3::from(self.axis.direction), self.half_angle());
        let along = axis * axis.transpose();
        let middle = self.axis.rotation(0.5 * (self.angles[START] + self.angles[END])).into_inner();
        middle * ((Matrix3::identity() - along) * half.cos() + along)
    }

    /// Turns the blocks of an evaluation from the frame into space.
    fn turn_blocks(&self, patches: &Patches, of_forces: &Matrix3<f64>, out: &mut Evaluation) {
        let (d, end) = (self.dimension, self.rotation(END).into_inner());
        let turn = |matrix: &Matrix3<f64>, vectors: &mut [f64]| {
            for vector in vectors.chunks_exact_mut(d) {
                let turned = matrix * Vector3::from_fn(|i, _| if i < d { vector[i] } else { 0.0 });
                vector.copy_from_slice(&turned.as_slice()[..d]);
            }
        };
        for p in (0..patches.len()).filter(|&p| out.live[p]) {
            let (gradient, square) = (out.gradient_range(patches, p), out.tangent_range(patches, p));
            turn(&end, &mut out.gradient_end[gradient.clone()]);
            turn(of_forces, &mut out.gradient_bar[gradient]);
            let width = patches.unknowns(p);
            let block = &mut out.tangent[square];
            // Columns are derivatives with respect to positions at the end.
            block.chunks_exact_mut(width).for_each(|row| turn(&end, row));
            for first in (0..if block.is_empty() { 0 } else { width }).step_by(d) {
                for column in 0..width {
                    let entry = |i: usize| (first + i) * width + column;
                    let turned = of_forces * Vector3::from_fn(|i, _| if i < d { block[entry(i)] } else { 0.0 });
                    (0..d).for_each(|i| block[entry(i)] = turned[i]);
                }
            }
        }
    }

    /// Predicted motion in the frame of the obstacle.
    fn motion<'a>(&self, in_space: &PredictedMotion<'a>) -> MappedMotion<'a> {
        let by: [f64; 3] = std::array::from_fn(|i| self.translations[END][i] - self.translations[START][i]);
        let field = |u: &[f64]| self.moved_in_frame(|node| self.node(in_space.q, node), u, (by, 2.0 * self.half_angle()));
        in_space.mapped(self.in_frame(in_space.q, START), <[f64]>::to_vec, field)
    }
}

impl PatchFunctions for TurningContact {
    fn sides(&self) -> &Sides {
        self.inner.sides()
    }

    fn inner(&self) -> Option<&dyn ContactKernel> {
        Some(&*self.inner)
    }

    fn inner_mut(&mut self) -> Option<&mut dyn ContactKernel> {
        Some(&mut *self.inner)
    }

    fn shown_at(&self, row: usize, q: &[f64]) -> Option<u32> {
        self.inner.shown_at(row, &self.in_frame(q, END))
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.start = q_0.to_vec();
        let q = self.in_frame(q_0, START);
        self.inner.begin_step(&q);
    }

    fn start_gap(&self) -> Vec<f64> {
        self.inner.start_gap()
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        // Blocks that the inner kernel leaves as they were would be turned twice.
        *out = Evaluation::default();
        self.inner.evaluate(derivative, &self.in_frame(q_1, END), lambda, out);
        self.turn_blocks(self.inner.patches(), &self.of_forces(derivative.placement().test), out);
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        *out = Evaluation::default();
        let q_1 = self.in_frame(step.q_1, END);
        let begin = |node: usize| self.node(step.q_1, node) - self.node(step.moved, node);
        let moved = self.moved_in_frame(begin, step.moved, self.carried);
        let q_0: Vec<f64> = q_1.iter().zip(&moved).map(|(q, moved)| q - moved).collect();
        self.inner.evaluate_slips(SlipStep { q_0: &q_0, q_1: &q_1, moved: &moved, ..step }, lambda, out);
        self.turn_blocks(self.inner.slip_patches(), &self.of_forces(step.test), out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.inner.gap(&self.in_frame(q, END))
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        self.inner.coverage(&self.in_frame(q, END))
    }
}

impl CandidateSearch for TurningContact {
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        let motion = self.motion(predicted_motion);
        self.inner.update_candidates(&motion.of_points())
    }

    fn margin(&self, predicted_motion: &PredictedMotion) -> f64 {
        self.inner.margin(&self.motion(predicted_motion).of_points())
    }

    fn overlooks(&self, q_0: &[f64], q_1: &[f64], tolerance: f64) -> bool {
        self.inner.overlooks(&self.in_frame(q_0, START), &self.in_frame(q_1, END), tolerance)
    }

    fn restore_candidates(&mut self, candidates: &Candidates, q: &[f64]) {
        self.start = q.to_vec();
        let q = self.in_frame(q, START);
        self.inner.restore_candidates(candidates, &q);
    }

    fn deepest(&self, q: &[f64]) -> f64 {
        self.inner.deepest(&self.in_frame(q, END))
    }

    fn crossing(&self, q: &[f64]) -> f64 {
        self.inner.crossing(&self.in_frame(q, END))
    }
}

impl RigidObstacle for TurningContact {
    fn move_obstacle(&mut self, &[start, _, end]: &[[f64; 3]; 3]) {
        self.translations = [start, end];
    }

    fn turn_obstacle(&mut self, angles: [f64; 2]) {
        self.angles = angles;
    }

    fn carry(&mut self, shift: [f64; 3], angle: f64) {
        self.carried = (shift, angle);
    }

    fn obstacle_placement(&self) -> ObstaclePlacement {
        self.axis.place(self.angles[END], self.translations[END])
    }

    fn passage(&self, q_1: &[f64]) -> [f64; 2] {
        self.inner.passage(&self.in_frame(q_1, END))
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let (in_frame, none) = (self.in_frame(q_1, END), vec![0.0; lambda.len()]);
        let mut sum = vec![0.0; q_1.len()];
        let mut add = |turn: Matrix3<f64>, before: &[f64], lambda: &[f64]| {
            if before.iter().chain(lambda).any(|lambda| *lambda != 0.0) {
                let mut own = vec![0.0; q_1.len()];
                self.inner.obstacle_force_into(derivative, &in_frame, before, lambda, &mut own);
                let turned = self.each_node(&own, |_, f| turn * f);
                sum.iter_mut().zip(turned).for_each(|(sum, f)| *sum += f);
            }
        };
        add(self.of_forces(derivative.placement().test), &none, lambda);
        add(self.rotation(START).into_inner(), before, &none);
        let (mut resultant, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let pivot = 0.5 * (self.pivot(START) + self.pivot(END));
        for node in 0..sum.len() / self.dimension {
            let f = self.node(&sum, node);
            resultant += f;
            moment += (0.5 * (self.node(&self.start, node) + self.node(q_1, node)) - pivot).cross(&f);
        }
        force.iter_mut().zip(&sum).for_each(|(force, f)| *force += f);
        let chord = 2.0 * self.half_angle().tan();
        resultant.dot(&(self.pivot(END) - self.pivot(START))) + chord * moment.dot(&Vector3::from(self.axis.direction))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::fixtures::{difference, evaluated, product, stored};
    use crate::contact::surface::Surface;
    use crate::contact::{Facets, Obstacle, ObstacleInSpace, RigidCorners, rigid_contact};

    const TRANSLATIONS: [[f64; 3]; 3] = [[0.1, -0.2, 0.0], [0.12, -0.15, 0.0], [0.15, -0.1, 0.0]];

    fn in_plane(q_0: &[f64], of_points: bool) -> TurningContact {
        let obstacle = Obstacle::Polyline { points: vec![[-1.0, -1.0], [1.0, -0.8], [0.2, 0.1], [0.1, 1.0], [-1.0, -1.0]] };
        let inner: Box<dyn ContactKernel> = if of_points {
            Box::new(RigidCorners::new(&Surface::new(&[[0, 1]]), &obstacle, [q_0, q_0], 1.0).expect("a polyline has corners"))
        } else {
            rigid_contact(Surface::new(&[[0, 1]]), &obstacle, q_0, Default::default())
        };
        begun(inner, TurningAxis::new([0.3, 0.2, 0.0], [0.0, 0.0, 1.0]), q_0)
    }

    fn in_space(q_0: &[f64]) -> TurningContact {
        let cube = Facets::cuboid([-0.8, -0.5, -0.4], [0.3, 0.6, 0.7]).expect("it has a volume");
        let cube = Obstacle::InSpace(ObstacleInSpace::Facets(cube.into()));
        let inner = rigid_contact(Surface::in_space([&[0, 1, 2][..]]), &cube, q_0, Default::default());
        begun(inner, TurningAxis::new([0.3, 0.2, -0.4], [1.0, -2.0, 0.5]), q_0)
    }

    fn begun(inner: Box<dyn ContactKernel>, axis: TurningAxis, q_0: &[f64]) -> TurningContact {
        let mut kernel = TurningContact::new(inner, axis, q_0);
        kernel.move_obstacle(&TRANSLATIONS);
        kernel.turn_obstacle([0.4, 0.9]);
        kernel.carry([0.05, 0.1, 0.0], 0.5);
        kernel.update_candidates(&PredictedMotion::within(q_0, 3.0));
        kernel.begin_step(q_0);
        kernel
    }

    fn cases() -> Vec<(TurningContact, Vec<f64>, Vec<f64>)> {
        let plane = |q_0: [f64; 4], q_1: [f64; 4], of_points| (in_plane(&q_0, of_points), q_0.to_vec(), q_1.to_vec());
        let space = |q_0: [f64; 9], q_1: [f64; 9]| (in_space(&q_0), q_0.to_vec(), q_1.to_vec());
        vec![
            plane([1.2, -0.3, 0.4, 0.9], [1.0, 0.1, 0.3, 1.1], false),
            plane([-0.9, 0.8, -1.2, -0.4], [-0.7, 0.4, -1.0, -0.6], false),
            plane([1.5, 0.6, 1.6, -1.2], [1.75, 0.8, 1.8, -0.9], true),
            space([0.9, 0.1, 0.2, 0.2, 0.9, -0.1, 0.1, 0.3, 1.2], [0.7, 0.3, 0.2, 0.1, 0.8, 0.1, 0.3, 0.2, 1.0]),
        ]
    }

    fn multipliers(count: usize) -> Vec<f64> {
        (0..count).map(|row| 1.5 - 0.7 * row as f64).collect()
    }

    /// Work of the forces = multipliers times changes of the gaps + work of the drive; the drive's work is that of resultant and moment.
    #[test]
    fn work_is_that_of_the_gaps_and_of_the_drive() {
        for (case, (kernel, q_0, q_1)) in cases().into_iter().enumerate() {
            let lambda = multipliers(kernel.rows());
            let out = evaluated(&kernel, Derivative::DiscreteGradient, &q_1, &lambda);
            let (mut force, none) = (vec![0.0; q_1.len()], vec![0.0; lambda.len()]);
            let by_drive = kernel.obstacle_force_into(Derivative::DiscreteGradient, &q_1, &none, &lambda, &mut force);
            let by_gaps = product(&lambda, &difference(&out.gap, &kernel.start_gap()));
            let work = product(&force, &difference(&q_1, &q_0));
            assert!(by_gaps.abs() > 1e-3 && by_drive.abs() > 1e-3, "{case}: the step moves both");
            assert!((work - by_gaps - by_drive).abs() < 1e-13, "{case}: {work} {by_gaps} {by_drive}");
        }
    }

    #[test]
    fn tangents_and_gradients_agree_with_differences() {
        for (case, (kernel, _, q_1)) in cases().into_iter().enumerate() {
            let (lambda, count, step) = (multipliers(kernel.rows()), q_1.len(), 1e-6);
            let forces = |q: &[f64], derivative: Derivative| {
                let (mut force, none) = (vec![0.0; count], vec![0.0; lambda.len()]);
                kernel.obstacle_force_into(derivative, q, &none, &lambda, &mut force);
                force
            };
            for derivative in Derivative::ALL {
                let out = evaluated(&kernel, derivative, &q_1, &lambda);
                let patches = kernel.patches();
                let (mut tangent, mut gradient) = (vec![0.0; count * count], vec![0.0; lambda.len() * count]);
                let d = patches.dimension();
                for p in (0..patches.len()).filter(|&p| out.live[p]) {
                    let unknowns: Vec<usize> =
                        patches.nodes(p).iter().flat_map(|&node| (0..d).map(move |i| d * node as usize + i)).collect();
                    let width = unknowns.len();
                    for (u, row) in unknowns.iter().enumerate() {
                        for (v, column) in unknowns.iter().enumerate() {
                            tangent[row * count + column] += out.tangent[patches.tangent_range(p)][u * width + v];
                        }
                    }
                    for (m, &row) in patches.rows(p).iter().enumerate() {
                        for (u, column) in unknowns.iter().enumerate() {
                            gradient[row as usize * count + column] += out.gradient_end[patches.gradient_range(p)][m * width + u];
                        }
                    }
                }
                for k in 0..count {
                    let [high, low] = [step, -step].map(|by| {
                        let mut q = q_1.clone();
                        q[k] += by;
                        (forces(&q, derivative), evaluated(&kernel, derivative, &q, &lambda).gap)
                    });
                    for i in 0..count {
                        let slope = (high.0[i] - low.0[i]) / (2.0 * step);
                        assert!((slope - tangent[i * count + k]).abs() < 1e-7, "{case} {derivative:?} {i} {k}: {slope}");
                    }
                    for row in 0..lambda.len() {
                        let slope = (high.1[row] - low.1[row]) / (2.0 * step);
                        assert!((slope - gradient[row * count + k]).abs() < 1e-7, "{case} gap {row} {k}");
                    }
                }
            }
        }
    }

    /// Nodes that move with the obstacle have no slip, and the force of slip does the work of the slip and of the drive.
    #[test]
    fn what_turns_along_has_no_slip() {
        for (case, (kernel, q_0, q_1)) in cases().into_iter().enumerate() {
            let (d, by) = (kernel.dimension, kernel.rotation(END) * kernel.rotation(START).inverse());
            let along = kernel.each_node(&q_0, |_, x| kernel.pivot(END) + by * (x - kernel.pivot(START)));
            let count = kernel.slip_patches().len();
            let live = vec![true; count];
            let tau = multipliers((d - 1) * kernel.rows());
            let slips = |q_1: &[f64]| {
                let (mut out, moved) = (Evaluation::default(), difference(q_1, &q_0));
                let step = SlipStep { q_0: &q_0, q_1, moved: &moved, test: Configuration::Middle, live: &live, wants_tangent: true };
                kernel.evaluate_slips(step, &tau, &mut out);
                stored(&out, kernel.slip_patches())
            };
            let still = slips(&along);
            assert!(still.gap.iter().all(|slip| slip.abs() < 1e-14), "{case}: {:?}", still.gap);
            let out = slips(&q_1);
            let patches = kernel.slip_patches();
            let (mut work, mut moment, mut resultant) = (0.0, Vector3::zeros(), Vector3::zeros());
            for p in (0..count).filter(|&p| out.live[p]) {
                let width = patches.unknowns(p);
                for (m, &row) in patches.rows(p).iter().enumerate() {
                    for (u, &node) in patches.nodes(p).iter().enumerate() {
                        let at = patches.gradient_range(p).start + m * width + d * u;
                        let f = Vector3::from_fn(|i, _| if i < d { tau[row as usize] * out.gradient_bar[at + i] } else { 0.0 });
                        let [x_0, x_1] = [&q_0, &q_1].map(|q| kernel.node(q, node as usize));
                        work += f.dot(&(x_1 - x_0));
                        resultant += f;
                        moment += (0.5 * (x_0 + x_1 - kernel.pivot(START) - kernel.pivot(END))).cross(&f);
                    }
                }
            }
            let chord = 2.0 * kernel.half_angle().tan();
            let drive =
                resultant.dot(&(kernel.pivot(END) - kernel.pivot(START))) + chord * moment.dot(&Vector3::from(kernel.axis.direction));
            let of_slip = product(&tau, &out.gap);
            assert!((work - of_slip - drive).abs() < 1e-13, "{case}: {work} {of_slip} {drive}");
        }
    }
}
