//! Interface of the laws of constraints.
//!
//! A constraint has a function `Phi` (a weighted gap) and a multiplier `lambda` with the force `lambda grad Phi`. The law gives the
//! conditions on both in a step, the residual at an iterate, and the equation of an active constraint in Newton's system,
//!
//! ```text
//! A G_1 dq + B lambda + N lambda_n = r,
//! ```
//!
//! with the gradient `G_1` of `Phi` at the end of the step and the increment `dq`. `lambda_n` is the normal multiplier in tangential
//! constraints (`friction_rows.rs`). In space these form groups of two (`slip_vector.rs`), whose equations also contain the slip and
//! multiplier of the other constraint. Laws are independent of contact methods and surfaces.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Contact state of a constraint in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RowState {
    /// Inactive: zero multiplier.
    #[default]
    Open,
    /// Active: the constraint holds and the multiplier may be nonzero; a tangential constraint sticks.
    Closed,
    /// Slip with a positive multiplier; in space slip of the group in any direction.
    Forward,
    /// Slip with a negative multiplier.
    Backward,
    /// Slip that ends within the step: zero slip rate at its end.
    Stops,
    /// Slip that reverses within the step, without dry friction.
    Turns,
}

impl RowState {
    /// Closed if `is_closed`, else open.
    pub fn closed_if(is_closed: bool) -> Self {
        if is_closed { RowState::Closed } else { RowState::Open }
    }

    /// True if the state is [`Self::Closed`].
    pub fn is_closed(self) -> bool {
        self == RowState::Closed
    }

    /// True if the multiplier follows from an equation of the gap or slip.
    pub fn holds(self) -> bool {
        matches!(self, RowState::Closed | RowState::Stops)
    }

    /// True if a tangential constraint slips at the end of the step.
    pub fn slides(self) -> bool {
        matches!(self, RowState::Forward | RowState::Backward | RowState::Turns)
    }

    /// True if the multiplier may be nonzero.
    pub fn acts(self) -> bool {
        self != RowState::Open
    }

    /// State of a tangential constraint that slips, with a multiplier of this sign.
    pub fn sliding(multiplier: f64) -> Self {
        if multiplier > 0.0 { RowState::Forward } else { RowState::Backward }
    }

    /// Sign of the multiplier of a slipping tangential constraint; `None` for other states.
    pub fn sense(self) -> Option<f64> {
        match self {
            RowState::Forward => Some(1.0),
            RowState::Backward => Some(-1.0),
            RowState::Open | RowState::Closed | RowState::Stops | RowState::Turns => None,
        }
    }

    /// Opposite state of a normal constraint.
    pub fn switched(self) -> Self {
        RowState::closed_if(!self.is_closed())
    }
}

/// Constraint at the start of a step.
pub struct RowStart {
    /// Constraint function `Phi` at the start of the step.
    pub gap: f64,
    /// Constraint function `Phi` in the penalty potential at the end of the previous step.
    pub penalty_gap: f64,
    /// Constraint function `Phi` at which an active constraint is held.
    pub held: f64,
    /// Excess of `Phi` over `held` up to which the constraint is active from the start.
    pub closed: f64,
    /// True if the update rule keeps the gaps of active constraints.
    pub keeps: bool,
    /// True if the forces of the step are evaluated at its end.
    pub end_point: bool,
}

/// Condition of a step on a constraint.
pub struct ConstraintCondition {
    /// `Phi` at the start of the step, as used by the law.
    pub gap: f64,
    /// `Phi` of an active constraint at the end of the step.
    pub target: f64,
    /// True if the constraint takes part in the step.
    pub is_member: bool,
    /// Offset that the law adds to `Phi` at the end of the step.
    pub shift: f64,
}

/// Constraint at an iterate.
pub struct Row {
    /// Constraint function `Phi`.
    pub gap: f64,
    /// Multiplier.
    pub lambda: f64,
    /// Constraint function `Phi` at the start of the step.
    pub gap_n: f64,
    /// `Phi` at the end of the step if the constraint is active.
    pub target: f64,
    /// Offset that the law adds to `gap`.
    pub shift: f64,
    /// True if the forces of the step are evaluated at its end.
    pub end_point: bool,
    /// `Phi` per change of the multiplier within an iteration.
    pub compliance: f64,
    /// Augmentation parameter: multiplier per `Phi` in the trial multiplier `lambda - c (Phi - target)`.
    pub c: f64,
    /// Stiffness of the penalty potential; 0 without one.
    pub stiffness: f64,
    /// Magnitude of `Phi` that counts as zero.
    pub tolerance: f64,
}

/// Equation of a constraint: `A G_1 dq + B lambda + N lambda_n = r`, with the normal multiplier `lambda_n` beside a tangential constraint;
/// in space `+ A' G'_1 dq + B' lambda'` of each other tangential constraint of its group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equation {
    /// True if the multiplier may be nonzero.
    pub acts: bool,
    /// Coefficient `A` of the change `G_1 dq` of the constraint function.
    pub gradient: f64,
    /// Coefficient `B` of the multiplier.
    pub diagonal: f64,
    /// Coefficient `N` of the normal multiplier.
    pub normal: f64,
    /// Coefficients `A'` and `B'` of the other tangential constraints of the group, from the next one on and around.
    pub beside: [[f64; 2]; 2],
    /// Right side `r`.
    pub right: f64,
    /// Tangential compliance within the iteration: the state is that of the slip `u + compliance (lambda - lambda_k)`, with the multiplier
    /// `lambda_k` of the iterate.
    pub compliance: f64,
}

impl Equation {
    /// Equation `lambda = 0` of an inactive constraint.
    pub const OPEN: Equation =
        Equation { acts: false, gradient: 0.0, diagonal: 1.0, normal: 0.0, beside: [[0.0; 2]; 2], right: 0.0, compliance: 0.0 };

    /// Equation `G_1 dq + compliance lambda = right` of an active constraint.
    pub fn held(compliance: f64, right: f64) -> Equation {
        Equation { acts: true, gradient: 1.0, diagonal: compliance, right, ..Equation::OPEN }
    }
}

/// Law of constraints.
pub trait RowLaw: fmt::Debug + Send + Sync {
    /// True if the multiplier is an unknown; false if it is a function of `Phi`, the derivative of a potential.
    fn has_multiplier(&self) -> bool {
        true
    }

    /// True if the constraint is always active and its multiplier has any sign.
    fn is_bilateral(&self) -> bool {
        false
    }

    /// Condition of the step on the constraint.
    fn demand(&self, start: &RowStart) -> ConstraintCondition;

    /// State at the first iteration.
    fn first_state(&self, row: &Row) -> RowState;

    /// Natural residual as a length of `Phi`, and its energy.
    fn residual(&self, row: &Row) -> (f64, f64);

    /// Equation of an active constraint.
    fn equation(&self, row: &Row) -> Equation;

    /// Magnitude of the violation that requires a change of the state, or `None`; `row` has the values of the frozen linearization.
    fn change(&self, state: RowState, row: &Row) -> Option<f64>;

    /// Multiplier as a function of `Phi` for a potential.
    fn pressure(&self, _row: &Row) -> f64 {
        0.0
    }

    /// Energy of the penalty potential at `_gap`.
    fn energy(&self, _stiffness: f64, _gap: f64) -> f64 {
        0.0
    }
}
