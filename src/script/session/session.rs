//! One engine with its scope, from the first line of a script to the files at its end.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use hmac_sha256::Hash;
use rhai::{Dynamic, Engine, Position, Scope};

use super::compile::{compile, constants};
use super::engine::engine;
use super::modules::KEEP_CONTEXT;
use super::worker::start_worker;
use crate::machine::files;
use crate::mesh::MESH_ENDINGS;
use crate::output::checkpoint::Checkpoint;
use crate::output::{COMPLETED, RunLock};
use crate::script::api::files::failures::output_failure;
use crate::script::api::files::results::Results;
use crate::script::api::files::run_folder::RunFolder;
use crate::script::api::models::change::warn_of_unseen_changes;
use crate::script::api::parameters::{Overrides, ParameterUnits, check_overrides};
use crate::script::api::simulations::ending;
use crate::script::api::simulations::handle::{SimulationHandle, Simulations};
use crate::script::api::simulations::journal::Journal;
use crate::script::api::simulations::known_columns::CELL_INDEXER;
use crate::script::language::diagnostics::{Diagnostic, defect};
use crate::script::language::explain::{explain, explain_failure};
use crate::script::language::failure::Class;
use crate::script::language::host::Host;
use crate::script::language::lint::lint;
use crate::script::language::observer::Observer;
use crate::script::language::registry::Registry;
use crate::script::language::sandbox::{Sandbox, reason};
use crate::script::language::scan;
use crate::script::language::settings::Settings;
use crate::script::language::sources::SourceSpan;
use crate::script::language::worker_pool::{MakeWorker, Program, Unit};

/// Outcome of a script.
#[derive(Clone, Debug)]
pub struct Report {
    /// Error with which the script ended.
    pub error: Option<Diagnostic>,
    /// Findings of `conserva check`.
    pub findings: Vec<String>,
    /// Place of the first use of a result, behind which `conserva check` checked nothing.
    pub stopped: Option<SourceSpan>,
    /// Number of checks that held.
    pub checks: usize,
    /// Energy changes, one line for each simulation with a change.
    pub energy: Vec<String>,
    /// True if all simulations conserved their energy, apart from loads and contact.
    pub is_conserving: bool,
    /// True if a warning reports unreliable results.
    pub is_doubtful: bool,
}

impl Report {
    /// Returns the report of a session that could not begin.
    pub fn failed(error: Diagnostic) -> Self {
        Report {
            error: Some(error),
            findings: Vec::new(),
            stopped: None,
            checks: 0,
            energy: Vec::new(),
            is_conserving: true,
            is_doubtful: false,
        }
    }
}

/// Functions, statements and parameters of a script's text.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Name, least number of parameters and first byte of each function, in the order of the text.
    pub functions: Vec<(String, usize, usize)>,
    /// True if there are statements outside of functions.
    pub has_statements: bool,
    /// Names of the parameters that the text reads; `None` if only a run can determine them, because names are computed or other files
    /// imported.
    pub parameters: Option<Vec<String>>,
}

/// The text of a script file.
///
/// # Errors
/// A file that cannot be read or is not text.
pub fn read_script(path: &Path) -> Result<String, Box<Diagnostic>> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_lowercase();
    if MESH_ENDINGS.contains(&&*ending) && path.is_file() {
        let (error, name) = (Diagnostic::error(Class::Script, format!("{} is a mesh, not a script", path.display())), path.display());
        let hint = format!("read it in a script: `let mesh = read_mesh(\"{name}\");`; `conserva info {name}` describes it");
        return Err(Box::new(error.hint(hint)));
    }
    files::read_text(path).map_err(|error| {
        let refused = Diagnostic::error(Class::Script, format!("the script {} cannot be read", path.display())).cause(reason(&error));
        Box::new(refused.hint("check the path of the script; one that comes through a pipe must be kept in a file first"))
    })
}

/// An engine with its scope and its host.
pub struct Session {
    pub(super) engine: Rc<RefCell<Engine>>,
    pub(super) scope: Scope<'static>,
    pub(super) host: Rc<Host>,
    begun: Instant,
    /// Time spent waiting for entries at the prompt, which is excluded from the run time.
    pub(super) idle: Duration,
}

impl Session {
    /// A session for scripts in a folder.
    ///
    /// # Errors
    /// A folder that does not exist.
    pub fn new(settings: Settings, home: &Path, observer: Rc<dyn Observer>) -> Result<Self, Box<Diagnostic>> {
        let begun = Instant::now();
        let sandbox = Sandbox::new(home, &settings.allow_read).map_err(|failure| Box::new(explain_failure(&failure)))?;
        let host = Rc::new(Host::new(settings, sandbox, observer));
        host.slots.set(Rc::new(Overrides::new(&host.settings.overrides)));
        host.slots.set(Rc::new(MakeWorker(Some(start_worker))));
        let engine = Rc::new(RefCell::new(engine(&host)));
        host.attach(&engine);
        Ok(Session { engine, scope: constants(), host, begun, idle: Duration::ZERO })
    }

    /// All functions of the language.
    pub fn registry(&self) -> Rc<Registry> {
        Registry::of(&self.host)
    }

    /// Returns the definition file for the language server of the language.
    pub fn definitions(&self) -> String {
        let all = self.engine.borrow().definitions().include_standard_packages(false).single_file();
        let is_internal = |block: &&str| [KEEP_CONTEXT, CELL_INDEXER].iter().any(|internal| block.contains(internal));
        all.split("\n\n").filter(|block| !is_internal(block)).collect::<Vec<_>>().join("\n\n")
    }

    /// Returns a digest (sixteen digits) of the scripts and of the files read so far.
    pub fn digest(&self) -> String {
        let texts = self.host.sources.all().into_iter().map(|(_, text)| Hash::hash(text.as_bytes()));
        let files = self.host.sandbox.files_read().into_iter().filter_map(|path| files::read(&path).ok()).map(|bytes| Hash::hash(&bytes));
        // Paths differ between machines; contents do not.
        let mut all: Vec<_> = texts.chain(files).collect();
        all.sort();
        Hash::hash(&all.concat()).iter().take(8).map(|byte| format!("{byte:02x}")).collect()
    }

    /// Returns the results that the script has named with `result`, in the order of the calls.
    pub fn results(&self) -> Vec<(String, serde_json::Value)> {
        Results::of(&self.host)
    }

    /// Returns the units of the results that have one, by name.
    pub fn result_units(&self) -> std::collections::BTreeMap<String, String> {
        Results::units(&self.host)
    }

    /// Returns the units of the parameters that have one, by name.
    pub fn parameter_units(&self) -> std::collections::BTreeMap<String, String> {
        ParameterUnits::of(&self.host)
    }

    /// Begins with the results of an earlier process for the first computations of the script.
    ///
    /// # Errors
    /// The journal of the run cannot be read.
    pub fn resume(&mut self, run: &Path, checkpoint: Checkpoint, lock: RunLock) -> std::io::Result<()> {
        RunFolder::of(&self.host).resume(run, &checkpoint, lock);
        self.host.slots.set(Rc::new(Journal::resumed(run, checkpoint)?));
        Ok(())
    }

    /// Runs a script file to its end and writes the files of the run; files of an earlier run are removed unless that is resumed. A script
    /// that cannot be read or parsed leaves the folder unchanged.
    pub fn run_file(&mut self, path: &Path) -> Report {
        let name = path.display().to_string();
        *self.host.main.borrow_mut() = name.clone();
        self.host.sandbox.inputs().add(path);
        if let Err(error) = RunFolder::of(&self.host).refuse_if_taken(&self.host) {
            return Report::failed(explain_failure(&output_failure(&error)));
        }
        match read_script(path).and_then(|text| self.outline(&name, &text).map(|_| text)) {
            Ok(text) => {
                let error = self.guarded(|session| session.evaluate(&name, &text));
                self.finish(error)
            }
            Err(error) => Report::failed(*error),
        }
    }

    /// Runs a script as a test: its statements and then, if named, one of its functions.
    pub fn run_test(&mut self, name: &str, text: &str, function: Option<&str>) -> Report {
        let error = self.guarded(|session| match function {
            None => session.evaluate(name, text),
            Some(function) => session.call(name, text, function),
        });
        self.finish(error)
    }

    /// Returns the functions of a text, and if it has statements, without running it.
    ///
    /// # Errors
    /// A text that does not parse.
    pub fn outline(&self, name: &str, text: &str) -> Result<Outline, Box<Diagnostic>> {
        *self.host.main.borrow_mut() = name.to_string();
        self.host.sources.insert(name, text);
        let engine = self.engine.borrow();
        let tree = compile(&engine, &self.scope, name, text).map_err(|error| Box::new(explain(&self.host, &engine, &error, name)))?;
        let lexemes = scan::lexemes(&engine, text);
        let starts = scan::functions(&lexemes);
        let asked: Option<Vec<String>> = scan::asked_parameters(&lexemes).into_iter().map(|(_, name)| name).collect();
        let asked = asked.filter(|_| scan::imports(&lexemes).is_empty());
        let parameters =
            |function: &str| tree.iter_functions().filter(|known| known.name == function).map(|known| known.params.len()).min();
        let functions = starts.into_iter().filter_map(|(function, start)| parameters(&function).map(|count| (function, count, start)));
        Ok(Outline { functions: functions.collect(), has_statements: !tree.statements().is_empty(), parameters: asked })
    }

    /// Evaluates, and converts a panic into a message, so that the files of the run are still completed.
    fn guarded(&mut self, work: impl FnOnce(&mut Self) -> Result<Dynamic, Box<Diagnostic>>) -> Option<Box<Diagnostic>> {
        match catch_unwind(AssertUnwindSafe(|| work(self))) {
            Ok(outcome) => outcome.err(),
            Err(panic) => Some(defect(&*panic)),
        }
    }

    /// Makes a text the main source.
    fn begin(&self, name: &str, text: &str) {
        *self.host.main.borrow_mut() = name.to_string();
        self.host.sources.insert(name, text);
        self.host.slots.set(Rc::new(Program(RefCell::new(vec![Unit { text: text.into(), names: Vec::new() }]))));
    }

    /// Evaluates a text as the source `name`.
    ///
    /// # Errors
    /// The text does not compile, or its evaluation fails.
    pub fn evaluate(&mut self, name: &str, text: &str) -> Result<Dynamic, Box<Diagnostic>> {
        self.begin(name, text);
        let engine = self.engine.borrow();
        lint(&self.host, &engine, name);
        let outcome =
            compile(&engine, &self.scope, name, text).and_then(|tree| engine.eval_ast_with_scope::<Dynamic>(&mut self.scope, &tree));
        outcome.map_err(|error| Box::new(explain(&self.host, &engine, &error, name)))
    }

    /// Runs the statements of a text as the source `name`, then one of its functions without parameters.
    fn call(&mut self, name: &str, text: &str, function: &str) -> Result<Dynamic, Box<Diagnostic>> {
        self.begin(name, text);
        let engine = self.engine.borrow();
        lint(&self.host, &engine, name);
        let outcome =
            compile(&engine, &self.scope, name, text).and_then(|tree| engine.call_fn::<Dynamic>(&mut self.scope, &tree, function, ()));
        let outcome = outcome.map_err(|mut error| {
            // Failures that end a run at once have no place; the name of the function serves as place.
            let defined = scan::functions(&scan::lexemes(&engine, text)).into_iter().find(|(name, _)| name == function);
            if let (true, Some((_, start))) = (error.position().is_none(), defined) {
                error.set_position(position_of_name(text, start));
            }
            error
        });
        outcome.map_err(|error| Box::new(explain(&self.host, &engine, &error, name)))
    }

    fn remove_checkpoints(&self) -> Option<Box<Diagnostic>> {
        let error = RunFolder::of(&self.host).remove_checkpoints(&self.host).err()?;
        Some(Box::new(explain_failure(&output_failure(&error))))
    }

    /// Writes the last checkpoint of an interrupted run. The frame of the interrupt is written afterwards; if it replaces a frame to which
    /// the checkpoint refers, the latter is kept.
    fn close_journal(&self) -> Option<Diagnostic> {
        Journal::of(&self.host).close(&self.host).err().map(|failure| explain_failure(&failure))
    }

    /// Completes the record of the files of the run.
    fn close_record(&self) -> Option<Box<Diagnostic>> {
        let error = RunFolder::of(&self.host).end().err()?;
        Some(Box::new(explain_failure(&output_failure(&error))))
    }

    /// Ends the run: refuses unknown `--set` names, gives warnings of unused definitions and of findings, writes the files.
    pub fn finish(&mut self, error: Option<Box<Diagnostic>>) -> Report {
        let host = &self.host;
        let stopped = error.as_ref().is_some_and(|error| error.class == Class::ResultUsed);
        let place = error.as_ref().and_then(|error| error.place.clone()).filter(|_| stopped);
        let error = error.map(|error| *error).filter(|error| error.class != Class::ResultUsed || !self.stopped_at(error));
        let unused = || check_overrides(host, &self.engine.borrow(), !stopped).err().map(|failure| explain_failure(&failure));
        let error = error.or_else(unused);
        // A load that never acted may be the cause of a failed check; after any other error the run is incomplete, so the warning would
        // mislead.
        if error.as_ref().is_none_or(|error| error.class == Class::Check) {
            for simulation in Simulations::of(host).0.borrow().iter() {
                simulation.warn_of_idle_parts(host);
                simulation.warn_of_findings(host);
            }
            warn_of_unseen_changes(host);
        }
        let overlap_left = || Simulations::of(host).0.borrow().iter().find_map(SimulationHandle::overlap_left);
        let error = error.or_else(|| overlap_left().map(|failure| explain_failure(&failure)));
        let is_interrupted = error.as_ref().is_some_and(|error| error.class == Class::Interrupted);
        let not_closed = if is_interrupted { self.close_journal() } else { None };
        let refused = ending::last_frames(host).err().map(|failure| explain_failure(&failure));
        let error = error.or(refused);
        let simulations = Simulations::of(host).0.borrow().clone();
        let is_conserving = simulations.iter().all(SimulationHandle::is_conserving);
        let is_doubtful = simulations.iter().any(SimulationHandle::is_doubtful);
        let energy = simulations.iter().filter_map(|simulation| simulation.energy_line(host)).collect();
        let outcome = match &error {
            None => COMPLETED.to_string(),
            Some(error) if error.class == Class::Interrupted => "interrupted".into(),
            Some(error) => error.title.clone(),
        };
        let written = ending::finish(host, self.begun + self.idle, &outcome).err().map(|failure| explain_failure(&failure));
        let error = error.or(written);
        // A completed run needs no checkpoint.
        let is_over = error.as_ref().is_none_or(|error| error.class == Class::Check);
        let removed = if is_over { self.remove_checkpoints() } else { None };
        let closed = removed.or_else(|| self.close_record()).map(|error| *error);
        Report {
            error: error.or(not_closed).or(closed),
            findings: host.findings.borrow().clone(),
            stopped: place,
            checks: host.checks(),
            energy,
            is_conserving,
            is_doubtful,
        }
    }

    /// Records where `conserva check` stopped.
    fn stopped_at(&self, error: &Diagnostic) -> bool {
        let place = error.place.as_ref().map(|place| format!("{place}: ")).unwrap_or_default();
        let finding = format!("{place}{}; what follows depends on it and was not checked", error.title);
        self.host.findings.borrow_mut().push(finding);
        true
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // Simulations hold closures, which hold the host, which holds the simulations.
        self.host.release();
    }
}

/// Position of the name of a function whose definition starts at a byte of the text.
fn position_of_name(text: &str, start: usize) -> Position {
    let start = start + text[start..].strip_prefix("fn").map_or(0, |rest| 2 + rest.len() - rest.trim_start().len());
    let before = &text[..start];
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    let (line, column) = (u16::try_from(before.matches('\n').count() + 1), u16::try_from(column));
    line.and_then(|line| Ok(Position::new(line, column?))).unwrap_or(Position::NONE)
}
