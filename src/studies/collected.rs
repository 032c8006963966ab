//! A study as it stands: its table, where each point is, what is remarkable.

use super::folder::PointState;
use super::record::RecordOutcome;
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

    /// Number of points that came to their end with an energy that their integrator has changed.
    pub(crate) fn not_conserving(&self) -> usize {
        self.count(|state| matches!(state, PointState::Done(record) if record.outcome == RecordOutcome::NotConserving))
    }

    /// How many points came to which end, in words.
    pub fn tally(&self) -> String {
        let (not_conserving, failed) = (self.not_conserving(), self.failed());
        let conserving = self.completed() - not_conserving;
        let open = self.states.len() - self.completed() - failed;
        let all = [(conserving, "completed"), (not_conserving, "not conserving"), (failed, "failed"), (open, "not done")];
        let told = all.iter().filter(|(count, word)| *count > 0 || matches!(*word, "completed" | "failed"));
        told.map(|(count, word)| format!("{count} {word}")).collect::<Vec<_>>().join(", ")
    }

    /// Number of points that failed.
    pub fn failed(&self) -> usize {
        self.count(|state| matches!(state, PointState::Done(record) if !record.outcome.is_completed()))
    }

    fn count(&self, is: impl Fn(&PointState) -> bool) -> usize {
        self.states.iter().filter(|state| is(state)).count()
    }
}
