//! A closure of a script that native code calls later, possibly after the call that took it has returned.
//!
//! The engine finds a closure by its name in the functions of the running script. A closure made inside an imported module is not found
//! there, so it is bound to the context of its module, which the module resolver has left with the host.

#![allow(deprecated)] // the engine marks its persistent call context as volatile, not as obsolete

use std::rc::Rc;

use rhai::{Dynamic, EvalAltResult, FnPtr, NativeCallContextStore};

use super::arguments::{Argument, Arguments};
use super::failure::{Failure, ScriptError};
use super::function::Call;
use super::host::Host;
use super::parameter::Kind;

/// A closure bound to its context.
#[derive(Clone)]
pub struct Callback {
    function: FnPtr,
    context: Rc<NativeCallContextStore>,
    host: Rc<Host>,
}

impl Callback {
    /// Binds a closure to the context of the call that received it, or of the module that made it.
    pub fn new(call: &Call, function: FnPtr) -> Self {
        let here = call.context.namespaces().first().is_some_and(|library| defines(library, function.fn_name()));
        let module = if here { None } else { call.host.module_context(function.fn_name()) };
        let context = module.unwrap_or_else(|| Rc::new(call.context.store_data()));
        Callback { function, context, host: call.host.clone() }
    }

    /// Calls the closure.
    ///
    /// # Errors
    /// Whatever the closure fails with.
    pub fn call(&self, arguments: impl IntoIterator<Item = Dynamic>) -> Result<Dynamic, Box<EvalAltResult>> {
        let engine = self.host.engine().ok_or_else(|| Failure::script("the closure outlived its script"))?;
        let engine = engine.borrow();
        let context = self.context.create_context(&engine);
        let arguments: Vec<Dynamic> = arguments.into_iter().collect();
        self.function.call_within_context::<Dynamic>(&context, arguments)
    }

    /// Wraps an error of the closure for its way through the kernels.
    pub fn wrap(&self, error: EvalAltResult) -> ScriptError {
        ScriptError { error: Rc::new(error), source: self.context.global.source.as_ref().map(ToString::to_string).unwrap_or_default() }
    }

    /// The error of a closure that gave a wrong value.
    pub fn refuse(&self, failure: Failure) -> ScriptError {
        self.wrap(*failure.raise(self.context.pos))
    }
}

impl<'a> Call<'a> {
    /// A closure together with what is needed to call it after this call has returned.
    pub fn callback(&self, name: &str) -> Result<Callback, Failure> {
        let argument = self.argument(name);
        match argument.value.as_ref().and_then(|value| value.read_lock::<FnPtr>().map(|function| function.clone())) {
            Some(function) => {
                if let Kind::Closure(parameters) = argument.parameter.kind {
                    argument.check_parameters(&function, parameters)?;
                }
                Ok(Callback::new(self, function))
            }
            None => Err(argument.wrong_type()),
        }
    }

    /// Number of values that a closure is called with, where its definition is found.
    fn parameters_of(&self, function: &FnPtr) -> Option<usize> {
        let name = function.fn_name();
        let of = |library: &rhai::Module| (0..PARAMETERS).find(|count| library.get_script_fn(name, *count).is_some());
        let here = self.context.namespaces().first().and_then(|library| of(library));
        let count = here.or_else(|| self.host.module_context(name)?.global.lib.iter().find_map(|library| of(library)))?;
        // What a closure captures comes first.
        count.checked_sub(function.iter_curry().count())
    }
}

impl Argument<'_> {
    /// Refuses a closure that has another number of parameters than `wanted`, which is written as in a script: `|t|`.
    ///
    /// # Errors
    /// It has.
    pub fn check_parameters(&self, function: &FnPtr, wanted: &str) -> Result<(), Failure> {
        let names = wanted.split(',').filter(|name| !name.trim_matches(['|', ' ']).is_empty()).count();
        let Some(count) = self.call.parameters_of(function) else { return Ok(()) };
        // A point has a third coordinate in space.
        if count == names || (wanted == "|x, y|" && count == names + 1) {
            return Ok(());
        }
        let failure = self.fail(format!("the closure for {} must have {}", self.title(), parameters(names)));
        Err(failure.label(format!("this one has {}", parameters(count))).hint(format!("write `{wanted} …`")))
    }
}

/// `no parameter`, `1 parameter`, `2 parameters`.
fn parameters(count: usize) -> String {
    match count {
        0 => "no parameter".into(),
        1 => "1 parameter".into(),
        count => format!("{count} parameters"),
    }
}

/// Most parameters (captured variables included) that a closure may have to be recognised.
const PARAMETERS: usize = 32;

fn defines(library: &rhai::Module, name: &str) -> bool {
    (0..PARAMETERS).any(|count| library.get_script_fn(name, count).is_some())
}
