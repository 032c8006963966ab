//! Results of a run's computations, kept so that an interrupted run is resumed with byte-identical results.
//!
//! A script cannot be suspended and continued: its variables and closures live in the engine. But the script's behavior follows from its
//! text and from the results of its simulations. A resumed run therefore executes the script again, and takes every step and equilibrium
//! computed before from the [journal](crate::output::journal). The journal has the rows of all steps, and those states from which the
//! script read more than the row of the step; in between, the solver has only that row (`is_behind`). Returns to kept states are
//! recorded, too, so that the state at the end of the journal is unambiguous. A checkpoint has the simulations at that moment. Frames of
//! the fields are already on disk ([`Artifacts`](super::artifacts::Artifacts)).

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::dynamics::State;
use crate::machine::files::read;
use crate::math::simd::instructions;
use crate::output::checkpoint::{Checkpoint, Origin, SavedSimulation};
use crate::output::journal::{Entry, JournalReader, JournalWriter, Mark};
use crate::output::{OutputError, RunFiles};
use crate::script::api::files::run_folder::{RunFolder, output_folder};
use crate::script::language::prelude::*;
use crate::script::language::settings::Checkpoints;

/// Largest size of the states in a journal `[bytes]`, which a script reaches that reads a large simulation after each of many steps; a
/// resumed run computes later steps again.
const MOST_BYTES: usize = 1 << 30;

/// Least time between checkpoints, relative to the time spent on the last checkpoint.
const PATIENCE: u32 = 30;

/// The journal of a session.
#[derive(Default)]
pub struct Journal(pub(super) RefCell<Pages>);

#[derive(Default)]
pub(super) struct Pages {
    /// Computations of an earlier process that the script has not requested yet.
    pub(super) earlier: Option<JournalReader>,
    /// Number of entries in `earlier` that are computations or returns to a stored state.
    pub(super) left: u64,
    /// Simulations of the earlier process at its end.
    pub(super) simulations: Vec<SavedSimulation>,
    /// End of the journal of the earlier process.
    pub(super) mark: Mark,
    pub(super) writer: Option<JournalWriter>,
    /// Bytes of the states in the journal.
    pub(super) bytes: usize,
    /// True if no further entries are added.
    pub(super) is_full: bool,
    /// Reason why the journal could not be written.
    pub(super) problem: Option<OutputError>,
    /// True while the failed computation is repeated, which is already in the journal.
    pub(super) repeats: bool,
    /// Number of computations since the last checkpoint.
    pub(super) new: usize,
    /// Moment of the last checkpoint, and the time spent on writing it.
    pub(super) last: Option<(Instant, Duration)>,
    /// Length and checksum of the files that the script has read.
    pub(super) files: BTreeMap<PathBuf, (u64, u32)>,
    /// True if an earlier process has begun this run.
    pub(super) is_resumed: bool,
    /// True if the warning that checkpoints cannot be written has been issued.
    pub(super) is_told: bool,
}

/// Records the files that the script has read since the last call.
fn note_files(host: &Host, files: &mut BTreeMap<PathBuf, (u64, u32)>) {
    for path in host.sandbox.files_read() {
        files.entry(path.clone()).or_insert_with(|| read(&path).map_or((0, 0), |bytes| Origin::digest(&bytes)));
    }
}

/// Returns the scripts, files, settings and program version on which results of a session depend.
fn origin(host: &Host, files: &BTreeMap<PathBuf, (u64, u32)>) -> Origin {
    Origin {
        program: env!("CARGO_PKG_VERSION").into(),
        instructions: instructions(),
        folder: std::env::current_dir().unwrap_or_default(),
        script: host.main.borrow().clone(),
        sources: host.sources.all().into_iter().map(|(name, text)| (name, text.to_string())).collect(),
        files: files.iter().map(|(path, &(length, checksum))| (path.clone(), length, checksum)).collect(),
        overrides: host.settings.overrides.clone(),
        allow_read: host.settings.allow_read.clone(),
        max_operations: host.settings.max_operations,
    }
}

pub(super) fn something_else() -> Failure {
    Failure::script("the script does something else than in the run that is resumed")
        .code("C0951")
        .cause("what it does must follow from its text, its parameters and the files that it reads")
        .hint("run it anew with `conserva run`")
}

pub(super) fn unreadable(error: &io::Error) -> Failure {
    Failure::script("the journal of the run cannot be read")
        .code("C0952")
        .cause(error.to_string())
        .hint("run the script anew with `conserva run`")
}

pub(super) fn of_another_model() -> Failure {
    Failure::script("the checkpoint is of another model than the script makes now")
        .code("C0953")
        .hint("run the script anew with `conserva run`")
}

impl Pages {
    /// The writer of the journal.
    fn writer(&mut self, host: &Host, files: &RunFiles) -> &mut JournalWriter {
        let mark = self.mark;
        let writer = self.writer.get_or_insert_with(|| JournalWriter::new(files, mark));
        if writer.is_empty() {
            let folder = std::env::current_dir().unwrap_or_default().display().to_string();
            // The entry stays in the buffer until the next write.
            let _ = writer.add(&Entry::Run(host.main.borrow().clone(), folder, host.settings.overrides.clone()));
        }
        writer
    }

    /// Adds an entry, unless the journal is closed (too large or not writable) or still being replayed; returns its size in bytes.
    fn add(&mut self, entry: &Entry) -> usize {
        let Some(writer) = self.writer.as_mut().filter(|_| !self.is_full && self.left == 0) else { return 0 };
        match writer.add(entry) {
            Ok(size) => size,
            Err(error) => {
                // The next checkpoint reports the error.
                self.is_full = true;
                self.problem = Some(error);
                0
            }
        }
    }

    pub(super) fn write(&mut self, host: &Host, files: &RunFiles, simulations: Vec<SavedSimulation>) -> Result<(), OutputError> {
        if self.is_full {
            // The journal is incomplete from here on, so the previous checkpoint is the last one.
            return self.problem.take().map_or(Ok(()), Err);
        }
        note_files(host, &mut self.files);
        let (origin, counted) = (origin(host, &self.files), files.counted());
        let journal = self.writer(host, files).secure()?;
        Checkpoint { origin, simulations, journal, files: counted.clone() }.write(files)?;
        files.promise(counted);
        Ok(())
    }
}

impl Journal {
    /// The journal of a session.
    pub fn of(host: &Host) -> Rc<Journal> {
        host.slots.get()
    }

    /// Opens the journal of a run that an earlier process has begun.
    ///
    /// # Errors
    /// The journal cannot be read.
    pub fn resumed(run: &Path, checkpoint: Checkpoint) -> io::Result<Self> {
        let Checkpoint { journal: mark, simulations, .. } = checkpoint;
        let earlier = Some(JournalReader::open(run, &mark)?);
        Ok(Journal(RefCell::new(Pages { earlier, left: mark.events, mark, simulations, is_resumed: true, ..Pages::default() })))
    }

    /// Begins recording before a simulation is made, if checkpoints are enabled.
    ///
    /// # Errors
    /// The folder of the run cannot be written to.
    pub fn begin(&self, host: &Host) -> Result<(), OutputError> {
        if is_kept(host)
            && let Some(files) = RunFolder::of(host).files(host)?
        {
            self.0.borrow_mut().writer(host, &files);
        }
        Ok(())
    }

    /// True while results of computations are taken from an earlier process.
    pub fn is_recalling(&self) -> bool {
        self.0.borrow().left > 0
    }

    /// True if an earlier process has begun this run.
    pub fn is_resumed(&self) -> bool {
        self.0.borrow().is_resumed
    }

    /// Returns the next entry if it is a state (of `simulation`, if given).
    pub(super) fn next_state(&self, simulation: Option<usize>) -> Result<Option<(usize, Arc<State>)>, Failure> {
        let mut pages = self.0.borrow_mut();
        let Some(reader) = &mut pages.earlier else { return Ok(None) };
        let take = |reader: &mut JournalReader| reader.take().map_err(|error| unreadable(&error));
        while let Some(Entry::Run(..)) = reader.peek() {
            take(reader)?;
        }
        match reader.peek() {
            Some(Entry::State { simulation: known, .. }) if simulation.is_none_or(|wanted| wanted == *known) => match take(reader)? {
                Some(Entry::State { simulation, state }) => Ok(Some((simulation, state))),
                _ => Ok(None),
            },
            _ => Ok(None),
        }
    }

    /// Adds a computation, or a return to a stored state.
    pub(super) fn add(&self, event: &Entry) {
        let mut pages = self.0.borrow_mut();
        if !std::mem::take(&mut pages.repeats) {
            pages.add(event);
            pages.new += 1;
        }
    }

    /// Adds the state of a simulation, because the script has read from it.
    pub(super) fn keep(&self, simulation: usize, state: Arc<State>) {
        let mut pages = self.0.borrow_mut();
        pages.bytes += pages.add(&Entry::State { simulation, state });
        pages.is_full |= pages.bytes > MOST_BYTES;
    }

    /// True if a checkpoint is due.
    pub(super) fn is_due(&self, host: &Host) -> bool {
        let mut pages = self.0.borrow_mut();
        if pages.new == 0 || pages.left > 0 || !is_kept(host) {
            return false;
        }
        let new = pages.new;
        let &mut (last, cost) = pages.last.get_or_insert_with(|| (Instant::now(), Duration::ZERO));
        match host.settings.checkpoints {
            Checkpoints::Never => false,
            Checkpoints::Steps(count) => new >= count,
            Checkpoints::Time(time) => last.elapsed() >= time.max(PATIENCE * cost),
        }
    }
}

/// True if a journal is kept: the run writes files and checkpoints are enabled.
pub fn is_kept(host: &Host) -> bool {
    output_folder(host).is_some() && host.settings.checkpoints != Checkpoints::Never
}
