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
    /// Calls of the linear solvers in the run before it was resumed.
    pub calls_before_resume: SolverCalls,
    /// Calls of the linear solvers of this process at the time of the resume, which are not counted again.
    pub calls_at_resume: SolverCalls,
}
