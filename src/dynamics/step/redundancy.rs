//! Constraints of ties that follow from others and from supports.
//!
//! Where a tie ends on a support that holds both sides, or where two ties join the same surfaces, some constraints say nothing new, and
//! the matrix would be singular. They are found by elimination at rest, the supported unknowns left out, and take part in no step.

use std::collections::BTreeMap;

use super::equations::Equations;
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::integrators::Derivative;
use crate::math::tolerances::{DEPENDENT, NEGLIGIBLE_ENTRY, ZERO_ROW};

/// A constraint row by its unknowns.
type Row = BTreeMap<usize, f64>;

impl<const D: usize> Equations<D> {
    /// Whether each constraint row follows from those of ties before it and from supports.
    pub fn redundant_rows(&self) -> Vec<bool> {
        let mut redundant = vec![false; self.multipliers];
        if self.pairs.iter().all(|pair| !pair.kind.is_bilateral()) {
            return redundant;
        }
        let mut pivots: BTreeMap<usize, Row> = BTreeMap::new();
        for pair in self.pairs.iter().filter(|pair| pair.kind.is_bilateral() && pair.law.is_bilateral()) {
            let mut evaluation = Evaluation::default();
            pair.kernel.evaluate(Derivative::AT_END, &self.nodes.reference, &vec![0.0; pair.rows.len()], &mut evaluation);
            // Nodes that are not tied may have entries of round-off, which would be taken for pivots.
            let is_covered = |(number, _): &(usize, Row)| evaluation.coverage[number - pair.rows.start] > ZERO_ROW;
            for (number, mut row) in self.rows_of(pair, &evaluation).into_iter().filter(is_covered) {
                // Of all its entries: what supports leave of a row may be round-off.
                let size = row.values().fold(0.0f64, |largest, value| largest.max(value.abs()));
                row.retain(|&unknown, value| !self.supports.fixed[unknown] && value.abs() > NEGLIGIBLE_ENTRY * size);
                let rest = reduced(row, size, &pivots);
                let entry = rest.iter().map(|(&unknown, &value)| (unknown, value)).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
                match entry.filter(|(_, value)| value.abs() > DEPENDENT * size) {
                    Some((unknown, value)) => {
                        pivots.insert(unknown, rest.into_iter().map(|(other, entry)| (other, entry / value)).collect());
                    }
                    None => redundant[number] = true,
                }
            }
        }
        redundant
    }

    /// The rows of a pair by their unknowns; none of nodes that lie opposite nothing.
    fn rows_of(&self, pair: &ContactPair, evaluation: &Evaluation) -> BTreeMap<usize, Row> {
        let mut rows: BTreeMap<usize, Row> = BTreeMap::new();
        for row in pair.live_rows(evaluation) {
            let entries = &evaluation.gradient_end[row.gradient.clone()];
            let sums = rows.entry(row.row).or_default();
            for (&node, entries) in row.nodes.iter().zip(entries.chunks_exact(D)) {
                for (i, &entry) in entries.iter().enumerate() {
                    *sums.entry(node as usize * D + i).or_insert(0.0) += entry;
                }
            }
        }
        rows
    }
}

/// What is left of a row of that size when the unknowns of all pivots are eliminated. Couplings along a surface fade from node to node, and
/// are dropped where they are round-off.
fn reduced(mut row: Row, size: f64, pivots: &BTreeMap<usize, Row>) -> Row {
    while let Some(unknown) = row.keys().copied().find(|unknown| pivots.contains_key(unknown)) {
        let factor = row[&unknown];
        for (&other, &entry) in &pivots[&unknown] {
            *row.entry(other).or_insert(0.0) -= factor * entry;
        }
        row.remove(&unknown);
        row.retain(|_, value| value.abs() > NEGLIGIBLE_ENTRY * size);
    }
    row
}
