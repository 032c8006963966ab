//! Counters of the work of linear solvers.

/// Work counters; equal in every run and on every machine with equal instructions.
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
    pub(super) fn and(self, other: Work) -> Work {
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
