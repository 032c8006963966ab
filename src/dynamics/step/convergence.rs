//! When the iterations of one attempt are done, go on or are given up.

use crate::math::tolerances::EXACT;

/// Growth of the energy, over what is tolerated, up to which a residual that falls no longer may be round-off.
const STALLED: f64 = 100.0;

/// The part of the last iteration's energy above which it falls no longer, where it may be round-off by its size, and where only the
/// residual says so: an iteration with an inexact tangent may take as little as a tenth, and what still falls is no round-off.
const FALLING: f64 = 0.5;
const FALLING_FAR: f64 = 0.9;

/// Growth of the number of iterations while all is met but the energy, which still falls.
const LONGER: usize = 3;

/// The part of the least distance from a solution that counts as nearer, and the iterations without coming nearer after which an attempt
/// is given up: what cycles does so until the last iteration. Fewer lead to other attempts too early, which may find another solution.
const NEARER: f64 = 0.7;
const MAX_IDLE: usize = 8;

/// What an iteration looked like.
#[derive(Clone, Debug, Default)]
pub struct Iteration {
    /// Largest component of the residual.
    pub residual: f64,
    /// Its unknown.
    pub worst: usize,
    /// Force by which residuals are judged in this iteration.
    pub target: f64,
    /// Round-off of the forces: a residual below it cannot be trusted to fall.
    pub floor: f64,
    /// Residual that ends a step at rest, whatever its energy; 0 in motion.
    pub enough: f64,
    /// Energy that the residual can still move, over what is tolerated.
    pub energy: f64,
    /// Largest violation of the contact conditions over what is tolerated.
    pub violation: f64,
    /// Its constraint.
    pub worst_row: usize,
    /// Constraints whose contact state changed.
    pub changed: Vec<usize>,
    /// Active contact nodes.
    pub active: usize,
}

/// What the iterations so far tell.
pub struct Convergence {
    /// Usual number of iterations.
    most: usize,
    /// Whether iterations go on although they come no nearer.
    is_patient: bool,
    /// Whether a residual that is met goes on falling, as far as it falls.
    is_exact: bool,
    /// Energy of the last iterate.
    last_energy: f64,
    /// Least distance from a solution, and iterations since.
    nearest: f64,
    idle: usize,
    /// Whether the last increment was not taken whole: then nothing can be expected of the residual yet.
    pub is_limited: bool,
}

/// What comes after an iterate.
pub enum Judgement {
    /// It is the solution.
    Done,
    /// Another one.
    GoesOn,
    /// Another attempt.
    GivesUp,
}

impl Convergence {
    /// Nothing is known yet of an attempt of that many iterations; a patient one takes them all, an exact one stops at
    /// round-off.
    pub fn new(most: usize, is_patient: bool, is_exact: bool) -> Self {
        Convergence { most, is_patient, is_exact, last_energy: f64::INFINITY, nearest: f64::INFINITY, idle: 0, is_limited: false }
    }

    /// Judges an iterate; not before the iteration `at_least` is it a solution.
    pub fn judge(&mut self, iteration: usize, at_least: usize, record: &Iteration) -> Judgement {
        let falls = record.energy <= if record.energy <= STALLED { FALLING } else { FALLING_FAR } * self.last_energy;
        self.last_energy = record.energy;
        let is_round_off = !falls && (record.energy <= STALLED || record.residual <= record.floor);
        let is_met = record.residual <= record.target && record.violation <= 1.0;
        let is_exact = !self.is_exact || !falls || record.energy <= EXACT;
        let is_enough = record.enough > 0.0 && record.residual <= record.enough;
        if iteration >= at_least && is_met && (record.energy <= 1.0 && is_exact || is_round_off || is_enough) {
            return Judgement::Done;
        }
        let distance = (record.residual / record.target).max(record.violation);
        // What is met has only its energy to lose.
        if is_met || distance <= NEARER * self.nearest {
            (self.nearest, self.idle) = (distance.min(self.nearest), 0);
        } else if !self.is_limited {
            self.idle += 1;
        }
        let is_idle = self.idle > MAX_IDLE && !self.is_patient;
        let is_over = iteration >= if is_met && falls { LONGER * self.most } else { self.most };
        if is_idle || is_over { Judgement::GivesUp } else { Judgement::GoesOn }
    }
}
