//! Natural vibrations as values: frequencies, shapes, participating masses.

use std::f64::consts::TAU;

use thiserror::Error;

use crate::dynamics::model::step_error::StepError;

/// Vibrations about a state, the slowest first.
#[derive(Clone, Debug)]
pub struct Modes {
    /// Time of the state `[time]`.
    pub time: f64,
    /// Vibration modes, the slowest first.
    pub modes: Vec<Mode>,
    /// Mass of the model `[mass]`.
    pub mass: f64,
    /// Directions in which effective masses are given, as indices of coordinates.
    pub directions: Vec<usize>,
    /// True if the inertia count confirms that no vibration is missed.
    pub is_complete: bool,
    /// Largest asymmetry of the stiffness relative to its largest entry, caused by follower loads; modes belong to the symmetric part.
    pub asymmetry: f64,
    /// Number of factorizations, and number of applications of the inverse operator.
    pub work: [usize; 2],
}

/// A vibration.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Square of the angular frequency `[1/time^2]`; negative for an unstable direction, 0 below round-off.
    pub eigenvalue: f64,
    /// Displacements of the nodes of every body, the largest of length 1.
    pub shape: Vec<Vec<[f64; 3]>>,
    /// Modal mass of the scaled shape, `x^T M x` `[mass]`.
    pub modal_mass: f64,
    /// Participation factor of this vibration for a unit motion along each direction, `x^T M e / x^T M x`.
    pub participation: Vec<f64>,
    /// Mass that vibrates along each direction, `(x^T M e)^2 / x^T M x` `[mass]`.
    pub effective_mass: Vec<f64>,
    /// Relative residual of the eigenvector.
    pub residual: f64,
}

impl Mode {
    /// Angular frequency `[1/time]`; 0 for an instability.
    pub fn angular_frequency(&self) -> f64 {
        self.eigenvalue.max(0.0).sqrt()
    }

    /// Oscillations per time `[1/time]`; 0 for an instability.
    pub fn frequency(&self) -> f64 {
        self.angular_frequency() / TAU
    }

    /// Growth rate of an instability, 0 for a vibration `[1/time]`.
    pub fn growth(&self) -> f64 {
        (-self.eigenvalue).max(0.0).sqrt()
    }
}

/// Error of a modal analysis.
#[derive(Debug, Error)]
pub enum ModesError {
    /// The stiffness cannot be computed, or the run was interrupted.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The matrix is singular for every shift.
    #[error("the constraints of the state depend on one another")]
    Dependent,
    /// More modes are requested than the model has motions.
    #[error("the model has {motions} motions that supports and constraints leave, fewer than {count}")]
    TooMany {
        /// Requested number of modes.
        count: usize,
        /// Number of motions admitted by supports and constraints.
        motions: usize,
    },
    /// Lanczos' method did not find all requested modes.
    #[error("{found} of {count} modes were found with {vectors} vectors")]
    NotFound {
        /// Requested number of modes.
        count: usize,
        /// Number of converged modes.
        found: usize,
        /// Number of vectors used.
        vectors: usize,
    },
}

impl ModesError {
    /// Stable code of the error, explained by `conserva doc`.
    pub fn code(&self) -> &'static str {
        match self {
            ModesError::Step(error) => error.code(),
            ModesError::Dependent => "C0701",
            ModesError::TooMany { .. } => "C0702",
            ModesError::NotFound { .. } => "C0703",
        }
    }
}
