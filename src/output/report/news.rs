//! Data for a page that follows a run: at first the page with all data, afterwards only changes that the page has not received.
//!
//! Updates are JSON; numbers are packed as in the page ([`blob`]). Every answer contains the number of its last change, which the page
//! sends with its next request.

use std::sync::Arc;

use serde_json::{Value, json};

use super::assets::{STYLE, WAITING};
use super::blob::blob;
use super::live::{FollowedSimulation, LiveReport, LiveRow, Shared};
use super::page::{Report, bytes_of, fields, page, pressing};
use crate::output::recording::Still;

/// Answer to a reader's request for changes.
pub struct ReportChanges {
    /// Answer to the browser, encoded as JSON.
    pub bytes: Arc<Vec<u8>>,
    /// True if the run has ended, so that no further changes follow.
    pub is_last: bool,
}

impl LiveReport {
    /// Returns the page of a simulation by its index (the newest without one), with all present data; the page requests later updates.
    pub fn page(&self, simulation: Option<usize>) -> Vec<u8> {
        let shared = self.look();
        let number = simulation.filter(|&number| number < shared.simulations.len()).or(shared.simulations.len().checked_sub(1));
        let Some(number) = number else { return WAITING.replace("{{style}}", STYLE).into_bytes() };
        let (followed, state) = (shared.simulations[number].clone(), self.state(&shared, Some(number)));
        let (change, warnings) = (shared.change, shared.warnings.1.clone());
        drop(shared);
        self.page_of(&followed, number, change, warnings, state)
    }

    fn page_of(&self, followed: &FollowedSimulation, number: usize, change: u64, warnings: Vec<String>, state: Value) -> Vec<u8> {
        let (model, (_, problem)) = (&followed.model, &followed.problem);
        let (row_numbers, rows): (Vec<u64>, Vec<&Arc<LiveRow>>) =
            followed.rows.entries().iter().map(|(number, row)| (*number, row)).unzip();
        let (still_numbers, stills): (Vec<u64>, Vec<&Still>) =
            followed.stills.entries().iter().map(|(number, still)| (*number, &**still)).unzip();
        let value = |row: &LiveRow, column: usize| row.values.get(column).copied().unwrap_or(f64::NAN);
        let columns = followed.columns.iter().enumerate();
        let live = json!({
            "change": change, "simulation": number, "rowNumbers": row_numbers, "stillNumbers": still_numbers,
            "rows": rows.iter().map(|row| row.number).collect::<Vec<_>>(),
            "stillRows": stills.iter().map(|still| still.row).collect::<Vec<_>>(), "state": state,
        });
        let report = Report {
            name: model.name.clone(),
            outcome: None,
            is_well: true,
            version: env!("CARGO_PKG_VERSION").into(),
            scripts: problem.scripts.clone(),
            parameters: problem.parameters.clone(),
            summary: Vec::new(),
            tables: problem.tables.clone(),
            warnings: warnings.into_iter().chain(followed.findings.1.iter().cloned()).collect(),
            printed: Vec::new(),
            pictures: Vec::new(),
            columns: columns.map(|(column, name)| (name.clone(), rows.iter().map(|row| value(row, column)).collect())).collect(),
            rows: rows.iter().map(|row| row.number).collect(),
            row_count: followed.row_count,
            contacts: model.contacts.clone(),
            bodies: &model.bodies,
            skins: &model.skins,
            shown: &model.shown,
            stills: &stills,
            obstacles: model.obstacles.clone(),
            units: model.units.clone(),
            marks: model.marks.clone(),
        };
        page(&report, live)
    }

    /// Returns the changes of a simulation after the change number `known`; without a simulation, the state of the run alone.
    pub fn news(&self, simulation: Option<usize>, known: u64) -> ReportChanges {
        let shared = self.look();
        let state = self.state(&shared, simulation);
        let (change, is_last) = (shared.change, shared.outcome.is_some());
        let followed = simulation.and_then(|number| shared.simulations.get(number)).cloned();
        let warned = shared.warnings.0.max(followed.as_ref().map_or(0, |followed| followed.findings.0)) > known;
        let warnings = warned.then(|| shared.warnings.1.clone());
        drop(shared);
        let mut answer = json!({ "change": change, "state": state });
        if let Some(followed) = followed {
            answer["warnings"] = warnings.map(|warnings| [warnings, followed.findings.1.clone()].concat()).into();
            tell(&mut answer, &followed, known);
        }
        ReportChanges { bytes: Arc::new(answer.to_string().into_bytes()), is_last }
    }

    /// Returns the current activity of the run, or its outcome.
    fn state(&self, shared: &Shared, simulation: Option<usize>) -> Value {
        let followed = simulation.and_then(|number| shared.simulations.get(number));
        let outcome = followed.and_then(|followed| followed.outcome.as_ref()).or(shared.outcome.as_ref());
        json!({
            "simulations": shared.simulations.iter().map(|followed| &followed.model.name).collect::<Vec<_>>(),
            "doing": shared.doing.what, "until": shared.doing.until, "outcome": outcome.map(|outcome| &outcome.words),
            "well": outcome.is_none_or(|outcome| outcome.is_well), "over": shared.outcome.is_some(), "folder": self.folder,
        })
    }
}

/// Adds the changes of a simulation after `known` to an answer; all data for `known` 0.
fn tell(answer: &mut Value, followed: &FollowedSimulation, known: u64) {
    if known == 0 {
        answer["columns"] = (*followed.columns).clone().into();
    } else if followed.shaped > known {
        // With other columns, the page begins anew.
        answer["anew"] = true.into();
        return;
    }
    let (told, problem) = &followed.problem;
    if *told > known {
        let scripts: Vec<Value> = problem.scripts.iter().map(|(name, text)| json!({ "name": name, "text": text })).collect();
        answer["problem"] = json!({ "scripts": scripts, "parameters": problem.parameters, "tables": problem.tables });
    }
    let rows = followed.rows.since(known);
    let (columns, added) = (followed.columns.len(), &rows.added);
    let value = |row: &LiveRow, column: usize| row.values.get(column).copied().unwrap_or(f64::NAN);
    let values = (0..columns).flat_map(|column| added.iter().map(move |(_, row)| value(row, column)));
    answer["rows"] = json!({
        "count": followed.row_count, "left": rows.left, "numbers": added.iter().map(|(number, _)| number).collect::<Vec<_>>(),
        "rows": added.iter().map(|(_, row)| row.number).collect::<Vec<_>>(), "values": blob(&bytes_of(values)),
    });
    let stills = followed.stills.since(known);
    if stills.left.is_none() && stills.added.is_empty() {
        return;
    }
    let all: Vec<&Still> = followed.stills.entries().iter().map(|(_, still)| &**still).collect();
    let list = stills.added.iter().map(|(_, still)| json!({ "time": still.time, "row": still.row, "obstacles": still.obstacles }));
    let bytes: Vec<u8> = stills.added.iter().flat_map(|(_, still)| still.bytes()).copied().collect();
    answer["stills"] = json!({
        "left": stills.left, "numbers": stills.added.iter().map(|(number, _)| number).collect::<Vec<_>>(), "list": list.collect::<Vec<_>>(),
        "bytes": blob(&bytes), "fields": fields(&followed.model.skins, &all, &followed.model.shown), "pressing": pressing(&all),
    });
}
