//! What a run has computed, kept so that an interrupted one goes on to the same bytes.
//!
//! A script cannot be stopped in its middle and gone on with: its variables and closures live in the engine. But all it does follows from
//! its text and from what its simulations answer. So a run that is resumed runs the script again, and every step and equilibrium that was
//! computed before comes from the [journal](crate::output::journal). It has the rows of all steps, and the states that the script asked for
//! anything but the row of their step; in between, the kernels know that row alone (`is_behind`). Ways back to kept states are in it, too,
//! so that the end of the journal is a moment at which nothing has happened to a state since. A checkpoint has what the simulations are
//! then. Frames of the fields are on the disk already ([`Artifacts`](super::artifacts::Artifacts)).

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
use crate::script::language::failure::Failure;
use crate::script::language::host::Host;
use crate::script::language::settings::Checkpoints;

/// Bytes that the states in a journal may take. A script that looks at a large simulation after each of many steps comes to it; what
/// follows is then computed again.
const MOST_BYTES: usize = 1 << 30;

/// How many times what the last checkpoint took must have passed until the next one.
const PATIENCE: u32 = 30;

/// The journal of a session.
#[derive(Default)]
pub struct Journal(pub(super) RefCell<Pages>);

#[derive(Default)]
pub(super) struct Pages {
    /// What an earlier program has computed and the script has not asked for yet.
    pub(super) earlier: Option<JournalReader>,
    /// Computations and ways back in it.
    pub(super) left: u64,
    /// What that program knew of its simulations at its end.
    pub(super) simulations: Vec<SavedSimulation>,
    /// Where its journal ends.
    pub(super) mark: Mark,
    pub(super) writer: Option<JournalWriter>,
    /// Bytes of the states.
    pub(super) bytes: usize,
    /// Whether nothing is added any more.
    pub(super) is_full: bool,
    /// Why, if it could not be written.
    pub(super) problem: Option<OutputError>,
    /// Whether the computation that failed is made again, and is in the journal already.
    pub(super) repeats: bool,
    /// Computations since the last checkpoint.
    pub(super) new: usize,
    /// When that was, and what it took.
    pub(super) last: Option<(Instant, Duration)>,
    /// Length and checksum of the files that the script has read.
    pub(super) files: BTreeMap<PathBuf, (u64, u32)>,
    /// Whether an earlier program has begun this run.
    pub(super) is_resumed: bool,
    /// Whether it was told that checkpoints cannot be written.
    pub(super) is_told: bool,
}

/// Notes the files that the script has read since it was asked last.
fn note_files(host: &Host, files: &mut BTreeMap<PathBuf, (u64, u32)>) {
    for path in host.sandbox.files_read() {
        files.entry(path.clone()).or_insert_with(|| read(&path).map_or((0, 0), |bytes| Origin::digest(&bytes)));
    }
}

/// What results of a session depend on.
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
            // It waits with what comes next.
            let _ = writer.add(&Entry::Run(host.main.borrow().clone(), folder, host.settings.overrides.clone()));
        }
        writer
    }

    /// Adds an entry, unless nobody will ask for it; the bytes that it takes.
    fn add(&mut self, entry: &Entry) -> usize {
        let Some(writer) = self.writer.as_mut().filter(|_| !self.is_full && self.left == 0) else { return 0 };
        match writer.add(entry) {
            Ok(size) => size,
            Err(error) => {
                // Told with the next checkpoint.
                self.is_full = true;
                self.problem = Some(error);
                0
            }
        }
    }

    pub(super) fn write(&mut self, host: &Host, files: &RunFiles, simulations: Vec<SavedSimulation>) -> Result<(), OutputError> {
        if self.is_full {
            // The journal has no more of the run, so that the checkpoint before is the last one.
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

    /// The journal of a run in a folder that an earlier program has begun.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn resumed(run: &Path, checkpoint: Checkpoint) -> io::Result<Self> {
        let Checkpoint { journal: mark, simulations, .. } = checkpoint;
        let earlier = Some(JournalReader::open(run, &mark)?);
        Ok(Journal(RefCell::new(Pages { earlier, left: mark.events, mark, simulations, is_resumed: true, ..Pages::default() })))
    }

    /// Before a simulation is made: what it computes is taken down, if checkpoints are wanted.
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

    /// Whether computations still come from an earlier program.
    pub fn is_recalling(&self) -> bool {
        self.0.borrow().left > 0
    }

    /// Whether an earlier program has begun this run.
    pub fn is_resumed(&self) -> bool {
        self.0.borrow().is_resumed
    }

    /// The next entry, if it is a state; of this simulation, if one is given.
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

    /// Adds a computation or a way back.
    pub(super) fn add(&self, event: &Entry) {
        let mut pages = self.0.borrow_mut();
        if !std::mem::take(&mut pages.repeats) {
            pages.add(event);
            pages.new += 1;
        }
    }

    /// Adds the state of a simulation, from which the script learns something.
    pub(super) fn keep(&self, simulation: usize, state: Arc<State>) {
        let mut pages = self.0.borrow_mut();
        pages.bytes += pages.add(&Entry::State { simulation, state });
        pages.is_full |= pages.bytes > MOST_BYTES;
    }

    /// Whether it is time for a checkpoint.
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

/// Whether a journal is kept: the run writes files, and wants checkpoints.
pub fn is_kept(host: &Host) -> bool {
    output_folder(host).is_some() && host.settings.checkpoints != Checkpoints::Never
}
