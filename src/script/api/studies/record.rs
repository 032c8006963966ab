//! The files of a study: its points as a table, and results for a resumed run.
//!
//! `studies/sweep.csv` in the folder of the run has a row for each point, in their order. Results of points are kept beside the checkpoints
//! as soon as they are computed, and removed when the run is complete.

use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};

use crate::output::{PointLog, RowsCsv, encoded};
use crate::script::api::files::failures::output_failure;
use crate::script::api::files::run_folder::RunFolder;
use crate::script::api::simulations::journal::{Journal, is_kept};
use crate::script::language::plain::Plain;
use crate::script::language::prelude::*;
use crate::script::language::worker_pool::Computed;

/// Name of the column, and of the key, for the cause of a point's failure.
pub const FAILURE: &str = "failure";

/// Names of the studies of a session.
#[derive(Default)]
struct Names(RefCell<BTreeSet<String>>);

/// Description of the option `name`.
pub fn name_parameter(absent: &'static str) -> Parameter {
    Parameter::text("name", "name of its table in the folder `studies` of the run: letters, digits, `-` and `_`").or(absent)
}

/// Returns the name of a study from its options, numbered if an earlier study of the session has that name.
///
/// # Errors
/// A name that is invalid for a file.
pub fn free_name(call: &Call, options: &Options) -> Result<String, Failure> {
    let argument = options.argument("name");
    let name = argument.text()?;
    if name.is_empty() || !name.chars().all(|letter| letter.is_alphanumeric() || "-_".contains(letter)) {
        let failure = argument.wrong(causes::WRONG_TYPE, "must be letters, digits, `-` and `_`");
        return Err(failure.label(format!("this is \"{name}\"")).hint("leave out folder and ending: they are given"));
    }
    let names = call.host.slots.get::<Names>();
    let numbered = (2..).map(|number| format!("{name}-{number}"));
    let free = std::iter::once(name.clone()).chain(numbered).find(|name| !names.0.borrow().contains(name)).unwrap_or_default();
    names.0.borrow_mut().insert(free.clone());
    Ok(free)
}

/// The files of a study.
#[derive(Default)]
pub struct Record {
    table: Option<RowsCsv>,
    log: Option<PointLog>,
    known: HashMap<Vec<u8>, Computed>,
}

impl Record {
    /// Begins the files of a study with the name in its options; no files if the session writes none.
    ///
    /// # Errors
    /// A name that is invalid for a file, a file that cannot be written.
    pub fn begin(call: &Call, options: &Options) -> Result<Self, Failure> {
        let host = call.host;
        let files = RunFolder::of(host).files(host).map_err(|error| output_failure(&error))?;
        let free = free_name(call, options)?;
        let Some(files) = files else { return Ok(Record::default()) };
        let open = || {
            let (log, records) = match (is_kept(host), Journal::of(host).is_resumed()) {
                (false, _) => (None, Vec::new()),
                (true, false) => (Some(PointLog::create(&files, &free)?), Vec::new()),
                (true, true) => PointLog::reopen(&files, &free).map(|(log, records)| (Some(log), records))?,
            };
            let table = RowsCsv::new(files, &format!("studies/{free}.csv"), FAILURE);
            Ok(Record { table: Some(table), log, known: records.into_iter().collect() })
        };
        let record = open().map_err(|error| output_failure(&error))?;
        if record.log.is_some() {
            Journal::of(host).secure(host)?;
        }
        Ok(record)
    }

    /// Returns the result of a point that an earlier process has computed.
    pub fn known(&self, point: &[Plain]) -> Option<Computed> {
        if self.known.is_empty() { None } else { self.known.get(&encoded(point)).cloned() }
    }

    /// Stores the result of a point for a resumed run.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&mut self, host: &Host, point: &[Plain], computed: &Computed) -> Result<(), Failure> {
        let Some(log) = &mut self.log else { return Ok(()) };
        let known = host.sandbox.files_read();
        let (files, modules) = (
            computed.read.iter().filter(|file| !known.contains(file)).collect::<Vec<_>>(),
            computed.modules.iter().filter(|(name, _)| host.sources.text(name).is_none()).collect::<Vec<_>>(),
        );
        if !files.is_empty() || !modules.is_empty() {
            // The inputs of a resumed run are recorded in the checkpoint.
            files.into_iter().for_each(|file| host.sandbox.note(file.clone()));
            modules.into_iter().for_each(|(name, text)| host.sources.insert(name, text));
            Journal::of(host).secure(host)?;
        }
        log.append(&(encoded(point), computed)).map_err(|error| output_failure(&error))
    }

    /// Adds a row to the table.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn add<'a>(&mut self, fields: impl IntoIterator<Item = &'a (String, Plain)>, failure: &str) -> Result<(), Failure> {
        let Some(table) = &mut self.table else { return Ok(()) };
        let fields: Vec<(String, String)> = fields.into_iter().map(|(name, value)| (name.clone(), value.field())).collect();
        table.add(&fields, failure).map_err(|error| output_failure(&error))
    }
}
