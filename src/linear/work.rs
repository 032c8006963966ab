//! Counters of the work of linear solvers.

use serde::{Deserialize, Serialize};

/// Work counters of linear solvers; reproducible on machines with equal instruction sets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Numeric factorisations.
    pub factorizations: usize,
    /// Floating-point operations of all factorizations.
    pub operations: f64,
    /// Symbolic factorisations.
    pub structures: usize,
    /// Nested dissections.
    pub dissections: usize,
    /// Hierarchies of coarser matrices made by the iterative solver.
    pub hierarchies: usize,
    /// Iterations of the iterative solver.
    pub iterations: usize,
}

impl Work {
    /// Sum of two counts.
    pub fn and(self, other: Work) -> Work {
        Work {
            factorizations: self.factorizations + other.factorizations,
            operations: self.operations + other.operations,
            structures: self.structures + other.structures,
            dissections: self.dissections + other.dissections,
            hierarchies: self.hierarchies + other.hierarchies,
            iterations: self.iterations + other.iterations,
        }
    }

    /// Calls of the two solvers, direct and iterative.
    pub fn solver_calls(self) -> SolverCalls {
        SolverCalls { factorizations: self.factorizations, iterations: self.iterations }
    }
}

/// Work counters that do not depend on an interruption of the run: a resumed run makes additional structures, but no additional calls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverCalls {
    /// Numeric factorizations of the direct solver.
    pub factorizations: usize,
    /// Iterations of the iterative solver.
    pub iterations: usize,
}

impl SolverCalls {
    /// Adds the difference of two counts, `self + later - earlier`.
    pub fn plus(self, later: SolverCalls, earlier: SolverCalls) -> SolverCalls {
        SolverCalls {
            factorizations: self.factorizations + later.factorizations - earlier.factorizations,
            iterations: self.iterations + later.iterations - earlier.iterations,
        }
    }
}
