//! Counters of the work of linear solvers.

use serde::{Deserialize, Serialize};

/// Work counters; equal in every run and on every machine with equal instructions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    /// Work after an earlier count of the same solver.
    pub fn since(self, earlier: Work) -> Work {
        Work {
            factorizations: self.factorizations - earlier.factorizations,
            operations: self.operations - earlier.operations,
            structures: self.structures - earlier.structures,
            dissections: self.dissections - earlier.dissections,
            hierarchies: self.hierarchies - earlier.hierarchies,
            iterations: self.iterations - earlier.iterations,
        }
    }

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
}
