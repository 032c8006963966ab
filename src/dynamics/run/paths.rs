//! Paths of equilibria as values: states along a load, where they lose their stability, how the path ended.

use std::sync::Arc;

use thiserror::Error;

use super::state::State;
use crate::dynamics::model::step_error::StepError;

/// How a path is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathOptions {
    /// Time of the loads at which the path ends `[time]`.
    pub until: f64,
    /// First increment of it `[time]`.
    pub increment: f64,
    /// Points at most.
    pub points: usize,
    /// Whether the load may fall on the way: the length of the path is given, not its load.
    pub by_arc: bool,
}

/// Equilibria along a load.
#[derive(Clone, Debug)]
pub struct Path {
    /// The equilibria, from that at which the path begins.
    pub points: Vec<PathPoint>,
    /// Where stability is lost or gained.
    pub critical: Vec<CriticalPoint>,
    /// How it ended.
    pub end: PathEnd,
}

/// An equilibrium on a path.
#[derive(Clone, Debug)]
pub struct PathPoint {
    /// The state.
    pub state: Arc<State>,
    /// In how many directions it is unstable; none where the factors do not tell.
    pub unstable: Option<usize>,
    /// Length of the path up to it, in displacements of all nodes `[length]`.
    pub length: f64,
}

/// Where the stiffness is singular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalPoint {
    /// Which kind it is.
    pub kind: CriticalKind,
    /// The load there, as a time `[time]`: of a limit point the extremum of the parabola through the points beside it, of others
    /// where the eigenvalue that changes its sign between two points vanishes.
    pub load: f64,
    /// The point before it.
    pub after: usize,
}

/// Kinds of critical points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CriticalKind {
    /// The load has an extremum.
    Limit,
    /// Another path branches off.
    Bifurcation,
}

/// How a path ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PathEnd {
    /// At the load that was asked for.
    Reached,
    /// With as many points as were allowed.
    Points,
    /// No further equilibrium was found, and why.
    Lost(String),
}

/// Why there is no path.
#[derive(Debug, Error)]
pub enum PathError {
    /// The first equilibrium was not found, or the run was interrupted.
    #[error(transparent)]
    Step(#[from] StepError),
    /// Sides may touch and part.
    #[error("contact \"{contact}\" may close and open, which the search for equilibria along a path does not follow")]
    Contact {
        /// Its name.
        contact: String,
    },
}

impl PathError {
    /// Its stable code, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            PathError::Step(error) => error.code(),
            PathError::Contact { .. } => "C0731",
        }
    }
}
