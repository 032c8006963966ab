//! The folder of a study: its files, and the right to compute a point.
//!
//! | file | what |
//! |---|---|
//! | `study.json` | the [`Plan`] |
//! | `points.csv` | the points as a table |
//! | `points/ID/` | the run of a point |
//! | `points/ID/point.json` | its [`Record`]: the point is done |
//! | `points/ID/.claim` | locked by the process that computes the point, with its identification |
//! | `table.csv`, `table.parquet`, `pictures/`, `study.html` | output of [`collect`](super::collect()) |
//!
//! Locks are those of the operating system (`flock`), which end with their process, also across machines on a shared file system. Only the
//! lock marks a point as under way, so no cleanup is needed after a crash.

use std::fs::{File, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::plan::{FORMAT, Plan, Point};
use super::record::{Record, RecordOutcome};
use super::values::refusal;
use crate::machine::files;
use crate::output::{OutputError, RunFiles};
use crate::script::{Class, Diagnostic};

const STUDY: &str = "study.json";
const RECORD: &str = "point.json";
const CLAIM: &str = ".claim";
const LOCK: &str = ".lock";

/// Number of attempts to take a lock.
const ATTEMPTS: usize = 4;
/// Time between two attempts to take a lock.
const MOMENT: Duration = Duration::from_millis(10);

/// The folder of a study.
#[derive(Clone, Debug)]
pub struct StudyFolder {
    files: RunFiles,
}

/// State of a point.
#[derive(Clone, Debug, PartialEq)]
pub enum PointState {
    /// The point is computed.
    Done(Record),
    /// Another process computes the point.
    UnderWay,
    /// A process began the point and was ended; the text identifies the process.
    Stopped(String),
    /// The point was not begun.
    Missing,
}

impl PointState {
    /// Returns the state of the point as written in tables.
    pub fn word(&self) -> &'static str {
        match self {
            PointState::Done(record) => record.outcome.word(),
            PointState::UnderWay => "under way",
            PointState::Stopped(_) => "stopped",
            PointState::Missing => "missing",
        }
    }

    /// True if the point must be computed: it is missing, stopped or was killed.
    pub fn is_open(&self) -> bool {
        match self {
            PointState::Done(record) => record.outcome == RecordOutcome::Killed,
            PointState::UnderWay => false,
            PointState::Stopped(_) | PointState::Missing => true,
        }
    }
}

/// Right to compute a point, until dropped.
#[derive(Debug)]
pub struct PointLock(#[allow(dead_code, reason = "the lock lasts as long as the file is open")] File);

/// Returns the message of a file that could not be written.
pub(super) fn unwritten(error: &OutputError) -> Box<Diagnostic> {
    Box::new(Diagnostic::error(Class::Output, error.to_string()).code(error.code()).hint(error.hint()))
}

fn unlocked(path: &Path, error: &std::io::Error) -> Box<Diagnostic> {
    let refused = Diagnostic::error(Class::Output, format!("\"{}\" could not be locked: {error}", path.display()));
    Box::new(refused.hint("keep the study on a file system that you may write to and that has locks (`flock`)"))
}

impl StudyFolder {
    /// Opens the folder of a new or growing study.
    ///
    /// # Errors
    /// The folder cannot be created.
    pub fn create(path: &Path) -> Result<Self, Box<Diagnostic>> {
        RunFiles::create(path).map(|files| StudyFolder { files }).map_err(|error| unwritten(&error))
    }

    /// Opens the folder of a planned study.
    ///
    /// # Errors
    /// The folder holds no study.
    pub fn open(path: &Path) -> Result<Self, Box<Diagnostic>> {
        if !Self::is_study(path) {
            let error = refusal(format!("{} holds no study", path.display())).cause(format!("there is no {STUDY} in it"));
            return Err(Box::new(error.hint("name the folder that `conserva sweep` or `conserva sweep plan` has written")));
        }
        Self::create(path)
    }

    /// True if a folder holds a study.
    pub(crate) fn is_study(path: &Path) -> bool {
        path.join(STUDY).is_file()
    }

    /// Path of the folder as given.
    pub fn path(&self) -> &Path {
        self.files.directory()
    }

    /// Writes a file of the study atomically.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, Box<Diagnostic>> {
        self.files.write(name, bytes).map_err(|error| unwritten(&error))
    }

    /// Reads the plan.
    ///
    /// # Errors
    /// A damaged file, or a file of a later version.
    pub fn plan(&self) -> Result<Plan, Box<Diagnostic>> {
        let path = self.path().join(STUDY);
        let damaged = |reason: String| {
            let error = refusal(format!("{} cannot be read", path.display())).cause(reason);
            Box::new(error.hint("plan the study again with the same command; points that are computed stay"))
        };
        let text = files::read(&path).map_err(|error| damaged(error.to_string()))?;
        let value: serde_json::Value = serde_json::from_slice(&text).map_err(|error| damaged(error.to_string()))?;
        match value.get("format").and_then(serde_json::Value::as_u64) {
            Some(format) if format > u64::from(FORMAT) => {
                let error = refusal(format!("{} is of a later version of the program", path.display()));
                Err(Box::new(error.cause(format!("format {format}, not {FORMAT}")).hint("go on with the program that planned the study")))
            }
            _ => {
                let plan: Plan = serde_json::from_value(value).map_err(|error| damaged(error.to_string()))?;
                match plan.points.iter().find(|point| point.values.len() != plan.names.len()) {
                    None => Ok(plan),
                    Some(Point { id, values }) => {
                        Err(damaged(format!("the point {id} has {} values for {} parameters", values.len(), plan.names.len())))
                    }
                }
            }
        }
    }

    /// Writes the plan in place of an older one.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_plan(&self, plan: &Plan) -> Result<(), Box<Diagnostic>> {
        // A plan of strings and numbers always has a JSON form.
        let text = serde_json::to_string_pretty(plan).unwrap_or_default() + "\n";
        self.write(STUDY, text.as_bytes())?;
        self.write("points.csv", &plan.to_csv()).map(drop)
    }

    /// Waits until no other process plans or collects, and locks the study until the result is dropped.
    ///
    /// # Errors
    /// The file system has no locks.
    pub fn lock(&self) -> Result<PointLock, Box<Diagnostic>> {
        let path = self.path().join(LOCK);
        let file = File::options().create(true).truncate(false).write(true).open(&path).map_err(|error| unlocked(&path, &error))?;
        file.lock().map_err(|error| unlocked(&path, &error))?;
        Ok(PointLock(file))
    }

    /// Path of the folder of a point.
    pub fn point(&self, point: &Point) -> PathBuf {
        self.path().join("points").join(&point.id)
    }

    /// Reads the record of a point; `None` if the point is not computed.
    pub fn record(&self, point: &Point) -> Option<Record> {
        Record::read(&self.point(point).join(RECORD), &point.id)
    }

    /// Writes the record of a computed point.
    ///
    /// # Errors
    /// The record cannot be written.
    pub fn write_record(&self, record: &Record) -> Result<(), Box<Diagnostic>> {
        self.write(&format!("points/{}/{RECORD}", record.id), record.to_json().as_bytes()).map(drop)
    }

    /// Removes the record of a point.
    ///
    /// # Errors
    /// The record cannot be removed.
    pub(crate) fn forget(&self, point: &Point) -> Result<(), Box<Diagnostic>> {
        let path = self.point(point).join(RECORD);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(unwritten(&OutputError::Write { path, source: error })),
            _ => Ok(()),
        }
    }

    /// Takes the right to compute a point; `None` while another process has it.
    ///
    /// # Errors
    /// The folder cannot be created, or has no locks.
    pub fn claim(&self, point: &Point) -> Result<Option<PointLock>, Box<Diagnostic>> {
        let path = self.files.place(&format!("points/{}/{CLAIM}", point.id)).map_err(|error| unwritten(&error))?;
        let open = File::options().create(true).truncate(false).read(true).write(true).open(&path);
        let mut file = open.map_err(|error| unlocked(&path, &error))?;
        for attempt in 1.. {
            match file.try_lock() {
                Ok(()) => break,
                // A process that only queries the state of a point holds the lock for a moment.
                Err(TryLockError::WouldBlock) if attempt < ATTEMPTS => std::thread::sleep(MOMENT),
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(error)) => return Err(unlocked(&path, &error)),
            }
        }
        // The identification is information only, so that a full disk may refuse the write.
        let _ = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(holder().as_bytes()));
        Ok(Some(PointLock(file)))
    }

    /// Returns the state of a point.
    pub fn state(&self, point: &Point) -> PointState {
        if let Some(record) = self.record(point) {
            return PointState::Done(record);
        }
        let Ok(mut file) = File::open(self.point(point).join(CLAIM)) else { return PointState::Missing };
        if matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)) {
            return PointState::UnderWay;
        }
        // The point may have been completed meanwhile.
        if let Some(record) = self.record(point) {
            return PointState::Done(record);
        }
        let mut text = String::new();
        let _ = file.read_to_string(&mut text);
        PointState::Stopped(text.trim().into())
    }
}

/// Identifies this process, and its task of a scheduler.
fn holder() -> String {
    let value = |name: &str| std::env::var(name).ok();
    let task = value("SLURM_ARRAY_JOB_ID").or(value("SLURM_JOB_ID")).map(|job| match value("SLURM_ARRAY_TASK_ID") {
        Some(task) => format!(", Slurm task {job}_{task}"),
        None => format!(", Slurm job {job}"),
    });
    let node = value("SLURMD_NODENAME").map(|node| format!(" on {node}")).unwrap_or_default();
    format!("process {}{node}{}\n", std::process::id(), task.unwrap_or_default())
}
