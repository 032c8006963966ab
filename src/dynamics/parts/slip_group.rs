//! The tangential rows beside a row that presses, whatever their number: one in the plane, two in space.

use super::friction_rows::SlipRow;
use super::laws::{Equation, RowState};
use super::slip_vector::SlipVector;

/// The tangential rows of a group at an iterate.
pub enum SlipGroup<'a> {
    /// In the plane.
    Row(SlipRow<'a>),
    /// In space.
    Vector(SlipVector<'a>),
}

impl SlipGroup<'_> {
    /// The state with which an iteration begins.
    pub fn first_state(&self) -> RowState {
        match self {
            SlipGroup::Row(row) => row.first_state(),
            SlipGroup::Vector(rows) => rows.first_state(),
        }
    }

    /// Natural residual: by how much the rows are off, as a slip, and the energy that goes with it.
    pub fn residual(&self) -> (f64, f64) {
        match self {
            SlipGroup::Row(row) => row.residual(),
            SlipGroup::Vector(rows) => rows.residual(),
        }
    }

    /// The same of rows that have nothing opposite: all that they have is too much.
    pub fn excess(&self) -> (f64, f64) {
        match self {
            SlipGroup::Row(row) => (row.lambda / row.pressed.c, row.lambda * row.slip),
            SlipGroup::Vector(rows) => {
                let [[a, b], [u, v]] = [rows.lambda, rows.slip];
                (a.hypot(b) / rows.pressed.c, a * u + b * v)
            }
        }
    }

    /// True if the direction of sliding is defined: in the plane always, in space if the trial is above round-off.
    pub fn is_directed(&self) -> bool {
        match self {
            SlipGroup::Row(_) => true,
            SlipGroup::Vector(rows) => rows.is_directed(),
        }
    }

    /// Slip that counts as zero.
    pub fn tolerance(&self) -> f64 {
        match self {
            SlipGroup::Row(row) => row.pressed.tolerance,
            SlipGroup::Vector(rows) => rows.pressed.tolerance,
        }
    }

    /// Sets the slip per change of a multiplier of rows that stick.
    pub fn set_compliance(&mut self, compliance: f64) {
        match self {
            SlipGroup::Row(row) => row.pressed.compliance = compliance,
            SlipGroup::Vector(rows) => rows.pressed.compliance = compliance,
        }
    }

    /// Lets rows that stick give way by at least so much per change of a multiplier.
    pub fn yield_by(&mut self, compliance: f64) {
        let pressed = match self {
            SlipGroup::Row(row) => &mut row.pressed,
            SlipGroup::Vector(rows) => &mut rows.pressed,
        };
        pressed.compliance = pressed.compliance.max(compliance);
    }

    /// The equations of the rows in a state; one row has the first.
    pub fn equations(&self, state: RowState) -> [Equation; 2] {
        match self {
            SlipGroup::Row(row) => [row.equation(state), Equation::OPEN],
            SlipGroup::Vector(rows) => rows.equations(state),
        }
    }

    /// The state that the rows ask for, and how strongly, if it is another one; `self` is what the frozen linearization makes of them.
    pub fn change(&self, state: RowState) -> Option<(RowState, f64)> {
        match self {
            SlipGroup::Row(row) => row.change(state),
            SlipGroup::Vector(rows) => rows.change(state),
        }
    }
}
