//! Floor 1 of `ARCHITECTURE.md`: sparse pattern built once, block positions for assembly, factorisation (symbolic once per pattern, numeric
//! many times).
//!
//! The matrix belongs to a graph: one vertex per node with its coordinates, and one per group of constraints with its multipliers. Its
//! pattern is symmetric, its values are not. The position of each block is looked up once in the [`Pattern`]; assembly adds entries to a
//! flat array of values. A [`LinearSolver`] solves with these values: [`Factorization`] directly, folders of their own by iteration and on
//! the ranks of an MPI job, and [`solver_of`] chooses.

mod aligned;
mod assembly;
mod dense;
#[cfg(unix)]
mod distributed;
mod elimination_order;
mod error;
mod factorization;
#[cfg(test)]
mod fixtures;
mod fronts;
mod handover;
mod inertia;
mod iterative;
mod lanczos;
#[cfg(test)]
mod large_tests;
mod multifrontal;
mod node_matrix;
mod ordering;
mod panels;
mod partial_pivoting;
mod pattern;
mod places;
#[cfg(test)]
mod random_tests;
mod refinement;
mod scaling;
mod solver;
mod strips;
mod substitution;
mod symbolic;
#[cfg(test)]
mod tests;
mod tiles;
mod tree;
mod triangular;
mod waiting;
mod watch;
mod work;

#[cfg(unix)]
pub use distributed::{MpiProcess, become_rank, end_ranks};
pub use error::{LinearError, RanksError};
pub use factorization::Factorization;
pub use handover::{ITERATED, SolverChoice, solver_of};
pub use lanczos::{Lanczos, Operator, Ritz, product};
pub use node_matrix::NodeMatrix;
pub use pattern::{Block, Pattern, Role, Vertex};
pub use solver::{LinearSolver, SolverMemory, TakenOver};
pub use watch::InterruptWatch;
pub use work::{SolverCalls, Work};
