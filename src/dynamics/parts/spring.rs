//! A linear spring between two nodes.
//!
//! `V = k/2 (l - L)^2` of the distance `l = |r|`, `r = x_b - x_a`. It is a function of the quadratic invariant `pi = r.r`, so its discrete
//! gradient is the quotient `g = (V_1 - V_0) / (pi_1 - pi_0)`, in which nothing cancels:
//!
//! ```text
//! g = k/2 (1 - 2 L / (l_0 + l_1)),    f = 2 g r_mid,    df/dr_1 = g I + 4 T r_mid r_1^T,    T = k L / (2 l_1 (l_0 + l_1)^2)
//! ```
//!
//! It does exactly the work by which `V` changes, pulls both nodes with opposite forces along the line of `r_mid`, and keeps both momenta.

use std::sync::Arc;

use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, Pose, Refusal, Sums};
use crate::integrators::{Configuration, Derivative};
use crate::linear::{Block, Pattern};

/// A spring between two nodes of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringDefinition {
    /// Name, unique among the parts.
    pub name: String,
    /// Its ends: body and node of the body's mesh.
    pub ends: [(usize, u32); 2],
    /// Stiffness `k` `[force/length]` (per thickness in the plane).
    pub stiffness: f64,
    /// Length `L` at which it does not pull `[length]`; `None`: its length in the undeformed bodies.
    pub rest_length: Option<f64>,
}

impl PartDefinition for SpringDefinition {
    fn name(&self) -> &str {
        &self.name
    }

    fn bodies(&self) -> Vec<usize> {
        self.ends.map(|(body, _)| body).to_vec()
    }

    fn check(&self, point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        let [a, b] = self.ends.map(|(body, node)| point(body, node));
        if a == b { Err(ModelError::SpringOfNoLength { spring: self.name.clone() }) } else { Ok(()) }
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        let nodes = self.ends.map(|(body, node)| numbering.first[body] as u32 + node);
        let mut spring =
            Spring { dimension: numbering.dimension, nodes, stiffness: self.stiffness, rest_length: 0.0, places: Default::default() };
        spring.rest_length = self.rest_length.unwrap_or_else(|| spring.vector(numbering.reference).1);
        Box::new(spring)
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let [mass, length, time] = change.units;
        Arc::new(SpringDefinition {
            stiffness: self.stiffness * mass / (time * time) / if change.is_plane { length } else { 1.0 },
            rest_length: self.rest_length.map(|rest| length * rest),
            ..self.clone()
        })
    }

    fn describe(&self) -> String {
        let rest = self.rest_length.map_or("its length at the start".into(), |length| format!("{length}"));
        format!("spring \"{}\": stiffness {}, at rest at {rest}", self.name, self.stiffness)
    }
}

/// A spring in the numbering of the model.
struct Spring {
    dimension: usize,
    nodes: [u32; 2],
    stiffness: f64,
    rest_length: f64,
    /// Blocks of the nodes, row by row.
    places: [Block; 4],
}

impl Spring {
    /// `r` and its length; in the plane the third component is zero.
    fn vector(&self, q: &[f64]) -> ([f64; 3], f64) {
        let [a, b] = self.nodes.map(|node| node as usize * self.dimension);
        let mut r = [0.0; 3];
        (0..self.dimension).for_each(|i| r[i] = q[b + i] - q[a + i]);
        (r, r[0].hypot(r[1]).hypot(r[2]))
    }

    /// `1 - L/l`, where two nodes have come together as in a spring without a length at rest.
    fn stretch(&self, length: f64) -> f64 {
        if length > 0.0 { 1.0 - self.rest_length / length } else { 1.0 }
    }
}

impl Part for Spring {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&self.nodes);
    }

    fn place(&mut self, pattern: &Pattern) {
        self.places = std::array::from_fn(|k| pattern.block(self.nodes[k / 2], self.nodes[k % 2]));
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let ((r_0, l_0), (r_1, l_1)) = (self.vector(at.q_0), self.vector(at.q_1));
        let middle: [f64; 3] = std::array::from_fn(|i| 0.5 * (r_0[i] + r_1[i]));
        let k = self.stiffness;
        // f = force r_test, df/dr_1 = isotropic I + along r_test r_trial^T
        let (force, isotropic, along, r_test, r_trial) = match at.derivative {
            Derivative::DiscreteGradient => {
                let (sum, g) = (l_0 + l_1, 0.5 * k * self.stretch(0.5 * (l_0 + l_1)));
                let slope = if l_1 > 0.0 { 0.5 * k * self.rest_length / (l_1 * sum * sum) } else { 0.0 };
                (2.0 * g, g, 4.0 * slope, middle, r_1)
            }
            Derivative::Gradient(configuration) => {
                let r = if configuration == Configuration::Middle { middle } else { r_1 };
                let l = r[0].hypot(r[1]).hypot(r[2]);
                let (pull, share) = (k * self.stretch(l), configuration.share());
                (pull, share * pull, if l > 0.0 { share * k * self.rest_length / l.powi(3) } else { 0.0 }, r, r)
            }
        };
        let [a, b] = self.nodes.map(|node| node as usize * self.dimension);
        for i in 0..self.dimension {
            let f = at.weight * force * r_test[i];
            sums.internal[a + i] -= f;
            sums.internal[b + i] += f;
        }
        let Some(values) = sums.tangent.as_deref_mut() else { return Ok(()) };
        for (block, sign) in self.places.iter().zip([1.0, -1.0, -1.0, 1.0]) {
            for i in 0..self.dimension {
                for j in 0..self.dimension {
                    let slope = along * r_test[i] * r_trial[j] + if i == j { isotropic } else { 0.0 };
                    values[block.at(i, j)] += sign * at.weight * slope;
                }
            }
        }
        Ok(())
    }

    fn energy(&self, at: Pose, _memory: &[f64]) -> f64 {
        0.5 * self.stiffness * (self.vector(at.q).1 - self.rest_length).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::Vertex;
    use crate::math::workers::Workers;

    /// Force and tangent (row by row of both nodes) of a spring of stiffness 3 and rest length 0.7 in a step.
    fn linearized(dimension: usize, derivative: Derivative, q_0: &[f64], q_1: &[f64]) -> (Vec<f64>, Vec<f64>, Spring) {
        let pattern = Pattern::new(&[Vertex::coordinates(dimension as u8); 2], [&[0u32, 1][..]].into_iter());
        let mut spring = Spring { dimension, nodes: [0, 1], stiffness: 3.0, rest_length: 0.7, places: Default::default() };
        spring.place(&pattern);
        let (mut internal, mut load, mut values) = (vec![0.0; q_0.len()], vec![0.0; q_0.len()], vec![0.0; pattern.values()]);
        let (u_0, u_1, inertia) = (q_0, q_1, &[][..]);
        let (velocity, velocity_slope) = (q_1, 0.0);
        let at =
            Iterate { derivative, weight: 1.0, time: 0.0, dt: 0.1, q_0, q_1, u_0, u_1, q_test: q_1, velocity, velocity_slope, inertia };
        let mut sums = Sums { internal: &mut internal, load: &mut load, tangent: Some(&mut values), workers: &Workers::new(1) };
        assert!(spring.linearize(&at, &[], &mut sums).is_ok());
        let count = 2 * dimension;
        let entry = |row: usize, column: usize| {
            let block = pattern.block((row / dimension) as u32, (column / dimension) as u32);
            values[block.at(row % dimension, column % dimension)]
        };
        let tangent = (0..count * count).map(|k| entry(k / count, k % count)).collect();
        (internal, tangent, spring)
    }

    #[test]
    fn a_discrete_gradient_does_the_work_of_the_potential_and_every_tangent_is_its_derivative() {
        let q_0 = [0.1, -0.2, 0.3, 1.0, 0.4, -0.5];
        for dimension in [2, 3] {
            for size in [1e-9, 1e-3, 0.4] {
                let q_0 = &q_0[..2 * dimension];
                let q_1: Vec<f64> = q_0.iter().enumerate().map(|(k, q)| q + size * (1.7 * k as f64).sin()).collect();
                for derivative in Derivative::ALL {
                    let (force, tangent, spring) = linearized(dimension, derivative, q_0, &q_1);
                    let work: f64 = force.iter().zip(q_1.iter().zip(q_0)).map(|(f, (b, a))| f * (b - a)).sum();
                    let gained = spring.energy(Pose { q: &q_1, u: &q_1 }, &[]) - spring.energy(Pose { q: q_0, u: q_0 }, &[]);
                    assert!(derivative != Derivative::DiscreteGradient || (work - gained).abs() < 1e-15, "{work} {gained}");
                    let count = 2 * dimension;
                    for column in 0..count {
                        let moved = |h: f64| {
                            let mut q = q_1.clone();
                            q[column] += h;
                            linearized(dimension, derivative, q_0, &q).0
                        };
                        let (up, down) = (moved(1e-6), moved(-1e-6));
                        for row in 0..count {
                            let slope = (up[row] - down[row]) / 2e-6;
                            // Truncation 1e-12, round-off 1e-10.
                            assert!((slope - tangent[row * count + column]).abs() < 1e-8, "{derivative:?} [{row}][{column}]");
                        }
                    }
                }
            }
        }
    }
}
