//! Multiplier of a joint's friction: the limit of the friction force, a function of the multipliers of the joint's constraints.

use super::law::{ConstraintCondition, Equation, Row, RowLaw, RowStart, RowState};
use crate::math::tolerances::SLIP_NOISE;

/// Law `lambda = Phi` of a friction limit: `Phi` is evaluated from the multipliers of the joint's constraints, not from positions.
#[derive(Debug)]
pub struct Reaction;

impl RowLaw for Reaction {
    fn has_multiplier(&self) -> bool {
        false
    }

    fn demand(&self, _start: &RowStart) -> ConstraintCondition {
        ConstraintCondition { gap: 0.0, target: 0.0, is_member: true, shift: 0.0 }
    }

    fn first_state(&self, _row: &Row) -> RowState {
        RowState::Closed
    }

    fn residual(&self, row: &Row) -> (f64, f64) {
        let off = (row.lambda - row.gap).abs() - SLIP_NOISE * row.gap;
        (off.max(0.0) / row.c, 0.0)
    }

    fn equation(&self, row: &Row) -> Equation {
        Equation { acts: true, diagonal: 1.0 / row.c, right: row.gap / row.c, ..Equation::OPEN }
    }

    fn change(&self, _state: RowState, _row: &Row) -> Option<f64> {
        None
    }
}
