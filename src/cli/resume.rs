//! `conserva resume`: resumes an interrupted run from its last checkpoint, with the files of an uninterrupted run.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::Args;

use super::console::{complain, ink};
use super::memory::MemoryArguments;
use super::process::exit_code;
use super::run::{RunControlArguments, RunObservers};
use super::signals::interrupt;
use crate::output::checkpoint::{self, Checkpoint, CheckpointError, Origin};
use crate::output::{CountedFile, OutputError, RunLock, SUMMARY};
use crate::script::{Class, Diagnostic, Mode, Session, Settings, home, processors};

/// Arguments of `conserva resume`.
#[derive(Args)]
pub struct Arguments {
    /// Folder of the run's results, or one of the checkpoints in it
    run: PathBuf,
    /// Stop at this time of the simulation, like an interrupt
    #[arg(long, value_name = "TIME")]
    until: Option<f64>,
    /// Continue even a run that another version of the program or another processor began: results may differ in the last digits
    #[arg(long)]
    anyway: bool,
    #[command(flatten)]
    course: RunControlArguments,
    #[command(flatten)]
    memory: MemoryArguments,
}

fn refusal(title: impl Into<String>) -> Diagnostic {
    Diagnostic::error(Class::Script, title)
}

/// Returns the folder of the run and the path of the checkpoint to resume from.
fn find(given: &Path) -> Result<(PathBuf, PathBuf), Box<Diagnostic>> {
    if !given.is_file() {
        let newest = checkpoint::places(given).pop().ok_or_else(|| Box::new(nothing_to_resume(given)))?;
        return Ok((given.to_path_buf(), newest));
    }
    let run = given.parent().and_then(Path::parent).unwrap_or(Path::new("."));
    Ok((if run.as_os_str().is_empty() { Path::new(".") } else { run }.to_path_buf(), given.to_path_buf()))
}

/// Returns a checkpoint that belongs to the folder of a run, and the files that the run has replaced since.
fn sound(run: &Path, place: &Path) -> Result<(Checkpoint, Vec<CountedFile>), Box<Diagnostic>> {
    let whole = |place: &Path| {
        let checkpoint = Checkpoint::read(place)?;
        let aside = checkpoint.belongs_to(run)?;
        Ok((checkpoint, aside))
    };
    whole(place).map_err(|error: CheckpointError| {
        let refused = refusal(format!("the checkpoint {} cannot be resumed", place.display())).code(error.code()).cause(error.to_string());
        let others = checkpoint::places(run).into_iter().rev().filter(|other| *other != place);
        let sound = others.filter_map(|other| whole(&other).ok().map(|(checkpoint, _)| (other, checkpoint))).next();
        Box::new(match sound {
            Some((other, checkpoint)) => {
                let reached = checkpoint.reached();
                refused.hint(format!("the one before it is sound{reached}: `conserva resume {}`", other.display()))
            }
            None => refused.hint("there is no other one: run the script anew with `conserva run`"),
        })
    })
}

/// Returns the diagnostic of a file that cannot be written.
fn unwritten(error: &OutputError) -> Box<Diagnostic> {
    let class = if matches!(error, OutputError::UnderWay { .. }) { Class::Script } else { Class::Output };
    Box::new(Diagnostic::error(class, error.to_string()).code(error.code()).hint(error.hint()))
}

fn nothing_to_resume(run: &Path) -> Diagnostic {
    if !run.exists() {
        return refusal(format!("there is no folder {}", run.display())).hint("name the folder of a run's results, such as `out/bearing`");
    }
    let error = refusal(format!("there is nothing to resume in {}", run.display()));
    if run.join(SUMMARY).exists() {
        return error
            .cause("it has no checkpoint: the run came to its end, or ended before the first one was written")
            .hint("run the script anew with `conserva run`");
    }
    error.cause("it has no checkpoint").hint("name the folder of a run's results, such as `out/bearing`")
}

/// Refuses to resume if results would differ.
fn compare(then: &Origin, now: &Origin, anyway: bool) -> Result<(), Box<Diagnostic>> {
    let (changed, digits) = then.differences(now);
    if let Some(first) = changed.first() {
        let error = refusal("the run cannot be resumed: what it depends on has changed").cause(first.clone());
        let error = changed[1..].iter().fold(error, |error, more| error.cause(more.clone()));
        return Err(Box::new(error.hint("put it back as it was, or run the script anew with `conserva run`")));
    }
    if let (Some(first), false) = (digits.first(), anyway) {
        let error = refusal("the run would not end with the same digits").cause(first.clone());
        let error = digits[1..].iter().fold(error, |error, more| error.cause(more.clone()));
        return Err(Box::new(error.hint("resume it where it began, or go on with `--anyway` if last digits do not matter")));
    }
    Ok(())
}

/// Resumes a run; returns the exit code.
pub fn resume(arguments: Arguments) -> u8 {
    if let Err(code) = arguments.course.solver.join_job() {
        return code;
    }
    arguments.memory.apply();
    attempt(&arguments).unwrap_or_else(|error| {
        complain(&error.render(ink()));
        exit_code(error.class)
    })
}

fn attempt(arguments: &Arguments) -> Result<u8, Box<Diagnostic>> {
    let (run, place) = find(&arguments.run)?;
    let out = run.canonicalize().unwrap_or_else(|_| run.clone());
    // The lock is taken before files are read that another process may change.
    let lock = RunLock::take(&out).map_err(|error| unwritten(&error))?;
    let (checkpoint, aside) = sound(&run, &place)?;
    let origin = checkpoint.origin.clone();
    // Paths are relative to the folder in which the run was started.
    std::env::set_current_dir(&origin.folder).map_err(|error| {
        let error = refusal(format!("the folder {} cannot be entered", origin.folder.display())).cause(error.to_string());
        Box::new(error.hint("the run began there, and the paths of its script and files are relative to it"))
    })?;
    compare(&origin, &Origin::now(&origin), arguments.anyway)?;
    if let (Some(until), [saved, ..]) = (arguments.until, &checkpoint.simulations[..])
        && until < saved.reached.1
    {
        let error = refusal(format!("the run has passed t = {until}")).cause(format!("the checkpoint is at t = {}", saved.reached.1));
        return Err(Box::new(error.hint("name a later time with `--until`, or an earlier checkpoint")));
    }
    let interrupt = interrupt()
        .map_err(|error| Box::new(Diagnostic::error(Class::Internal, "the interrupt key cannot be watched").cause(error.to_string())))?;
    let watch = RunObservers::new(&arguments.course, &run)?;
    let settings = Settings {
        mode: Mode::Run,
        overrides: origin.overrides,
        allow_read: origin.allow_read,
        output: Some(out.clone()),
        threads: usize::from(arguments.course.threads),
        solver: arguments.course.solver.choice(),
        workers: processors(),
        max_operations: origin.max_operations,
        interrupt: interrupt.clone(),
        factorization: watch.console.factorization(),
        checkpoints: arguments.course.checkpoint,
        until: arguments.until,
        live: watch.live(),
        interactive: false,
    };
    let script = PathBuf::from(&origin.script);
    watch.begin(&script, &run, arguments.course.threads, &settings.overrides);
    let mut session = Session::new(settings, home(&script), watch.observer())?;
    watch.console.note(&format!("resuming{}", checkpoint.reached()));
    checkpoint::restore_files(&out, &aside).map_err(|error| unwritten(&error))?;
    let resumed = session.resume(&out, checkpoint, lock);
    resumed.map_err(|error| Box::new(refusal("the journal of the run cannot be read").cause(error.to_string())))?;
    let report = session.run_file(&script);
    match &report.error {
        Some(error) if error.class == Class::Interrupted && arguments.until.is_some() && !interrupt.load(Ordering::Relaxed) => {
            watch.show_end(&report);
            watch.console.note(&format!("{}; go on with `conserva resume {}`", error.title, run.display()));
            Ok(0)
        }
        _ => Ok(watch.end(&report, &run)),
    }
}
