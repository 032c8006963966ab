//! Bilateral constraints (ties): zero gap with a multiplier of any sign.

use super::law::{ConstraintCondition, Equation, Row, RowLaw, RowStart, RowState};

/// Law `Phi = 0`.
#[derive(Debug)]
pub struct Bilateral;

impl RowLaw for Bilateral {
    fn is_bilateral(&self) -> bool {
        true
    }

    fn demand(&self, start: &RowStart) -> ConstraintCondition {
        ConstraintCondition { gap: start.gap, target: if start.keeps { start.gap } else { 0.0 }, is_member: true, shift: 0.0 }
    }

    fn first_state(&self, _row: &Row) -> RowState {
        RowState::Closed
    }

    fn residual(&self, row: &Row) -> (f64, f64) {
        let gap = row.gap - row.target;
        (gap, row.lambda * gap)
    }

    fn equation(&self, row: &Row) -> Equation {
        held(row)
    }

    fn change(&self, _state: RowState, _row: &Row) -> Option<f64> {
        None
    }
}

/// Equation `Phi = target`, with the compliance of an augmentation.
pub(super) fn held(row: &Row) -> Equation {
    Equation::held(row.compliance, row.target - row.gap + row.compliance * row.lambda)
}
