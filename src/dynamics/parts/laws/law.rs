//! What the law of a constraint row is.
//!
//! A row has a constraint function `Phi` (a weighted gap) and a multiplier `lambda`, which presses with `lambda grad Phi`. The law says
//! what a step demands of the two, by how much an iterate is off, and which equation a row that holds has in Newton's system,
//!
//! ```text
//! A G_1 dq + B lambda + N lambda_n = r,
//! ```
//!
//! with `G_1` the gradient of `Phi` at the end of the step and `dq` the increment; `lambda_n` is there for tangential rows
//! (`friction_rows.rs`) alone. In space these come in groups of two (`slip_vector.rs`), of which each also has the other one's slip and
//! multiplier in its equation. A law knows neither methods nor surfaces.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What a constraint row is in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RowState {
    /// Its multiplier is zero.
    #[default]
    Open,
    /// Its condition holds, its multiplier may press; a tangential row sticks.
    Closed,
    /// A tangential row slides, its multiplier is positive; in space a group of them slides in whatever direction.
    Forward,
    /// A tangential row slides, its multiplier is negative.
    Backward,
    /// A tangential row comes to rest: at the end of the step it has no speed.
    Stops,
    /// A tangential row turns around within the step, without dry friction.
    Turns,
}

impl RowState {
    /// Closed where that is so, open otherwise.
    pub fn closed_if(is_closed: bool) -> Self {
        if is_closed { RowState::Closed } else { RowState::Open }
    }

    /// Whether it is closed.
    pub fn is_closed(self) -> bool {
        self == RowState::Closed
    }

    /// Whether its multiplier follows from an equation of its gap or slip.
    pub fn holds(self) -> bool {
        matches!(self, RowState::Closed | RowState::Stops)
    }

    /// Whether it is a tangential row that has a speed at the end of the step.
    pub fn slides(self) -> bool {
        matches!(self, RowState::Forward | RowState::Backward | RowState::Turns)
    }

    /// Whether its multiplier may differ from zero.
    pub fn acts(self) -> bool {
        self != RowState::Open
    }

    /// The state of a tangential row that slides against a multiplier of that sign.
    pub fn sliding(multiplier: f64) -> Self {
        if multiplier > 0.0 { RowState::Forward } else { RowState::Backward }
    }

    /// Sign of the multiplier of a tangential row that slides.
    pub fn sense(self) -> Option<f64> {
        match self {
            RowState::Forward => Some(1.0),
            RowState::Backward => Some(-1.0),
            RowState::Open | RowState::Closed | RowState::Stops | RowState::Turns => None,
        }
    }

    /// The other state of a row that presses or is open.
    pub fn switched(self) -> Self {
        RowState::closed_if(!self.is_closed())
    }
}

/// A row where a step starts.
pub struct RowStart {
    /// `Phi` there.
    pub gap: f64,
    /// `Phi` as the row's potential had it at the end of the step before.
    pub penalty_gap: f64,
    /// `Phi` of a closed row.
    pub held: f64,
    /// `Phi` above that which counts as closed.
    pub closed: f64,
    /// Whether the update rule keeps what is closed as it is.
    pub keeps: bool,
    /// Whether forces are those of the end of the step.
    pub end_point: bool,
}

/// What a step demands of a row.
pub struct Demand {
    /// `Phi` at the start of the step as the law takes it.
    pub gap: f64,
    /// `Phi` of the row at the end of the step where it holds.
    pub target: f64,
    /// Whether it takes part in the step.
    pub is_member: bool,
    /// By how much the law takes `Phi` larger than it is at the end.
    pub shift: f64,
}

/// A row at an iterate.
pub struct Row {
    /// `Phi`.
    pub gap: f64,
    /// Multiplier.
    pub lambda: f64,
    /// `Phi` at the start of the step, as [`Demand::gap`].
    pub gap_n: f64,
    /// `Phi` at the end of the step where the row holds.
    pub target: f64,
    /// By how much the law takes `gap` larger than it is.
    pub shift: f64,
    /// Whether forces are those of the end of the step.
    pub end_point: bool,
    /// `Phi` per change of the multiplier within an iteration.
    pub compliance: f64,
    /// Pressure per `Phi`, which compares the two.
    pub c: f64,
    /// Stiffness of the row's potential, if it has one.
    pub stiffness: f64,
    /// `Phi` that counts as zero.
    pub tolerance: f64,
}

/// The equation of a row: `A G_1 dq + B lambda + N lambda_n = r`, with the pressing multiplier `lambda_n` of a tangential row; in space
/// `+ A' G'_1 dq + B' lambda'` of the other tangential row of its group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equation {
    /// Whether its multiplier presses.
    pub acts: bool,
    /// `A`.
    pub gradient: f64,
    /// `B`.
    pub diagonal: f64,
    /// `N`.
    pub normal: f64,
    /// `A'` and `B'`.
    pub beside: [f64; 2],
    /// `r`.
    pub right: f64,
    /// Compliance of a tangential row within the iteration: its state is that of the slip `u + compliance (lambda - lambda_k)`, with the
    /// multiplier `lambda_k` of the iterate.
    pub compliance: f64,
}

impl Equation {
    /// `lambda = 0`.
    pub const OPEN: Equation =
        Equation { acts: false, gradient: 0.0, diagonal: 1.0, normal: 0.0, beside: [0.0; 2], right: 0.0, compliance: 0.0 };

    /// `G_1 dq + compliance lambda = right`.
    pub fn held(compliance: f64, right: f64) -> Equation {
        Equation { acts: true, gradient: 1.0, diagonal: compliance, right, ..Equation::OPEN }
    }
}

/// The law of constraint rows.
pub trait RowLaw: fmt::Debug + Send + Sync {
    /// Whether the multiplier is an unknown that a condition determines; else it is a function of `Phi`, the derivative of a potential.
    fn has_multiplier(&self) -> bool {
        true
    }

    /// Whether the row holds always and may pull.
    fn is_bilateral(&self) -> bool {
        false
    }

    /// What a step demands.
    fn demand(&self, start: &RowStart) -> Demand;

    /// The state with which an iteration begins.
    fn first_state(&self, row: &Row) -> RowState;

    /// Natural residual: by how much the row is off, as a length of `Phi`, and the energy that goes with it.
    fn residual(&self, row: &Row) -> (f64, f64);

    /// The equation of the row where it holds.
    fn equation(&self, row: &Row) -> Equation;

    /// Whether the row is to change its state, and how strongly it asks for that; `row` is what the frozen linearization makes of it.
    fn change(&self, state: RowState, row: &Row) -> Option<f64>;

    /// The multiplier that belongs to `Phi` where a potential gives it.
    fn pressure(&self, _row: &Row) -> f64 {
        0.0
    }

    /// Energy that the row's potential stores where it has this `Phi`.
    fn energy(&self, _stiffness: f64, _gap: f64) -> f64 {
        0.0
    }
}
