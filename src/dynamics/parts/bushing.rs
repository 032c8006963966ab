//! A bushing between two rigid bodies, or a rigid body and the ground: stiffness and damping for all relative displacements and rotations.
//!
//! With axes `a_i` of the second body and `b_i` of the first, equal at rest, and the vector `r` between the points that coincide at rest,
//!
//! ```text
//! d_i = r.a_i,    c = cos phi,    sin phi n = sum e_i (a_k.b_j - a_j.b_k) / 2        (plane: b_1.a_1 and b_1.a_2)
//! s = (d, (4 - c) / 3 sin phi n),    V = s.K s / 2
//! ```
//!
//! `(4 - cos phi) / 3 sin phi` is `phi (1 - phi^4 / 30 + ...)`. `d`, `c` and `sin phi n` are products of vectors, hence quadratic in
//! positions and invariant under rigid motions. Their gradients at mid-step are discrete gradients, and so are those of `s` and `V` by the
//! product rule `u_1 v_1 - u_0 v_0 = (u_0 + u_1)/2 (v_1 - v_0) + (v_0 + v_1)/2 (u_1 - u_0)`: energy is exact, and momenta between two
//! bodies are conserved (O. Gonzalez, J. Nonlinear Science 6, 1996). Damping adds `C ds/dt` to `K s`; the heat is `dt s'.C s'`.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::contact::{CandidateSearch, Evaluation, PatchFunctions, PointConstraints, PointFunction, PointVector, PredictedMotion};
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, PartPlace, PartStepResult, Pose, Refusal, Sums};
use crate::dynamics::model::quantity::Quantity;
use crate::dynamics::model::step_error::StepError;
use crate::integrators::Derivative;
use crate::linear::{Block, Pattern};
use crate::math::tolerances::EQUAL;

const REMEDY: &str = "a stiffness and a damping are symmetric, without negative eigenvalues, and have a row for each motion: those along \
                      the axes, then turns about them";

/// Bushing between two bodies, or a body and the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct BushingDefinition {
    /// Name, unique among the parts.
    pub name: String,
    /// Bodies, each with its masters; `None`: the ground. The axes rotate with the second body.
    pub bodies: [Option<(usize, Vec<u32>)>; 2],
    /// Reference position of the point `[length]`.
    pub point: [f64; 3],
    /// Initial axes of the bushing; the first two in the plane.
    pub axes: [[f64; 3]; 3],
    /// Stiffness matrix: forces, then moments, by displacements, then rotations, row by row: 3 x 3 in the plane, 6 x 6 in space.
    pub stiffness: Vec<f64>,
    /// Damping matrix: forces, then moments, by rates of displacements, then of rotations; of the size of the stiffness matrix.
    pub damping: Vec<f64>,
}

impl BushingDefinition {
    /// Number of relative motions.
    fn motions(&self) -> usize {
        if self.stiffness.len() == 9 { 3 } else { 6 }
    }
}

impl PartDefinition for BushingDefinition {
    fn name(&self) -> &str {
        &self.name
    }

    fn bodies(&self) -> Vec<usize> {
        self.bodies.iter().flatten().map(|(body, _)| *body).collect()
    }

    fn is_grounded(&self) -> bool {
        self.bodies.iter().any(Option::is_none)
    }

    fn readings(&self) -> &'static [Quantity] {
        const READINGS: &[Quantity] = &[
            Quantity::new("displacement", "length"),
            Quantity::new("angle", "rad"),
            Quantity::new("force", "force"),
            Quantity::new("moment", "force * length"),
            Quantity::new("energy", "energy"),
        ];
        READINGS
    }

    fn dissipates(&self) -> bool {
        self.damping.iter().any(|entry| *entry != 0.0)
    }

    fn check(&self, _point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        let count = self.motions();
        let unsound = |reason: String| Err(ModelError::Unsound { what: "bushing", name: self.name.clone(), reason, remedy: REMEDY });
        for (what, entries) in [("stiffness", &self.stiffness), ("damping", &self.damping)] {
            if entries.len() != count * count {
                return unsound(format!("its {what} has {} entries, and {count} x {count} are needed", entries.len()));
            }
            let matrix = DMatrix::from_row_slice(count, count, entries);
            let largest = matrix.amax();
            if !largest.is_finite() || (&matrix - matrix.transpose()).amax() > EQUAL * largest {
                return unsound(format!("its {what} is not symmetric"));
            }
            if matrix.symmetric_eigenvalues().min() < -EQUAL * largest {
                return unsound(format!("its {what} has a negative eigenvalue: it would drive a motion"));
            }
        }
        Ok(())
    }

    fn places(&self) -> Vec<PartPlace> {
        let body = self.bodies.iter().rev().flatten().next().map(|(body, _)| *body);
        vec![PartPlace::Point(body, self.point)]
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        let (d, count) = (numbering.dimension, self.motions());
        let sides = self.bodies.each_ref().map(|body| BushingEnd::new(body.as_ref(), numbering));
        let [b, a] = &sides;
        let axes = &self.axes[..d];
        let mut vectors = vec![b.point(self.point).minus(&a.point(self.point))];
        vectors.extend(axes.iter().map(|axis| a.direction(*axis)));
        vectors.extend(axes.iter().map(|axis| b.direction(*axis)));
        let of = |products: Vec<(usize, usize, f64)>, constant: f64| PointFunction { products, linear: Vec::new(), constant };
        let mut functions: Vec<PointFunction> = (0..d).map(|i| of(vec![(0, 1 + i, 1.0)], 0.0)).collect();
        if d == 2 {
            functions.extend([of(vec![(3, 2, 1.0)], 0.0), of(vec![(3, 1, 1.0)], 0.0)]);
        } else {
            let turn = |i: usize| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                of(vec![(1 + k, 4 + j, 0.5), (1 + j, 4 + k, -0.5)], 0.0)
            };
            functions.extend((0..3).map(turn));
            functions.push(of((0..3).map(|i| (1 + i, 4 + i, 0.5)).collect(), -0.5));
        }
        let mut invariants = PointConstraints::new(d, 1.0);
        invariants.add(vectors, functions, None, self.is_grounded());
        invariants.update_candidates(&PredictedMotion::within(numbering.reference, 0.0));
        let matrix = |entries: &[f64]| DMatrix::from_row_slice(count, count, entries);
        let [stiffness, damping] = [matrix(&self.stiffness), matrix(&self.damping)];
        Box::new(Bushing { invariants, dimension: d, stiffness, damping, is_outside: self.is_grounded(), places: Vec::new() })
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let [_, length, time] = change.units;
        let energy = change.energy();
        let (count, shifts) = (self.motions(), if change.is_plane { 2 } else { 3 });
        let scaled = |entries: &[f64], by: f64| -> Vec<f64> {
            let unit = |k: usize| if k < shifts { length } else { 1.0 };
            entries.iter().enumerate().map(|(k, entry)| by * entry / (unit(k / count) * unit(k % count))).collect()
        };
        Arc::new(BushingDefinition {
            point: (change.point)(self.point),
            axes: std::array::from_fn(|i| if i < shifts { (change.direction)(self.axes[i]) } else { self.axes[i] }),
            stiffness: scaled(&self.stiffness, energy),
            damping: scaled(&self.damping, energy * time),
            ..self.clone()
        })
    }

    fn describe(&self) -> String {
        format!("bushing \"{}\"", self.name)
    }
}

/// One side of a bushing: a body given by its masters at rest, or the ground.
struct BushingEnd {
    masters: Vec<u32>,
    origin: Vector3<f64>,
    /// Inverse of the edges from the first master to the others, which gives the coefficients of a vector.
    inverse: Matrix3<f64>,
}

impl BushingEnd {
    fn new(body: Option<&(usize, Vec<u32>)>, numbering: &Numbering) -> Self {
        let masters: Vec<u32> =
            body.map_or(Vec::new(), |(body, masters)| masters.iter().map(|node| numbering.first[*body] as u32 + node).collect());
        let d = numbering.dimension;
        let at = |node: u32| Vector3::from_fn(|i, _| if i < d { numbering.reference[node as usize * d + i] } else { 0.0 });
        let origin = masters.first().map_or(Vector3::zeros(), |&node| at(node));
        let mut edges = Matrix3::identity();
        masters.iter().skip(1).enumerate().for_each(|(k, &node)| edges.set_column(k, &(at(node) - origin)));
        BushingEnd { masters, origin, inverse: edges.try_inverse().unwrap_or_else(Matrix3::identity) }
    }

    /// Vector that rotates with the body.
    fn direction(&self, vector: [f64; 3]) -> PointVector {
        let Some((&first, others)) = self.masters.split_first() else { return PointVector { parts: Vec::new(), offset: vector } };
        let shares = self.inverse * Vector3::from(vector);
        let sum: f64 = shares.iter().take(others.len()).sum();
        let parts = std::iter::once((first, -sum)).chain(others.iter().copied().zip(shares.iter().copied())).collect();
        PointVector { parts, offset: [0.0; 3] }
    }

    /// A point of the body.
    fn point(&self, point: [f64; 3]) -> PointVector {
        let mut vector = self.direction((Vector3::from(point) - self.origin).into());
        match vector.parts.first_mut() {
            Some((_, share)) => *share += 1.0,
            None => vector.offset = point,
        }
        vector
    }
}

/// A bushing in global node numbers.
struct Bushing {
    /// Invariants: displacements `d`, rotations `sin phi n`, then `cos phi`, as functions of positions.
    invariants: PointConstraints,
    dimension: usize,
    stiffness: DMatrix<f64>,
    damping: DMatrix<f64>,
    is_outside: bool,
    places: Vec<Block>,
}

/// Response of a bushing at an iterate.
struct Response {
    /// Forces on the unknowns and, on request, their derivative.
    force: DVector<f64>,
    slope: Option<DMatrix<f64>>,
    /// Power dissipated by the damping `[energy/time]`.
    power: f64,
}

impl Bushing {
    fn nodes(&self) -> &[u32] {
        self.invariants.patches().nodes(0)
    }

    /// Generalized displacements `s` from the invariants `z`.
    fn motions(&self, z: &[f64]) -> DVector<f64> {
        let cosine = z[z.len() - 1];
        DVector::from_fn(z.len() - 1, |k, _| if k < self.dimension { z[k] } else { (4.0 - cosine) / 3.0 * z[k] })
    }

    /// Derivative of the generalized displacements `s` with respect to the invariants `z`.
    fn shares(&self, z: &[f64]) -> DMatrix<f64> {
        let last = z.len() - 1;
        DMatrix::from_fn(last, z.len(), |k, j| match (k < self.dimension, k == j, j == last) {
            (true, true, _) => 1.0,
            (false, true, _) => (4.0 - z[last]) / 3.0,
            (false, _, true) => -z[k] / 3.0,
            _ => 0.0,
        })
    }

    fn response(&self, at: &Iterate, wants_slope: bool) -> Response {
        let is_discrete = at.derivative == Derivative::DiscreteGradient;
        let share = at.derivative.placement().share;
        let (from, to) = if is_discrete { (at.q_0, at.q_1) } else { (&[][..], at.q_test) };
        let rows = self.stiffness.nrows() + 1;
        let count = self.nodes().len() * self.dimension;
        let evaluated = |weights: &[f64]| {
            let mut out = Evaluation::default();
            self.invariants.evaluate_from(from, at.derivative, to, weights, &mut out);
            out
        };
        let plain = evaluated(&vec![0.0; rows]);
        let z_1 = plain.gap.clone();
        let z: Vec<f64> =
            if is_discrete { self.invariants.gap(at.q_0).iter().zip(&z_1).map(|(a, b)| 0.5 * (a + b)).collect() } else { z_1.clone() };
        let mean = if is_discrete { 0.5 * (self.motions(&self.invariants.gap(at.q_0)) + self.motions(&z_1)) } else { self.motions(&z_1) };
        let gradients = DMatrix::from_row_slice(rows, count, &plain.gradient_bar);
        let shares = self.shares(&z);
        let own = |values: &[f64]| {
            let of_node = |&node: &u32| (0..self.dimension).map(move |i| values[node as usize * self.dimension + i]);
            DVector::from_iterator(count, self.nodes().iter().flat_map(of_node))
        };
        let velocity = own(at.velocity);
        let passing = &gradients * &velocity;
        let rate = &shares * &passing;
        let loads = &self.stiffness * mean + &self.damping * &rate;
        let weights = shares.transpose() * &loads;
        let power = rate.dot(&(&self.damping * &rate));
        let force = gradients.transpose() * &weights;
        if !wants_slope {
            return Response { force, slope: None, power };
        }
        let hessian = |weights: &[f64]| DMatrix::from_row_slice(count, count, &evaluated(weights).tangent);
        // Derivatives of the invariants at the configuration at which `s` and its derivative `ds/dz` are evaluated, with respect to `q_1`.
        let changes = DMatrix::from_row_slice(rows, count, &plain.gradient_end) * share;
        let last = rows - 1;
        // Derivative of `(ds/dz) a` with respect to `q_1`, for a fixed vector `a` of one entry per invariant; `bent_back`: of `(ds/dz)^T
        // b`.
        let bent = |vector: &DVector<f64>| {
            DMatrix::from_fn(last, count, |k, i| {
                if k < self.dimension { 0.0 } else { -(changes[(last, i)] * vector[k] + changes[(k, i)] * vector[last]) / 3.0 }
            })
        };
        let bent_back = |vector: &DVector<f64>| {
            DMatrix::from_fn(rows, count, |j, i| match (j < self.dimension, j == last) {
                (true, _) => 0.0,
                (_, true) => (self.dimension..last).map(|k| -changes[(k, i)] * vector[k] / 3.0).sum(),
                _ => -changes[(last, i)] * vector[j] / 3.0,
            })
        };
        let mut of_loads = &self.stiffness * self.shares(&z_1) * &changes;
        if self.damping.amax() > 0.0 {
            let mut of_passing = &gradients * at.velocity_slope;
            for row in 0..rows {
                let unit: Vec<f64> = (0..rows).map(|k| if k == row { 1.0 } else { 0.0 }).collect();
                let turned = hessian(&unit) * &velocity;
                (0..count).for_each(|i| of_passing[(row, i)] += turned[i]);
            }
            of_loads += &self.damping * (&shares * of_passing + bent(&passing));
        }
        let of_weights = shares.transpose() * of_loads + bent_back(&loads);
        let slope = gradients.transpose() * of_weights + hessian(weights.as_slice());
        Response { force, slope: Some(slope), power }
    }
}

impl Part for Bushing {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(self.nodes());
    }

    fn place(&mut self, pattern: &Pattern) {
        let nodes = self.nodes();
        self.places = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| pattern.block(a, b))).collect();
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let Response { force, slope, .. } = self.response(at, sums.tangent.is_some());
        let (d, nodes) = (self.dimension, self.nodes());
        for (&node, force) in nodes.iter().zip(force.as_slice().chunks_exact(d)) {
            (0..d).for_each(|i| sums.internal[node as usize * d + i] += at.weight * force[i]);
        }
        let (Some(values), Some(slope)) = (sums.tangent.as_deref_mut(), slope) else { return Ok(()) };
        for (k, block) in self.places.iter().enumerate() {
            let (row, column) = (k / nodes.len() * d, k % nodes.len() * d);
            for i in 0..d {
                (0..d).for_each(|j| values[block.at(i, j)] += at.weight * slope[(row + i, column + j)]);
            }
        }
        Ok(())
    }

    fn energy(&self, at: Pose, _memory: &[f64]) -> f64 {
        let motions = self.motions(&self.invariants.gap(at.q));
        0.5 * motions.dot(&(&self.stiffness * &motions))
    }

    fn is_outside(&self) -> bool {
        self.is_outside
    }

    fn readings(&self, at: Pose, _velocity: &[f64], memory: &[f64]) -> Vec<f64> {
        let motions = self.motions(&self.invariants.gap(at.q));
        let loads = &self.stiffness * &motions;
        let sizes = |of: &DVector<f64>| [of.rows(0, self.dimension).norm(), of.rows_range(self.dimension..).norm()];
        let ([displacement, angle], [force, moment]) = (sizes(&motions), sizes(&loads));
        vec![displacement, angle, force, moment, self.energy(at, memory)]
    }

    fn after_step(&self, at: &Iterate, _memory: &[f64]) -> Result<PartStepResult, StepError> {
        Ok(PartStepResult { dissipated: at.dt * self.response(at, false).power, ..PartStepResult::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::super::in_step::linearized;
    use super::*;
    use crate::linear::Vertex;

    fn bushing(dimension: usize, is_grounded: bool, damps: f64) -> BushingDefinition {
        let count = if dimension == 2 { 3 } else { 6 };
        let root = DMatrix::from_fn(count, count, |i, j| (1.3 * (i * count + j) as f64).sin());
        let matrix = &root * root.transpose();
        let masters: Vec<u32> = (0..=dimension as u32).collect();
        let turned = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];
        let second = (!is_grounded).then(|| (1, masters.clone()));
        BushingDefinition {
            name: "b".into(),
            bodies: [Some((0, masters)), second],
            point: [0.2, 0.3, if dimension == 2 { 0.0 } else { 0.1 }],
            axes: turned,
            stiffness: matrix.as_slice().to_vec(),
            damping: (matrix * damps).as_slice().to_vec(),
        }
    }

    /// Masters of two bodies at rest, then rotated and displaced, each by a step of the given size.
    fn positions(dimension: usize, size: f64) -> [Vec<f64>; 2] {
        let unit = |k: usize, i: usize| if k == i + 1 { 1.0 } else { 0.0 };
        let rest: Vec<f64> = (0..2 * (dimension + 1) * dimension).map(|k| unit(k / dimension % (dimension + 1), k % dimension)).collect();
        let moved = rest.iter().enumerate().map(|(k, q)| q + size * (1.7 * k as f64).sin()).collect();
        [rest, moved]
    }

    #[test]
    fn it_does_the_work_of_its_energy_and_heat_and_its_tangent_is_its_derivative() {
        for (dimension, is_grounded, damps) in [(2, true, 0.0), (2, false, 0.3), (3, true, 0.3), (3, false, 0.0)] {
            let ([rest, q_0], [_, q_1]) = (positions(dimension, 0.2), positions(dimension, 0.31));
            let per_body = dimension + 1;
            let first = [0, per_body];
            let mut part = bushing(dimension, is_grounded, damps).part(&Numbering { dimension, first: &first, reference: &rest });
            let count = q_0.len();
            let all: Vec<u32> = (0..2 * per_body as u32).collect();
            let pattern = Pattern::new(&vec![Vertex::coordinates(dimension as u8); 2 * per_body], [&all[..]].into_iter());
            part.place(&pattern);
            for derivative in Derivative::ALL {
                let linearized = |q_1: &[f64]| linearized(&*part, &pattern, derivative, [&q_0, q_1], 0.1);
                let (force, values, heat) = linearized(&q_1);
                let work: f64 = force.iter().zip(q_1.iter().zip(&q_0)).map(|(f, (b, a))| f * (b - a)).sum();
                let energy = |q: &[f64]| part.energy(Pose { q, u: q }, &[]);
                let change = energy(&q_1) - energy(&q_0) + heat;
                assert!(
                    derivative != Derivative::DiscreteGradient || (work - change).abs() < 1e-12 * work.abs().max(1.0),
                    "{work} {change}"
                );
                for column in 0..count {
                    let [up, down] = [1e-6, -1e-6].map(|h| {
                        let mut q = q_1.clone();
                        q[column] += h;
                        linearized(&q).0
                    });
                    for row in 0..count {
                        let block = pattern.block((row / dimension) as u32, (column / dimension) as u32);
                        let entry = values[block.at(row % dimension, column % dimension)];
                        let slope = (up[row] - down[row]) / 2e-6;
                        assert!(
                            (slope - entry).abs() < 1e-5 * (1.0 + entry.abs()),
                            "{dimension} {derivative:?} [{row}][{column}] {slope} {entry}"
                        );
                    }
                }
            }
        }
    }
}
