//! Creates the engine of a session: limits, types, functions, and callbacks into the session.

#![allow(deprecated)] // rhai marks the type as deprecated because its interface may change

use std::cell::Cell;
use std::rc::Rc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use rhai::packages::{Package, StandardPackage};
use rhai::{Dynamic, Engine, FuncRegistration, Module, NativeCallContext, OptimizationLevel, RhaiFunc, Shared};

use super::help;
use super::modules::{KEEP_CONTEXT, Modules};
use crate::machine::memory::{self, written};
use crate::script::api;
use crate::script::api::contacts::friction::FrictionHandle;
use crate::script::api::contacts::methods::ContactMethodHandle;
use crate::script::api::contacts::obstacles::ObstacleHandle;
use crate::script::api::files::shown::Printed;
use crate::script::api::materials::MaterialHandle;
use crate::script::api::meshes::handle::MeshHandle;
use crate::script::api::meshes::regions::CurveHandle;
use crate::script::api::models::handle::{BodyHandle, BoundaryHandle, ModelHandle};
use crate::script::api::simulations::buckling::BucklingHandle;
use crate::script::api::simulations::contact_state::ContactHandle;
use crate::script::api::simulations::fields::BodyStateHandle;
use crate::script::api::simulations::forensics::FailedStepHandle;
use crate::script::api::simulations::handle::SimulationHandle;
use crate::script::api::simulations::harmonic::ResponseHandle;
use crate::script::api::simulations::history::HistoryHandle;
use crate::script::api::simulations::integrators::IntegratorHandle;
use crate::script::api::simulations::joints::JointHandle;
use crate::script::api::simulations::known_columns::register_column_cells;
use crate::script::api::simulations::lines::LineHandle;
use crate::script::api::simulations::modes::ModesHandle;
use crate::script::api::simulations::paths::PathHandle;
use crate::script::api::simulations::probes::ProbeHandle;
use crate::script::api::simulations::reactions::ReactionHandle;
use crate::script::api::simulations::sections::SectionHandle;
use crate::script::api::simulations::settling::register_settle_to_come;
use crate::script::api::simulations::states::StateHandle;
use crate::script::api::simulations::step_control::StepControlHandle;
use crate::script::api::time_functions::TimeFunctionHandle;
use crate::script::language::comparison;
use crate::script::language::elementwise;
use crate::script::language::failure::{Class, Failure};
use crate::script::language::function::Function;
use crate::script::language::growth;
use crate::script::language::handle::Types;
use crate::script::language::host::Host;
use crate::script::language::limits::{MAX_ARRAY, MAX_CALL_LEVELS, MAX_MAP, MAX_STRING};
use crate::script::language::registry::Registry;

/// All functions of the language, topic by topic.
fn functions() -> Vec<Function> {
    let mut all = api::functions();
    all.extend(help::functions());
    all
}

/// Number of interned strings, as in a default engine.
const STRINGS_INTERNED: usize = 256;

thread_local! {
    /// Functions of the engine, shared because their registration is most of the cost of making an engine, and tests make many.
    static STANDARD: Shared<Module> = StandardPackage::new().as_shared_module();
}

/// The engine of a session, with all functions and types of the language.
pub fn engine(host: &Rc<Host>) -> Engine {
    let mut engine = Engine::new_raw();
    engine.set_max_strings_interned(STRINGS_INTERNED);
    STANDARD.with(|standard| engine.register_global_module(standard.clone()));
    engine.set_optimization_level(OptimizationLevel::Simple);
    // The operators of the language take precedence over those of the engine.
    engine.set_fast_operators(false);
    engine.set_strict_variables(true);
    engine.set_fail_on_invalid_map_property(true);
    engine.disable_symbol("eval");
    limit(&mut engine, host);
    connect(&mut engine, host);

    let types = Rc::new(types(&mut engine));
    host.slots.set(types.clone());
    if host.is_check() {
        register_settle_to_come(&mut engine);
    }
    register_column_cells(&mut engine);
    let mut registry = Registry::new(types);
    let mut module = Module::new();
    registry.add(&mut module, host, functions());
    keep_context(&mut module, host);
    elementwise::register(&mut module, host);
    comparison::register(&mut module);
    growth::register(&mut module);
    engine.register_global_module(module.into());
    host.slots.set(Rc::new(registry));
    engine
}

/// Sets the limits of a script.
fn limit(engine: &mut Engine, host: &Host) {
    engine.set_max_operations(host.settings.max_operations);
    engine.set_max_call_levels(MAX_CALL_LEVELS);
    engine.set_max_expr_depths(128, 64);
    engine.set_max_string_size(MAX_STRING);
    engine.set_max_array_size(MAX_ARRAY);
    engine.set_max_map_size(MAX_MAP);
    engine.set_max_modules(1000);
}

/// Number of operations between checks of the clock: each operation may make an array of [`MAX_ARRAY`] entries.
const LOOK: u64 = 8;
/// Period at which the free memory is checked.
const BETWEEN_LOOKS: Duration = Duration::from_millis(20);

/// Returns the failure of a script whose arrays, strings, meshes and simulations exceed the memory limit.
fn out_of_memory() -> Failure {
    let failure = Failure::script("there is no memory left for the script");
    let failure = match memory::limit() {
        Some(limit) => failure.cause(format!("arrays, strings, meshes and simulations may take {} together", written(limit))),
        None => failure.cause("arrays, strings, meshes and simulations have taken all that this machine can give"),
    };
    failure.hint("keep less at a time, or allow more with `--memory`")
}

/// Connects the engine with the session: interrupts, printed lines, modules.
fn connect(engine: &mut Engine, host: &Rc<Host>) {
    let interrupt = host.settings.interrupt.clone();
    let progress = Rc::downgrade(host);
    let looked = Cell::new(Instant::now());
    engine.on_progress(move |operations| {
        if operations % LOOK == 0 && looked.get().elapsed() > BETWEEN_LOOKS {
            looked.set(Instant::now());
            if memory::left() == Some(0) {
                return Some(Dynamic::from(out_of_memory()));
            }
        }
        let is_over = || progress.upgrade().is_some_and(|host| host.is_stopped() && !host.is_stepping());
        (interrupt.load(Ordering::Relaxed) || is_over()).then(|| Dynamic::from(Failure::new(Class::Interrupted, "interrupted")))
    });
    let printing = Rc::downgrade(host);
    let print = move |text: &str| {
        if let Some(host) = printing.upgrade() {
            Printed::show(&host, text);
        }
    };
    engine.on_print(print.clone());
    engine.on_debug(move |text, source, position| {
        let source = source.map(|source| format!("{source}:{}: ", position.line().unwrap_or(0))).unwrap_or_default();
        print(&format!("{source}{text}"));
    });
    engine.set_module_resolver(Modules::new(host.clone()));
}

/// All types of objects.
fn types(engine: &mut Engine) -> Types {
    let mut types = Types::default();
    types.add::<MeshHandle>(engine);
    types.add::<CurveHandle>(engine);
    types.add::<MaterialHandle>(engine);
    types.add::<ModelHandle>(engine);
    types.add::<BodyHandle>(engine);
    types.add::<BoundaryHandle>(engine);
    types.add::<ContactMethodHandle>(engine);
    types.add::<ObstacleHandle>(engine);
    types.add::<FrictionHandle>(engine);
    types.add::<ProbeHandle>(engine);
    types.add::<ContactHandle>(engine);
    types.add::<ReactionHandle>(engine);
    types.add::<SectionHandle>(engine);
    types.add::<LineHandle>(engine);
    types.add::<JointHandle>(engine);
    types.add::<BodyStateHandle>(engine);
    types.add::<ModesHandle>(engine);
    types.add::<PathHandle>(engine);
    types.add::<ResponseHandle>(engine);
    types.add::<BucklingHandle>(engine);
    types.add::<TimeFunctionHandle>(engine);
    types.add::<IntegratorHandle>(engine);
    types.add::<StepControlHandle>(engine);
    types.add::<SimulationHandle>(engine);
    types.add::<StateHandle>(engine);
    types.add::<HistoryHandle>(engine);
    types.add::<FailedStepHandle>(engine);
    types.add::<Failure>(engine);
    types
}

/// Registers the hidden function by which a module stores its context; not part of the language.
fn keep_context(module: &mut Module, host: &Rc<Host>) {
    let host = host.clone();
    FuncRegistration::new(KEEP_CONTEXT).in_global_namespace().set_into_module_raw(
        module,
        [],
        RhaiFunc::Pure {
            func: Rc::new(move |context: Option<NativeCallContext>, _: &mut [&mut Dynamic]| {
                if let Some(context) = context {
                    host.keep_module_context(context.store_data());
                }
                Ok(Dynamic::UNIT)
            }),
            has_context: true,
            is_pure: true,
            is_volatile: true,
        },
    );
}
