//! Counters and wall-clock times of the work on the equations of a model.

use std::time::Duration;

use crate::linear::SolverCalls;

/// Wall-clock time by phase since the simulation was made.
#[derive(Clone, Copy, Debug, Default)]
pub struct PhaseTimes {
    /// Element loop: residual and tangent.
    pub assembly: Duration,
    /// Evaluation of contact functions and their tangents.
    pub contact: Duration,
    /// Symbolic and numeric factorisation.
    pub factorization: Duration,
    /// Forward and backward substitution with refinement.
    pub solve: Duration,
    /// Search for candidate pairs.
    pub search: Duration,
}

/// Work done so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counters {
    /// Time by phase.
    pub times: PhaseTimes,
    /// Numeric factorisations.
    pub factorizations: usize,
    /// Factorizations of failed attempts and of undone steps.
    pub discarded: usize,
    /// Number of force evaluations.
    pub assemblies: usize,
    /// Calls of the linear solvers that a continued run counts from, and the solvers' own count at that time.
    pub solver_calls_before: [SolverCalls; 2],
}
