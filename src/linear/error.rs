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
    /// MPI processes (ranks) of the distributed solver that are missing, or have ended too early.
    #[error(transparent)]
    Ranks(#[from] RanksError),
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
            LinearError::Ranks(error) => error.code(),
        }
    }

    /// Returns the error of equations that do not fit into memory.
    pub fn out_of_memory(unknowns: usize, shortage: Shortage) -> Self {
        LinearError::OutOfMemory { unknowns, needed: shortage.needed }
    }
}

/// Failures of the ranks of the distributed solver.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum RanksError {
    /// The program of a rank is not installed.
    #[error("the distributed solver is not installed: there is no program conserva-mumps")]
    NoProgram,
    /// The command that starts several processes is not installed.
    #[error("the ranks of the distributed solver cannot be started: there is no mpirun")]
    NoLauncher,
    /// The processes did not connect.
    #[error("the ranks of the distributed solver did not start")]
    NotStarted,
    /// A rank has ended while it was needed.
    #[error("a rank of the distributed solver was lost")]
    Lost,
}

impl RanksError {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            RanksError::NoProgram | RanksError::NoLauncher => "C0526",
            RanksError::NotStarted => "C0527",
            RanksError::Lost => "C0528",
        }
    }

    /// Suggested remedy in one sentence.
    pub fn hint(&self) -> &'static str {
        match self {
            RanksError::NoProgram | RanksError::NoLauncher => {
                "install MPI and MUMPS (Debian: `apt-get install libmumps-dev libopenmpi-dev openmpi-bin`) and build the program with \
                 `packages/mumps/build.sh`; it is looked for beside conserva, on the PATH, and as CONSERVA_MUMPS names it"
            }
            RanksError::NotStarted => {
                "see what mpirun writes to standard error; it starts no more ranks than cores without `--oversubscribe`, and none for root \
                 without `--allow-run-as-root`"
            }
            RanksError::Lost => {
                "mpirun writes to standard error which rank has ended, and why; resume it with ranks, or with another solver"
            }
        }
    }
}
