//! Unilateral contact: `Phi >= 0`, `lambda >= 0`, `lambda Phi = 0` (Signorini), relative to the target of the step.

use super::bilateral::held;
use super::law::{ConstraintCondition, Equation, Row, RowLaw, RowStart, RowState};
use crate::math::tolerances;

/// Unilateral law `Phi >= target`, `lambda >= 0`.
///
/// The target never exceeds an overlap at the start: contact does not push apart an initial overlap, and its work `lambda (target - Phi_n)`
/// is never positive.
#[derive(Debug)]
pub struct Unilateral;

impl RowLaw for Unilateral {
    fn demand(&self, start: &RowStart) -> ConstraintCondition {
        let &RowStart { gap, held, closed, keeps, .. } = start;
        let (target, is_member) = if keeps { (gap, gap <= held + closed) } else { (gap.min(held), true) };
        ConstraintCondition { gap, target, is_member, shift: 0.0 }
    }

    fn first_state(&self, row: &Row) -> RowState {
        RowState::closed_if(row.lambda - row.c * (row.gap - row.target) > 0.0)
    }

    fn residual(&self, row: &Row) -> (f64, f64) {
        let gap = row.gap - row.target;
        (gap.min(row.lambda / row.c), row.lambda * gap)
    }

    fn equation(&self, row: &Row) -> Equation {
        held(row)
    }

    fn change(&self, state: RowState, row: &Row) -> Option<f64> {
        let violation = if state.is_closed() { -row.lambda / row.c } else { row.target - row.gap - tolerances::CLEARLY * row.tolerance };
        (violation > 0.0 || (state.is_closed() && row.lambda <= 0.0)).then_some(violation)
    }
}
