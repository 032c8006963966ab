//! Record of a computed point: `point.json` in the folder of the point, written at its end.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::machine::files;

/// Outcome of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RecordOutcome {
    /// The script ended normally.
    #[serde(rename = "completed")]
    Completed,
    /// The script ended normally, but its integrator changed the energy.
    #[serde(rename = "not conserving")]
    NotConserving,
    /// The script ended with an error; a further attempt would fail again.
    #[serde(rename = "failed")]
    Failed,
    /// The point was stopped at its time limit.
    #[serde(rename = "out of time")]
    OutOfTime,
    /// The process of the point was killed from outside; a further attempt may succeed.
    #[serde(rename = "killed")]
    Killed,
}

impl RecordOutcome {
    /// Returns the outcome as written to files.
    pub fn word(self) -> &'static str {
        match self {
            RecordOutcome::Completed => "completed",
            RecordOutcome::NotConserving => "not conserving",
            RecordOutcome::Failed => "failed",
            RecordOutcome::OutOfTime => "out of time",
            RecordOutcome::Killed => "killed",
        }
    }

    /// True if the script ended normally.
    pub(crate) fn is_completed(self) -> bool {
        matches!(self, RecordOutcome::Completed | RecordOutcome::NotConserving)
    }
}

/// A result of the script.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointResult {
    /// Name of the result.
    pub name: String,
    /// Number, text, `true` or `false`, or an array of these.
    pub value: Value,
    /// Unit of the value; empty without one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
}

/// Record of a computed point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Name of the point.
    pub id: String,
    /// Outcome of the point.
    pub outcome: RecordOutcome,
    /// Cause of an outcome other than completed.
    pub cause: Option<String>,
    /// Units of the parameters that have one, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameter_units: BTreeMap<String, String>,
    /// Results of the script.
    pub results: Vec<PointResult>,
    /// Number of warnings.
    pub warnings: u64,
    /// Accepted steps.
    pub steps: Option<u64>,
    /// Drifts and the worst defect, by their names in `summary.json`.
    pub balance: Vec<Option<f64>>,
    /// Version of the program.
    pub version: String,
    /// Digest of the scripts and of the files that they read.
    pub scripts: Option<String>,
    /// Wall time `[s]`.
    pub wall_seconds: f64,
}

/// Entries of `summary.json` that measure conservation, in the order of [`Record::balance`].
pub const BALANCE: [&str; 5] = ["energy_drift", "energy_unexplained", "momentum_drift", "angular_momentum_drift", "worst_energy_defect"];

impl Record {
    /// Returns a record with outcome and cause only.
    pub fn of(id: &str, outcome: RecordOutcome, cause: impl Into<String>) -> Self {
        Record {
            id: id.into(),
            outcome,
            cause: Some(cause.into()),
            parameter_units: BTreeMap::new(),
            results: Vec::new(),
            warnings: 0,
            steps: None,
            balance: vec![None; BALANCE.len()],
            version: env!("CARGO_PKG_VERSION").into(),
            scripts: None,
            wall_seconds: 0.0,
        }
    }

    /// Reads the record of a point; `None` without a file, or for a file damaged by a power failure.
    pub fn read(path: &Path, id: &str) -> Option<Record> {
        let record: Record = serde_json::from_slice(&files::read(path).ok()?).ok()?;
        Some(record).filter(|record| record.id == id && record.balance.len() == BALANCE.len())
    }

    /// Returns the text of the file.
    pub(crate) fn to_json(&self) -> String {
        // Strings, numbers and lists always have a JSON form.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}
