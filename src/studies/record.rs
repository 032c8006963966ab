//! What became of a point: `point.json` in its folder, written when it is over.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::machine::files;

/// How a point ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RecordOutcome {
    /// It came to its end.
    #[serde(rename = "completed")]
    Completed,
    /// It came to its end with an energy that its integrator has changed.
    #[serde(rename = "not conserving")]
    NotConserving,
    /// It ended with an error, which the next attempt would meet again.
    #[serde(rename = "failed")]
    Failed,
    /// It was given up after its time.
    #[serde(rename = "out of time")]
    OutOfTime,
    /// Its process was ended from outside; the next attempt may do better.
    #[serde(rename = "killed")]
    Killed,
}

impl RecordOutcome {
    /// Its word in files.
    pub fn word(self) -> &'static str {
        match self {
            RecordOutcome::Completed => "completed",
            RecordOutcome::NotConserving => "not conserving",
            RecordOutcome::Failed => "failed",
            RecordOutcome::OutOfTime => "out of time",
            RecordOutcome::Killed => "killed",
        }
    }

    /// Whether it came to its end.
    pub(crate) fn is_completed(self) -> bool {
        matches!(self, RecordOutcome::Completed | RecordOutcome::NotConserving)
    }
}

/// A result of the script.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Yield {
    /// Its name.
    pub name: String,
    /// What it is: a number, a text, `true` or `false`, or an array of these.
    pub value: Value,
}

/// What became of a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The point's name.
    pub id: String,
    /// How it ended.
    pub outcome: RecordOutcome,
    /// Why, unless it was completed.
    pub cause: Option<String>,
    /// What the script yielded.
    pub results: Vec<Yield>,
    /// Number of warnings.
    pub warnings: u64,
    /// Accepted steps.
    pub steps: Option<u64>,
    /// Drifts and the worst defect, by their names in `summary.json`.
    pub balance: Vec<Option<f64>>,
    /// Version of the program.
    pub version: String,
    /// A digest of the scripts and of the files that they read.
    pub scripts: Option<String>,
    /// Wall time `[s]`.
    pub wall_seconds: f64,
}

/// Numbers of `summary.json` that tell how well a run conserves, in the order of [`Record::balance`].
pub const BALANCE: [&str; 5] = ["energy_drift", "energy_unexplained", "momentum_drift", "angular_momentum_drift", "worst_energy_defect"];

impl Record {
    /// A record of a point of which nothing else is known.
    pub fn of(id: &str, outcome: RecordOutcome, cause: impl Into<String>) -> Self {
        Record {
            id: id.into(),
            outcome,
            cause: Some(cause.into()),
            results: Vec::new(),
            warnings: 0,
            steps: None,
            balance: vec![None; BALANCE.len()],
            version: env!("CARGO_PKG_VERSION").into(),
            scripts: None,
            wall_seconds: 0.0,
        }
    }

    /// Reads the record of a point; none where there is none, or what a power failure has left of one.
    pub fn read(path: &Path, id: &str) -> Option<Record> {
        let record: Record = serde_json::from_slice(&files::read(path).ok()?).ok()?;
        Some(record).filter(|record| record.id == id && record.balance.len() == BALANCE.len())
    }

    /// The text of the file.
    pub(crate) fn to_json(&self) -> String {
        // Strings, numbers and lists always have a JSON form.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}
