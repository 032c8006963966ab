//! Data of Newton's method in one step: initial values and termination criteria, and the record of the iterations.

use super::attempts::PreferredAttempt;
use super::conditions::Conditions;
use super::convergence::Iteration;
use super::start::StepStart;

/// Iterations of Newton's method, for the report of a failure.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// The iterations of the last strategy.
    pub iterations: Vec<Iteration>,
    /// Displacements of the last iterate.
    pub u_1: Vec<f64>,
    /// Iterations of earlier strategies.
    pub earlier: Vec<Vec<Iteration>>,
}

/// Initial values and termination criteria of Newton's method.
pub struct Task<'a> {
    /// Step to be solved.
    pub start: &'a StepStart<'a>,
    /// Initial positions.
    pub predicted: &'a [f64],
    /// Displacements in the step to the initial positions.
    pub moved: &'a [f64],
    /// Initial multipliers.
    pub lambda: &'a [f64],
    /// Contact conditions of the step.
    pub conditions: &'a Conditions,
    /// Reference energy of the residual `[energy]`.
    pub energy: f64,
    /// Relative energy tolerance of the residual.
    pub tolerance: f64,
    /// True if the energy of the bodies is so small that the round-off of contact forces exceeds the tolerance.
    pub is_still: bool,
    /// Continue while the residual decreases, even below the tolerance.
    pub is_exact: bool,
    /// Least number of iterations: if a step starts at its own solution, its residual does no work on the first increment.
    pub at_least: usize,
    /// Do not abandon stagnating attempts (used where the step cannot be halved).
    pub is_patient: bool,
    /// Order of solution attempts, the last successful one first.
    pub preferred: PreferredAttempt,
    /// Returns true if the user interrupts the run.
    pub interrupted: &'a dyn Fn() -> bool,
}
