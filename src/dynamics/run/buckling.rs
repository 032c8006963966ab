//! Linear buckling as values: load factors and shapes.

use thiserror::Error;

use super::modes::ModesError;

/// How a model buckles under the load of a state.
#[derive(Clone, Debug)]
pub struct Buckling {
    /// Time of the state `[time]`.
    pub time: f64,
    /// Factors of the load, the smallest first, all positive.
    pub factors: Vec<f64>,
    /// For each of them the displacements of the nodes of every body, the largest of length 1.
    pub shapes: Vec<Vec<Vec<[f64; 3]>>>,
    /// Whether there are no others below the last, counted by the inertia of the stiffness under a little more than that load.
    pub is_complete: bool,
    /// By how much the strain energy of the state differs from that of the linear model with the same displacements, relative.
    pub nonlinearity: f64,
}

/// Why there are no factors.
#[derive(Debug, Error)]
pub enum BucklingError {
    /// The matrix could not be made or solved with.
    #[error(transparent)]
    Matrix(#[from] ModesError),
    /// A load that turns with the surface.
    #[error("the load on \"{boundary}\" turns with its boundary")]
    Follows {
        /// `body.boundary`.
        boundary: String,
    },
    /// Nothing is loaded.
    #[error("the state is not loaded: it has no displacements")]
    Unloaded,
    /// Supports do not hold the model.
    #[error("the model is not held against rigid motions")]
    Loose,
    /// The load makes nothing softer.
    #[error("{found} of {count} load factors were found: in other shapes the load makes nothing softer")]
    NotFound {
        /// How many were asked for.
        count: usize,
        /// How many there are.
        found: usize,
    },
}

impl BucklingError {
    /// Its stable code, which `conserva doc` explains.
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
