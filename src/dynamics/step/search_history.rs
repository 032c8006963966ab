//! What a system keeps from one step to the next.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::contact::Candidates;
use crate::linear::{Account, EliminationOrder};

/// What a system keeps from one step to the next. Sums depend on it in their last bits, so it belongs to the state. States share what has
/// not changed between them; only the account is another one after every step.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SearchHistory {
    /// One for each contact pair that searches.
    pub candidates: Arc<Vec<Option<Candidates>>>,
    /// Order of elimination.
    pub order: Option<EliminationOrder>,
    /// What the order has cost.
    pub account: Account,
}

impl SearchHistory {
    /// Whether it refers to what there is in the model of another one alone.
    pub fn is_sound_beside(&self, own: &Self) -> bool {
        let are_pairs_sound = |(found, own): (&Option<Candidates>, &Option<Candidates>)| match (found, own) {
            (Some(found), Some(own)) => found.is_sound_beside(own),
            (found, _) => found.is_none(),
        };
        let pairs = self.candidates.len() == own.candidates.len() && self.candidates.iter().zip(own.candidates.iter()).all(are_pairs_sound);
        pairs && self.order.as_ref().is_none_or(EliminationOrder::is_sound)
    }
}
