//! Errors of the linear solver.

use thiserror::Error;

use crate::machine::memory::{Shortage, written};

/// Errors of the linear solver.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum LinearError {
    /// The matrix is singular up to round-off; `Factorization::near_null_vector` estimates a null vector.
    #[error("the matrix is singular")]
    Singular {
        /// Vertex at which the null vector, scaled by the stiffness of each vertex, is largest.
        vertex: Option<u32>,
    },
    /// A value of the matrix or of the right-hand side is infinite or not a number.
    #[error("the matrix or the right-hand side is not finite")]
    NotFinite,
    /// The solution does not satisfy the system.
    #[error("the linear solve left a relative residual of {residual:.1e}")]
    Inaccurate {
        /// Largest residual component divided by the largest component of the right-hand side.
        residual: f64,
    },
    /// The factorization was ended by the interrupt flag of its [`InterruptWatch`](super::InterruptWatch).
    #[error("the factorisation was interrupted")]
    Interrupted,
    /// There is not enough memory.
    #[error("the factorisation of {unknowns} unknowns does not fit into memory: it takes at least {}", written(*needed))]
    OutOfMemory {
        /// Number of unknowns.
        unknowns: usize,
        /// Least number of bytes needed.
        needed: u64,
    },
}

impl LinearError {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            LinearError::Singular { .. } => "C0521",
            LinearError::NotFinite => "C0522",
            LinearError::Inaccurate { .. } => "C0523",
            LinearError::Interrupted => "C0524",
            LinearError::OutOfMemory { .. } => "C0525",
        }
    }

    /// Returns the error of equations that do not fit into memory.
    pub fn out_of_memory(unknowns: usize, shortage: Shortage) -> Self {
        LinearError::OutOfMemory { unknowns, needed: shortage.needed }
    }
}
