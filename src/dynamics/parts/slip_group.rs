//! Tangential constraints beside a normal constraint: one in the plane, two in space, three of a ball joint.

use super::friction_rows::SlipRow;
use super::laws::{Equation, RowState};
use super::slip_vector::SlipVector;
use crate::math::norms::length;

/// Tangential constraints of a group at an iterate.
pub enum SlipGroup<'a> {
    /// One constraint in the plane.
    Row(SlipRow<'a>),
    /// Two constraints in space, or three of a rotation in space.
    Vector(SlipVector<'a>),
}

impl SlipGroup<'_> {
    /// State at the first iteration.
    pub fn first_state(&self) -> RowState {
        match self {
            SlipGroup::Row(row) => row.first_state(),
            SlipGroup::Vector(rows) => rows.first_state(),
        }
    }

    /// Natural residual as a slip, and its energy.
    pub fn residual(&self) -> (f64, f64) {
        match self {
            SlipGroup::Row(row) => row.residual(),
            SlipGroup::Vector(rows) => rows.residual(),
        }
    }

    /// Residual and energy of tangential constraints at an uncovered node: their whole multipliers.
    pub fn excess(&self) -> (f64, f64) {
        match self {
            SlipGroup::Row(row) => (row.lambda / row.pressed.c, row.lambda * row.slip),
            SlipGroup::Vector(rows) => rows.excess(),
        }
    }

    /// Ratios of tangential to normal impulses of an impact at the end of the step.
    pub fn impulse_ratios(&self) -> [f64; 3] {
        match self {
            SlipGroup::Row(row) => row.pressed.impulse_ratios([row.lambda, 0.0, 0.0], row.slip.abs()),
            SlipGroup::Vector(rows) => rows.pressed.impulse_ratios(rows.lambda, length(rows.slip)),
        }
    }

    /// True if the slip direction is defined: always in the plane, in space if the trial is above round-off.
    pub fn is_directed(&self) -> bool {
        match self {
            SlipGroup::Row(_) => true,
            SlipGroup::Vector(rows) => rows.is_directed(),
        }
    }

    /// Slip below which slips count as zero.
    pub fn tolerance(&self) -> f64 {
        match self {
            SlipGroup::Row(row) => row.pressed.tolerance,
            SlipGroup::Vector(rows) => rows.pressed.tolerance,
        }
    }

    /// Tangential compliance of sticking constraints.
    pub fn compliance(&mut self) -> &mut f64 {
        match self {
            SlipGroup::Row(row) => &mut row.pressed.compliance,
            SlipGroup::Vector(rows) => &mut rows.pressed.compliance,
        }
    }

    /// Equations of the constraints in a state; those beyond the number of constraints are inactive.
    pub fn equations(&self, state: RowState) -> [Equation; 3] {
        match self {
            SlipGroup::Row(row) => [row.equation(state), Equation::OPEN, Equation::OPEN],
            SlipGroup::Vector(rows) => rows.equations(state),
        }
    }

    /// New state and magnitude of the violation that requires it, or `None`; `self` has the values of the frozen linearization at the
    /// iterate `iterate`.
    pub fn change(&self, state: RowState, iterate: &Self) -> Option<(RowState, f64)> {
        match (self, iterate) {
            (SlipGroup::Row(row), _) => row.change(state),
            (SlipGroup::Vector(rows), SlipGroup::Vector(iterate)) => rows.change(state, iterate),
            (SlipGroup::Vector(_), SlipGroup::Row(_)) => None,
        }
    }
}
