//! What a run has computed, kept so that an interrupted one goes on to the same bytes.
//!
//! A script cannot be stopped in its middle and gone on with: its variables and closures live in the engine. But all it does follows from
//! its text and from what its simulations answer. So a run that is resumed runs the script again, and every step and equilibrium that was
//! computed before comes from the journal. Where the script could look at a state (after a call that took steps, and after every step
//! where a closure runs) the journal has the state; elsewhere the rows of the ledger are enough. Frames of the fields are on the disk
//! already ([`Artifacts`](super::artifacts::Artifacts)).

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::artifacts::output_failure;
use super::handle::{SimulationHandle, Simulations};
use super::run_folder::{RunFolder, output_folder};
use crate::dynamics::{State, TimeFunction};
use crate::math::simd::instructions;
use crate::output::checkpoint::{Checkpoint, Computation, Course, Origin, Outcome, Record};
use crate::script::language::failure::Failure;
use crate::script::language::function::Call;
use crate::script::language::host::Host;
use crate::script::language::settings::Checkpoints;

/// Bytes that the states of a journal may take. A script that looks at a large simulation after each of many steps comes to it; what
/// follows is then computed again.
const MOST_BYTES: usize = 256 << 20;

/// How many times what the last checkpoint took must have passed until the next one.
const PATIENCE: u32 = 30;

/// The journal of a session.
#[derive(Default)]
pub struct Journal(RefCell<Pages>);

#[derive(Default)]
struct Pages {
    records: Vec<Record>,
    /// Records that the script has asked for; beyond them is what an earlier program has computed.
    read: usize,
    /// What that program knew of its simulations at the end.
    courses: Vec<Course>,
    /// Bytes of the states.
    bytes: usize,
    /// Whether nothing is added any more.
    is_full: bool,
    /// Records in the last checkpoint.
    written: usize,
    /// When that was, and what it took.
    last: Option<(Instant, Duration)>,
    /// Length and checksum of the files that the script has read.
    files: BTreeMap<PathBuf, (u64, u32)>,
    /// Whether an earlier program has begun this run.
    is_resumed: bool,
}

/// Notes the files that the script has read since it was asked last.
fn note_files(host: &Host, files: &mut BTreeMap<PathBuf, (u64, u32)>) {
    for path in host.sandbox.files_read() {
        files.entry(path.clone()).or_insert_with(|| std::fs::read(&path).map_or((0, 0), |bytes| Origin::digest(&bytes)));
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

impl Journal {
    /// The journal of a session.
    pub fn of(host: &Host) -> Rc<Journal> {
        host.slots.get()
    }

    /// A journal of what an earlier program has computed.
    pub fn resumed(checkpoint: Checkpoint) -> Self {
        let Checkpoint { records, courses, .. } = checkpoint;
        let size = |record: &Record| record.state.as_deref().map_or(0, State::size);
        let (bytes, written) = (records.iter().map(size).sum(), records.len());
        Journal(RefCell::new(Pages { records, courses, bytes, written, is_resumed: true, ..Pages::default() }))
    }

    /// Whether computations still come from an earlier program.
    pub fn is_recalling(&self) -> bool {
        let pages = self.0.borrow();
        pages.read < pages.records.len()
    }

    /// Whether an earlier program has begun this run.
    pub fn is_resumed(&self) -> bool {
        self.0.borrow().is_resumed
    }

    /// Before something long that is kept elsewhere ([`PointLog`](crate::output::PointLog)): a checkpoint to resume from.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn secure(&self, host: &Host) -> Result<(), Failure> {
        if self.is_recalling() {
            return Ok(());
        }
        go_on(host)?;
        self.write(host)
    }

    /// The next record, which must be of this computation.
    fn next(&self, simulation: usize, computation: Computation) -> Result<Option<Record>, Failure> {
        let mut pages = self.0.borrow_mut();
        let Some(record) = pages.records.get(pages.read).cloned() else { return Ok(None) };
        if (record.simulation, record.computation) != (simulation, computation) {
            return Err(Failure::script("the script does something else than in the run that is resumed")
                .cause("what it does must follow from its text, its parameters and the files that it reads")
                .hint("run it anew with `conserva run`"));
        }
        if record.outcome == Outcome::Failed && pages.read + 1 == pages.records.len() {
            // It is made again, and taken down again.
            pages.records.pop();
        } else {
            pages.read += 1;
        }
        Ok(Some(record))
    }

    /// Adds a computation, unless nobody will ask for it.
    fn add(&self, host: &Host, record: Record) {
        let mut pages = self.0.borrow_mut();
        let is_recalled = pages.read < pages.records.len();
        if is_kept(host) && !pages.is_full && !is_recalled {
            pages.records.push(record);
            pages.read = pages.records.len();
        }
    }

    /// Keeps the state of a simulation after its last computation, which the script may look at now.
    fn keep(&self, simulation: usize, state: &Arc<State>) {
        let mut pages = self.0.borrow_mut();
        if pages.is_full || pages.read < pages.records.len() {
            return;
        }
        let Some(record) = pages.records.iter_mut().rev().find(|record| record.simulation == simulation) else { return };
        if record.state.is_none() && record.outcome != Outcome::Failed {
            record.state = Some(state.clone());
            pages.bytes += state.size();
            pages.is_full = pages.bytes > MOST_BYTES;
        }
    }

    /// Whether it is time for a checkpoint.
    fn is_due(&self, host: &Host) -> bool {
        let mut pages = self.0.borrow_mut();
        let new = pages.records.len() - pages.written;
        if new == 0 || !is_kept(host) {
            return false;
        }
        let &mut (last, cost) = pages.last.get_or_insert_with(|| (Instant::now(), Duration::ZERO));
        match host.settings.checkpoints {
            Checkpoints::Never => false,
            Checkpoints::Steps(count) => new >= count,
            Checkpoints::Time(time) => last.elapsed() >= time.max(PATIENCE * cost),
        }
    }

    /// Writes a checkpoint of all simulations as they stand.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, host: &Host) -> Result<(), Failure> {
        let begun = Instant::now();
        let Some(files) = RunFolder::of(host).files(host).map_err(|error| output_failure(&error))? else { return Ok(()) };
        let mut pages = self.0.borrow_mut();
        let (mut courses, mut lent) = (Vec::new(), Vec::new());
        for (number, handle) in Simulations::of(host).0.borrow().iter().enumerate() {
            let Ok(simulation) = handle.0.simulation.try_borrow() else { return Ok(()) };
            // Frames that the journal counts on are on the disk before it.
            handle.0.artifacts.borrow_mut().as_mut().map_or(Ok(()), |artifacts| artifacts.wait())?;
            let (row, name) = (simulation.row(), handle.0.name.clone());
            let recording = handle.0.artifacts.borrow().as_ref().map(|artifacts| artifacts.recording().clone());
            let (unknowns, reached, tally) = (simulation.unknowns(), (row.step, row.time), simulation.tally());
            courses.push(Course { name, unknowns, reached, tally, recording });
            let last = pages.records.iter().rposition(|record| record.simulation == number);
            if let Some(last) = last.filter(|&last| pages.records[last].state.is_none() && pages.records[last].outcome != Outcome::Failed) {
                pages.records[last].state = Some(simulation.shared_state());
                lent.push(last);
            }
        }
        note_files(host, &mut pages.files);
        let origin = origin(host, &pages.files);
        let checkpoint = Checkpoint { origin, courses, records: std::mem::take(&mut pages.records) };
        let written = checkpoint.write(&files).map_err(|error| output_failure(&error));
        pages.records = checkpoint.records;
        lent.into_iter().for_each(|record| pages.records[record].state = None);
        pages.written = pages.records.len();
        pages.last = Some((Instant::now(), begun.elapsed()));
        written
    }

    /// Writes a last checkpoint of a run that was interrupted, if there is something new in it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn close(&self, host: &Host) -> Result<(), Failure> {
        let is_new = !self.is_recalling() && self.0.borrow().written < self.0.borrow().records.len();
        if is_new && is_kept(host) { self.write(host) } else { Ok(()) }
    }
}

/// Whether a journal is kept: the run writes files, and wants checkpoints.
pub fn is_kept(host: &Host) -> bool {
    output_folder(host).is_some() && host.settings.checkpoints != Checkpoints::Never
}

impl SimulationHandle {
    /// Its number among those of the script; those of a check for itself have none.
    fn number(&self, host: &Host) -> Option<usize> {
        Simulations::of(host).0.borrow().iter().position(|known| known.is(self))
    }

    /// How a computation ended that an earlier program has made; the kernels then stand after it. `None` when it is to be made.
    ///
    /// # Errors
    /// The script asks for another one than in the run that is resumed.
    pub fn recalled(&self, call: &Call, computation: Computation) -> Result<Option<Outcome>, Failure> {
        let journal = Journal::of(call.host);
        if !journal.is_recalling() {
            go_on(call.host)?;
            return Ok(None);
        }
        let Some(number) = self.number(call.host) else { return Ok(None) };
        let Some(record) = journal.next(number, computation)? else { return Ok(None) };
        let Ok(mut simulation) = self.0.simulation.try_borrow_mut() else { return Ok(None) };
        match &record.state {
            Some(state) if !simulation.fits(state) => {
                return Err(call.fail("the checkpoint is of another model than the script makes now").hint("run the script anew"));
            }
            Some(state) => simulation.restore(state),
            None => {
                if let Outcome::Stepped(rows) = &record.outcome {
                    rows.last().into_iter().for_each(|row| simulation.recall(row));
                }
            }
        }
        self.0.is_behind.set(record.state.is_none() && record.outcome != Outcome::Failed);
        drop(simulation);
        if let Outcome::Stepped(rows) = &record.outcome {
            // Loads note whether they acted, when they are asked.
            let asked = || rows.iter().flat_map(|row| [row.time - 0.5 * row.dt, row.time]);
            self.0.model.loads.iter().for_each(|load| asked().for_each(|time| drop(load.amplitude.value(time))));
        }
        Ok(Some(record.outcome).filter(|outcome| *outcome != Outcome::Failed))
    }

    /// Takes down a computation; one that failed begins at a state that is kept.
    pub fn take_down(&self, call: &Call, computation: Computation, outcome: Outcome, before: &Arc<State>) {
        let (journal, Some(number)) = (Journal::of(call.host), self.number(call.host)) else { return };
        if outcome == Outcome::Failed {
            journal.keep(number, before);
        }
        journal.add(call.host, Record { simulation: number, computation, outcome, state: None });
    }

    /// Prepares the state for the script, which may look at it from now on, and keeps it.
    pub fn show(&self, host: &Host) {
        let Ok(mut simulation) = self.0.simulation.try_borrow_mut() else { return };
        if !self.0.is_behind.get() {
            simulation.look();
        }
        if let Some(number) = self.number(host) {
            Journal::of(host).keep(number, &simulation.shared_state());
        }
    }

    /// Writes a checkpoint where it is time for one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn checkpoint(&self, host: &Host) -> Result<(), Failure> {
        let journal = Journal::of(host);
        if journal.is_due(host) { journal.write(host) } else { Ok(()) }
    }
}

/// From here on everything is computed, unless it was before: the simulations count on from what they had counted, and their files grow
/// again. It comes after all that an earlier program had computed has gone into the files.
///
/// # Errors
/// A file that cannot be written.
pub fn go_on(host: &Host) -> Result<(), Failure> {
    let journal = Journal::of(host);
    if journal.is_recalling() {
        return Ok(());
    }
    let courses = std::mem::take(&mut journal.0.borrow_mut().courses);
    for (handle, course) in Simulations::of(host).0.borrow().iter().zip(courses) {
        if let Ok(mut simulation) = handle.0.simulation.try_borrow_mut() {
            simulation.count_from(&course.tally);
        }
        handle.warn_of_large_motion(host);
        if let (Some(artifacts), Some(recording)) = (handle.0.artifacts.borrow_mut().as_mut(), course.recording) {
            artifacts.go_on(recording)?;
        }
    }
    Ok(())
}
