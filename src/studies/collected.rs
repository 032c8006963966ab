//! A study as it stands: its table, where each point is, what is remarkable.

use super::folder::PointState;
use super::table::StudyTable;

/// A study as it stands.
pub struct Collected {
    /// Its table.
    pub table: StudyTable,
    /// Where each point stands.
    pub states: Vec<PointState>,
    /// What is remarkable about it.
    pub remarks: Vec<String>,
}

impl Collected {
    /// Number of points that came to their end.
    pub fn completed(&self) -> usize {
        self.count(|state| matches!(state, PointState::Done(record) if record.outcome.is_completed()))
    }

    /// Number of points that failed.
    pub fn failed(&self) -> usize {
        self.count(|state| matches!(state, PointState::Done(record) if !record.outcome.is_completed()))
    }

    fn count(&self, is: impl Fn(&PointState) -> bool) -> usize {
        self.states.iter().filter(|state| is(state)).count()
    }
}
