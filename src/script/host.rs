//! What script functions share with the session that runs them: files, parameters, the observer, warnings, the interrupt flag.

#![allow(deprecated)] // the engine marks its persistent call context as volatile, not as obsolete

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::{Rc, Weak};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use rhai::{Engine, NativeCallContextStore, Position};

use super::arguments::{Call, interrupted};
use super::diagnostics::{Diagnostic, Ink};
use super::failure::Failure;
use super::models::ModelHandle;
use super::motion::Motion;
use super::overrides::Overrides;
use super::registry::Registry;
use super::sandbox::Sandbox;
use super::scan::{self, Target};
use super::simulations::SimulationHandle;
use super::sources::{Place, Sources, offset};
use crate::dynamics::LedgerRow;

/// What a session does with a script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Runs it.
    Run,
    /// Builds its models and reports what it would do; takes no step.
    Check,
}

/// How a session runs a script.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Run or check.
    pub mode: Mode,
    /// Values for `param`, as given with `--set`.
    pub overrides: Vec<(String, String)>,
    /// Folders that a script may read besides its own.
    pub allow_read: Vec<PathBuf>,
    /// Folder of the results; none are written without it.
    pub output: Option<PathBuf>,
    /// Threads of the element loop.
    pub threads: usize,
    /// Operations after which a script counts as endless; time spent in native functions does not count.
    pub max_operations: u64,
    /// Ends the run at the last accepted step when it becomes true.
    pub interrupt: Arc<AtomicBool>,
    /// Tells how far a long factorization is, in thousandths; 0 while none runs.
    pub factorization: Arc<AtomicU32>,
    /// Whether somebody sits at a prompt, who can ask further.
    pub interactive: bool,
}

/// Operations of a script at most by default: about a minute of pure script.
pub const MAX_OPERATIONS: u64 = 500_000_000;

impl Default for Settings {
    fn default() -> Self {
        Settings {
            mode: Mode::Run,
            overrides: Vec::new(),
            allow_read: Vec::new(),
            output: None,
            threads: 1,
            max_operations: MAX_OPERATIONS,
            interrupt: Arc::default(),
            factorization: Arc::default(),
            interactive: false,
        }
    }
}

/// An accepted step, as an observer sees it.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Name of the model.
    pub model: &'a str,
    /// Time at which the current `run_to` began.
    pub from: f64,
    /// Time at which it ends, if it is known.
    pub until: Option<f64>,
    /// The step.
    pub row: &'a LedgerRow,
    /// Largest total energy so far, to relate the defect to.
    pub scale: f64,
}

/// Watches a session: what the script prints, what it checks, how far it is.
pub trait Observer {
    /// A line that the script prints.
    fn print(&self, line: &str);
    /// A check that holds, with what it measured.
    fn passed(&self, line: &str);
    /// Something the user should know; the run goes on.
    fn warn(&self, warning: &Diagnostic);
    /// An accepted step.
    fn advanced(&self, progress: &Progress);
    /// A long computation without steps begins, such as `settle`.
    fn began(&self, what: &str);
    /// A computation that reported progress has ended.
    fn ended(&self);
    /// Whether printed lines may have colors.
    fn ink(&self) -> Ink {
        Ink::Plain
    }
}

/// An observer that looks away.
pub struct Silent;

impl Observer for Silent {
    fn print(&self, _: &str) {}
    fn passed(&self, _: &str) {}
    fn warn(&self, _: &Diagnostic) {}
    fn advanced(&self, _: &Progress) {}
    fn began(&self, _: &str) {}
    fn ended(&self) {}
}

/// What script functions share with their session.
pub struct Host {
    /// How the script is run.
    pub settings: Settings,
    /// Texts of the script and its modules.
    pub sources: Sources,
    /// Files.
    pub sandbox: Sandbox,
    /// Values of `param`.
    pub overrides: Overrides,
    /// Who watches.
    pub observer: Rc<dyn Observer>,
    /// All functions, once they are registered.
    pub registry: RefCell<Registry>,
    /// Name of the main source.
    pub main: RefCell<String>,
    /// Simulations in the order in which the script made them.
    pub simulations: RefCell<Vec<SimulationHandle>>,
    /// What `conserva check` found out.
    pub findings: RefCell<Vec<String>>,
    engine: RefCell<Weak<RefCell<Engine>>>,
    module_contexts: RefCell<HashMap<String, Option<Rc<NativeCallContextStore>>>>,
    loading: RefCell<Vec<Vec<String>>>,
    warned: RefCell<Vec<String>>,
    passed: RefCell<Vec<String>>,
    study: Cell<Option<Study>>,
    effects: Cell<u64>,
    /// Models of which simulations were made.
    models: RefCell<Vec<ModelHandle>>,
    /// Changes after which the script is stopped.
    limit: Cell<Option<u64>>,
    /// Simulations that take steps now.
    stepping: Cell<usize>,
}

/// What holds while a check runs a scenario for itself.
#[derive(Clone, Copy)]
struct Study {
    motion: Option<Motion>,
}

/// Ends a study when it goes out of scope.
pub struct Aside<'a> {
    host: &'a Host,
    before: Option<Study>,
}

impl Drop for Aside<'_> {
    fn drop(&mut self) {
        self.host.study.set(self.before);
    }
}

impl Host {
    /// A host for a sandbox.
    pub fn new(settings: Settings, sandbox: Sandbox, observer: Rc<dyn Observer>) -> Self {
        Host {
            overrides: Overrides::new(&settings.overrides),
            settings,
            sources: Sources::default(),
            sandbox,
            observer,
            registry: RefCell::default(),
            main: RefCell::default(),
            simulations: RefCell::default(),
            findings: RefCell::default(),
            engine: RefCell::default(),
            module_contexts: RefCell::default(),
            loading: RefCell::default(),
            warned: RefCell::default(),
            passed: RefCell::default(),
            study: Cell::default(),
            effects: Cell::new(0),
            models: RefCell::default(),
            limit: Cell::default(),
            stepping: Cell::default(),
        }
    }

    /// Counts changes of objects that scripts share: a call that failed without one can be left out of a record of the session.
    pub fn count_effect(&self) {
        self.effects.set(self.effects.get() + 1);
    }

    /// Changes of shared objects so far.
    pub fn effects(&self) -> u64 {
        self.effects.get()
    }

    /// Notes that a simulation was made of a model as it is now.
    pub fn keep_model(&self, model: &ModelHandle) {
        let mut data = model.0.borrow_mut();
        (data.is_simulated, data.unseen) = (true, None);
        let mut models = self.models.borrow_mut();
        if !self.is_study() && !models.iter().any(|known| Rc::ptr_eq(&known.0, &model.0)) {
            models.push(model.clone());
        }
    }

    /// Warns of changes of models that came after the last `simulate`.
    pub fn warn_of_unseen_changes(&self) {
        for model in self.models.borrow().iter() {
            let data = model.0.borrow();
            let Some((function, place)) = &data.unseen else { continue };
            let title = format!("`{function}` changes model \"{}\" after its simulation was made", data.model.name);
            let warning = Diagnostic::warning(title, place.clone()).cause("a simulation is one of the model as it was at `simulate`");
            self.warn(warning.hint("complete the model before `simulate`, or make another simulation after the change"));
        }
    }

    /// Stops the script after so many changes, until this is set otherwise; what held before.
    pub fn stop_after(&self, changes: Option<u64>) -> Option<u64> {
        self.limit.replace(changes)
    }

    /// Whether the changes are made after which the script stops.
    pub fn is_stopped(&self) -> bool {
        self.limit.get().is_some_and(|limit| self.effects.get() >= limit)
    }

    /// Whether a simulation takes steps: closures between these are not stopped halfway.
    pub fn is_stepping(&self) -> bool {
        self.stepping.get() > 0
    }

    /// Notes that a simulation begins to take steps, until [`Self::end_steps`].
    pub fn begin_steps(&self) {
        self.stepping.set(self.stepping.get() + 1);
    }

    /// Notes that a simulation has taken its steps.
    pub fn end_steps(&self) {
        self.stepping.set(self.stepping.get().saturating_sub(1));
    }

    /// The engine, while its session lives.
    pub fn engine(&self) -> Option<Rc<RefCell<Engine>>> {
        self.engine.borrow().upgrade()
    }

    /// Tells the host its engine.
    pub fn attach(&self, engine: &Rc<RefCell<Engine>>) {
        *self.engine.borrow_mut() = Rc::downgrade(engine);
    }

    /// While the returned value lives, simulations are aside of the run: no files, no summary, and moved if a motion is given (or was
    /// already).
    pub fn study(&self, motion: Option<Motion>) -> Aside<'_> {
        let before = self.study.get();
        self.study.set(Some(Study { motion: motion.or(self.motion()) }));
        Aside { host: self, before }
    }

    /// Whether simulations are made for a check only.
    pub fn is_study(&self) -> bool {
        self.study.get().is_some()
    }

    /// How models are moved now.
    pub fn motion(&self) -> Option<Motion> {
        self.study.get().and_then(|study| study.motion)
    }

    /// Whether this is `conserva check`.
    pub fn is_check(&self) -> bool {
        self.settings.mode == Mode::Check
    }

    /// Whether the user asked to stop, or the script is to stop here.
    pub fn is_interrupted(&self) -> bool {
        self.settings.interrupt.load(Ordering::Relaxed) || self.is_stopped()
    }

    /// The failure of an interrupted run, if it is interrupted.
    ///
    /// # Errors
    /// The user asked to stop.
    pub fn go_on(&self) -> Result<(), Failure> {
        if self.is_interrupted() { Err(interrupted("interrupted")) } else { Ok(()) }
    }

    /// The place that a position and a target mean. An empty source is the main one.
    pub fn place(&self, engine: &Engine, source: &str, position: Position, target: &Target, method: bool) -> Option<Place> {
        let source = if source.is_empty() { self.main.borrow().clone() } else { source.to_string() };
        let text = self.sources.text(&source)?;
        let start = offset(&text, position)?;
        let lexemes = scan::lexemes(engine, &text);
        let start = scan::name_after_dot(&lexemes, start);
        let range = scan::locate(&lexemes, start, target, method).unwrap_or_else(|| scan::word(&lexemes, &text, start));
        Some(Place { source, text, range })
    }

    /// Shows a warning, once.
    pub fn warn(&self, mut warning: Diagnostic) {
        warning.place = warning.place.map(|place| self.sources.relocate(place));
        let key = format!("{} {}", warning.title, warning.place.as_ref().map(ToString::to_string).unwrap_or_default());
        if !self.warned.borrow().contains(&key) {
            self.warned.borrow_mut().push(key);
            self.observer.warn(&warning);
        }
    }

    /// Warns of what a text certainly does not mean: a division of two whole numbers that drops a remainder, `^` for a power.
    pub fn lint(&self, engine: &Engine, source: &str) {
        let Some(text) = self.sources.text(source) else { return };
        let lexemes = scan::lexemes(engine, &text);
        for (range, a, b) in scan::exclusive_ors(&lexemes) {
            let place = Place { source: source.to_string(), text: text.clone(), range };
            let warning = Diagnostic::warning(format!("{a} ^ {b} is {}", a ^ b), Some(place)).label("an exclusive or of bits");
            self.warn(warning.hint(format!("write `{a} ** {b}` for the power")));
        }
        for (range, dividend, divisor) in scan::truncating_divisions(&lexemes) {
            let place = Place { source: source.to_string(), text: text.clone(), range };
            let warning = Diagnostic::warning(format!("{dividend}/{divisor} is {}", dividend / divisor), Some(place))
                .label("a division of whole numbers")
                .cause("whole numbers are divided without a remainder")
                .hint(format!("write `{dividend}.0/{divisor}` for the fraction"));
            self.warn(warning);
        }
    }

    /// Refuses values of `--set` that the script did not ask for: at its end all of them, before that only those for which no `param` is
    /// written anywhere.
    ///
    /// # Errors
    /// The first such name.
    pub fn check_overrides(&self, engine: &Engine, is_over: bool) -> Result<(), Failure> {
        let unused = self.overrides.unused();
        if unused.is_empty() {
            return Ok(());
        }
        let texts = self.sources.all();
        let (mut written, mut is_computed) = (Vec::new(), false);
        for (source, text) in &texts {
            let lexemes = scan::lexemes(engine, text);
            for (range, name) in scan::asked_parameters(&lexemes) {
                is_computed |= name.is_none();
                let place = Place { source: source.clone(), text: text.clone(), range };
                written.extend(name.map(|name| (name, place)));
            }
            let loaded = |path: &str| texts.iter().any(|(name, _)| name.trim_end_matches(".rhai") == path.trim_end_matches(".rhai"));
            is_computed |= scan::imports(&lexemes).iter().any(|path| path.as_deref().is_none_or(|path| !loaded(path)));
        }
        for name in unused {
            match written.iter().find(|(known, _)| *known == name) {
                Some((_, place)) if is_over => return Err(self.overrides.unreached(&name, Some(self.sources.relocate(place.clone())))),
                Some(_) => {}
                None if is_computed && !is_over => {}
                None => {
                    let written: Vec<String> = written.into_iter().map(|(name, _)| name).collect();
                    return Err(self.overrides.unknown(&name, &written));
                }
            }
        }
        Ok(())
    }

    /// Lets go of everything that holds the host itself.
    pub fn release(&self) {
        self.simulations.borrow_mut().clear();
        self.models.borrow_mut().clear();
        self.module_contexts.borrow_mut().clear();
    }

    /// Reports a check that holds, the first time that it does: in a loop or after every step it is asked often.
    pub fn passed(&self, line: &str, place: Option<&Place>) {
        let key = place.map_or_else(|| line.to_string(), ToString::to_string);
        if !self.passed.borrow().contains(&key) {
            self.passed.borrow_mut().push(key);
            let place = place.map(|place| self.sources.relocate(place.clone()));
            let place = place.map(|place| format!("  [{}:{}]", place.source, place.line_column().0)).unwrap_or_default();
            self.observer.passed(&format!("{line}{place}"));
        }
    }

    /// Number of checks that held.
    pub fn checks(&self) -> usize {
        self.passed.borrow().len()
    }

    /// The context of the imported module that made a closure.
    pub fn module_context(&self, closure: &str) -> Option<Rc<NativeCallContextStore>> {
        self.module_contexts.borrow().get(closure).cloned().flatten()
    }

    /// A module with these closures begins to load.
    pub fn begin_module(&self, closures: Vec<String>) {
        self.loading.borrow_mut().push(closures);
    }

    /// The module that began last has loaded.
    pub fn end_module(&self) {
        self.loading.borrow_mut().pop();
    }

    /// Keeps the context of the module that is loading for its closures. Closures with the same text in two modules have the same name;
    /// neither is bound then.
    pub fn keep_module_context(&self, call: &Call) {
        let context = Rc::new(call.context.store_data());
        let loading = self.loading.borrow();
        let mut contexts = self.module_contexts.borrow_mut();
        for closure in loading.last().into_iter().flatten() {
            contexts.entry(closure.clone()).and_modify(|known| *known = None).or_insert_with(|| Some(context.clone()));
        }
    }
}
