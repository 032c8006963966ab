//! Paths of equilibria as values: states along a load, critical points, termination.

use std::sync::Arc;

use thiserror::Error;

use super::state::State;
use crate::dynamics::model::step_error::StepError;

/// Options of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathOptions {
    /// Time of the loads at which the path ends `[time]`.
    pub until: f64,
    /// First increment of the load `[time]`.
    pub increment: f64,
    /// Largest number of points.
    pub points: usize,
    /// Arc-length control: the load may decrease along the path.
    pub by_arc: bool,
}

/// Equilibria along a load.
#[derive(Clone, Debug)]
pub struct Path {
    /// Equilibria on the path, from its start on.
    pub points: Vec<PathPoint>,
    /// Critical points, where stability is lost or gained.
    pub critical: Vec<CriticalPoint>,
    /// Reason of the termination.
    pub end: PathEnd,
}

/// An equilibrium on a path.
#[derive(Clone, Debug)]
pub struct PathPoint {
    /// State in this equilibrium.
    pub state: Arc<State>,
    /// Number of unstable directions; `None` if the inertia is not available.
    pub unstable: Option<usize>,
    /// Length of the path up to this point, in displacements of all nodes `[length]`.
    pub length: f64,
}

/// Critical point, where the stiffness is singular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalPoint {
    /// Kind of the critical point.
    pub kind: CriticalKind,
    /// Load at the critical point, as a time `[time]`: for a limit point the extremum of the parabola through the adjacent points, for
    /// others the zero of the eigenvalue that changes its sign between two points.
    pub load: f64,
    /// Index of the path point before the critical point.
    pub after: usize,
}

/// Kinds of critical points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CriticalKind {
    /// The load has an extremum.
    Limit,
    /// Another path branches off at this point.
    Bifurcation,
}

/// Reason of a path's termination.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PathEnd {
    /// The requested load was reached.
    Reached,
    /// The largest number of points was reached.
    Points,
    /// No further equilibrium was found; the reason.
    Lost(String),
}

/// Error of a path.
#[derive(Debug, Error)]
pub enum PathError {
    /// The first equilibrium was not found, or the run was interrupted.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The model has a contact that may close and open.
    #[error("contact \"{contact}\" may close and open, which the search for equilibria along a path does not follow")]
    Contact {
        /// Name of the contact.
        contact: String,
    },
}

impl PathError {
    /// Stable code of the error, explained by `conserva doc`.
    pub fn code(&self) -> &'static str {
        match self {
            PathError::Step(error) => error.code(),
            PathError::Contact { .. } => "C0731",
        }
    }
}
