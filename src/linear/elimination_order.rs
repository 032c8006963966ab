//! Order of elimination and block structure of the factors, as a value that can be stored and restored.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ordering::{Order, anchored};
use super::pattern::{Couplings, Pattern};
use super::symbolic::Symbolic;

/// Order of elimination, valid across pattern changes, and the couplings whose blocks the factors include, which depend on earlier
/// matrices. It is constant during factorizations and shared by copies; counters are in an [`Account`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EliminationOrder {
    /// Best order of elimination found.
    pub(super) found: Arc<Order>,
    /// Operations of a factorization at the time when the order was made.
    pub(super) best: f64,
    /// Couplings whose blocks are in the structure of the factors; empty before the first matrix.
    pub(super) kept: Arc<Couplings>,
    /// Operations of a factorization when `kept` contained the couplings of a single matrix.
    pub(super) least: f64,
}

/// Cost counters since an order and its blocks were chosen. They decide when the order is replaced, so an earlier order is restored
/// together with its counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Account {
    /// Number of factorizations since `kept` was reset to the couplings of one matrix.
    pub(super) uses: usize,
    /// Sum of the operations beyond `best` of all factorizations since the order was made.
    pub(super) wasted: f64,
}

impl EliminationOrder {
    /// Bytes of the data that is not shared with the earlier value `before`.
    pub(super) fn size(&self, before: Option<&Self>) -> usize {
        let order = if before.is_some_and(|before| Arc::ptr_eq(&self.found, &before.found)) { 0 } else { self.found.size() };
        let kept = if before.is_some_and(|before| Arc::ptr_eq(&self.kept, &before.kept)) { 0 } else { self.kept.size() };
        order + kept
    }

    /// True if the order and its structure have as many vertices as the pattern.
    pub(super) fn fits(&self, pattern: &Pattern) -> bool {
        self.found.vertices.len() == pattern.vertices() && self.kept.vertices() == pattern.vertices()
    }

    /// False if the order is no valid permutation or its tree is invalid, as is possible for a value read from a file.
    pub fn is_sound(&self) -> bool {
        let count = self.found.vertices.len();
        self.found.is_sound() && self.kept.is_sound() && (self.kept.vertices() == 0 || self.kept.vertices() == count)
    }

    /// Structure of the factors in this order, with the given couplings of a pattern.
    pub(super) fn structure(&self, pattern: &Pattern, couplings: &Couplings) -> Symbolic {
        let restricted = pattern.restricted(couplings);
        Symbolic::new(&restricted, &anchored(&restricted, &self.found.repaired(&restricted)))
    }
}
