//! Search results and solver data that a system keeps from one step to the next.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::contact::Candidates;
use crate::linear::SolverMemory;

/// Search results and solver data that a system keeps from one step to the next. Sums depend on them in the last bits, so they belong to
/// the state. States share unchanged data; only the solver's counters always change.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SearchHistory {
    /// Candidate pairs of each contact pair with a search.
    pub candidates: Arc<Vec<Option<Candidates>>>,
    /// Data of the linear solver.
    pub solver: SolverMemory,
}

impl SearchHistory {
    /// Size in bytes, without the data that is shared with `before`.
    pub fn size(self: &Arc<Self>, before: Option<&Arc<Self>>) -> usize {
        if before.is_some_and(|before| Arc::ptr_eq(self, before)) {
            return 0;
        }
        let are_shared = before.is_some_and(|before| Arc::ptr_eq(&self.candidates, &before.candidates));
        let candidates = if are_shared { 0 } else { self.candidates.iter().flatten().map(Candidates::size).sum() };
        size_of::<Self>() + candidates + self.solver.size(before.map(|before| &before.solver))
    }

    /// True if the search history refers only to entities of the model that `own` belongs to.
    pub fn is_sound_beside(&self, own: &Self) -> bool {
        let are_pairs_sound = |(found, own): (&Option<Candidates>, &Option<Candidates>)| match (found, own) {
            (Some(found), Some(own)) => found.is_sound_beside(own),
            (found, _) => found.is_none(),
        };
        let pairs = self.candidates.len() == own.candidates.len() && self.candidates.iter().zip(own.candidates.iter()).all(are_pairs_sound);
        pairs && self.solver.is_sound()
    }
}
