//! Reasons for which the iterative solver leaves a system to the direct one.

use crate::linear::error::LinearError;

/// Reason for which a system is not solved by iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::linear) enum Refusal {
    /// Most nodes of the matrix have constraints, or it has no nodes with coordinates.
    Unsuited,
    /// The residual did not fall far enough.
    NotConverged,
    /// An error that another solver has, too.
    Error(LinearError),
}
