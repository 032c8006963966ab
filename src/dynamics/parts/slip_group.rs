//! Tangential constraints beside a normal constraint: one in the plane, two in space, three of a ball joint.

use super::friction_rows::SlipRow;
use super::laws::{Equation, RowState};
use super::slip_vector::SlipVector;

/// Tangential constraints of a group at an iterate.
pub enum SlipGroup<'a> {
    /// One constraint in the plane.
    Row(SlipRow<'a>),
    /// Two constraints in space.
    Pair(SlipVector<'a, 2>),
    /// Three constraints of a rotation in space.
    Triple(SlipVector<'a, 3>),
}

impl SlipGroup<'_> {
    /// State at the first iteration.
    pub fn first_state(&self) -> RowState {
        match self {
            SlipGroup::Row(row) => row.first_state(),
            SlipGroup::Pair(rows) => rows.first_state(),
            SlipGroup::Triple(rows) => rows.first_state(),
        }
    }

    /// Natural residual as a slip, and its energy.
    pub fn residual(&self) -> (f64, f64) {
        match self {
            SlipGroup::Row(row) => row.residual(),
            SlipGroup::Pair(rows) => rows.residual(),
            SlipGroup::Triple(rows) => rows.residual(),
        }
    }

    /// Residual and energy of tangential constraints at an uncovered node: their whole multipliers.
    pub fn excess(&self) -> (f64, f64) {
        match self {
            SlipGroup::Row(row) => (row.lambda / row.pressed.c, row.lambda * row.slip),
            SlipGroup::Pair(rows) => rows.excess(),
            SlipGroup::Triple(rows) => rows.excess(),
        }
    }

    /// True if the slip direction is defined: always in the plane, in space if the trial is above round-off.
    pub fn is_directed(&self) -> bool {
        match self {
            SlipGroup::Row(_) => true,
            SlipGroup::Pair(rows) => rows.is_directed(),
            SlipGroup::Triple(rows) => rows.is_directed(),
        }
    }

    /// Slip below which slips count as zero.
    pub fn tolerance(&self) -> f64 {
        match self {
            SlipGroup::Row(row) => row.pressed.tolerance,
            SlipGroup::Pair(rows) => rows.pressed.tolerance,
            SlipGroup::Triple(rows) => rows.pressed.tolerance,
        }
    }

    /// Sets the tangential compliance of sticking constraints.
    pub fn set_compliance(&mut self, compliance: f64) {
        match self {
            SlipGroup::Row(row) => row.pressed.compliance = compliance,
            SlipGroup::Pair(rows) => rows.pressed.compliance = compliance,
            SlipGroup::Triple(rows) => rows.pressed.compliance = compliance,
        }
    }

    /// Raises the tangential compliance of sticking constraints to at least `compliance`.
    pub fn raise_compliance(&mut self, compliance: f64) {
        let pressed = match self {
            SlipGroup::Row(row) => &mut row.pressed,
            SlipGroup::Pair(rows) => &mut rows.pressed,
            SlipGroup::Triple(rows) => &mut rows.pressed,
        };
        pressed.compliance = pressed.compliance.max(compliance);
    }

    /// Equations of the constraints in a state; those beyond the number of constraints are inactive.
    pub fn equations(&self, state: RowState) -> [Equation; 3] {
        match self {
            SlipGroup::Row(row) => [row.equation(state), Equation::OPEN, Equation::OPEN],
            SlipGroup::Pair(rows) => {
                let [first, second] = rows.equations(state);
                [first, second, Equation::OPEN]
            }
            SlipGroup::Triple(rows) => rows.equations(state),
        }
    }

    /// New state and magnitude of the violation that requires it, or `None`; `self` has the values of the frozen linearization at the
    /// iterate `iterate`.
    pub fn change(&self, state: RowState, iterate: &Self) -> Option<(RowState, f64)> {
        match (self, iterate) {
            (SlipGroup::Row(row), _) => row.change(state),
            (SlipGroup::Pair(rows), SlipGroup::Pair(iterate)) => rows.change(state, iterate),
            (SlipGroup::Triple(rows), SlipGroup::Triple(iterate)) => rows.change(state, iterate),
            _ => None,
        }
    }
}
