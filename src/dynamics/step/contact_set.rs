//! Which constraints of an iterate are active, by how much it violates their conditions, and the rows that Newton's system gets from them.

use std::collections::BTreeMap;

use super::conditions::Conditions;
use super::constraint_rows::ConstraintRows;
use super::iterate::Linearization;
use super::system::System;
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::parts::friction_rows::{FrictionRows, SlipRow};
use crate::dynamics::parts::laws::RowState;
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

/// A tangential row of the model at an iterate.
pub struct SlipPlace<'a> {
    /// The row, and the one that presses, among all rows.
    pub row: usize,
    pub pressing: usize,
    /// Its pair.
    pub pair: &'a ContactPair,
    /// Whether it can have a multiplier at all: both rows have something opposite.
    pub exists: bool,
    friction: &'a FrictionRows,
    local: usize,
    slip: &'a Evaluation,
    around: f64,
    rest: f64,
    is_held: bool,
}

impl<'a> SlipPlace<'a> {
    /// The row with what a solution makes of its slip and of both multipliers.
    pub fn with(&self, conditions: &Conditions, slip: f64, lambda: &[f64]) -> SlipRow<'a> {
        let &SlipPlace { row, pressing, pair, local, around, rest, is_held, .. } = self;
        let length = self.slip.coverage[local] * pair.kernel.weights()[local];
        SlipRow {
            law: &*self.friction.law,
            coefficient: self.friction.coefficients[local],
            normal: lambda[pressing],
            lambda: lambda[row],
            slip,
            speed: if conditions.dt > 0.0 && length > 0.0 { 1.0 / (length * conditions.dt) } else { 0.0 },
            around,
            compliance: conditions.compliance[row],
            c: self.friction.c,
            tolerance: pair.gap_tolerance,
            rest: if conditions.stops[row] { rest } else { 0.0 },
            is_held,
        }
    }

    /// The row at the iterate.
    pub fn at(&self, conditions: &Conditions, at: &Linearization) -> SlipRow<'a> {
        self.with(conditions, self.slip.gap[self.local], &at.lambda)
    }
}

/// All tangential rows at an iterate.
pub fn slips_at<'a, const D: usize>(system: &'a System<D>, at: &'a Linearization) -> impl Iterator<Item = SlipPlace<'a>> {
    pairs_at(system, at).zip(&at.slips).flat_map(move |((pair, evaluation), slip)| {
        let rows = pair.friction.iter().flat_map(|friction| friction.rows.clone().enumerate().map(move |at| (friction, at)));
        rows.map(move |(friction, (local, row))| {
            let pressing = pair.rows.start + local;
            let around = pair.node_of(pressing).map_or(1.0, |node| pair.circumference(node, &at.q_1));
            let exists = has_row(pair, evaluation, local) && slip.coverage[local] > tolerances::SLIVER && around > 0.0;
            let (rest, is_held) = (at.rests[row - system.pressing], at.held[row - system.pressing]);
            SlipPlace { row, pressing, pair, exists, friction, local, slip, around, rest, is_held }
        })
    })
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
    for place in slips_at(system, at).filter(|place| !dropped[place.row]) {
        let row = place.at(conditions, at);
        let (natural, energy) = if place.exists { row.residual() } else { (row.lambda / row.c, row.lambda * row.slip) };
        let violation = natural.abs() / row.tolerance;
        if violation > worst {
            (worst, worst_row) = (violation, place.row);
        }
        work += energy;
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
    for place in slips_at(system, at).filter(|place| !dropped[place.row]) {
        set[place.row] = first_state(&place, conditions, at, &set);
    }
    set
}

/// The constraint rows for a set of active nodes; `yielding` is how far tangential rows of nodes with more rows than motions give way, over
/// what they do at first.
pub fn constraint_rows<const D: usize>(
    system: &System<D>,
    at: &Linearization,
    conditions: &Conditions,
    set: &[RowState],
    yielding: f64,
) -> ConstraintRows {
    let mut rows = ConstraintRows::open(system.multipliers);
    for (pair, evaluation) in pairs_at(system, at) {
        for row in pair.rows.clone().filter(|&row| set[row].is_closed()) {
            let at_iterate = conditions.row(pair, row, evaluation.gap[row - pair.rows.start], at.lambda[row]);
            rows.0[row] = pair.law.equation(&at_iterate);
        }
    }
    let held = rows_of_nodes(system, set);
    for place in slips_at(system, at).filter(|place| set[place.row].acts()) {
        let mut row = place.at(conditions, at);
        // More rows than a node can move: those that stick give way, until the multipliers are found.
        if place.pair.node_of(place.row).is_some_and(|node| held[&node] > system.supports.free_components::<D>(node)) {
            row.compliance = row.compliance.max(yielding * conditions.yielding[place.row]);
        }
        rows.0[place.row] = row.equation(set[place.row]);
    }
    rows
}

/// How many rows hold each node that has tangential ones: those that press and those that stick.
fn rows_of_nodes<const D: usize>(system: &System<D>, set: &[RowState]) -> BTreeMap<u32, usize> {
    let mut counts = BTreeMap::new();
    for pair in &system.pairs {
        let Some(friction) = &pair.friction else { continue };
        for row in pair.rows.clone().chain(friction.rows.clone()) {
            if let Some(node) = pair.node_of(row) {
                *counts.entry(node).or_default() += usize::from(set[row].holds());
            }
        }
    }
    counts
}

/// The state with which an iteration begins for a tangential row, by the state of the row that presses: open without pressure.
pub fn first_state(place: &SlipPlace, conditions: &Conditions, at: &Linearization, set: &[RowState]) -> RowState {
    if place.exists && set[place.pressing].is_closed() { place.at(conditions, at).first_state() } else { RowState::Open }
}
