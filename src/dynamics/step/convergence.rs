//! Termination of the iterations of one attempt: converged, continued or given up.

use crate::math::tolerances::EXACT;

/// Energy relative to its tolerance up to which a residual that does not decrease any more may be round-off.
const STALLED: f64 = 100.0;

/// Residual relative to the round-off of the forces up to which one iteration without a decrease shows round-off: a friction law with an
/// inexact tangent converges so slowly that the energy may rise once far above it.
const NEAR_ROUND_OFF: f64 = 100.0;

/// Number of successive iterations without a decrease that show round-off of an energy that may be round-off by its size, for any residual.
const FLAT: usize = 3;

/// Ratio to the last iteration's energy above which an energy that may be round-off by its size counts as no longer decreasing.
const FALLING: f64 = 0.5;
/// Ratio to the last iteration's energy above which the energy counts as no longer decreasing, if the residual alone indicates round-off.
/// An iteration with an inexact tangent may reduce it by as little as a tenth, and an energy that still decreases is no round-off.
const FALLING_FAR: f64 = 0.9;

/// Growth of the number of iterations while the last one reduces the energy error and meets all other criteria, or while the last [`SOME`]
/// iterations reduce the product of energy error and violation to [`TENTH`]. Stacks of rigid bodies that begin without multipliers, and
/// friction that decreases with the speed, take 30 (`tests/scripts/rigid_friction_in_space.rhai`).
const LONGER: usize = 3;
/// Reduction of the product of energy error and violation in [`SOME`] iterations that permits more iterations.
const TENTH: f64 = 0.1;
/// Number of iterations for the reduction [`TENTH`].
const SOME: usize = 4;

/// Iteration from which an energy below the round-off of contact forces is accepted although it still falls: the next linear solve of
/// redundant constraints may increase it again.
const LATE: usize = 12;

/// Ratio to the least distance from a solution that counts as nearer.
const NEARER: f64 = 0.7;
/// Number of iterations without coming nearer after which an attempt is given up: a cycling attempt would use all its iterations. A smaller
/// number leads to other attempts too early, which may find another solution.
const MAX_IDLE: usize = 8;

/// Residuals, energies and active set changes of one Newton iteration.
#[derive(Clone, Debug, Default)]
pub struct Iteration {
    /// Largest component of the residual.
    pub residual: f64,
    /// Unknown with the largest residual.
    pub worst: usize,
    /// Force by which residuals are judged in this iteration.
    pub target: f64,
    /// Round-off of the forces: a residual below it need not decrease `[force]`.
    pub floor: f64,
    /// Number of successive iterations without a decrease of the energy after which a residual below the floor is accepted.
    pub stalls: usize,
    /// Residual that terminates a step at rest, for any energy; 0 in motion.
    pub enough: f64,
    /// Energy error of the iterate relative to its tolerance: work of the residual along the displacement in the step, plus the energy of
    /// the violated contact conditions.
    pub energy: f64,
    /// Energy of contact forces times the round-off of positions, relative to the energy tolerance.
    pub round_off: f64,
    /// Largest violation of the contact conditions, relative to its tolerance.
    pub violation: f64,
    /// Constraint with the largest violation.
    pub worst_row: usize,
    /// Constraints whose contact state changed.
    pub changed: Vec<usize>,
    /// Active contact nodes.
    pub active: usize,
}

/// Convergence history of an attempt.
pub struct Convergence {
    /// Usual number of iterations.
    most: usize,
    /// Continue although the iterations come no nearer to a solution.
    is_patient: bool,
    /// Continue while the residual decreases, even below the tolerance.
    is_exact: bool,
    /// Energy of the last iterate.
    last_energy: f64,
    /// Residual of the last iterate.
    last_residual: f64,
    /// Products of energy error and contact violation, each relative to its tolerance and at least 1, of the last iterates; the latest
    /// first.
    merits: [f64; SOME],
    /// Least distance from a solution.
    nearest: f64,
    /// Number of iterations since the least distance from a solution.
    idle: usize,
    /// Number of successive iterations that have not decreased the energy.
    stalls: usize,
    /// True if the last increment was limited, so that its residual need not decrease.
    pub is_limited: bool,
}

/// Decision after an iterate.
pub enum IterateDecision {
    /// The iterate is the solution.
    Done,
    /// Another iteration follows.
    GoesOn,
    /// The attempt is given up.
    GivesUp,
}

impl Convergence {
    /// Starts the history of an attempt of at most `most` iterations; `is_patient`: without early termination, `is_exact`: until the energy
    /// no longer decreases or is below `EXACT`.
    pub fn new(most: usize, is_patient: bool, is_exact: bool) -> Self {
        Convergence {
            most,
            is_patient,
            is_exact,
            last_energy: f64::INFINITY,
            last_residual: f64::INFINITY,
            merits: [f64::INFINITY; SOME],
            nearest: f64::INFINITY,
            idle: 0,
            stalls: 0,
            is_limited: false,
        }
    }

    /// Decision on an iterate, which is a solution from the iteration `at_least` on at the earliest.
    pub fn judge(&mut self, iteration: usize, at_least: usize, record: &Iteration) -> IterateDecision {
        let energy_falls = record.energy <= if record.energy <= STALLED { FALLING } else { FALLING_FAR } * self.last_energy;
        // The energy is a sum of terms of both signs, which may stay while they decrease.
        let residual_falls = record.residual > record.floor && record.residual <= TENTH * self.last_residual;
        let falls = energy_falls || residual_falls;
        (self.last_energy, self.last_residual) = (record.energy, record.residual);
        let merit = record.energy.max(1.0) * record.violation.max(1.0);
        let falls_far = record.residual <= record.target && merit <= TENTH * self.merits[SOME - 1];
        self.merits.rotate_right(1);
        self.merits[0] = merit;
        self.stalls = if falls { 0 } else { self.stalls + 1 };
        let is_near_round_off = record.residual <= NEAR_ROUND_OFF * record.floor || self.stalls >= FLAT;
        let is_small = record.energy <= STALLED && is_near_round_off;
        let is_stalled = !falls && (is_small || record.residual <= record.floor && self.stalls >= record.stalls);
        let is_round_off = is_stalled || (!falls || iteration >= LATE) && record.energy <= record.round_off;
        let is_met = record.residual <= record.target && record.violation <= 1.0;
        let is_exact = !self.is_exact || !falls || record.energy <= EXACT;
        let is_enough = record.enough > 0.0 && record.residual <= record.enough;
        if iteration >= at_least && is_met && (record.energy <= 1.0 && is_exact || is_round_off || is_enough) {
            return IterateDecision::Done;
        }
        let distance = (record.residual / record.target).max(record.violation);
        // If all conditions are met, only the energy still decreases: this counts as progress.
        if is_met || distance <= NEARER * self.nearest {
            (self.nearest, self.idle) = (distance.min(self.nearest), 0);
        } else if !self.is_limited {
            self.idle += 1;
        }
        let is_idle = self.idle > MAX_IDLE && !self.is_patient;
        let is_over = iteration >= if is_met && falls || falls_far { LONGER * self.most } else { self.most };
        if is_idle || is_over { IterateDecision::GivesUp } else { IterateDecision::GoesOn }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// True if the third of three iterates is accepted, whose energies are 1e3, 20 and 30 times the tolerance.
    fn is_accepted(residual: f64) -> bool {
        let mut convergence = Convergence::new(20, false, false);
        let record = |energy: f64, residual: f64| Iteration { residual, target: 1e-6, floor: 1e-12, energy, ..Iteration::default() };
        convergence.judge(0, 1, &record(1e3, 1e-6));
        convergence.judge(1, 1, &record(20.0, residual));
        matches!(convergence.judge(2, 1, &record(30.0, residual)), IterateDecision::Done)
    }

    #[test]
    fn an_energy_that_rises_once_is_round_off_only_if_the_residual_is_near_it() {
        assert!(is_accepted(1e-11));
        assert!(!is_accepted(1e-8));
    }
}
