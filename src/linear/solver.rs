//! Interface of linear solvers for the solution of steps: pattern analysis, factorization, solution, report.

use serde::{Deserialize, Serialize};

use super::elimination_order::{Account, EliminationOrder};
use super::error::LinearError;
use super::factorization::Factorization;
use super::pattern::Pattern;
use super::watch::InterruptWatch;
use super::work::Work;

/// State that a solver keeps from one matrix to the next. The last bits of sums depend on it, so it belongs to the state of a run. Copies
/// share large data.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverMemory {
    /// Order of elimination; `None` before the first matrix.
    pub(super) order: Option<EliminationOrder>,
    /// Cost counters of the order.
    pub(super) account: Account,
    /// Matrices that the direct solver took over from the iterative one.
    pub(super) taken_over: TakenOver,
}

/// Matrices that the direct solver solved in place of the chosen one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TakenOver {
    /// Matrices for which the iteration did not converge, or MUMPS found no accurate solution.
    pub unconverged: u32,
    /// True if half of the nodes of a matrix or more have constraints, so that the coarsest level would be the matrix itself.
    pub is_unsuited: bool,
}

impl SolverMemory {
    /// Bytes of the data that is not shared with the earlier value `before`.
    pub fn size(&self, before: Option<&Self>) -> usize {
        self.order.as_ref().map_or(0, |order| order.size(before.and_then(|before| before.order.as_ref())))
    }

    /// False if indices are inconsistent, as is possible for a value read from a file.
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

    /// Sets the positions of the nodes at the start of a step: as many numbers for each of the leading vertices as it has unknowns. They
    /// determine the rigid motions that an iterative solver represents on coarse levels.
    fn locate(&mut self, _positions: &[f64]) {}

    /// Factorizes the matrix with these values.
    ///
    /// # Errors
    /// Values that are not finite, lack of memory, an interrupt.
    fn factorize(&mut self, values: &[f64]) -> Result<(), LinearError>;

    /// Factorizes the matrix with these values so that its inertia is available.
    ///
    /// # Errors
    /// Values that are not finite, lack of memory, an interrupt.
    fn factorize_directly(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.factorize(values)
    }

    /// Solves with the last factored values, which are given again; `rights`, right-hand sides one after another, become the solutions.
    /// Returns the largest backward error.
    ///
    /// # Errors
    /// The matrix is singular, or a solution is not accurate.
    fn solve(&mut self, values: &[f64], rights: &mut [f64]) -> Result<f64, LinearError>;

    /// Solves like [`Self::solve`] without refinement and without an error for an inaccurate solution: for estimates.
    ///
    /// # Errors
    /// The matrix is singular, or its solution is not found.
    fn estimate(&mut self, values: &[f64], rights: &mut [f64]) -> Result<(), LinearError> {
        self.solve(values, rights).map(drop)
    }

    /// Number of right-hand sides whose estimated solutions cost about as much as another factorization with one.
    fn substitutions_for_a_factorization(&self) -> usize;

    /// Estimated null vector of a singular matrix, one number per unknown.
    fn near_null_vector(&self) -> Option<&[f64]>;

    /// Number of negative eigenvalues of the last factored matrix, if symmetric; `None` if the factors do not provide it.
    fn negative_eigenvalues(&self) -> Option<usize> {
        None
    }

    /// Returns the state kept for the next matrix.
    fn memory(&self) -> SolverMemory;

    /// Restores an earlier state; [`Self::analyse`] must follow.
    fn recall(&mut self, memory: &SolverMemory);

    /// Returns the counters of the work done by this solver.
    fn work(&self) -> Work;

    /// Returns the matrices that a direct solver took over from an iterative one.
    fn taken_over(&self) -> TakenOver {
        TakenOver::default()
    }

    /// Bytes of the factors.
    fn bytes(&self) -> usize;

    /// Largest memory of each rank of a distributed solver `[bytes]`; empty for others.
    fn rank_bytes(&self) -> &[u64] {
        &[]
    }

    /// Sets the interrupt flag and the progress counter of long work.
    fn set_watch(&mut self, watch: InterruptWatch);
}

impl LinearSolver for Factorization {
    fn analyse(&mut self, pattern: &Pattern) -> Result<(), LinearError> {
        self.renew(pattern)
    }

    fn factorize(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.factorize(values)
    }

    fn solve(&mut self, values: &[f64], rights: &mut [f64]) -> Result<f64, LinearError> {
        self.solve_all(values, rights)
    }

    fn estimate(&mut self, values: &[f64], rights: &mut [f64]) -> Result<(), LinearError> {
        self.estimate(values, rights)
    }

    fn substitutions_for_a_factorization(&self) -> usize {
        self.substitutions_for_a_factorization()
    }

    fn near_null_vector(&self) -> Option<&[f64]> {
        self.near_null_vector()
    }

    fn negative_eigenvalues(&self) -> Option<usize> {
        self.negative_eigenvalues()
    }

    fn memory(&self) -> SolverMemory {
        SolverMemory { order: Some(self.order().clone()), account: self.account(), taken_over: TakenOver::default() }
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

    fn set_watch(&mut self, watch: InterruptWatch) {
        self.set_watch(watch);
    }
}
