//! A closure of a script that native code calls later, possibly after the receiving call has returned.
//!
//! The engine finds a closure by its name in the functions of the running script. A closure made inside an imported module is not found
//! there, so it is bound to the context of its module, which the module resolver has stored in the host.

#![allow(deprecated)] // rhai marks the type as deprecated because its interface may change

use std::rc::Rc;

use rhai::{Dynamic, EvalAltResult, FnPtr, ImmutableString, NativeCallContextStore, ScriptFuncDef, Shared};

use super::arguments::{Argument, Arguments};
use super::causes;
use super::failure::{Failure, ScriptError};
use super::function::Call;
use super::host::Host;
use super::parameter::Kind;
use super::plain::Plain;

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

    /// Returns a closure of a program by its name; `None` if the program of the context does not have it.
    pub fn named(host: &Rc<Host>, context: Rc<NativeCallContextStore>, name: &str) -> Option<Self> {
        let function = FnPtr::from(definition(&context, name)?.clone());
        Some(Callback { function, context, host: host.clone() })
    }

    /// Name by which the engine finds the closure.
    pub fn name(&self) -> &str {
        self.function.fn_name()
    }

    /// Values captured by the closure.
    pub fn captured(&self) -> impl Iterator<Item = &Dynamic> {
        self.function.iter_curry()
    }

    /// Calls the closure independently of earlier calls: operations are counted from zero, and captured values are copies of `captured` (or
    /// of the closure's own where not given).
    ///
    /// # Errors
    /// Errors of the closure, or a change of a captured value.
    pub(crate) fn call_by_itself(
        &self,
        captured: &[Option<Plain>],
        arguments: Vec<Dynamic>,
    ) -> Result<Result<Dynamic, Failure>, Box<EvalAltResult>> {
        let engine = self.host.engine().ok_or_else(|| Failure::script("the closure outlived its script"))?;
        let engine = engine.borrow();
        let mut context = (*self.context).clone();
        context.global.num_operations = Default::default();
        let own = self.captured().cloned().map(Some).chain(std::iter::repeat(None));
        let copy = |(plain, own): (&Option<Plain>, Option<Dynamic>)| match plain {
            Some(plain) => plain.value().into_shared(),
            None => own.unwrap_or_default(),
        };
        let values: Vec<Dynamic> = captured.iter().zip(own).map(copy).collect();
        let mut function = self.function.clone();
        function.set_curry(values.iter().cloned());
        let value = function.call_within_context::<Dynamic>(&context.create_context(&engine), arguments)?;
        let is_changed = |(plain, value): (&Option<Plain>, &Dynamic)| {
            plain.as_ref().is_some_and(|plain| Plain::of(value).is_none_or(|after| !after.is_same(plain)))
        };
        match captured.iter().zip(&values).position(is_changed) {
            None => Ok(Ok(value.flatten())),
            Some(index) => Ok(Err(changed(definition(&context, self.name()).and_then(|function| function.params.get(index))))),
        }
    }

    /// Wraps an error of the closure to be passed through the solver.
    pub(crate) fn wrap(&self, error: EvalAltResult) -> ScriptError {
        ScriptError { error: Rc::new(error), source: self.context.global.source.as_ref().map(ToString::to_string).unwrap_or_default() }
    }

    /// Error of a closure that returned an invalid value.
    pub fn refuse(&self, failure: Failure) -> ScriptError {
        self.wrap(*failure.raise(self.context.pos))
    }
}

impl<'a> Call<'a> {
    /// Returns a closure with its context, for calls after this call has returned.
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

    /// Returns the number of arguments of a closure, if its definition is found.
    fn parameters_of(&self, function: &FnPtr) -> Option<usize> {
        let name = function.fn_name();
        let of = |library: &rhai::Module| (0..PARAMETERS).find(|count| library.get_script_fn(name, *count).is_some());
        let here = self.context.namespaces().first().and_then(|library| of(library));
        let count = here.or_else(|| self.host.module_context(name)?.global.lib.iter().find_map(|library| of(library)))?;
        // Captured values come first.
        count.checked_sub(function.iter_curry().count())
    }
}

impl Argument<'_> {
    /// Refuses a closure whose number of parameters differs from `wanted`, written as in a script: `|t|`.
    ///
    /// # Errors
    /// The numbers differ.
    pub fn check_parameters(&self, function: &FnPtr, wanted: &str) -> Result<(), Failure> {
        let names = wanted.split(',').filter(|name| !name.trim_matches(['|', ' ']).is_empty()).count();
        let Some(count) = self.call.parameters_of(function) else { return Ok(()) };
        // A point has a third coordinate in space.
        if count == names || (wanted == "|x, y|" && count == names + 1) {
            return Ok(());
        }
        let failure = self.refuse(causes::CLOSURE, format!("the closure for {} must have {}", self.title(), parameters(names)));
        Err(failure.label(format!("this one has {}", parameters(count))).hint(format!("write `{wanted} …`")))
    }
}

/// Number of parameters in words: `no parameter`, `1 parameter`, `2 parameters`.
fn parameters(count: usize) -> String {
    match count {
        0 => "no parameter".into(),
        1 => "1 parameter".into(),
        count => format!("{count} parameters"),
    }
}

/// Returns the definition of a function of a program.
fn definition<'a>(context: &'a NativeCallContextStore, name: &str) -> Option<&'a Shared<ScriptFuncDef>> {
    let of = |library: &'a Shared<rhai::Module>| (0..PARAMETERS).find_map(|count| library.get_script_fn(name, count));
    context.global.lib.iter().rev().find_map(of)
}

/// Returns the failure of a closure that changes a captured value although calls must be independent.
fn changed(name: Option<&ImmutableString>) -> Failure {
    let variable = name.map_or_else(|| "a variable".to_string(), |name| format!("`{name}`"));
    let failure = Failure::script(format!("the closure changes {variable}, which belongs to the script around it")).code(causes::CLOSURE);
    let failure = failure.cause("points of a study are computed independently, possibly in parallel, with the values at its start");
    failure.hint("let the closure give what it found: `#{ name: value, … }`")
}

/// Most parameters (captured variables included) that a closure may have to be recognised.
const PARAMETERS: usize = 32;

fn defines(library: &rhai::Module, name: &str) -> bool {
    (0..PARAMETERS).any(|count| library.get_script_fn(name, count).is_some())
}
