//! Rotating frame: inertia forces on all masses where positions are relative to the frame.
//!
//! With the unit vector `n` of an axis through `c`, the angular velocity `w`, `r = x - c` and `P r = r - n (n.r)`, the force on every mass
//! is
//!
//! ```text
//! f = M (w^2 P r  -  2 w n x v  -  dw/dt n x r)         centrifugal, Coriolis, Euler force
//! ```
//!
//! with the mass matrix of the model: the motion satisfies the equations of a frame at rest, rotated. For constant `w` the centrifugal
//! force has the quadratic potential `-w^2 r.M P r / 2`, whose gradient at mid-step is a discrete gradient. For varying `w` its work is
//! that of a load, like that of the Euler force. The Coriolis force is normal to the velocity at which forces act, and does no work if that
//! is the mean velocity of the step. An equilibrium at given `w` includes the centrifugal force only. In axisymmetric models, whose axis
//! must be that of the frame, the two other forces act in the hoop direction, without motion.

use std::sync::Arc;

use super::time_values::value_of;
use crate::dynamics::model::amplitude::{Amplitude, Rescaled};
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, Pose, Refusal, Sums};
use crate::dynamics::model::step_error::StepError;
use crate::linear::{Block, NodeMatrix, Pattern};

/// Angular velocity of a rotating frame.
#[derive(Clone)]
pub enum Spin {
    /// Constant angular velocity `[1/time]`.
    Constant(f64),
    /// Angular velocity as a function of time `[1/time]`.
    Varying(Amplitude),
}

/// Rotating frame.
#[derive(Clone)]
pub struct RotatingFrameDefinition {
    /// Axis of rotation, of any length: the third axis in plane models, the axis of symmetry in axisymmetric ones.
    pub axis: [f64; 3],
    /// A point of the axis `[length]`.
    pub center: [f64; 3],
    /// Angular velocity about the axis.
    pub velocity: Spin,
}

const NAME: &str = "rotating frame";

impl PartDefinition for RotatingFrameDefinition {
    fn name(&self) -> &str {
        NAME
    }

    fn bodies(&self) -> Vec<usize> {
        Vec::new()
    }

    fn is_gyroscopic(&self) -> bool {
        true
    }

    fn functions(&self) -> Vec<Amplitude> {
        match &self.velocity {
            Spin::Constant(_) => Vec::new(),
            Spin::Varying(function) => vec![function.clone()],
        }
    }

    fn check(&self, _point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        let unsound = |reason: &str| {
            let (reason, remedy) = (reason.into(), "give the direction of the axis, such as `[0.0, 0.0, 1.0]`");
            Err(ModelError::Unsound { what: "frame", name: NAME.into(), reason, remedy })
        };
        if self.axis == [0.0; 3] { unsound("its axis has no direction") } else { Ok(()) }
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        let [x, y, z] = self.axis;
        let length = x.hypot(y).hypot(z);
        let axis = self.axis.map(|component| component / length);
        let (dimension, [x, y, z]) = (numbering.dimension, axis);
        let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
        let across = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 } - axis[i] * axis[j]));
        Box::new(RotatingFrame { dimension, center: self.center, cross, across, velocity: self.velocity.clone(), masses: Vec::new() })
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let [_, _, time] = change.units;
        let velocity = match &self.velocity {
            Spin::Constant(value) => Spin::Constant(value / time),
            Spin::Varying(function) => Spin::Varying(Rescaled::of(function, time, 1.0 / time)),
        };
        let axis = if change.is_plane { self.axis } else { (change.direction)(self.axis) };
        Arc::new(RotatingFrameDefinition { axis, center: (change.point)(self.center), velocity })
    }

    fn describe(&self) -> String {
        let velocity = match &self.velocity {
            Spin::Constant(value) => value.to_string(),
            Spin::Varying(function) => function.describe(),
        };
        format!("{NAME}: angular velocity {velocity} about {:?} through {:?}", self.axis, self.center)
    }
}

/// Matrix with 3 x 3 entries.
type Matrix = [[f64; 3]; 3];

/// Rotating frame in global node numbers.
struct RotatingFrame {
    dimension: usize,
    center: [f64; 3],
    /// Matrix of `n x`.
    cross: Matrix,
    /// Projection `P`.
    across: Matrix,
    velocity: Spin,
    /// Masses between nodes, with their blocks in the matrix.
    masses: Vec<(u32, u32, f64, Block)>,
}

impl RotatingFrame {
    /// Angular velocity, and its rate; the rate is 0 at rest.
    fn spin(&self, time: f64, is_still: bool) -> Result<[f64; 2], StepError> {
        match &self.velocity {
            Spin::Constant(value) => Ok([*value, 0.0]),
            Spin::Varying(function) => {
                let failed = |source| StepError::Amplitude { boundary: NAME.into(), time, source };
                let rate = if is_still { 0.0 } else { function.rate(time).map_err(failed)? };
                Ok([value_of(NAME, function, time)?, rate])
            }
        }
    }

    /// Vector from the center to a node.
    fn arm(&self, q: &[f64], node: u32) -> [f64; 3] {
        let mut arm = vector(self.dimension, q, node);
        (0..self.dimension).for_each(|i| arm[i] -= self.center[i]);
        arm
    }
}

fn vector(dimension: usize, values: &[f64], node: u32) -> [f64; 3] {
    let mut vector = [0.0; 3];
    vector[..dimension].copy_from_slice(&values[node as usize * dimension..][..dimension]);
    vector
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Part for RotatingFrame {
    fn for_each_coupling(&self, _visit: &mut dyn FnMut(&[u32])) {
        // The body couples nodes with a common mass already.
    }

    fn weigh(&mut self, mass: &NodeMatrix) {
        let masses = mass.entries().filter(|(.., mass)| *mass != 0.0);
        self.masses = masses.map(|(row, column, mass)| (row, column, mass, Block::default())).collect();
    }

    fn place(&mut self, pattern: &Pattern) {
        self.masses.iter_mut().for_each(|(row, column, _, block)| *block = pattern.block(*row, *column));
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let (d, share) = (self.dimension, at.derivative.placement().share);
        let [speed, rate] = self.spin(at.time, at.is_still).map_err(Refusal::Load)?;
        let combined = |of: [f64; 2]| -> Matrix {
            std::array::from_fn(|i| std::array::from_fn(|j| of[0] * self.across[i][j] + of[1] * self.cross[i][j]))
        };
        let (outward, sideways) = (combined([speed * speed, -rate]), combined([0.0, 2.0 * speed]));
        let is_potential = matches!(self.velocity, Spin::Constant(_));
        for &(row, column, mass, ref block) in &self.masses {
            let (r, v, first) = (self.arm(at.q_test, column), vector(d, at.velocity, column), row as usize * d);
            for i in 0..d {
                let push = mass * dot(&outward[i], &r);
                sums.internal[first + i] += at.weight * mass * dot(&sideways[i], &v);
                if is_potential {
                    sums.internal[first + i] -= at.weight * push;
                } else {
                    sums.load[first + i] += push;
                }
            }
            if let Some(values) = sums.tangent.as_deref_mut() {
                for (i, j) in (0..d).flat_map(|i| (0..d).map(move |j| (i, j))) {
                    values[block.at(i, j)] += at.weight * mass * (at.velocity_slope * sideways[i][j] - share * outward[i][j]);
                }
            }
        }
        Ok(())
    }

    fn energy(&self, at: Pose, _memory: &[f64]) -> f64 {
        let Spin::Constant(speed) = self.velocity else { return 0.0 };
        let mut sum = 0.0;
        for &(row, column, mass, _) in &self.masses {
            let (a, b) = (self.arm(at.q, row), self.arm(at.q, column));
            sum += mass * (0..3).map(|i| a[i] * dot(&self.across[i], &b)).sum::<f64>();
        }
        -0.5 * speed * speed * sum
    }

    fn is_outside(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::in_step::linearized;
    use super::*;
    use crate::dynamics::model::amplitude::Sine;
    use crate::integrators::Derivative;
    use crate::linear::Vertex;

    /// Two nodes with a consistent mass.
    fn frame(dimension: usize, velocity: Spin) -> (Box<dyn Part>, Pattern) {
        let pattern = Pattern::new(&[Vertex::coordinates(dimension as u8); 2], [&[0u32, 1][..]].into_iter());
        let axis = if dimension == 2 { [0.0, 0.0, 2.0] } else { [1.0, -2.0, 0.5] };
        let definition = RotatingFrameDefinition { axis, center: [0.3, -0.1, 0.0], velocity };
        let reference = vec![0.0; 2 * dimension];
        let mut part = definition.part(&Numbering { dimension, first: &[0], reference: &reference });
        let mut mass = NodeMatrix::new(&pattern, 2);
        [(0, 0, 2.0), (0, 1, 0.7), (1, 0, 0.7), (1, 1, 1.5)].into_iter().for_each(|(row, column, value)| mass.add(row, column, value));
        part.weigh(&mass);
        part.place(&pattern);
        (part, pattern)
    }

    #[test]
    fn the_force_of_a_step_does_the_work_of_the_potential_and_every_tangent_is_its_derivative() {
        let all: [f64; 6] = [0.1, -0.2, 0.3, 1.0, 0.4, -0.5];
        for dimension in [2, 3] {
            let (q_0, dt) = (&all[..2 * dimension], 0.3);
            let q_1: Vec<f64> = q_0.iter().enumerate().map(|(k, q)| q + 0.4 * (1.7 * k as f64).sin()).collect();
            for velocity in [Spin::Constant(1.3), Spin::Varying(Arc::new(Sine { amplitude: 2.0, frequency: 0.4 }))] {
                let is_constant = matches!(velocity, Spin::Constant(_));
                let (part, pattern) = frame(dimension, velocity);
                for derivative in Derivative::ALL {
                    let (force, tangent, _) = linearized(&*part, &pattern, derivative, [q_0, &q_1], dt);
                    let work: f64 = force.iter().zip(q_1.iter().zip(q_0)).map(|(f, (b, a))| f * (b - a)).sum();
                    let energy = |q| part.energy(Pose { q, u: q }, &[]);
                    let is_exact = derivative.placement().share == 0.5;
                    assert!(!is_exact || (work - (energy(&q_1) - energy(q_0))).abs() < 1e-14, "{work}");
                    for column in (0..2 * dimension).filter(|_| is_constant) {
                        let moved = |h: f64| {
                            let mut q = q_1.clone();
                            q[column] += h;
                            linearized(&*part, &pattern, derivative, [q_0, &q], dt).0
                        };
                        // Forces are linear in positions.
                        let (up, down) = (moved(1.0), moved(-1.0));
                        for row in 0..2 * dimension {
                            let block = pattern.block((row / dimension) as u32, (column / dimension) as u32);
                            let slope = 0.5 * (up[row] - down[row]);
                            assert!((slope - tangent[block.at(row % dimension, column % dimension)]).abs() < 1e-12, "[{row}][{column}]");
                        }
                    }
                }
            }
        }
    }
}
