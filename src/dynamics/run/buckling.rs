//! Linear buckling as values: load factors and shapes.

use thiserror::Error;

use super::modes::ModesError;

/// Linear buckling under the load of a state.
#[derive(Clone, Debug)]
pub struct Buckling {
    /// Time of the state `[time]`.
    pub time: f64,
    /// Load factors in ascending order, all positive.
    pub factors: Vec<f64>,
    /// Buckling shapes: for each factor the displacements of the nodes of every body, the largest of length 1.
    pub shapes: Vec<Vec<Vec<[f64; 3]>>>,
    /// True if no factors are missed below the last one, by the inertia of the stiffness slightly above that load.
    pub is_complete: bool,
    /// Relative difference of the state's strain energy from that of the linear model with the same displacements.
    pub nonlinearity: f64,
}

/// Error of a buckling analysis.
#[derive(Debug, Error)]
pub enum BucklingError {
    /// The matrix could not be made or solved with.
    #[error(transparent)]
    Matrix(#[from] ModesError),
    /// A follower load, which rotates with the surface.
    #[error("the load on \"{boundary}\" turns with its boundary")]
    Follows {
        /// Name of the boundary, `body.boundary`.
        boundary: String,
    },
    /// No load acts.
    #[error("the state is not loaded: it has no displacements")]
    Unloaded,
    /// The supports do not prevent rigid motions.
    #[error("the model is not held against rigid motions")]
    Loose,
    /// The load reduces the stiffness in no direction.
    #[error("{found} of {count} load factors were found: in other shapes the load makes nothing softer")]
    NotFound {
        /// Requested number of factors.
        count: usize,
        /// Number of factors found.
        found: usize,
    },
}

impl BucklingError {
    /// Stable code of the error, explained by `conserva doc`.
    pub fn code(&self) -> &'static str {
        match self {
            BucklingError::Matrix(error) => error.code(),
            BucklingError::Follows { .. } => "C0721",
            BucklingError::Unloaded => "C0722",
            BucklingError::Loose => "C0723",
            BucklingError::NotFound { .. } => "C0724",
        }
    }
}
