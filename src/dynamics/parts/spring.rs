//! A spring between two ends: nodes, means of boundaries, points of the ground.
//!
//! The potential `V(x)` depends on the elongation `x = l - L`, with the distance `l = |r|`, `r = x_b - x_a`. As a function of the quadratic
//! invariant `pi = r.r` its discrete gradient is the quotient `g = (V_1 - V_0) / (pi_1 - pi_0) = F / (l_0 + l_1)`, with the mean force `F`
//! over the step ([`super::force_laws`]). For a linear spring, `V = k/2 x^2`,
//!
//! ```text
//! g = k/2 (1 - 2 L / (l_0 + l_1)),    f = 2 g r_mid,    df/dr_1 = g I + 4 T r_mid r_1^T,    T = k L / (2 l_1 (l_0 + l_1)^2)
//! ```
//!
//! The work of this force equals the change of `V`. The forces on both ends are opposite and along `r_mid`: linear and angular momentum are
//! conserved unless an end is on the ground.

use super::force_laws::SpringLaw;
use super::line::{Line, LineDefinition, LineElement};
use crate::dynamics::model::part::{Change, Iterate, Part, Pose, Refusal, Sums};
use crate::dynamics::model::quantity::Quantity;
use crate::integrators::{Configuration, Derivative};
use crate::linear::Pattern;

/// A spring between two ends.
pub type SpringDefinition = LineDefinition<SpringElement>;

/// Force law of a spring.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringElement {
    /// Elastic force law (per thickness in the plane).
    pub law: SpringLaw,
    /// Rest length `L` `[length]`; `None`: the length in the undeformed bodies.
    pub rest_length: Option<f64>,
}

impl LineElement for SpringElement {
    const READINGS: &'static [Quantity] =
        &[Quantity::new("length", "length"), Quantity::new("force", "force"), Quantity::new("energy", "energy")];

    fn part(&self, _: &str, line: Line, at_rest: f64, is_grounded: bool) -> Box<dyn Part> {
        let rest_length = self.rest_length.unwrap_or(at_rest);
        Box::new(Spring { line, law: self.law.clone(), rest_length, is_outside: is_grounded })
    }

    fn changed(&self, change: &Change) -> Self {
        let length = change.units[1];
        SpringElement {
            law: self.law.changed([length, change.force(), change.stiffness()]),
            rest_length: self.rest_length.map(|rest| length * rest),
        }
    }

    fn describe(&self, name: &str) -> String {
        let rest = self.rest_length.map_or("its length at the start".into(), |length| format!("{length}"));
        format!("spring \"{name}\": {}, at rest at {rest}", self.law.describe())
    }
}

/// A spring in global node numbers.
struct Spring {
    line: Line,
    law: SpringLaw,
    rest_length: f64,
    is_outside: bool,
}

/// Force `pull r_test` of a spring, and its derivative `isotropic I + along r_test r_trial^T` with respect to `r_1`.
pub(super) struct SpringForce {
    pull: f64,
    isotropic: f64,
    along: f64,
    test: [f64; 3],
    trial: [f64; 3],
}

impl SpringForce {
    /// Adds the force along a line and its derivative.
    pub(super) fn add(&self, line: &Line, weight: f64, sums: &mut Sums) {
        let &SpringForce { pull, isotropic, along, test, trial } = self;
        let slope = |i: usize, j: usize| along * test[i] * trial[j] + if i == j { isotropic } else { 0.0 };
        line.add(weight, test.map(|r| pull * r), slope, sums);
    }
}

/// Force of a linear spring with the stiffness `k` and the rest length `rest`, from the vectors between its ends and their lengths at start
/// and end of a step.
pub(super) fn linear_pull(k: f64, rest: f64, derivative: Derivative, [(r_0, l_0), (r_1, l_1)]: [([f64; 3], f64); 2]) -> SpringForce {
    let middle: [f64; 3] = std::array::from_fn(|i| 0.5 * (r_0[i] + r_1[i]));
    // Coinciding ends: as with zero rest length.
    let stretch = |length: f64| if length > 0.0 { 1.0 - rest / length } else { 1.0 };
    match derivative {
        Derivative::DiscreteGradient => {
            let (sum, g) = (l_0 + l_1, 0.5 * k * stretch(0.5 * (l_0 + l_1)));
            let slope = if l_1 > 0.0 { 0.5 * k * rest / (l_1 * sum * sum) } else { 0.0 };
            SpringForce { pull: 2.0 * g, isotropic: g, along: 4.0 * slope, test: middle, trial: r_1 }
        }
        Derivative::Gradient(configuration) => {
            let r = if configuration == Configuration::Middle { middle } else { r_1 };
            let l = r[0].hypot(r[1]).hypot(r[2]);
            let (pull, share) = (k * stretch(l), configuration.share());
            let along = if l > 0.0 { share * k * rest / l.powi(3) } else { 0.0 };
            SpringForce { pull, isotropic: share * pull, along, test: r, trial: r }
        }
    }
}

impl Spring {
    /// Force of a spring with any law, and its derivative; zero direction if the ends coincide.
    fn general(&self, derivative: Derivative, [(r_0, l_0), (r_1, l_1)]: [([f64; 3], f64); 2]) -> SpringForce {
        let middle: [f64; 3] = std::array::from_fn(|i| 0.5 * (r_0[i] + r_1[i]));
        let (share, test, trial, length, (force, slope)) = match derivative {
            Derivative::DiscreteGradient => {
                // Force F / ((l_0 + l_1)/2) r_mid; the mean distance depends on l_1 by one half.
                let mean = self.law.mean(l_0 - self.rest_length, l_1 - self.rest_length);
                (0.5, middle, r_1, 0.5 * (l_0 + l_1), (mean.0, 2.0 * mean.1))
            }
            Derivative::Gradient(configuration) => {
                let r = if configuration == Configuration::Middle { middle } else { r_1 };
                let l = r[0].hypot(r[1]).hypot(r[2]);
                (configuration.share(), r, r, l, self.law.force(l - self.rest_length))
            }
        };
        let along_by = if derivative == Derivative::DiscreteGradient { l_1 } else { length };
        if length == 0.0 || along_by == 0.0 {
            return SpringForce { pull: slope, isotropic: share * slope, along: 0.0, test, trial };
        }
        let pull = force / length;
        SpringForce { pull, isotropic: share * pull, along: share * (slope - pull) / (length * along_by), test, trial }
    }
}

impl Part for Spring {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&self.line.nodes());
    }

    fn place(&mut self, pattern: &Pattern) {
        self.line.place(pattern);
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let vectors = [at.q_0, at.q_1].map(|q| self.line.vector(q));
        let pull = match self.law.constant_stiffness() {
            Some(stiffness) => linear_pull(stiffness, self.rest_length, at.derivative, vectors),
            None => self.general(at.derivative, vectors),
        };
        pull.add(&self.line, at.weight, sums);
        Ok(())
    }

    fn energy(&self, at: Pose, _memory: &[f64]) -> f64 {
        self.law.energy(self.line.vector(at.q).1 - self.rest_length)
    }

    fn is_outside(&self) -> bool {
        self.is_outside
    }

    fn readings(&self, at: Pose, _velocity: &[f64], memory: &[f64]) -> Vec<f64> {
        let length = self.line.vector(at.q).1;
        vec![length, self.law.force(length - self.rest_length).0, self.energy(at, memory)]
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::in_step;
    use super::super::line::End;
    use super::*;
    use crate::dynamics::model::part::Numbering;
    use crate::dynamics::parts::force_laws::{Elastic, Sides};
    use crate::linear::Vertex;

    /// Force and tangent (row by row over both nodes) of a spring of rest length 0.7 in a step.
    fn linearized(law: &SpringLaw, dimension: usize, derivative: Derivative, q_0: &[f64], q_1: &[f64]) -> (Vec<f64>, Vec<f64>, Spring) {
        let pattern = Pattern::new(&[Vertex::coordinates(dimension as u8); 2], [&[0u32, 1][..]].into_iter());
        let numbering = Numbering { dimension, first: &[0], reference: q_0 };
        let line = Line::new(&[End::Node(0, 0), End::Node(0, 1)], &numbering);
        let mut spring = Spring { line, law: law.clone(), rest_length: 0.7, is_outside: false };
        spring.place(&pattern);
        let (internal, values, _) = in_step::linearized(&spring, &pattern, derivative, [q_0, q_1], 0.1);
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
        let table = Elastic::Table(Arc::new(vec![(-0.5, -2.0), (0.2, 0.1), (0.5, 3.0), (0.6, 4.0)]));
        let laws = [SpringLaw::linear(3.0), SpringLaw { elastic: table, sides: Sides::Tension }];
        laws.iter().for_each(check_law);
    }

    fn check_law(law: &SpringLaw) {
        let q_0 = [0.1, -0.2, 0.3, 1.0, 0.4, -0.5];
        for dimension in [2, 3] {
            for size in [1e-9, 1e-3, 0.4] {
                let q_0 = &q_0[..2 * dimension];
                let q_1: Vec<f64> = q_0.iter().enumerate().map(|(k, q)| q + size * (1.7 * k as f64).sin()).collect();
                for derivative in Derivative::ALL {
                    let (force, tangent, spring) = linearized(law, dimension, derivative, q_0, &q_1);
                    let work: f64 = force.iter().zip(q_1.iter().zip(q_0)).map(|(f, (b, a))| f * (b - a)).sum();
                    let gained = spring.energy(Pose { q: &q_1, u: &q_1 }, &[]) - spring.energy(Pose { q: q_0, u: q_0 }, &[]);
                    assert!(derivative != Derivative::DiscreteGradient || (work - gained).abs() < 1e-15, "{work} {gained}");
                    let count = 2 * dimension;
                    for column in 0..count {
                        let moved = |h: f64| {
                            let mut q = q_1.clone();
                            q[column] += h;
                            linearized(law, dimension, derivative, q_0, &q).0
                        };
                        let (up, down) = (moved(1e-6), moved(-1e-6));
                        for row in 0..count {
                            let slope = (up[row] - down[row]) / 2e-6;
                            // Errors of the difference quotient: truncation 1e-12, round-off 1e-10.
                            assert!((slope - tangent[row * count + column]).abs() < 1e-8, "{derivative:?} [{row}][{column}]");
                        }
                    }
                }
            }
        }
    }
}
