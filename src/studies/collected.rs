//! Present results of a study: its table, the state of each point, remarks.

use super::folder::PointState;
use super::record::RecordOutcome;
use super::table::StudyTable;

/// Present results of a study.
pub struct Collected {
    /// Table of the study.
    pub table: StudyTable,
    /// State of each point.
    pub states: Vec<PointState>,
    /// Remarks on the study.
    pub remarks: Vec<String>,
}

impl Collected {
    /// Number of points whose script ended normally.
    pub fn completed(&self) -> usize {
        self.count(|state| matches!(state, PointState::Done(record) if record.outcome.is_completed()))
    }

    /// Number of points whose script ended normally, but whose integrator changed the energy.
    pub(crate) fn not_conserving(&self) -> usize {
        self.count(|state| matches!(state, PointState::Done(record) if record.outcome == RecordOutcome::NotConserving))
    }

    /// Returns the number of points by outcome, in words.
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
