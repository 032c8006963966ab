//! One engine with its scope, from the first line of a script to the files at its end.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use rhai::packages::{Package, StandardPackage};
use rhai::{AST, Dynamic, Engine, EvalAltResult, FuncRegistration, Module, NativeCallContext, OptimizationLevel, RhaiFunc, Scope, Shared};

use super::arguments::Call;
use super::contacts::{self, ContactMethodHandle, ObstacleHandle};
use super::diagnostics::Diagnostic;
use super::explain::{explain, explain_failure};
use super::failure::{Class, Failure};
use super::forensics::FailedStepHandle;
use super::host::{Host, Observer, Settings};
use super::materials::{self, MaterialHandle};
use super::meshes::{self, MeshHandle};
use super::models::{self, BodyHandle, BoundaryHandle, ModelHandle};
use super::modules::{KEEP_CONTEXT, Modules};
use super::probes::{self, ProbeHandle};
use super::registry::{Form, Function, Registry, Topic, body};
use super::run;
use super::sandbox::{Sandbox, reason};
use super::scan;
use super::simulations::{self, ContactHandle, HistoryHandle, IntegratorHandle, SimulationHandle, StateHandle};
use super::time_functions::{self, TimeFunctionHandle};
use super::{MAX_ARRAY, MAX_CALL_LEVELS, MAX_MAP, MAX_STRING, checks, constants, help, numbers, overrides, record, results, studies};

/// How a script ended.
#[derive(Clone, Debug)]
pub struct Report {
    /// The error it ended with, if it did.
    pub error: Option<Diagnostic>,
    /// What `conserva check` found out.
    pub findings: Vec<String>,
    /// Number of checks that held.
    pub checks: usize,
}

/// What a text consists of.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Name, least number of parameters and first byte of each function, in the order in which they are written.
    pub functions: Vec<(String, usize, usize)>,
    /// Whether there are statements outside of functions.
    pub has_statements: bool,
}

/// The text of a script file.
///
/// # Errors
/// A file that cannot be read or is not text.
pub fn read_script(path: &Path) -> Result<String, Box<Diagnostic>> {
    let text = match std::fs::read(path) {
        Ok(bytes) => String::from_utf8(bytes).map_err(|_| "it is not text (UTF-8)".to_string()),
        Err(error) => Err(reason(&error)),
    };
    text.map_err(|cause| {
        let error = Diagnostic::error(Class::Script, format!("the script {} cannot be read", path.display()));
        Box::new(error.cause(cause).hint("check the path of the script"))
    })
}

/// An engine with its scope and its host.
pub struct Session {
    pub(super) engine: Rc<RefCell<Engine>>,
    pub(super) scope: Scope<'static>,
    pub(super) host: Rc<Host>,
    begun: Instant,
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
        let engine = Rc::new(RefCell::new(engine(&host)));
        host.attach(&engine);
        Ok(Session { engine, scope: constants(), host, begun })
    }

    /// All functions of the language.
    pub fn registry(&self) -> std::cell::Ref<'_, Registry> {
        self.host.registry.borrow()
    }

    /// The definition file of the language for its language server.
    pub fn definitions(&self) -> String {
        let all = self.engine.borrow().definitions().include_standard_packages(false).single_file();
        all.split("\n\n").filter(|block| !block.contains(KEEP_CONTEXT)).collect::<Vec<_>>().join("\n\n")
    }

    /// Runs a script file to its end and writes the files of the run.
    pub fn run_file(&mut self, path: &Path) -> Report {
        let name = path.display().to_string();
        *self.host.main.borrow_mut() = name.clone();
        let error = match read_script(path) {
            Ok(text) => self.guarded(|session| session.evaluate(&name, &text)),
            Err(error) => Some(error),
        };
        self.finish(error)
    }

    /// Runs a script as a test: its statements and then, if one is named, one of its functions.
    pub fn run_test(&mut self, name: &str, text: &str, function: Option<&str>) -> Report {
        let error = self.guarded(|session| match function {
            None => session.evaluate(name, text),
            Some(function) => session.call(name, text, function),
        });
        self.finish(error)
    }

    /// Functions of a text and whether it has statements, without running it.
    ///
    /// # Errors
    /// A text that does not parse.
    pub fn outline(&self, name: &str, text: &str) -> Result<Outline, Box<Diagnostic>> {
        *self.host.main.borrow_mut() = name.to_string();
        self.host.sources.insert(name, text);
        let engine = self.engine.borrow();
        let tree = compile(&engine, &self.scope, name, text).map_err(|error| Box::new(explain(&self.host, &engine, &error, name)))?;
        let starts = scan::functions(&scan::lexemes(&engine, text));
        let parameters =
            |function: &str| tree.iter_functions().filter(|known| known.name == function).map(|known| known.params.len()).min();
        let functions = starts.into_iter().filter_map(|(function, start)| parameters(&function).map(|count| (function, count, start)));
        Ok(Outline { functions: functions.collect(), has_statements: !tree.statements().is_empty() })
    }

    /// Evaluates, and turns a defect of the program into a message, so that the files of the run are still completed.
    fn guarded(&mut self, work: impl FnOnce(&mut Self) -> Result<Dynamic, Box<Diagnostic>>) -> Option<Box<Diagnostic>> {
        match catch_unwind(AssertUnwindSafe(|| work(self))) {
            Ok(outcome) => outcome.err(),
            Err(panic) => Some(defect(&*panic)),
        }
    }

    /// Runs a text under a name.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn evaluate(&mut self, name: &str, text: &str) -> Result<Dynamic, Box<Diagnostic>> {
        *self.host.main.borrow_mut() = name.to_string();
        self.host.sources.insert(name, text);
        let engine = self.engine.borrow();
        self.host.lint(&engine, name);
        let outcome =
            compile(&engine, &self.scope, name, text).and_then(|tree| engine.eval_ast_with_scope::<Dynamic>(&mut self.scope, &tree));
        outcome.map_err(|error| Box::new(explain(&self.host, &engine, &error, name)))
    }

    /// Runs the statements of a text under a name, then one of its functions, which has no parameters.
    fn call(&mut self, name: &str, text: &str, function: &str) -> Result<Dynamic, Box<Diagnostic>> {
        *self.host.main.borrow_mut() = name.to_string();
        self.host.sources.insert(name, text);
        let engine = self.engine.borrow();
        self.host.lint(&engine, name);
        let outcome =
            compile(&engine, &self.scope, name, text).and_then(|tree| engine.call_fn::<Dynamic>(&mut self.scope, &tree, function, ()));
        outcome.map_err(|error| Box::new(explain(&self.host, &engine, &error, name)))
    }

    /// Ends the run: refuses unknown `--set` names, warns of what never acted and of what was found, writes the files.
    pub fn finish(&mut self, error: Option<Box<Diagnostic>>) -> Report {
        let host = &self.host;
        let stopped = error.as_ref().is_some_and(|error| error.class == Class::ResultUsed);
        let error = error.map(|error| *error).filter(|error| error.class != Class::ResultUsed || !self.stopped_at(error));
        let unused = || host.check_overrides(&self.engine.borrow(), !stopped).err().map(|failure| explain_failure(&failure));
        let error = error.or_else(unused);
        // What never acted may be why a check fails; after any other error it says nothing.
        if error.as_ref().is_none_or(|error| error.class == Class::Check) {
            for simulation in host.simulations.borrow().iter() {
                simulation.warn_of_idle_parts(host);
                simulation.warn_of_findings(host);
            }
            host.warn_of_unseen_changes();
        }
        let refused = run::last_frames(host).err().map(|failure| explain_failure(&failure));
        let error = error.or(refused);
        let outcome = match &error {
            None => "completed".to_string(),
            Some(error) if error.class == Class::Interrupted => "interrupted".into(),
            Some(error) => error.title.clone(),
        };
        let written = run::finish(host, self.begun, &outcome).err().map(|failure| explain_failure(&failure));
        Report { error: error.or(written), findings: host.findings.borrow().clone(), checks: host.checks() }
    }

    /// Notes where `conserva check` stopped.
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

/// The message of a panic, which is a defect of the program.
pub(super) fn defect(panic: &(dyn std::any::Any + Send)) -> Box<Diagnostic> {
    let what = panic.downcast_ref::<String>().cloned().or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
    let error = Diagnostic::error(Class::Internal, "the program has a defect and had to stop")
        .cause(what.unwrap_or_else(|| "unknown".into()))
        .hint("please report it together with the script; results up to the last accepted step are kept");
    Box::new(error)
}

fn compile(engine: &Engine, scope: &Scope, name: &str, text: &str) -> Result<AST, Box<EvalAltResult>> {
    let mut tree = engine.compile_with_scope(scope, text)?;
    tree.set_source(name);
    Ok(tree)
}

/// All functions of the language, topic by topic.
fn functions() -> Vec<Function> {
    [
        meshes::functions(),
        materials::functions(),
        models::functions(),
        contacts::functions(),
        probes::functions(),
        time_functions::functions(),
        simulations::functions(),
        results::functions(),
        checks::functions(),
        studies::functions(),
        overrides::functions(),
        record::functions(),
        numbers::functions(),
        help::functions(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Strings of which an engine keeps one copy; as many as a default engine.
const STRINGS_INTERNED: usize = 256;

thread_local! {
    /// The functions that the engine brings with it. Describing them is most of the work of making an engine, and tests make many.
    static STANDARD: Shared<Module> = StandardPackage::new().as_shared_module();
}

fn engine(host: &Rc<Host>) -> Engine {
    let mut engine = Engine::new_raw();
    engine.set_max_strings_interned(STRINGS_INTERNED);
    STANDARD.with(|standard| engine.register_global_module(standard.clone()));
    engine.set_optimization_level(OptimizationLevel::Simple);
    engine.set_strict_variables(true);
    engine.set_fail_on_invalid_map_property(true);
    engine.set_max_operations(host.settings.max_operations);
    engine.set_max_call_levels(MAX_CALL_LEVELS);
    engine.set_max_expr_depths(128, 64);
    engine.set_max_string_size(MAX_STRING);
    engine.set_max_array_size(MAX_ARRAY);
    engine.set_max_map_size(MAX_MAP);
    engine.set_max_modules(1000);
    engine.disable_symbol("eval");

    let interrupt = host.settings.interrupt.clone();
    let progress = Rc::downgrade(host);
    engine.on_progress(move |_| {
        let is_over = || progress.upgrade().is_some_and(|host| host.is_stopped() && !host.is_stepping());
        (interrupt.load(Ordering::Relaxed) || is_over()).then(|| Dynamic::from(Failure::new(Class::Interrupted, "interrupted")))
    });
    let observer = host.observer.clone();
    engine.on_print(move |text| observer.print(text));
    let observer = host.observer.clone();
    engine.on_debug(move |text, source, position| {
        let source = source.map(|source| format!("{source}:{}: ", position.line().unwrap_or(0))).unwrap_or_default();
        observer.print(&format!("{source}{text}"));
    });
    engine.set_module_resolver(Modules::new(host.clone()));

    let mut registry = Registry::default();
    registry.add_type::<MeshHandle>(&mut engine);
    registry.add_type::<MaterialHandle>(&mut engine);
    registry.add_type::<ModelHandle>(&mut engine);
    registry.add_type::<BodyHandle>(&mut engine);
    registry.add_type::<BoundaryHandle>(&mut engine);
    registry.add_type::<ContactMethodHandle>(&mut engine);
    registry.add_type::<ObstacleHandle>(&mut engine);
    registry.add_type::<ProbeHandle>(&mut engine);
    registry.add_type::<ContactHandle>(&mut engine);
    registry.add_type::<TimeFunctionHandle>(&mut engine);
    registry.add_type::<IntegratorHandle>(&mut engine);
    registry.add_type::<SimulationHandle>(&mut engine);
    registry.add_type::<StateHandle>(&mut engine);
    registry.add_type::<HistoryHandle>(&mut engine);
    registry.add_type::<FailedStepHandle>(&mut engine);
    registry.add_type::<Failure>(&mut engine);
    if host.is_check() {
        simulations::register_settle_to_come(&mut engine);
    }
    let mut module = Module::new();
    registry.add(&mut module, host, functions());
    keep_context(&mut module, host);
    engine.register_global_module(module.into());
    *host.registry.borrow_mut() = registry;
    engine
}

/// The hidden function by which a module leaves its context; not part of the language.
fn keep_context(module: &mut Module, host: &Rc<Host>) {
    let function = Function {
        name: KEEP_CONTEXT,
        form: Form::Function,
        topic: Topic::Numbers,
        summary: "",
        parameters: Vec::new(),
        returns: "",
        example: "".into(),
        see_also: &[],
        body: body(|_| Ok(Dynamic::UNIT)),
    };
    let host = host.clone();
    FuncRegistration::new(KEEP_CONTEXT).in_global_namespace().set_into_module_raw(
        module,
        [],
        RhaiFunc::Pure {
            func: Rc::new(move |context: Option<NativeCallContext>, _: &mut [&mut Dynamic]| {
                if let Some(context) = context {
                    host.keep_module_context(&Call::new(&context, &function, Vec::new(), &host));
                }
                Ok(Dynamic::UNIT)
            }),
            has_context: true,
            is_pure: true,
            is_volatile: true,
        },
    );
}
