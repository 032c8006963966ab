//! Reasons for which the direct solver takes over a system from the iterative solver.

use crate::linear::error::LinearError;

/// Reason for which a system is not solved by iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::linear) enum Refusal {
    /// Most nodes of the matrix have constraints, or it has no nodes with coordinates.
    Unsuited,
    /// The residual did not decrease to the required tolerance.
    NotConverged,
    /// An error that also occurs with the direct solver.
    Error(LinearError),
}
