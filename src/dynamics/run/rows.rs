//! Rows of a ledger in their order, in memory or on disk.

use super::ledger::LedgerRow;

/// Ordered rows of a ledger, such as an array or a history whose older rows are on disk.
pub trait Rows {
    /// Number of rows of the ledger.
    fn count(&self) -> usize;

    /// Calls a function with every row from index `from` on.
    fn visit(&self, from: usize, each: &mut dyn FnMut(&LedgerRow));

    /// Last row of the ledger; `None` if it has no rows.
    fn last_row(&self) -> Option<LedgerRow>;
}

impl Rows for [LedgerRow] {
    fn count(&self) -> usize {
        self.len()
    }

    fn visit(&self, from: usize, each: &mut dyn FnMut(&LedgerRow)) {
        self.iter().skip(from).for_each(each);
    }

    fn last_row(&self) -> Option<LedgerRow> {
        self.last().cloned()
    }
}

impl Rows for Vec<LedgerRow> {
    fn count(&self) -> usize {
        self.len()
    }

    fn visit(&self, from: usize, each: &mut dyn FnMut(&LedgerRow)) {
        self.as_slice().visit(from, each);
    }

    fn last_row(&self) -> Option<LedgerRow> {
        self.last().cloned()
    }
}
