//! The table of all functions, and the registration of functions in the engine.
//!
//! A function is registered with every number of arguments that its optional parameters allow. Its body receives a `Call` whose keys are
//! already checked.

use std::any::TypeId;
use std::rc::Rc;

use rhai::{Dynamic, FuncRegistration, ImmutableString, Module, NativeCallContext, RhaiFunc};

use super::failure::Failure;
use super::function::{Call, Form, Function};
use super::handle::Types;
use super::host::Host;
use super::parameter::Parameter;

/// All functions of the language.
#[derive(Default)]
pub struct Registry {
    functions: Vec<Rc<Function>>,
    types: Rc<Types>,
}

impl Registry {
    /// A registry without functions, of objects of these types.
    pub fn new(types: Rc<Types>) -> Self {
        Registry { functions: Vec::new(), types }
    }

    /// The registry of a session.
    pub fn of(host: &Host) -> Rc<Registry> {
        host.slots.get()
    }

    /// Types of objects.
    pub fn types(&self) -> &Types {
        &self.types
    }

    /// The functions in the order of their registration.
    pub fn functions(&self) -> &[Rc<Function>] {
        &self.functions
    }

    /// Functions, methods and properties of that name.
    pub fn named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Rc<Function>> + 'a {
        self.functions.iter().filter(move |function| function.name == name)
    }

    /// Methods and properties of a type.
    pub fn members<'a>(&'a self, type_name: &'a str) -> impl Iterator<Item = &'a Rc<Function>> + 'a {
        self.functions.iter().filter(move |function| function.form.receiver().is_some_and(|receiver| receiver.name == type_name))
    }

    /// Adds functions to a module and to the reference.
    pub fn add(&mut self, module: &mut Module, host: &Rc<Host>, functions: Vec<Function>) {
        for function in functions {
            let function = Rc::new(function);
            register(module, host, &function);
            self.functions.push(function);
        }
    }
}

fn register(module: &mut Module, host: &Rc<Host>, function: &Rc<Function>) {
    let least = function.parameters.iter().take_while(|parameter| !parameter.is_optional()).count();
    debug_assert!(function.parameters[least..].iter().all(Parameter::is_optional), "optional parameters of {} come last", function.name);
    for count in least..=function.parameters.len() {
        let registration = match function.form {
            Form::Property(_) => FuncRegistration::new_getter(function.name),
            Form::Column(_) => FuncRegistration::new_index_getter(),
            Form::Function | Form::Method(_) => FuncRegistration::new(function.name).in_global_namespace(),
        };
        let receiver = function.form.receiver();
        let types: Vec<TypeId> = receiver
            .map(|receiver| receiver.id)
            .into_iter()
            .chain(function.parameters[..count].iter().map(|_| match function.form {
                Form::Column(_) => TypeId::of::<ImmutableString>(),
                _ => TypeId::of::<Dynamic>(),
            }))
            .collect();
        let information = receiver
            .map(|receiver| format!("{}: {}", receiver.name.to_lowercase(), receiver.name))
            .into_iter()
            .chain(function.parameters[..count].iter().map(|parameter| format!("{}: {}", parameter.name, parameter.kind.word())))
            .chain([if function.returns.is_empty() { "()".to_string() } else { function.returns.to_string() }]);
        let (host, function) = (host.clone(), function.clone());
        let comment = format!("/// {}\n///\n/// ```\n/// {}\n/// ```", function.summary, function.example.replace('\n', "\n/// "));
        registration.with_params_info(information).with_comments([comment]).set_into_module_raw(
            module,
            types,
            RhaiFunc::Pure {
                func: Rc::new(move |context: Option<NativeCallContext>, values: &mut [&mut Dynamic]| {
                    let context = context.ok_or_else(|| Failure::script("the function was called without a context"))?;
                    let values: Vec<Dynamic> = values.iter_mut().map(|value| value.flatten_clone()).collect();
                    let call = Call::new(&context, &function, values, &host);
                    call.check()?;
                    (function.body)(&call)
                }),
                has_context: true,
                is_pure: true,
                is_volatile: true,
            },
        );
    }
}
