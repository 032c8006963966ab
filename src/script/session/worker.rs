//! A session that calls closures for another session, on its own thread.
//!
//! The worker compiles the texts of the other session and runs only their imports, so that it has every function and closure written there;
//! captured values are transferred as data. Before every call it discards all data of earlier calls, so that results do not depend on the
//! worker.

#![allow(deprecated)] // rhai marks the type as deprecated because its interface may change

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

use rhai::{AST, Dynamic, Engine, ImmutableString, NativeCallContextStore};

use super::compile::constants;
use super::engine::engine;
use super::modules::KEEP_CONTEXT;
use crate::script::api::nested_runs::{NestedRun, begin_study};
use crate::script::api::parameters::Overrides;
use crate::script::api::units::DeclaredUnits;
use crate::script::language::callback::Callback;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::failure::Class;
use crate::script::language::handle::Types;
use crate::script::language::host::Host;
use crate::script::language::message::Message;
use crate::script::language::observer::Observer;
use crate::script::language::plain::Plain;
use crate::script::language::registry::Registry;
use crate::script::language::sandbox::Sandbox;
use crate::script::language::worker_pool::{
    Blueprint, ClosureCaller, Computed, MakeWorker, Outcome, PortableClosure, Program, ScriptOutput, Unit, outcome_of,
};

/// Key under which the host stores the context of the program.
const PROGRAM: &str = "the program";

/// A session that calls closures for another session.
struct Worker {
    engine: Rc<RefCell<Engine>>,
    host: Rc<Host>,
    program: Vec<Unit>,
    units: Vec<String>,
    notes: Rc<Notes>,
    context: Rc<NativeCallContextStore>,
    aside: Option<NestedRun>,
}

/// Makes a worker on this thread; `None` if its folder or an import can no longer be read.
pub fn start_worker(blueprint: &Blueprint) -> Option<Box<dyn ClosureCaller>> {
    let notes = Rc::new(Notes::default());
    let sandbox = Sandbox::new(&blueprint.home, &blueprint.settings.allow_read).ok()?;
    let host = Rc::new(Host::new(blueprint.settings.clone(), sandbox, notes.clone()));
    let engine = Rc::new(RefCell::new(engine(&host)));
    host.attach(&engine);
    host.sources.take(&blueprint.sources);
    host.main.borrow_mut().clone_from(&blueprint.main);
    // Units are set before modules are imported, because these may contain quantities with units.
    host.slots.set(Rc::new(DeclaredUnits::of_names(&blueprint.units)));
    let context = context(&host, &engine.borrow(), blueprint)?;
    Some(Box::new(Worker { engine, host, program: blueprint.program.clone(), units: blueprint.units.clone(), notes, context, aside: None }))
}

/// Compiles the functions of the texts; returns the context of their calls.
fn context(host: &Rc<Host>, engine: &Engine, blueprint: &Blueprint) -> Option<Rc<NativeCallContextStore>> {
    let mut tree = AST::empty();
    for unit in &blueprint.program {
        let mut scope = constants();
        for name in &unit.names {
            scope.push(name.as_str(), ());
        }
        tree = tree.merge(&engine.compile_with_scope(&scope, &unit.text).ok()?);
    }
    tree.clear_statements();
    let import = |(alias, path): &(String, String)| match alias.as_str() {
        "" => format!("import {path:?};"),
        alias => format!("import {path:?} as {alias};"),
    };
    let imports: String = blueprint.imports.iter().map(import).collect();
    let mut tree = tree.merge(&engine.compile(format!("{imports}{KEEP_CONTEXT}();")).ok()?);
    tree.set_source(&blueprint.main);
    host.begin_module(vec![PROGRAM.into()]);
    let outcome = engine.eval_ast_with_scope::<Dynamic>(&mut constants(), &tree);
    host.end_module();
    drop(outcome.ok()?);
    let mut context = (*host.module_context(PROGRAM)?).clone();
    let values = blueprint.constants.iter().map(|(name, value)| (ImmutableString::from(name), value.value()));
    context.global.constants = Some(Rc::new(RefCell::new(values.collect())));
    Some(Rc::new(context))
}

impl Worker {
    /// The closure as a value of this session.
    fn closure(&self, name: &str) -> Option<Callback> {
        let here = Callback::named(&self.host, self.context.clone(), name);
        here.or_else(|| Callback::named(&self.host, self.host.module_context(name)?, name))
    }

    /// Discards the data of earlier calls, except those that functions of the language need.
    fn forget(&mut self) {
        self.aside = None;
        let slots = &self.host.slots;
        let (types, registry) = (slots.get::<Types>(), slots.get::<Registry>());
        slots.clear();
        slots.set(types);
        slots.set(registry);
        slots.set(Rc::new(Overrides::new(&self.host.settings.overrides)));
        slots.set(Rc::new(DeclaredUnits::of_names(&self.units)));
        slots.set(Rc::new(MakeWorker(Some(start_worker))));
        slots.set(Rc::new(Program(RefCell::new(self.program.clone()))));
        self.host.take_reported();
        self.notes.told.take();
        self.aside = Some(begin_study(&self.host, None));
    }

    fn call(&self, closure: &PortableClosure, arguments: &[Plain]) -> Outcome {
        let Some(callback) = self.closure(&closure.name) else {
            let error = Diagnostic::error(Class::Internal, "a session does not know a closure of another one");
            return Outcome::Refused(Message::of(&error));
        };
        let captured: Vec<Option<Plain>> = closure.captured.iter().cloned().map(Some).collect();
        let value = callback.call_by_itself(&captured, arguments.iter().map(Plain::value).collect());
        let engine = self.engine.borrow();
        outcome_of(&self.host, &engine, value, closure.reading)
    }

    /// Returns the messages of a call, with the keys that identify checks.
    fn told(&self) -> Vec<ScriptOutput> {
        let mut keys = self.host.take_reported().into_iter().map(|(key, _)| key);
        let named = |told| match told {
            ScriptOutput::Passed(_, line) => ScriptOutput::Passed(keys.next().unwrap_or_default(), line),
            other => other,
        };
        self.notes.told.take().into_iter().map(named).collect()
    }
}

impl ClosureCaller for Worker {
    fn knows(&self, closure: &PortableClosure) -> bool {
        self.closure(&closure.name).is_some()
    }

    fn compute(&mut self, closure: &PortableClosure, arguments: &[Plain]) -> Computed {
        self.forget();
        let host = &self.host;
        let before: BTreeSet<String> = host.sources.all().into_iter().map(|(name, _)| name).collect();
        let outcome = self.call(closure, arguments);
        let asked = host.slots.get::<Overrides>().parameters();
        let modules = host.sources.all().into_iter().filter(|(name, _)| !before.contains(name));
        Computed {
            outcome,
            told: self.told(),
            asked: asked.iter().filter_map(|(name, value)| Some((name.clone(), Plain::of(value)?))).collect(),
            read: host.sandbox.files_read(),
            modules: modules.map(|(name, text)| (name, text.to_string())).collect(),
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.aside = None;
        // Simulations hold closures, which hold the host, which holds the simulations.
        self.host.release();
    }
}

/// Observer that records the messages of a call.
#[derive(Default)]
struct Notes {
    told: RefCell<Vec<ScriptOutput>>,
}

impl Observer for Notes {
    fn print(&self, line: &str) {
        self.told.borrow_mut().push(ScriptOutput::Line(line.into()));
    }

    fn passed(&self, line: &str) {
        self.told.borrow_mut().push(ScriptOutput::Passed(String::new(), line.into()));
    }

    fn warn(&self, warning: &Diagnostic) {
        self.told.borrow_mut().push(ScriptOutput::Warning(Message::of(warning)));
    }
}
