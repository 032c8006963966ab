//! One point of a study: a plain run of the script in a folder of its own.

use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use serde_json::Value;

use super::folder::{StudyFolder, unwritten};
use super::plan::{Plan, Point};
use super::record::{BALANCE, PointResult, Record, RecordOutcome};
use super::transcript::Transcript;
use super::watchdog::Watchdog;
use crate::output::checkpoint::{self, Checkpoint, Origin};
use crate::output::{CountedFile, NOT_CONSERVING, OutputError, RunFiles, RunLock, SUMMARY, read_summary};
use crate::script::{Class, Diagnostic, Ink, Mode, Report, Session, Settings, home};

/// Result of a request to compute a point.
#[derive(Clone, Debug, PartialEq)]
pub enum PointOutcome {
    /// The point was computed now.
    Computed(Record),
    /// The point was computed before.
    Kept(Record),
    /// Another process computes the point.
    UnderWay,
    /// The process was interrupted; the point has to be continued from its last checkpoint.
    Interrupted,
}

/// Computes a point unless it is computed or under way. Paths of the study are relative to the current folder.
///
/// # Errors
/// Files that cannot be written: the point then does not count as computed.
pub fn compute(study: &StudyFolder, plan: &Plan, point: &Point, watchdog: &Watchdog) -> Result<PointOutcome, Box<Diagnostic>> {
    let Some(claim) = study.claim(point)? else { return Ok(PointOutcome::UnderWay) };
    if let Some(record) = study.record(point).filter(|record| record.outcome != RecordOutcome::Killed) {
        return Ok(PointOutcome::Kept(record));
    }
    if watchdog.is_interrupted() {
        return Ok(PointOutcome::Interrupted);
    }
    let folder = study.point(point);
    let resumed = go_on_from(&folder);
    if resumed.is_none() {
        clean(&folder)?;
    }
    let record = run(study, plan, point, watchdog, resumed)?;
    let Some(record) = record else { return Ok(PointOutcome::Interrupted) };
    study.write_record(&record)?;
    drop(claim);
    Ok(PointOutcome::Computed(record))
}

/// Returns the checkpoint of an earlier attempt, if resuming from it gives equal results.
fn go_on_from(folder: &Path) -> Option<(Checkpoint, Vec<CountedFile>)> {
    let checkpoint = Checkpoint::read(&checkpoint::places(folder).pop()?).ok()?;
    let aside = checkpoint.belongs_to(folder).ok()?;
    let (changed, digits) = checkpoint.origin.differences(&Origin::now(&checkpoint.origin));
    (changed.is_empty() && digits.is_empty()).then_some((checkpoint, aside))
}

/// Removes the files of an earlier attempt.
fn clean(folder: &Path) -> Result<(), Box<Diagnostic>> {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name() == ".claim" {
            continue;
        }
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        let removed = if is_folder { std::fs::remove_dir_all(entry.path()) } else { std::fs::remove_file(entry.path()) };
        removed.map_err(|source| unwritten(&OutputError::Write { path: entry.path(), source }))?;
    }
    Ok(())
}

/// Runs the script; `None` if the process was interrupted.
fn run(
    study: &StudyFolder,
    plan: &Plan,
    point: &Point,
    watchdog: &Watchdog,
    resumed: Option<(Checkpoint, Vec<CountedFile>)>,
) -> Result<Option<Record>, Box<Diagnostic>> {
    let begun = Instant::now();
    let folder = study.point(point);
    let files = RunFiles::create(&folder).map_err(|error| unwritten(&error))?;
    let transcript = Rc::new(Transcript::new(&files).map_err(|error| unwritten(&error))?);
    let late = Record::of(&point.id, RecordOutcome::OutOfTime, late(plan));
    let (place, written_off) = (study.clone(), late.clone());
    let stop = watchdog.begin(plan.limits.seconds, move || {
        // A failed write cannot be reported here.
        let _ = place.write_record(&written_off);
    });
    let script = &plan.scenario.script;
    let settings = Settings {
        mode: Mode::Run,
        overrides: plan.overrides(point),
        allow_read: plan.scenario.allow_read.clone(),
        output: Some(folder.clone()),
        threads: usize::from(plan.limits.threads.max(1)),
        solver: None,
        workers: usize::from(plan.limits.threads.max(1)),
        max_operations: plan.scenario.max_operations,
        interrupt: stop.clone(),
        ..Settings::default()
    };
    let (report, scripts, results, [units, parameter_units]) = match Session::new(settings, home(script), transcript.clone()) {
        Ok(mut session) => {
            if let Some((checkpoint, aside)) = resumed {
                let lock = RunLock::take(&folder).and_then(|lock| checkpoint::restore_files(&folder, &aside).map(|()| lock));
                let lock = lock.map_err(|error| unwritten(&error))?;
                session
                    .resume(&folder, checkpoint, lock)
                    .map_err(|error| unwritten(&OutputError::Write { path: folder.clone(), source: error }))?;
            }
            let report = session.run_file(script);
            (report, Some(session.digest()), session.results(), [session.result_units(), session.parameter_units()])
        }
        Err(error) => (Report::failed(*error), None, Vec::new(), Default::default()),
    };
    let results =
        results.into_iter().map(|(name, value)| PointResult { unit: units.get(&name).cloned().unwrap_or_default(), name, value }).collect();
    report.error.iter().for_each(|error| transcript.say(&error.render(Ink::Plain)));
    let is_late = watchdog.end();
    let seconds = begun.elapsed().as_secs_f64();
    match &report.error {
        Some(error) if error.class == Class::Output => Err(Box::new(error.clone())),
        Some(error) if error.class == Class::Interrupted && stop.load(Ordering::Relaxed) && !is_late => Ok(None),
        Some(error) if error.class == Class::Interrupted && is_late => {
            // Resuming would only lead to the time limit again.
            checkpoint::remove_all(&folder).map_err(|error| unwritten(&error))?;
            // The steps reached depend on the machine, so that the table does not list them.
            Ok(Some(Record { scripts, parameter_units, results, wall_seconds: seconds, ..late }))
        }
        error => {
            let outcome = if error.is_some() { RecordOutcome::Failed } else { RecordOutcome::Completed };
            let cause = error.as_ref().map(told);
            let warnings = transcript.warnings();
            let record =
                Record { cause, scripts, parameter_units, results, warnings, wall_seconds: seconds, ..Record::of(&point.id, outcome, "") };
            Ok(Some(filled(record, &folder, &report.energy)))
        }
    }
}

fn late(plan: &Plan) -> String {
    format!("not done after {} s", plan.limits.seconds.unwrap_or_default())
}

/// Formats an error in one line: place, fault, cause.
fn told(error: &Diagnostic) -> String {
    let place = error.place.as_ref().map(|place| format!("{place}: ")).unwrap_or_default();
    let cause = error.causes.first().map(|cause| format!("; {cause}")).unwrap_or_default();
    format!("{place}{}{cause}", error.title)
}

/// Adds steps and drifts from `summary.json` to the record. A completed run whose summary reports that energy was not conserved gets
/// that outcome, with `energy`, the energy changes by cause, as explanation.
fn filled(mut record: Record, folder: &Path, energy: &[String]) -> Record {
    let Ok(summary) = read_summary(&folder.join(SUMMARY)) else { return record };
    if record.outcome == RecordOutcome::Completed && summary.get("outcome").and_then(Value::as_str) == Some(NOT_CONSERVING) {
        record.outcome = RecordOutcome::NotConserving;
        record.cause = Some(energy.join("; "));
    }
    record.steps = summary.get("steps").and_then(Value::as_u64);
    record.balance = BALANCE.iter().map(|name| summary.get(*name).and_then(Value::as_f64)).collect();
    record
}
