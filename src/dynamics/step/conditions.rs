//! The conditions that contact pairs put on a step, by their update rules.

use super::start::StepStart;
use super::system::System;
use crate::dynamics::model::update_rules::Holds;
use crate::dynamics::parts::contact_pair::{ContactPair, Hold};
use crate::integrators::Derivative;

/// The contact conditions of a step: `Phi_A(q_1) >= target_A` for the members, with a multiplier that presses or is zero.
pub struct Conditions {
    /// Weighted gaps at the start of the step.
    pub gap_n: Vec<f64>,
    /// What the weighted gap of an active node is at the end of the step.
    pub targets: Vec<f64>,
    /// Whether a node takes part in this step.
    pub members: Vec<bool>,
    /// Weighted gap per change of the multiplier within an iteration, `1/kappa_A`: 0 but for augmented Lagrange.
    pub compliance: Vec<f64>,
    /// Penalty pressures belong to the end of the step (statics, trapezoidal rule) instead of to its change of energy.
    pub end_point: bool,
    /// By how much a penalty potential feels the weighted gaps larger than they are: an overlap that no motion has made, but that pairs
    /// find which take part in this step and took none in the one before, has no potential.
    pub shift: Vec<f64>,
}

impl Conditions {
    /// Pressure of a penalty potential of stiffness `kappa` at a constraint whose weighted gap is `gap`, and its derivative.
    pub fn penalty_pressure(&self, kappa: f64, row: usize, gap: f64) -> (f64, f64) {
        // From a start at zero the quotient is half the pressure of the end.
        if self.end_point {
            penalty_pressure(2.0 * kappa, 0.0, gap)
        } else {
            penalty_pressure(kappa, self.gap_n[row], gap + self.shift[row])
        }
    }
}

impl<const D: usize> System<D> {
    /// Inverse augmentation of every constraint row in a step.
    pub fn compliance(&self, start: &StepStart) -> Vec<f64> {
        let factor = |pair: &ContactPair| match pair.hold {
            Hold::Augmented { factor } => Some(factor),
            Hold::Multiplier | Hold::Penalty => None,
        };
        if self.pairs.iter().all(|pair| factor(pair).is_none()) {
            return vec![0.0; self.multipliers];
        }
        let mut compliance = self.row_stiffness(start);
        for pair in &self.pairs {
            let rows = &mut compliance[pair.rows.clone()];
            rows.iter_mut().for_each(|row| *row = factor(pair).map_or(0.0, |factor| 1.0 / (factor * *row)));
        }
        compliance
    }

    /// Pressure per weighted gap with which the node of every constraint row resists, by its stiffness and its inertia in a step.
    pub fn row_stiffness(&self, start: &StepStart) -> Vec<f64> {
        let mut stiffness = Vec::with_capacity(self.multipliers);
        for pair in &self.pairs {
            stiffness.extend(pair.rows.clone().zip(pair.kernel.weights()).map(|(row, weight)| {
                let inertia = pair.node_of(row).map_or(0.0, |node| {
                    let node = node as usize;
                    let body = self.bodies.iter().position(|body| body.nodes.contains(&node)).expect("every node belongs to a body");
                    start.inertia(body) * self.nodes.lumped_mass[node] / weight.powi(2)
                });
                pair.c + inertia
            }));
        }
        stiffness
    }

    /// Weighted gaps of closed constraints: zero, but for corners.
    pub fn closed_gaps(&self) -> Vec<f64> {
        let of = |pair: &ContactPair| -> Vec<f64> {
            let Some(corners) = pair.corners else { return vec![0.0; pair.kernel.weights().len()] };
            pair.kernel.weights().iter().zip(pair.kernel.slacks()).map(|(weight, slack)| -corners.slack * slack * weight).collect()
        };
        self.pairs.iter().flat_map(of).collect()
    }

    /// The contact conditions of the step that has begun, by the pairs' update rules; `felt` are the weighted gaps that penalty potentials
    /// felt at the end of the step before.
    ///
    /// Whatever the rule, the target of a unilateral constraint is not above the gap at the start where that is an overlap: contact drives
    /// nothing apart, its work `lambda (target - Phi_n)` is never positive.
    pub fn conditions(&self, start: &StepStart, felt: &[f64]) -> Conditions {
        let mut gap_n: Vec<f64> = self.pairs.iter().flat_map(|pair| pair.kernel.start_gap()).collect();
        let held = self.closed_gaps();
        let mut targets = vec![0.0; gap_n.len()];
        let mut members: Vec<bool> = self.redundant.iter().map(|is_redundant| !is_redundant).collect();
        let mut shift = vec![0.0; gap_n.len()];
        let end_point = start.derivative() == Derivative::AT_END;
        for pair in &self.pairs {
            let closed = pair.closed();
            for row in pair.rows.clone() {
                let held = held[row];
                if !pair.has_multipliers() {
                    if !end_point {
                        shift[row] = (felt[row].min(0.0) - gap_n[row].min(0.0)).max(0.0);
                        gap_n[row] += shift[row];
                    }
                } else if pair.update.holds == Holds::AsItIs {
                    members[row] &= pair.equality || gap_n[row] <= held + closed;
                    targets[row] = gap_n[row];
                } else if !pair.equality {
                    targets[row] = gap_n[row].min(held);
                }
            }
        }
        Conditions { gap_n, targets, members, compliance: self.compliance(start), end_point, shift }
    }
}

/// Pressure of the penalty potential `kappa/2 min(Phi, 0)^2` over a step, `-(U_1 - U_0)/(Phi_1 - Phi_0)`, and its derivative with respect
/// to `Phi_1`.
fn penalty_pressure(kappa: f64, gap_n: f64, gap: f64) -> (f64, f64) {
    if gap_n <= 0.0 && gap <= 0.0 {
        (-0.5 * kappa * (gap_n + gap), -0.5 * kappa)
    } else if gap_n >= 0.0 && gap >= 0.0 {
        (0.0, 0.0)
    } else {
        // One end is open: the numerator is the other end's potential.
        let (step, closed) = (gap - gap_n, gap.min(0.0).powi(2) - gap_n.min(0.0).powi(2));
        (-0.5 * kappa * closed / step, -0.5 * kappa * (2.0 * gap.min(0.0) - closed / step) / step)
    }
}

#[cfg(test)]
mod tests {
    use super::penalty_pressure;

    #[test]
    fn penalty_pressure_does_the_work_of_its_potential_and_has_an_exact_derivative() {
        let energy = |gap: f64| 0.5 * 3.0 * gap.min(0.0).powi(2);
        for (gap_n, gap) in [(-0.3, -0.1), (-0.3, 0.2), (0.4, -0.1), (0.4, 0.2), (0.0, -0.2), (-0.2, 0.0)] {
            let (pressure, slope) = penalty_pressure(3.0, gap_n, gap);
            assert!((pressure * (gap - gap_n) + energy(gap) - energy(gap_n)).abs() < 1e-16);
            assert!(pressure >= 0.0);
            let h = 1e-6;
            let difference = (penalty_pressure(3.0, gap_n, gap + h).0 - penalty_pressure(3.0, gap_n, gap - h).0) / (2.0 * h);
            // At a kink (gap = 0) the two sides differ by order kappa h.
            assert!((difference - slope).abs() < 1e-5, "{gap_n} {gap}: {difference} {slope}");
        }
    }
}
