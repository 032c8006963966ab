//! Data that a session shares with the functions of its scripts: files, texts, warnings, the interrupt, a slot for each topic of the API.
//!
//! The host has the state common to all scripts: check or run, interrupt, warnings already given. State of a topic of the API (simulations,
//! values of `param`) is stored in `slots`, whose types are opaque to the host.

#![allow(deprecated)] // rhai marks the type as deprecated because its interface may change

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::{Rc, Weak};
use std::sync::atomic::Ordering;

use rhai::{Engine, Module, NativeCallContextStore, Position, Shared};

use super::diagnostics::{Diagnostic, Ink};
use super::failure::{Failure, interrupted};
use super::observer::Observer;
use super::sandbox::Sandbox;
use super::scan::{self, Target};
use super::settings::{Mode, Settings};
use super::slots::Slots;
use super::sources::{SourceSpan, Sources, offset};
use crate::machine::{consulted, watched};

/// Data that script functions share with their session.
pub struct Host {
    /// Settings of the run.
    pub settings: Settings,
    /// Texts of the script and its modules.
    pub sources: Sources,
    /// Files that the script may read.
    pub sandbox: Sandbox,
    /// Observer of the session.
    pub observer: Rc<dyn Observer>,
    /// Name of the main source.
    pub main: RefCell<String>,
    /// State of the API's topics.
    pub slots: Slots,
    /// Findings of `conserva check`.
    pub findings: RefCell<Vec<String>>,
    engine: RefCell<Weak<RefCell<Engine>>>,
    module_contexts: RefCell<HashMap<String, Option<Rc<NativeCallContextStore>>>>,
    /// Paths of imported modules by the addresses of the modules.
    module_paths: RefCell<HashMap<usize, String>>,
    loading: RefCell<Vec<Vec<String>>>,
    /// Keys and texts of the warnings.
    warned: RefCell<Vec<(String, String)>>,
    /// Keys of the checks that held, and their messages.
    passed: RefCell<Vec<(String, String)>>,
    effects: Cell<u64>,
    /// Changes after which the script is stopped.
    limit: Cell<Option<u64>>,
    /// Number of simulations that are taking steps.
    stepping: Cell<usize>,
}

impl Host {
    /// A host for a sandbox.
    pub fn new(settings: Settings, sandbox: Sandbox, observer: Rc<dyn Observer>) -> Self {
        Host {
            settings,
            sources: Sources::default(),
            sandbox,
            observer,
            main: RefCell::default(),
            slots: Slots::default(),
            findings: RefCell::default(),
            engine: RefCell::default(),
            module_contexts: RefCell::default(),
            module_paths: RefCell::default(),
            loading: RefCell::default(),
            warned: RefCell::default(),
            passed: RefCell::default(),
            effects: Cell::new(0),
            limit: Cell::default(),
            stepping: Cell::default(),
        }
    }

    /// Counts changes of shared objects: a failed call without a change can be left out of a record of the session.
    pub(crate) fn count_effect(&self) {
        self.effects.set(self.effects.get() + 1);
    }

    /// Number of changes of shared objects in this session.
    pub(crate) fn effects(&self) -> u64 {
        self.effects.get()
    }

    /// Sets the number of changes after which the script stops; returns the earlier setting.
    pub(crate) fn stop_after(&self, changes: Option<u64>) -> Option<u64> {
        self.limit.replace(changes)
    }

    /// True if the number of changes is reached after which the script stops.
    pub fn is_stopped(&self) -> bool {
        self.limit.get().is_some_and(|limit| self.effects.get() >= limit)
    }

    /// True while a simulation takes steps; closures called within are not stopped halfway.
    pub(crate) fn is_stepping(&self) -> bool {
        self.stepping.get() > 0
    }

    /// Records that a simulation begins to take steps, until [`Self::end_steps`].
    pub(crate) fn begin_steps(&self) {
        self.stepping.set(self.stepping.get() + 1);
    }

    /// Ends the steps of a simulation.
    pub(crate) fn end_steps(&self) {
        self.stepping.set(self.stepping.get().saturating_sub(1));
    }

    /// Returns the engine while its session exists.
    pub fn engine(&self) -> Option<Rc<RefCell<Engine>>> {
        self.engine.borrow().upgrade()
    }

    /// Sets the engine.
    pub(crate) fn attach(&self, engine: &Rc<RefCell<Engine>>) {
        *self.engine.borrow_mut() = Rc::downgrade(engine);
    }

    /// True in `conserva check`.
    pub(crate) fn is_check(&self) -> bool {
        self.settings.mode == Mode::Check
    }

    /// True if the user has requested an interrupt, or the script has to stop here.
    pub fn is_interrupted(&self) -> bool {
        self.settings.interrupt.load(Ordering::Relaxed) || self.is_stopped()
    }

    /// Returns an error if the run is interrupted.
    ///
    /// # Errors
    /// The user has requested an interrupt.
    pub(crate) fn go_on(&self) -> Result<(), Failure> {
        if self.is_interrupted() { Err(interrupted("interrupted")) } else { Ok(()) }
    }

    /// Returns the result of `work`, which cannot check the interrupt itself; on an interrupt, `work` is abandoned.
    ///
    /// # Errors
    /// The user has requested an interrupt.
    pub fn watched<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Failure> {
        watched(&self.settings.interrupt, work).ok_or_else(|| interrupted("interrupted"))
    }

    /// Returns the result of `work`, whose queries are answered on this thread; on an interrupt, `work` is abandoned.
    ///
    /// # Errors
    /// The user has requested an interrupt.
    pub fn consulted<T: Send + 'static, Q: Send + 'static, A: Send + 'static>(
        &self,
        work: impl FnOnce(&dyn Fn(Q) -> Option<A>) -> T + Send + 'static,
        answer: impl FnMut(Q) -> A,
    ) -> Result<T, Failure> {
        consulted(&self.settings.interrupt, work, answer).ok_or_else(|| interrupted("interrupted"))
    }

    /// Returns the text range at a position of a source, for the part `target` of a call; an empty source name is the main script.
    pub fn place(&self, engine: &Engine, source: &str, position: Position, target: &Target, method: bool) -> Option<SourceSpan> {
        let source = if source.is_empty() { self.main.borrow().clone() } else { source.to_string() };
        let text = self.sources.text(&source)?;
        let start = offset(&text, position)?;
        let lexemes = scan::lexemes_of_source(engine, &text);
        let start = scan::name_after_dot(&lexemes, start);
        let range = scan::locate(&lexemes, start, target, method).unwrap_or_else(|| scan::word(&lexemes, &text, start));
        Some(SourceSpan { source, text, range })
    }

    /// Shows a warning, once.
    pub fn warn(&self, mut warning: Diagnostic) {
        warning.place = warning.place.map(|place| self.sources.relocate(place));
        let key = format!("{} {}", warning.title, warning.place.as_ref().map(ToString::to_string).unwrap_or_default());
        if !self.warned.borrow().iter().any(|(known, _)| *known == key) {
            self.observer.warn(&warning);
            // Warnings in files name scripts without folders, which differ between machines.
            if let Some(place) = &mut warning.place {
                place.source = place.source.rsplit(['/', '\\']).next().unwrap_or_default().into();
            }
            self.warned.borrow_mut().push((key, warning.render(Ink::Plain)));
        }
    }

    /// Returns the warnings so far.
    pub fn warnings(&self) -> Vec<String> {
        self.warned.borrow().iter().map(|(_, text)| text.clone()).collect()
    }

    /// Reports a check that holds, once per place: checks in a loop or after every step are evaluated often.
    pub fn passed(&self, line: &str, place: Option<&SourceSpan>) {
        let key = place.map_or_else(|| line.to_string(), ToString::to_string);
        let place = place.map(|place| self.sources.relocate(place.clone()));
        let place = place.map(|place| format!("  [{}:{}]", place.source, place.line_column().0)).unwrap_or_default();
        self.passed_as(&key, &format!("{line}{place}"));
    }

    /// Reports a check that holds as `line`, unless a check with the same `key` was reported before.
    pub(crate) fn passed_as(&self, key: &str, line: &str) {
        if !self.passed.borrow().iter().any(|(known, _)| known == key) {
            self.passed.borrow_mut().push((key.into(), line.into()));
            self.observer.passed(line);
        }
    }

    /// Returns passed checks (by their keys) and warnings, and clears both, so that they are reported again.
    pub(crate) fn take_reported(&self) -> Vec<(String, String)> {
        self.warned.take();
        self.passed.take()
    }

    /// Messages of the checks that held.
    pub fn passed_checks(&self) -> Vec<String> {
        self.passed.borrow().iter().map(|(_, line)| line.clone()).collect()
    }

    /// Number of checks that held.
    pub fn checks(&self) -> usize {
        self.passed.borrow().len()
    }

    /// Stores the path of an imported module, which lives as long as the session.
    pub(crate) fn note_module(&self, module: &Shared<Module>, path: &str) {
        self.module_paths.borrow_mut().insert(Shared::as_ptr(module) as usize, path.into());
    }

    /// The path of an imported module.
    pub fn module_path(&self, module: &Shared<Module>) -> Option<String> {
        self.module_paths.borrow().get(&(Shared::as_ptr(module) as usize)).cloned()
    }

    /// Context of the imported module in which a closure was made.
    pub(crate) fn module_context(&self, closure: &str) -> Option<Rc<NativeCallContextStore>> {
        self.module_contexts.borrow().get(closure).cloned().flatten()
    }

    /// Records that a module with these closures begins to load.
    pub(crate) fn begin_module(&self, closures: Vec<String>) {
        self.loading.borrow_mut().push(closures);
    }

    /// Records that the module that began last has been loaded.
    pub(crate) fn end_module(&self) {
        self.loading.borrow_mut().pop();
    }

    /// Stores the context of the module that is loading for its closures. Closures with equal texts in two modules have equal names;
    /// neither is bound then.
    pub(crate) fn keep_module_context(&self, context: NativeCallContextStore) {
        let context = Rc::new(context);
        let loading = self.loading.borrow();
        let mut contexts = self.module_contexts.borrow_mut();
        for closure in loading.last().into_iter().flatten() {
            contexts.entry(closure.clone()).and_modify(|known| *known = None).or_insert_with(|| Some(context.clone()));
        }
    }

    /// Drops everything that refers to the host itself, which would keep it alive.
    pub fn release(&self) {
        self.slots.clear();
        self.module_contexts.borrow_mut().clear();
    }
}
