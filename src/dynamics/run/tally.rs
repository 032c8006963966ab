//! Counters of a simulation: the content of its summary beyond the state.

use serde::{Deserialize, Serialize};

use super::halvings::{Halving, Halvings};
use crate::dynamics::model::bounds::BodyPastObstacle;
use crate::linear::SolverCalls;

/// Counters of a simulation, for continuation. No step depends on them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    pub(super) steps: usize,
    pub(super) newton_iterations: usize,
    pub(super) halvings: usize,
    pub(super) factorizations: usize,
    pub(super) discarded: usize,
    pub(super) assemblies: usize,
    pub(super) solver_calls: SolverCalls,
    pub(super) causes: Halvings,
    /// Deepest penetration of a body into a rigid obstacle by a part of the body outside the contact definition.
    pub(super) passed: Option<BodyPastObstacle>,
}

impl Tally {
    /// Halvings by cause.
    pub fn causes(&self) -> &[Halving] {
        self.causes.all()
    }
}
