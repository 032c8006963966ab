//! What a simulation has counted so far: beside its state, all that its summary tells of how it came there.

use serde::{Deserialize, Serialize};

use super::halvings::{Halving, Halvings};
use crate::dynamics::model::bounds::Passed;

/// Counters of a simulation, to go on counting from. No step depends on them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    pub(super) steps: usize,
    pub(super) newton_iterations: usize,
    pub(super) halvings: usize,
    pub(super) factorizations: usize,
    pub(super) discarded: usize,
    pub(super) assemblies: usize,
    pub(super) causes: Halvings,
    /// The deepest place of a body in a rigid obstacle that its contact does not know.
    pub(super) passed: Option<Passed>,
}

impl Tally {
    /// Why steps were halved.
    pub fn causes(&self) -> &[Halving] {
        self.causes.all()
    }
}
