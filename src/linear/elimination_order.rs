//! Order of elimination and blocks with room in the factors, as a value that can be stored and restored.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ordering::{Order, anchored};
use super::pattern::{Couplings, Pattern};
use super::symbolic::Symbolic;

/// An order of elimination, which outlives changes of the pattern, and the blocks that the factors have room for: which ones are in use
/// depends on the matrices before. It stays equal to itself while matrices are factored, and copies share it; what is counted meanwhile is
/// an [`Account`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EliminationOrder {
    /// The order that was found best.
    pub(super) found: Arc<Order>,
    /// Work of a factorisation when the order was made.
    pub(super) best: f64,
    /// The couplings whose blocks are in the structure; none before the first matrix.
    pub(super) kept: Arc<Couplings>,
    /// Work of a factorisation when `kept` was that of one matrix alone.
    pub(super) least: f64,
}

/// Cost counters since an order and its blocks were chosen. They decide when the order is replaced, so an earlier order is restored
/// together with its counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Account {
    /// Factorisations since the blocks were those of one matrix alone.
    pub(super) uses: usize,
    /// Work in excess of the best since the order was made.
    pub(super) wasted: f64,
}

impl EliminationOrder {
    /// Size of the data in bytes that is not shared with `before`.
    pub(super) fn size(&self, before: Option<&Self>) -> usize {
        let order = if before.is_some_and(|before| Arc::ptr_eq(&self.found, &before.found)) { 0 } else { self.found.size() };
        let kept = if before.is_some_and(|before| Arc::ptr_eq(&self.kept, &before.kept)) { 0 } else { self.kept.size() };
        order + kept
    }

    /// True if the order and its structure have as many vertices as the pattern.
    pub(super) fn fits(&self, pattern: &Pattern) -> bool {
        self.found.vertices.len() == pattern.vertices() && self.kept.vertices() == pattern.vertices()
    }

    /// True if the order is consistent with its number of vertices, whatever file it was read from.
    pub fn is_sound(&self) -> bool {
        let count = self.found.vertices.len();
        self.found.is_sound() && self.kept.is_sound() && (self.kept.vertices() == 0 || self.kept.vertices() == count)
    }

    /// The structure of the factors in this order, with these blocks of a pattern.
    pub(super) fn structure(&self, pattern: &Pattern, couplings: &Couplings) -> Symbolic {
        let restricted = pattern.restricted(couplings);
        Symbolic::new(&restricted, &anchored(&restricted, &self.found.repaired(&restricted)))
    }
}
