//! What a linear solver is for the solver of steps: analyse a pattern, factor values, solve, report.

use serde::{Deserialize, Serialize};

use super::elimination_order::{Account, EliminationOrder};
use super::error::LinearError;
use super::factorization::{Factorization, Work};
use super::pattern::Pattern;
use super::watch::Watch;

/// What a solver keeps from one matrix to the next, as a value: sums depend on it in their last bits, so it belongs to the state of a run.
/// Copies share what is large.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverMemory {
    /// Order of elimination, once there is one.
    pub(super) order: Option<EliminationOrder>,
    /// What the order has cost.
    pub(super) account: Account,
}

impl SolverMemory {
    /// Whether it refers to nothing but itself, whatever file it comes from.
    pub fn is_sound(&self) -> bool {
        self.order.as_ref().is_none_or(EliminationOrder::is_sound)
    }
}

/// A direct or iterative solver of linear systems on a [`Pattern`].
pub trait LinearSolver: Send {
    /// Adapts to a pattern.
    ///
    /// # Errors
    /// The system does not fit into memory.
    fn analyse(&mut self, pattern: &Pattern) -> Result<(), LinearError>;

    /// Factors the matrix with these values.
    ///
    /// # Errors
    /// Values that are no numbers, lack of memory, an interrupt.
    fn factorize(&mut self, values: &[f64]) -> Result<(), LinearError>;

    /// Solves with the last factored values, which are given again; `right` becomes the solution. Gives the backward error.
    ///
    /// # Errors
    /// The matrix is singular, or the solution is not accurate.
    fn solve(&mut self, values: &[f64], right: &mut [f64]) -> Result<f64, LinearError>;

    /// An estimate of the vector that a singular matrix maps to zero, one number per unknown.
    fn near_null_vector(&self) -> Option<&[f64]>;

    /// Number of negative eigenvalues of the last factored matrix, if that was symmetric; `None` where its factors do not tell.
    fn negative_eigenvalues(&self) -> Option<usize> {
        None
    }

    /// What it keeps for the next matrix.
    fn memory(&self) -> SolverMemory;

    /// Puts an earlier memory in place; [`Self::analyse`] must follow.
    fn recall(&mut self, memory: &SolverMemory);

    /// What has been done since it was made.
    fn work(&self) -> Work;

    /// Bytes of the factors.
    fn bytes(&self) -> usize;

    /// Lets long work be looked into.
    fn set_watch(&mut self, watch: Watch);
}

impl LinearSolver for Factorization {
    fn analyse(&mut self, pattern: &Pattern) -> Result<(), LinearError> {
        self.renew(pattern)
    }

    fn factorize(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.factorize(values)
    }

    fn solve(&mut self, values: &[f64], right: &mut [f64]) -> Result<f64, LinearError> {
        self.solve(values, right)
    }

    fn near_null_vector(&self) -> Option<&[f64]> {
        self.near_null_vector()
    }

    fn negative_eigenvalues(&self) -> Option<usize> {
        self.negative_eigenvalues()
    }

    fn memory(&self) -> SolverMemory {
        SolverMemory { order: Some(self.order().clone()), account: self.account() }
    }

    fn recall(&mut self, memory: &SolverMemory) {
        if let Some(order) = &memory.order {
            self.restore_order(order, memory.account);
        }
    }

    fn work(&self) -> Work {
        self.work()
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }

    fn set_watch(&mut self, watch: Watch) {
        self.set_watch(watch);
    }
}
