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
