//! A damper between two ends: nodes, means of boundaries, points of the ground.
//!
//! The force `F(s) e` opposes the relative speed `s = e.w` of the ends, with the direction `e` of the line between them and their relative
//! velocity `w`, both where forces act in the step. The forces on both ends are opposite and along their line: momenta are conserved unless
//! an end is on the ground. The heat is `dt F(s) s`, never negative, and equals the work of the forces if velocities are the change of
//! positions over the step. With the share `k` of the step and the derivative `c` of velocities with respect to positions,
//!
//! ```text
//! df/dr_1 = (F' e (x) (c e + k (w - s e)/|r|)) + F k (I - e (x) e)/|r|
//! ```

use super::force_laws::Viscous;
use super::line::{Line, LineDefinition, LineElement};
use crate::dynamics::model::part::{Change, Iterate, Part, PartStepResult, Pose, Refusal, Sums};
use crate::dynamics::model::quantity::Quantity;
use crate::dynamics::model::step_error::StepError;
use crate::linear::Pattern;

/// Damper between two ends.
pub type DamperDefinition = LineDefinition<DamperElement>;

/// Force law of a damper: force as a function of speed (per thickness in the plane).
#[derive(Clone, Debug, PartialEq)]
pub struct DamperElement(pub Viscous);

impl LineElement for DamperElement {
    const READINGS: &'static [Quantity] = &[Quantity::new("speed", "velocity"), Quantity::new("force", "force")];
    const DISSIPATES: bool = true;

    fn part(&self, _: &str, line: Line, _: f64, is_grounded: bool) -> Box<dyn Part> {
        Box::new(Damper { line, law: self.0.clone(), is_outside: is_grounded })
    }

    fn changed(&self, change: &Change) -> Self {
        let [_, length, time] = change.units;
        DamperElement(self.0.changed([length / time, change.force()]))
    }

    fn describe(&self, name: &str) -> String {
        format!("damper \"{name}\": {}", self.0.describe())
    }
}

/// A damper in global node numbers.
struct Damper {
    line: Line,
    law: Viscous,
    is_outside: bool,
}

/// Kinematics of a damper.
struct Stroke {
    /// Unit vector from tail to head.
    direction: [f64; 3],
    /// Distance of tail and head.
    length: f64,
    /// Relative velocity of the ends.
    velocity: [f64; 3],
    /// Component of the relative velocity along the damper.
    speed: f64,
}

impl Damper {
    /// Kinematics at positions `q` and velocities `v`; `None` where both ends coincide and have no direction.
    fn stroke(&self, q: &[f64], v: &[f64]) -> Option<Stroke> {
        let ((r, length), velocity) = (self.line.vector(q), self.line.velocity(v));
        let direction = r.map(|r| r / length);
        let speed = direction.iter().zip(velocity).map(|(e, w)| e * w).sum();
        (length > 0.0).then_some(Stroke { direction, length, velocity, speed })
    }
}

impl Part for Damper {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&self.line.nodes());
    }

    fn place(&mut self, pattern: &Pattern) {
        self.line.place(pattern);
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let Some(Stroke { direction: e, length, velocity, speed }) = self.stroke(at.q_test, at.velocity) else { return Ok(()) };
        let ((force, slope), share) = (self.law.force(speed), at.derivative.placement().share);
        let turning = share * force / length;
        let slope = |i: usize, j: usize| {
            let of_speed = at.velocity_slope * e[j] + share * (velocity[j] - speed * e[j]) / length;
            slope * e[i] * of_speed - turning * e[i] * e[j] + if i == j { turning } else { 0.0 }
        };
        self.line.add(at.weight, e.map(|e| force * e), slope, sums);
        Ok(())
    }

    fn is_outside(&self) -> bool {
        self.is_outside
    }

    fn readings(&self, at: Pose, velocity: &[f64], _memory: &[f64]) -> Vec<f64> {
        let speed = self.stroke(at.q, velocity).map_or(0.0, |stroke| stroke.speed);
        vec![speed, self.law.force(speed).0]
    }

    fn after_step(&self, at: &Iterate, _memory: &[f64]) -> Result<PartStepResult, StepError> {
        let power = self.stroke(at.q_test, at.velocity).map_or(0.0, |stroke| stroke.speed * self.law.force(stroke.speed).0);
        Ok(PartStepResult { dissipated: at.dt * power, ..PartStepResult::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::super::in_step::linearized;
    use super::super::line::End;
    use super::*;
    use crate::dynamics::model::part::Numbering;
    use crate::integrators::Derivative;
    use crate::linear::{Pattern, Vertex};

    #[test]
    fn its_tangent_is_its_derivative_and_its_heat_the_work() {
        let numbering = Numbering { dimension: 3, first: &[0], reference: &[] };
        let ends = [End::Mean(0, vec![(0, 0.25), (1, 0.75)]), End::Ground([0.2, 1.5, -0.3])];
        let law = Viscous::Power { coefficient: 2.0, exponent: 1.7, smoothing: 0.0 };
        let mut damper = Damper { line: Line::new(&ends, &numbering), law, is_outside: true };
        let pattern = Pattern::new(&[Vertex::coordinates(3); 2], [&[0u32, 1][..]].into_iter());
        damper.place(&pattern);
        let q_0 = [0.1, -0.2, 0.3, 1.0, 0.4, -0.5];
        let linearized = |q_1: &[f64]| linearized(&damper, &pattern, Derivative::DiscreteGradient, [&q_0, q_1], 0.1);
        let q_1: Vec<f64> = q_0.iter().enumerate().map(|(k, q)| q + 0.1 * (1.7 * k as f64).sin()).collect();
        let (force, values, heat) = linearized(&q_1);
        let work: f64 = force.iter().zip(q_1.iter().zip(q_0)).map(|(f, (b, a))| f * (b - a)).sum();
        assert!(heat > 0.0 && (work - heat).abs() < 1e-15);
        for column in 0..6 {
            let moved = |h: f64| {
                let mut q = q_1.clone();
                q[column] += h;
                linearized(&q).0
            };
            let (up, down) = (moved(1e-6), moved(-1e-6));
            for row in 0..6 {
                let entry = values[pattern.block(row as u32 / 3, column as u32 / 3).at(row % 3, column % 3)];
                assert!(((up[row] - down[row]) / 2e-6 - entry).abs() < 1e-7, "[{row}][{column}]");
            }
        }
    }
}
