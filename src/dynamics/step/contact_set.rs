//! Active constraints of an iterate, violations of their conditions, and their equations in Newton's system.

use std::collections::BTreeMap;
use std::ops::Range;

use super::conditions::Conditions;
use super::constraint_rows::ConstraintRows;
use super::equations::Equations;
use super::iterate::Linearization;
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::parts::friction_rows::{FrictionRows, NormalState, SlipRow};
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::parts::slip_group::SlipGroup;
use crate::dynamics::parts::slip_vector::SlipVector;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// All contact pairs with their evaluations at an iterate.
pub fn pairs_at<'a, const D: usize>(
    equations: &'a Equations<D>,
    at: &'a Linearization,
) -> impl Iterator<Item = (&'a ContactPair, &'a Evaluation)> {
    equations.pairs.iter().zip(&at.pairs)
}

/// True if constraint `local` of a pair can be active at this iterate, because its node has an overlap; always true for a penalty
/// potential.
pub fn has_row(pair: &ContactPair, evaluation: &Evaluation, local: usize) -> bool {
    !pair.has_multipliers() || evaluation.coverage[local] > tolerances::ZERO_ROW
}

/// Tangential constraints of one normal constraint, at an iterate.
pub struct SlipPlace<'a> {
    /// Indices of the tangential constraints among all constraints.
    pub rows: Range<usize>,
    /// Index of the normal constraint among all constraints.
    pub normal_row: usize,
    /// Contact pair of the constraints.
    pub pair: &'a ContactPair,
    /// True if the tangential constraints can be active: the node faces the other side at the end of the step and where slip is measured.
    pub exists: bool,
    friction: &'a FrictionRows,
    slip: &'a Evaluation,
    covered: f64,
    /// -1 where a bilateral contact pulls at the iterate, so that its frozen linearization has one sign; 1 elsewhere.
    sense: f64,
    around: f64,
    rests: &'a [f64],
    is_held: bool,
}

impl<'a> SlipPlace<'a> {
    /// Group of tangential constraints for given slips and multipliers, in the order of all constraints.
    pub fn with(&self, conditions: &Conditions, slips: &[f64], lambda: &[f64]) -> SlipGroup<'a> {
        self.group(conditions, |row| slips[row], lambda)
    }

    /// Group of tangential constraints at the iterate.
    pub fn at(&self, conditions: &Conditions, at: &Linearization) -> SlipGroup<'a> {
        self.under(conditions, &at.lambda)
    }

    /// Slips of the step, one for each constraint.
    pub fn slips(&self) -> &'a [f64] {
        &self.slip.gap[self.rows.start - self.friction.rows.start..self.rows.end - self.friction.rows.start]
    }

    /// Group of tangential constraints for given multipliers.
    pub fn under(&self, conditions: &Conditions, lambda: &[f64]) -> SlipGroup<'a> {
        self.group(conditions, |row| self.slip.gap[row - self.friction.rows.start], lambda)
    }

    fn group(&self, conditions: &Conditions, slip: impl Fn(usize) -> f64, lambda: &[f64]) -> SlipGroup<'a> {
        let &SlipPlace { normal_row, pair, friction, sense, around, rests, is_held, .. } = self;
        let first = self.rows.start;
        let local = normal_row - pair.rows.start;
        let length = self.covered * pair.kernel.weights()[local];
        let pressed = NormalState {
            law: &*friction.law,
            coefficient: friction.coefficients[local],
            normal: sense * lambda[normal_row],
            sense,
            speed: if conditions.dt > 0.0 && length > 0.0 { 1.0 / (length * conditions.dt) } else { 0.0 },
            lagged: conditions.lagged_speeds.get(first).copied(),
            around,
            compliance: conditions.compliance[first],
            c: friction.c,
            stiffness: conditions.stiffness[first],
            tolerance: pair.gap_tolerance,
        };
        let rest = |k: usize| if conditions.stops[first] { rests[k] } else { 0.0 };
        let count = self.rows.len();
        if count == 1 {
            return SlipGroup::Row(SlipRow { pressed, lambda: lambda[first], slip: slip(first), rest: rest(0), is_held });
        }
        let vector = |of: &dyn Fn(usize) -> f64| std::array::from_fn(|k| if k < count { of(k) } else { 0.0 });
        let (lambda, slip) = (vector(&|k| lambda[first + k]), vector(&|k| slip(first + k)));
        SlipGroup::Vector(SlipVector { pressed, count, lambda, slip, rest: vector(&rest) })
    }
}

/// Tangential constraints of all pairs at an iterate.
pub fn slips_at<'a, const D: usize>(equations: &'a Equations<D>, at: &'a Linearization) -> impl Iterator<Item = SlipPlace<'a>> {
    pairs_at(equations, at).zip(&at.slips).flat_map(move |((pair, evaluation), slip)| {
        let groups = pair.friction.iter().flat_map(|friction| pair.rows.clone().enumerate().map(move |of| (friction, of)));
        groups.map(move |(friction, (local, normal_row))| {
            let rows = friction.group(local);
            let (first, end) = (rows.start - equations.normal_count, rows.end - equations.normal_count);
            let covered = slip.coverage[rows.start - friction.rows.start];
            let around = pair.node_of(normal_row).map_or(1.0, |node| pair.circumference(node, &at.q_1));
            let exists = has_row(pair, evaluation, local) && covered > tolerances::SLIVER && around > 0.0;
            let sense = if pair.law.is_bilateral() && at.lambda[normal_row] < 0.0 { -1.0 } else { 1.0 };
            let (rests, is_held) = (&at.rests[first..end], at.held[first]);
            SlipPlace { rows, normal_row, pair, exists, friction, slip, covered, sense, around, rests, is_held }
        })
    })
}

/// Excludes nodes with a sliver of overlap from the step; returns true if a nonzero multiplier was dropped.
pub fn drop_slivers<const D: usize>(equations: &Equations<D>, at: &Linearization, dropped: &mut [bool], lambda: &mut [f64]) -> bool {
    let mut lost = false;
    for (pair, evaluation) in pairs_at(equations, at).filter(|(pair, _)| pair.has_multipliers()) {
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

/// Largest violation of the contact conditions relative to its tolerance, its constraint, and the energy of all violations.
pub fn worst_violation<const D: usize>(
    equations: &Equations<D>,
    at: &Linearization,
    conditions: &Conditions,
    dropped: &[bool],
) -> (f64, usize, f64) {
    let (mut worst, mut worst_row, mut work) = (0.0, 0, 0.0);
    let reach = largest_size(&at.q_1);
    for (pair, evaluation) in pairs_at(equations, at) {
        let gap_tolerance = pair.gap_tolerance_at(reach);
        for row in pair.rows.clone().filter(|&row| !dropped[row]) {
            let (local, lambda) = (row - pair.rows.start, at.lambda[row]);
            // A node without an opposite facet must not keep its multiplier: the force has no gap function.
            let (natural, energy) = if has_row(pair, evaluation, local) {
                pair.law.residual(&conditions.row(pair, row, evaluation.gap[local], lambda))
            } else {
                (lambda / pair.c, lambda * conditions.gap_n[row])
            };
            let violation = natural.abs() / gap_tolerance;
            if violation > worst {
                (worst, worst_row) = (violation, row);
            }
            work += energy;
        }
    }
    for place in slips_at(equations, at).filter(|place| !dropped[place.rows.start]) {
        let group = place.at(conditions, at);
        let (natural, energy) = if place.exists { group.residual() } else { group.excess() };
        let violation = natural.abs() / group.tolerance();
        if violation > worst {
            (worst, worst_row) = (violation, place.rows.start);
        }
        work += energy;
    }
    (worst, worst_row, work)
}

/// Work of the multipliers on slips of constraints that stick in the active set: in joints its magnitude, in contacts as far as it is
/// positive. Solutions with a tangential compliance leave such slips, and friction must not supply energy.
pub fn sticking_work<const D: usize>(equations: &Equations<D>, at: &Linearization, active: &[RowState]) -> [f64; 2] {
    let (mut of_joints, mut of_contacts) = (0.0, 0.0);
    for place in slips_at(equations, at).filter(|place| place.exists && active[place.rows.start].is_closed()) {
        let slip = |row: usize| place.slip.gap[row - place.friction.rows.start];
        let work: f64 = place.rows.clone().map(|row| at.lambda[row] * slip(row)).sum();
        if place.pair.reaction.is_some() { of_joints += work.abs() } else { of_contacts += work.max(0.0) }
    }
    [of_joints, of_contacts]
}

/// True if an iterate satisfies the contact conditions.
pub fn meets<const D: usize>(equations: &Equations<D>, at: &Linearization, conditions: &Conditions) -> bool {
    let (mut dropped, mut kept) = (equations.redundant.clone(), at.lambda.clone());
    !drop_slivers(equations, at, &mut dropped, &mut kept) && worst_violation(equations, at, conditions, &dropped).0 <= 1.0
}

/// Initial active set of an iteration: constraints with positive multipliers, and overlapping ones.
pub fn starting_set<const D: usize>(
    equations: &Equations<D>,
    at: &Linearization,
    conditions: &Conditions,
    dropped: &[bool],
) -> Vec<RowState> {
    let mut set = vec![RowState::Open; equations.multipliers];
    for (pair, evaluation) in pairs_at(equations, at) {
        for row in pair.rows.clone() {
            let local = row - pair.rows.start;
            if !dropped[row] && has_row(pair, evaluation, local) {
                set[row] = pair.law.first_state(&conditions.row(pair, row, evaluation.gap[local], at.lambda[row]));
            }
        }
    }
    for place in slips_at(equations, at).filter(|place| !dropped[place.rows.start]) {
        let state = first_state(&place, conditions, at, &set);
        set[place.rows].fill(state);
    }
    set
}

/// Equations of the constraints for an active set. `compliance_ratio`: compliance of regularized constraints, and of tangential ones of
/// overconstrained nodes, relative to its initial value; tangential constraints include the proximal `terms`.
pub fn constraint_rows<const D: usize>(
    equations: &Equations<D>,
    at: &Linearization,
    conditions: &Conditions,
    set: &[RowState],
    compliance_ratio: f64,
    proximal: Option<&[f64]>,
) -> ConstraintRows {
    let mut rows = ConstraintRows::open(equations.multipliers);
    for (pair, evaluation) in pairs_at(equations, at) {
        for row in pair.rows.clone().filter(|&row| set[row].is_closed()) {
            let mut at_iterate = conditions.row(pair, row, evaluation.gap[row - pair.rows.start], at.lambda[row]);
            at_iterate.compliance = conditions.compliance_at(row, compliance_ratio);
            rows.0[row] = match &pair.reaction {
                Some(reaction) => reaction.equation(&at.lambda, conditions.stiffness[row]),
                None => pair.law.equation(&at_iterate),
            };
        }
    }
    let held = rows_of_nodes(equations, set);
    for place in slips_at(equations, at).filter(|place| set[place.rows.start].acts()) {
        let (mut group, first) = (place.at(conditions, at), place.rows.start);
        *group.compliance() = conditions.compliance_at(first, compliance_ratio) + proximal.map_or(0.0, |terms| terms[first]);
        // Overconstrained node: sticking constraints are compliant until the multipliers are found.
        if place.pair.node_of(first).is_some_and(|node| held[&node] > equations.supports.free_components::<D>(node)) {
            let least = compliance_ratio / (tolerances::SHARED_AUGMENTATION * conditions.stiffness[first]);
            *group.compliance() = group.compliance().max(least);
        }
        for (row, equation) in place.rows.zip(group.equations(set[first])) {
            rows.0[row] = equation;
        }
    }
    rows
}

/// Number of active constraints of each node with friction: active normal ones and sticking tangential ones.
fn rows_of_nodes<const D: usize>(equations: &Equations<D>, set: &[RowState]) -> BTreeMap<u32, usize> {
    let mut counts = BTreeMap::new();
    for pair in &equations.pairs {
        let Some(friction) = &pair.friction else { continue };
        for row in pair.rows.clone().chain(friction.rows.clone()) {
            if let Some(node) = pair.node_of(row) {
                *counts.entry(node).or_default() += usize::from(set[row].holds());
            }
        }
    }
    counts
}

/// First state of tangential constraints in an iteration, by the state of the normal constraint: inactive without pressure.
pub fn first_state(place: &SlipPlace, conditions: &Conditions, at: &Linearization, set: &[RowState]) -> RowState {
    if place.exists && set[place.normal_row].is_closed() { place.at(conditions, at).first_state() } else { RowState::Open }
}
