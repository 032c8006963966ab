//! What a system keeps from one step to the next.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::contact::Candidates;
use crate::linear::SolverMemory;

/// What a system keeps from one step to the next. Sums depend on it in their last bits, so it belongs to the state. States share what has
/// not changed between them; only what the solver counts is another one after every step.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SearchHistory {
    /// One for each contact pair that searches.
    pub candidates: Arc<Vec<Option<Candidates>>>,
    /// What the linear solver keeps.
    pub solver: SolverMemory,
}

impl SearchHistory {
    /// Whether it refers to what there is in the model of another one alone.
    pub fn is_sound_beside(&self, own: &Self) -> bool {
        let are_pairs_sound = |(found, own): (&Option<Candidates>, &Option<Candidates>)| match (found, own) {
            (Some(found), Some(own)) => found.is_sound_beside(own),
            (found, _) => found.is_none(),
        };
        let pairs = self.candidates.len() == own.candidates.len() && self.candidates.iter().zip(own.candidates.iter()).all(are_pairs_sound);
        pairs && self.solver.is_sound()
    }
}
