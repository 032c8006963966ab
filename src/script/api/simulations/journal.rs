//! What a run has computed, kept so that an interrupted one goes on to the same bytes.
//!
//! A script cannot be stopped in its middle and gone on with: its variables and closures live in the engine. But all it does follows from
//! its text and from what its simulations answer. So a run that is resumed runs the script again, and every step and equilibrium that was
//! computed before comes from the [journal](crate::output::journal). It has the rows of all steps, and the states that the script asked for
//! anything but the row of their step; in between, the kernels know that row alone (`is_behind`). Ways back to kept states are in it, too,
//! so that the end of the journal is a moment at which nothing has happened to a state since. A checkpoint has what the simulations are
//! then. Frames of the fields are on the disk already ([`Artifacts`](super::artifacts::Artifacts)).

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::artifacts::output_failure;
use super::handle::{Past, SimulationHandle, Simulations};
use super::run_folder::{RunFolder, output_folder};
use crate::dynamics::{State, Tally, TimeFunction};
use crate::machine::files::read;
use crate::math::simd::instructions;
use crate::output::checkpoint::{Checkpoint, Course, Origin};
use crate::output::journal::{Computation, Entry, JournalReader, JournalWriter, Mark, Outcome};
use crate::output::{OutputError, RunFiles};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::failure::Failure;
use crate::script::language::function::Call;
use crate::script::language::host::Host;
use crate::script::language::settings::Checkpoints;

/// Bytes that the states in a journal may take. A script that looks at a large simulation after each of many steps comes to it; what
/// follows is then computed again.
const MOST_BYTES: usize = 1 << 30;

/// How many times what the last checkpoint took must have passed until the next one.
const PATIENCE: u32 = 30;

/// The function for which states before the last steps are kept in checkpoints.
const GOES_BACK: &str = "back";

/// The journal of a session.
#[derive(Default)]
pub struct Journal(RefCell<Pages>);

#[derive(Default)]
struct Pages {
    /// What an earlier program has computed and the script has not asked for yet.
    earlier: Option<JournalReader>,
    /// Computations and ways back in it.
    left: u64,
    /// What that program knew of its simulations at its end.
    courses: Vec<Course>,
    /// Where its journal ends.
    mark: Mark,
    writer: Option<JournalWriter>,
    /// Bytes of the states.
    bytes: usize,
    /// Whether nothing is added any more.
    is_full: bool,
    /// Why, if it could not be written.
    problem: Option<OutputError>,
    /// Whether the computation that failed is made again, and is in the journal already.
    repeats: bool,
    /// Computations since the last checkpoint.
    new: usize,
    /// When that was, and what it took.
    last: Option<(Instant, Duration)>,
    /// Length and checksum of the files that the script has read.
    files: BTreeMap<PathBuf, (u64, u32)>,
    /// Whether an earlier program has begun this run.
    is_resumed: bool,
    /// Whether it was told that checkpoints cannot be written.
    is_told: bool,
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

fn something_else() -> Failure {
    Failure::script("the script does something else than in the run that is resumed")
        .cause("what it does must follow from its text, its parameters and the files that it reads")
        .hint("run it anew with `conserva run`")
}

fn unreadable(error: &io::Error) -> Failure {
    Failure::script("the journal of the run cannot be read").cause(error.to_string()).hint("run the script anew with `conserva run`")
}

fn of_another_model() -> Failure {
    Failure::script("the checkpoint is of another model than the script makes now").hint("run the script anew with `conserva run`")
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

    fn write(&mut self, host: &Host, files: &RunFiles, courses: Vec<Course>) -> Result<(), OutputError> {
        if self.is_full {
            // The journal has no more of the run, so that the checkpoint before is the last one.
            return self.problem.take().map_or(Ok(()), Err);
        }
        note_files(host, &mut self.files);
        let (origin, counted) = (origin(host, &self.files), files.counted());
        let journal = self.writer(host, files).secure()?;
        Checkpoint { origin, courses, journal, files: counted.clone() }.write(files)?;
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
        let Checkpoint { journal: mark, courses, .. } = checkpoint;
        let earlier = Some(JournalReader::open(run, &mark)?);
        Ok(Journal(RefCell::new(Pages { earlier, left: mark.events, mark, courses, is_resumed: true, ..Pages::default() })))
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

    /// Before something long that is kept elsewhere ([`PointLog`](crate::output::PointLog)): a checkpoint to resume from.
    ///
    /// # Errors
    /// An interrupt, or a result that cannot be written.
    pub fn secure(&self, host: &Host) -> Result<(), Failure> {
        if self.is_recalling() {
            return Ok(());
        }
        go_on(host)?;
        self.write(host)
    }

    /// The next computation, which must be this one.
    fn next(&self, host: &Host, simulation: usize, computation: Computation) -> Result<(Outcome, Tally), Failure> {
        match self.next_event(host)? {
            Some(Entry::Computed { simulation: known, computation: asked, outcome, tally })
                if (known, asked) == (simulation, computation) =>
            {
                self.0.borrow_mut().repeats = outcome == Outcome::Failed;
                Ok((outcome, tally))
            }
            _ => Err(something_else()),
        }
    }

    /// The next computation or way back; the simulations whose states come before it stand at these.
    fn next_event(&self, host: &Host) -> Result<Option<Entry>, Failure> {
        while let Some((other, state)) = self.next_state(None)? {
            let handle = Simulations::of(host).0.borrow().get(other).cloned().ok_or_else(something_else)?;
            handle.stand_at(&state)?;
        }
        let mut pages = self.0.borrow_mut();
        pages.left = pages.left.saturating_sub(1);
        pages.earlier.as_mut().map_or(Ok(None), |reader| reader.take().map_err(|error| unreadable(&error)))
    }

    /// The next entry, if it is a state; of this simulation, if one is given.
    fn next_state(&self, simulation: Option<usize>) -> Result<Option<(usize, Arc<State>)>, Failure> {
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
    fn add(&self, event: &Entry) {
        let mut pages = self.0.borrow_mut();
        if !std::mem::take(&mut pages.repeats) {
            pages.add(event);
            pages.new += 1;
        }
    }

    /// Adds the state of a simulation, from which the script learns something.
    fn keep(&self, simulation: usize, state: Arc<State>) {
        let mut pages = self.0.borrow_mut();
        pages.bytes += pages.add(&Entry::State { simulation, state });
        pages.is_full |= pages.bytes > MOST_BYTES;
    }

    /// Whether it is time for a checkpoint.
    fn is_due(&self, host: &Host) -> bool {
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

    /// Writes a checkpoint of all simulations as they stand. One that cannot be written is told once, and the run goes on.
    ///
    /// # Errors
    /// A result that cannot be written.
    pub fn write(&self, host: &Host) -> Result<(), Failure> {
        let begun = Instant::now();
        let Some(files) = RunFolder::of(host).files(host).map_err(|error| output_failure(&error))? else { return Ok(()) };
        let Some(courses) = courses(host)? else { return Ok(()) };
        let mut pages = self.0.borrow_mut();
        let written = pages.write(host, &files, courses);
        pages.new = 0;
        pages.last = Some((Instant::now(), begun.elapsed()));
        let told = written.err().filter(|_| !std::mem::replace(&mut pages.is_told, true));
        drop(pages);
        told.iter().for_each(|error| {
            let warning = Diagnostic::warning("the run cannot be resumed from here: a checkpoint could not be written", None);
            // Not in the files of the run: what it computes is as it would be.
            host.observer.warn(&warning.cause(error.to_string()).hint(format!("the run goes on; {}", error.cure())));
        });
        Ok(())
    }

    /// Writes a last checkpoint of a run that was interrupted, if there is something new in it.
    ///
    /// # Errors
    /// A result that cannot be written.
    pub fn close(&self, host: &Host) -> Result<(), Failure> {
        let is_new = !self.is_recalling() && self.0.borrow().new > 0;
        if is_new && is_kept(host) { self.write(host) } else { Ok(()) }
    }
}

/// What is known of the simulations now; `None` in the middle of a step.
fn courses(host: &Host) -> Result<Option<Vec<Course>>, Failure> {
    let goes_back = host.sources.all().iter().any(|(_, text)| text.contains(GOES_BACK));
    let mut courses = Vec::new();
    for handle in Simulations::of(host).0.borrow().iter() {
        let Ok(simulation) = handle.0.simulation.try_borrow() else { return Ok(None) };
        // Frames that the checkpoint counts on are on the disk before it.
        handle.0.artifacts.borrow_mut().as_mut().map_or(Ok(()), |artifacts| artifacts.wait())?;
        let (row, past) = (simulation.row(), handle.0.past.borrow());
        courses.push(Course {
            name: handle.0.name.clone(),
            unknowns: simulation.unknowns(),
            reached: (row.step, row.time),
            tally: simulation.tally(),
            state: Some(simulation.shared_state()),
            past: if goes_back { known_states(&past) } else { Vec::new() },
            recording: handle.0.artifacts.borrow().as_ref().map(|artifacts| artifacts.recording().clone()),
        });
    }
    Ok(Some(courses))
}

/// The states before the last steps, the newest last, as far as they are known without a gap.
fn known_states(past: &VecDeque<Past>) -> Vec<Arc<State>> {
    let mut known: Vec<Arc<State>> = past.iter().rev().map_while(|past| past.state.clone()).collect();
    known.reverse();
    known
}

/// Whether a journal is kept: the run writes files, and wants checkpoints.
pub fn is_kept(host: &Host) -> bool {
    output_folder(host).is_some() && host.settings.checkpoints != Checkpoints::Never
}

impl SimulationHandle {
    fn stand_at(&self, state: &State) -> Result<(), Failure> {
        let Ok(mut simulation) = self.0.simulation.try_borrow_mut() else { return Ok(()) };
        if !simulation.fits(state) {
            return Err(of_another_model());
        }
        simulation.restore(state);
        self.0.is_behind.set(false);
        self.0.is_known.set(true);
        Ok(())
    }

    /// How a computation ended that an earlier program has made; the kernels then know its row. `None` when it is to be made.
    ///
    /// # Errors
    /// The script asks for another one than in the run that is resumed.
    pub fn recalled(&self, call: &Call, computation: Computation) -> Result<Option<Outcome>, Failure> {
        if !Journal::of(call.host).is_recalling() {
            go_on(call.host)?;
            return Ok(None);
        }
        let Some((journal, number)) = self.0.journal.clone() else { return Ok(None) };
        let (outcome, tally) = journal.next(call.host, number, computation)?;
        if outcome == Outcome::Failed {
            // It is made again, from the state that came before it.
            return Ok(None);
        }
        self.0.is_behind.set(true);
        self.0.is_known.set(false);
        let Ok(mut simulation) = self.0.simulation.try_borrow_mut() else { return Ok(Some(outcome)) };
        simulation.count_from(&tally);
        if let Outcome::Stepped(rows) = &outcome {
            rows.last().into_iter().for_each(|row| simulation.recall(row));
            // Loads note whether they acted, when they are asked.
            let asked = || rows.iter().flat_map(|row| [row.time - 0.5 * row.dt, row.time]);
            self.0.model.loads.iter().for_each(|load| asked().for_each(|time| drop(load.amplitude.value(time))));
        }
        Ok(Some(outcome))
    }

    /// Takes down a computation; one that failed begins at a state that is kept.
    pub fn take_down(&self, computation: Computation, outcome: Outcome, before: &Arc<State>, tally: Tally) {
        let Some((journal, simulation)) = self.0.journal.as_ref().map(|(journal, number)| (journal, *number)) else { return };
        let has_failed = outcome == Outcome::Failed;
        if has_failed && !self.0.is_known.get() {
            journal.keep(simulation, before.clone());
        }
        journal.add(&Entry::Computed { simulation, computation, outcome, tally });
        self.0.is_known.set(has_failed);
    }

    /// Takes down that the simulation has gone to a state that the script had kept, or takes it from what an earlier program has done.
    ///
    /// # Errors
    /// The script asks for something else than in the run that is resumed; a file that cannot be written.
    pub fn take_down_way_back(&self, host: &Host) -> Result<(), Failure> {
        let Some((journal, simulation)) = self.0.journal.as_ref().map(|(journal, number)| (journal, *number)) else { return Ok(()) };
        let event = Entry::WentBack { simulation };
        if !journal.is_recalling() {
            go_on(host)?;
            journal.add(&event);
        } else if journal.next_event(host)? != Some(event) {
            return Err(something_else());
        }
        Ok(())
    }

    /// Before the script learns more of the state than the row of its step: a run that is resumed must know it, too.
    ///
    /// # Errors
    /// The script asks for something else than in the run that is resumed.
    pub fn looked(&self) -> Result<(), Failure> {
        let data = &self.0;
        let Some((journal, number)) = data.journal.as_ref().filter(|_| !data.is_known.get()) else { return Ok(()) };
        if data.is_behind.get() {
            let (_, state) = journal.next_state(Some(*number))?.ok_or_else(something_else)?;
            return self.stand_at(&state);
        }
        // In the middle of a step there is nothing to look at.
        if let Ok(simulation) = data.simulation.try_borrow() {
            journal.keep(*number, simulation.shared_state());
            data.is_known.set(true);
        }
        Ok(())
    }

    /// The state before one of the last steps, to which the script goes back.
    ///
    /// # Errors
    /// It was not kept.
    pub fn past_state(&self, call: &Call, index: usize) -> Result<Arc<State>, Failure> {
        let past = self.0.past.borrow()[index].clone();
        match (past.state, self.0.journal.as_ref().filter(|_| !past.is_known)) {
            (Some(state), None) => Ok(state),
            (Some(state), Some((journal, number))) => {
                journal.keep(*number, state.clone());
                Ok(state)
            }
            (None, journal) => {
                let known = journal.map_or(Ok(None), |(journal, number)| journal.next_state(Some(*number)))?;
                let missing = || call.fail("the state to go back to is not in the checkpoint from which the run was resumed");
                let cure = "keep a state with `sim.save()` and go back to it with `sim.restore(state)`, or run the script anew";
                known.map(|(_, state)| state).ok_or_else(|| missing().hint(cure))
            }
        }
    }

    /// Prepares the state for the script, which may look at it from now on.
    pub fn show(&self) {
        if let Ok(mut simulation) = self.0.simulation.try_borrow_mut()
            && !self.0.is_behind.get()
        {
            simulation.look();
        }
    }

    /// Writes a checkpoint where it is time for one.
    ///
    /// # Errors
    /// A result that cannot be written.
    pub fn checkpoint(&self, host: &Host) -> Result<(), Failure> {
        let journal = Journal::of(host);
        if journal.is_due(host) { journal.write(host) } else { Ok(()) }
    }
}

/// From here on everything is computed, unless it was before: the simulations are what they were where the journal ends, count on from what
/// they had counted, and their files grow again. It comes after all that an earlier program had computed has gone into the files.
///
/// # Errors
/// A file that cannot be written; a state of another model.
pub fn go_on(host: &Host) -> Result<(), Failure> {
    let journal = Journal::of(host);
    if journal.is_recalling() {
        return Ok(());
    }
    let courses = std::mem::take(&mut journal.0.borrow_mut().courses);
    for (handle, course) in Simulations::of(host).0.borrow().iter().zip(courses) {
        let data = &handle.0;
        if let Ok(mut simulation) = data.simulation.try_borrow_mut() {
            if let Some(state) = course.state.filter(|_| data.is_behind.get()) {
                if !simulation.fits(&state) {
                    return Err(of_another_model());
                }
                simulation.restore(&state);
                data.is_behind.set(false);
            }
            simulation.count_from(&course.tally);
        }
        for (past, state) in data.past.borrow_mut().iter_mut().rev().zip(course.past.into_iter().rev()) {
            past.state.get_or_insert(state);
        }
        handle.warn_of_large_motion(host);
        if let (Some(artifacts), Some(recording)) = (data.artifacts.borrow_mut().as_mut(), course.recording) {
            artifacts.go_on(recording, &data.history.borrow())?;
        }
    }
    Ok(())
}
