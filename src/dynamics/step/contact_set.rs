//! Which constraints of an iterate are active, by how much it violates their conditions, and the rows that Newton's system gets from them.

use super::conditions::Conditions;
use super::constraints::ConstraintRows;
use super::iterate::Linearization;
use super::system::System;
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::parts::laws::{Equation, RowState};
use crate::math::tolerances;

/// Every pair with what it is at an iterate.
pub fn pairs_at<'a, const D: usize>(
    system: &'a System<D>,
    at: &'a Linearization,
) -> impl Iterator<Item = (&'a ContactPair, &'a Evaluation)> {
    system.pairs.iter().zip(&at.pairs)
}

/// Whether constraint `local` of a pair can hold at all at this iterate: its node has an overlap. A penalty potential always counts.
pub fn has_row(pair: &ContactPair, evaluation: &Evaluation, local: usize) -> bool {
    !pair.has_multipliers() || evaluation.coverage[local] > tolerances::ZERO_ROW
}

/// Takes nodes with a sliver of overlap out of the step; returns whether a multiplier was lost.
pub fn drop_slivers<const D: usize>(system: &System<D>, at: &Linearization, dropped: &mut [bool], lambda: &mut [f64]) -> bool {
    let mut lost = false;
    for (pair, evaluation) in pairs_at(system, at).filter(|(pair, _)| pair.has_multipliers()) {
        for row in pair.rows.clone() {
            let covered = evaluation.coverage[row - pair.rows.start];
            if !dropped[row] && covered > 0.0 && covered < tolerances::SLIVER {
                dropped[row] = true;
                lost |= lambda[row] != 0.0;
                lambda[row] = 0.0;
            }
        }
    }
    lost
}

/// The largest violation of the contact conditions over what is tolerated, its constraint, and the energy of all violations.
pub fn worst_violation<const D: usize>(
    system: &System<D>,
    at: &Linearization,
    conditions: &Conditions,
    dropped: &[bool],
) -> (f64, usize, f64) {
    let (mut worst, mut worst_row, mut work) = (0.0, 0, 0.0);
    for (pair, evaluation) in pairs_at(system, at) {
        for row in pair.rows.clone().filter(|&row| !dropped[row]) {
            let (local, lambda) = (row - pair.rows.start, at.lambda[row]);
            // A node that has come to lie opposite nothing must not keep its multiplier: the force would have no function.
            let (natural, energy) = if has_row(pair, evaluation, local) {
                pair.law.residual(&conditions.row(pair, row, evaluation.gap[local], lambda))
            } else {
                (lambda / pair.c, lambda * conditions.gap_n[row])
            };
            let violation = natural.abs() / pair.gap_tolerance;
            if violation > worst {
                (worst, worst_row) = (violation, row);
            }
            work += energy;
        }
    }
    (worst, worst_row, work)
}

/// Whether an iterate meets the contact conditions.
pub fn meets<const D: usize>(system: &System<D>, at: &Linearization, conditions: &Conditions) -> bool {
    let (mut dropped, mut kept) = (system.redundant.clone(), at.lambda.clone());
    !drop_slivers(system, at, &mut dropped, &mut kept) && worst_violation(system, at, conditions, &dropped).0 <= 1.0
}

/// The set that an iteration begins with: pressed nodes and nodes that overlap.
pub fn starting_set<const D: usize>(system: &System<D>, at: &Linearization, conditions: &Conditions, dropped: &[bool]) -> Vec<RowState> {
    let mut set = vec![RowState::Open; system.multipliers];
    for (pair, evaluation) in pairs_at(system, at) {
        for row in pair.rows.clone() {
            let local = row - pair.rows.start;
            if !dropped[row] && has_row(pair, evaluation, local) {
                set[row] = pair.law.first_state(&conditions.row(pair, row, evaluation.gap[local], at.lambda[row]));
            }
        }
    }
    set
}

/// The constraint rows for a set of active nodes.
pub fn constraint_rows<const D: usize>(
    system: &System<D>,
    at: &Linearization,
    conditions: &Conditions,
    set: &[RowState],
) -> ConstraintRows {
    let (diagonal, right) = (vec![1.0; system.multipliers], vec![0.0; system.multipliers]);
    let mut rows = ConstraintRows { gradient: set.iter().map(|row| row.is_closed()).collect(), diagonal, right };
    for (pair, evaluation) in pairs_at(system, at) {
        for row in pair.rows.clone().filter(|&row| set[row].is_closed()) {
            let at_iterate = conditions.row(pair, row, evaluation.gap[row - pair.rows.start], at.lambda[row]);
            let Equation { has_gradient, diagonal, right } = pair.law.equation(&at_iterate);
            (rows.gradient[row], rows.diagonal[row], rows.right[row]) = (has_gradient, diagonal, right);
        }
    }
    rows
}
