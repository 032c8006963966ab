//! A motor between two rigid bodies, or a rigid body and the ground: a torque about an axis, given by a time function, on one body, and its
//! reaction on the other.
//!
//! The edges `d_k` of a body lead from its first master to the others. The forces `f_k = w x d_k` on the other masters, and `-sum f_k` on
//! the first one, have zero resultant and the moment `J w` with `J = sum |d_k|^2 I - d_k d_k^T`. With `J w = M n` the torque is exact at
//! every configuration of the step, and momenta between two bodies are conserved. The axis `n` rotates with the second body. The work is
//! that of a load.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::time_values::value_of;
use crate::dynamics::model::amplitude::{Amplitude, Rescaled};
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, PartStepResult, Pose, Refusal, Sums};
use crate::dynamics::model::quantity::Quantity;
use crate::dynamics::model::step_error::StepError;
use crate::linear::{Block, Pattern};

/// Motor between two bodies, or a body and the ground.
#[derive(Clone)]
pub struct MotorDefinition {
    /// Name, unique among the parts.
    pub name: String,
    /// Body with the forward torque and body with the reaction, each with its masters; `None`: the ground.
    pub bodies: [Option<(usize, Vec<u32>)>; 2],
    /// Initial axis; the third one in the plane.
    pub axis: [f64; 3],
    /// Torque over time `[force * length]` (per thickness in the plane).
    pub torque: Amplitude,
}

impl PartDefinition for MotorDefinition {
    fn name(&self) -> &str {
        &self.name
    }

    fn bodies(&self) -> Vec<usize> {
        self.bodies.iter().flatten().map(|(body, _)| *body).collect()
    }

    fn functions(&self) -> Vec<Amplitude> {
        vec![self.torque.clone()]
    }

    fn readings(&self) -> &'static [Quantity] {
        const READINGS: &[Quantity] = &[Quantity::new("torque", "force * length"), Quantity::new("work", "energy")];
        READINGS
    }

    fn check(&self, _point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        Ok(())
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        let masters = |end: &Option<(usize, Vec<u32>)>| match end {
            Some((body, masters)) => masters.iter().map(|node| numbering.first[*body] as u32 + node).collect(),
            None => Vec::new(),
        };
        let sides = [masters(&self.bodies[0]), masters(&self.bodies[1])];
        let axis = Vector3::from(self.axis).normalize();
        let mut motor = Motor {
            name: self.name.clone(),
            dimension: numbering.dimension,
            sides,
            shares: None,
            axis,
            torque: self.torque.clone(),
            places: Vec::new(),
        };
        let edges = motor.edges(1, numbering.reference);
        if edges.len() == 3 {
            motor.shares = Matrix3::from_columns(&[edges[0], edges[1], edges[2]]).try_inverse().map(|inverse| inverse * axis);
        }
        Box::new(motor)
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let axis = if change.is_plane { self.axis } else { (change.direction)(self.axis) };
        Arc::new(MotorDefinition { axis, torque: Rescaled::of(&self.torque, change.units[2], change.energy()), ..self.clone() })
    }

    fn describe(&self) -> String {
        format!("motor \"{}\": torque {}", self.name, self.torque.describe())
    }
}

/// A motor in global node numbers.
struct Motor {
    name: String,
    dimension: usize,
    /// Masters of both bodies; empty for the ground.
    sides: [Vec<u32>; 2],
    /// Coefficients of the axis in the edges of the second body, in space.
    shares: Option<Vector3<f64>>,
    /// Initial axis.
    axis: Vector3<f64>,
    torque: Amplitude,
    places: Vec<Block>,
}

impl Motor {
    fn nodes(&self) -> Vec<u32> {
        self.sides.concat()
    }

    /// Edges of a body from its first master to the others.
    fn edges(&self, side: usize, q: &[f64]) -> Vec<Vector3<f64>> {
        let d = self.dimension;
        let at = |node: u32, i: usize| if i < d { q[node as usize * d + i] } else { 0.0 };
        let masters = &self.sides[side];
        masters.iter().skip(1).map(|&node| Vector3::from_fn(|i, _| at(node, i) - at(masters[0], i))).collect()
    }

    /// Axis from the edges of the second body, of any length.
    fn direction(&self, edges: &[Vector3<f64>]) -> Vector3<f64> {
        self.shares.map_or(self.axis, |shares| edges.iter().zip(shares.iter()).map(|(edge, share)| edge * *share).sum())
    }

    /// Forces of a unit torque on the nodes, in the order of [`Self::nodes`].
    fn forces(&self, q: &[f64]) -> Vec<Vector3<f64>> {
        let edges = [self.edges(0, q), self.edges(1, q)];
        let couple = self.direction(&edges[1]).normalize();
        let mut forces = Vec::new();
        for (edges, sign) in edges.iter().zip([1.0, -1.0]).filter(|(edges, _)| !edges.is_empty()) {
            let spin = inverse(edges) * couple * sign;
            let on_edges: Vec<Vector3<f64>> = edges.iter().map(|edge| spin.cross(edge)).collect();
            forces.push(-on_edges.iter().sum::<Vector3<f64>>());
            forces.extend(on_edges);
        }
        forces
    }

    /// Derivative of the nodal forces of a unit torque with respect to component `component` of node `column`.
    fn slope(&self, q: &[f64], column: usize, component: usize) -> Vec<Vector3<f64>> {
        let edges = [self.edges(0, q), self.edges(1, q)];
        let mut changes = [vec![Vector3::zeros(); edges[0].len()], vec![Vector3::zeros(); edges[1].len()]];
        let side = usize::from(column >= self.sides[0].len());
        let number = column - side * self.sides[0].len();
        let unit = Vector3::from_fn(|i, _| if i == component { 1.0 } else { 0.0 });
        match number {
            0 => changes[side].fill(-unit),
            _ => changes[side][number - 1] = unit,
        }
        let axis = self.direction(&edges[1]);
        let (size, turned) = (axis.norm(), if self.shares.is_some() { self.direction(&changes[1]) } else { Vector3::zeros() });
        let couple = axis / size;
        let change = (turned - couple * couple.dot(&turned)) / size;
        let mut slopes = Vec::new();
        for ((edges, changes), sign) in edges.iter().zip(&changes).zip([1.0, -1.0]).filter(|((edges, _), _)| !edges.is_empty()) {
            let inverse = inverse(edges);
            let spin = inverse * couple * sign;
            let of_tensor = edges.iter().zip(changes).map(|(d, e)| spin * (2.0 * d.dot(e)) - e * d.dot(&spin) - d * e.dot(&spin));
            let turned = inverse * (change * sign - of_tensor.sum::<Vector3<f64>>());
            let on_edges: Vec<Vector3<f64>> = edges.iter().zip(changes).map(|(d, e)| turned.cross(d) + spin.cross(e)).collect();
            slopes.push(-on_edges.iter().sum::<Vector3<f64>>());
            slopes.extend(on_edges);
        }
        slopes
    }
}

/// Inverse of the tensor `sum |d|^2 I - d d^T` of the edges, which maps a moment to `w`.
fn inverse(edges: &[Vector3<f64>]) -> Matrix3<f64> {
    let tensor: Matrix3<f64> = edges.iter().map(|d| Matrix3::identity() * d.norm_squared() - d * d.transpose()).sum();
    tensor.try_inverse().unwrap_or_else(Matrix3::zeros)
}

impl Part for Motor {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&self.nodes());
    }

    fn place(&mut self, pattern: &Pattern) {
        let nodes = self.nodes();
        self.places = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| pattern.block(a, b))).collect();
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let torque = value_of(&self.name, &self.torque, at.time).map_err(Refusal::Load)?;
        let (d, nodes) = (self.dimension, self.nodes());
        for (&node, force) in nodes.iter().zip(self.forces(at.q_test)) {
            (0..d).for_each(|i| sums.load[node as usize * d + i] += torque * force[i]);
        }
        let Some(values) = sums.tangent.as_deref_mut() else { return Ok(()) };
        let factor = at.weight * at.derivative.placement().share * torque;
        for column in (0..nodes.len()).filter(|_| factor != 0.0) {
            for j in 0..d {
                for (row, slope) in self.slope(at.q_test, column, j).into_iter().enumerate() {
                    let block = self.places[row * nodes.len() + column];
                    (0..d).for_each(|i| values[block.at(i, j)] -= factor * slope[i]);
                }
            }
        }
        Ok(())
    }

    fn is_outside(&self) -> bool {
        true
    }

    fn readings(&self, _at: Pose, _velocity: &[f64], memory: &[f64]) -> Vec<f64> {
        memory.to_vec()
    }

    fn memory(&self) -> Vec<f64> {
        vec![0.0; 2]
    }

    fn after_step(&self, at: &Iterate, _memory: &[f64]) -> Result<PartStepResult, StepError> {
        let torque = value_of(&self.name, &self.torque, at.time)?;
        let d = self.dimension;
        let moved = |node: u32, i: usize| at.q_1[node as usize * d + i] - at.q_0[node as usize * d + i];
        let forces = self.forces(at.q_test);
        let work: f64 = self.nodes().iter().zip(&forces).map(|(&node, force)| (0..d).map(|i| force[i] * moved(node, i)).sum::<f64>()).sum();
        Ok(PartStepResult { memory: vec![torque, torque * work], ..PartStepResult::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::model::amplitude::Constant;

    #[test]
    fn it_has_the_torque_and_no_force_and_its_slope_is_its_derivative() {
        for (dimension, masters) in [(2, 3), (3, 4)] {
            for grounded in [true, false] {
                let all: Vec<u32> = (0..2 * masters).collect();
                let (first, second) = all.split_at(masters as usize);
                let second = if grounded { Vec::new() } else { second.to_vec() };
                let axis = if dimension == 2 { Vector3::z() } else { Vector3::new(1.0, 2.0, 2.0) / 3.0 };
                let shares = (dimension == 3 && !grounded).then(|| Vector3::new(0.3, -0.7, 0.5));
                let motor = Motor {
                    name: String::new(),
                    dimension,
                    sides: [first.to_vec(), second],
                    shares,
                    axis,
                    torque: Arc::new(Constant(1.0)),
                    places: Vec::new(),
                };
                let q: Vec<f64> = (0..all.len() * dimension).map(|k| (1.7 * k as f64).sin()).collect();
                let at = |node: u32| Vector3::from_fn(|i, _| if i < dimension { q[node as usize * dimension + i] } else { 0.0 });
                let forces = motor.forces(&q);
                let couple = motor.direction(&motor.edges(1, &q)).normalize();
                let moment =
                    |range: std::ops::Range<usize>| -> Vector3<f64> { range.map(|k| at(motor.nodes()[k]).cross(&forces[k])).sum() };
                assert!((moment(0..first.len()) - couple).norm() < 1e-13);
                if !grounded {
                    assert!(moment(0..forces.len()).norm() < 1e-13);
                }
                assert!(forces.iter().sum::<Vector3<f64>>().norm() < 1e-13);
                for column in 0..motor.nodes().len() {
                    for j in 0..dimension {
                        let slope = motor.slope(&q, column, j);
                        let sides = [1e-6, -1e-6].map(|h| {
                            let mut q = q.clone();
                            q[motor.nodes()[column] as usize * dimension + j] += h;
                            motor.forces(&q)
                        });
                        for (row, slope) in slope.iter().enumerate() {
                            assert!(((sides[0][row] - sides[1][row]) / 2e-6 - slope).norm() < 1e-7);
                        }
                    }
                }
            }
        }
    }
}
