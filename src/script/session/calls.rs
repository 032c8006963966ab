//! Calls of single functions by a program in another language, with the checks and messages of scripts.
//!
//! A call is a short text such as `a0.add_body(a1, a2)`, compiled once for each function and number of values; the values are the variables
//! of its scope. Operators, checks and messages are thus those of the engine, and functions need no second description.

use std::cell::RefCell;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::rc::Rc;

use rhai::{AST, Dynamic, EvalAltResult, Scope};

use super::compile::compile;
use super::reference::Reference;
use super::session::{Report, Session};
use super::shown::shown;
use crate::script::language::diagnostics::{Diagnostic, defect};
use crate::script::language::explain::explain;
use crate::script::language::failure::interrupted;
use crate::script::language::function::{Form, Function};
use crate::script::language::observer::Observer;
use crate::script::language::registry::Registry;
use crate::script::language::settings::Settings;

/// First letters of the source names of calls.
const CALL: &str = "call ";

/// Functions of a session for a program without a script.
pub struct Calls {
    pub(super) session: RefCell<Session>,
    pub(super) registry: Rc<Registry>,
    /// Compiled calls by the number of the function in the registry and the number of values.
    prepared: RefCell<HashMap<(usize, usize), Rc<Prepared>>>,
}

/// A compiled call.
struct Prepared {
    source: String,
    tree: AST,
    variables: Vec<String>,
}

impl Calls {
    /// A session for files below a folder.
    ///
    /// # Errors
    /// A folder that does not exist.
    pub fn new(settings: Settings, home: &Path, observer: Rc<dyn Observer>) -> Result<Self, Box<Diagnostic>> {
        let session = Session::new(settings, home, observer)?;
        session.host.main.replace("call".into());
        let registry = session.registry();
        Ok(Calls { session: RefCell::new(session), registry, prepared: RefCell::default() })
    }

    /// Functions of the language; calls use their index in this list.
    pub fn functions(&self) -> &[Rc<Function>] {
        self.registry.functions()
    }

    /// The reference of the functions as JSON.
    pub fn reference(&self) -> String {
        Reference::new(&self.registry).json()
    }

    /// Name of the type of an object; `None` for numbers, texts, arrays, maps and closures.
    pub fn type_name(&self, value: &Dynamic) -> Option<&'static str> {
        self.registry.types().name_of(value)
    }

    /// Names of the types of objects.
    pub fn type_names(&self) -> &[&'static str] {
        self.registry.types().names()
    }

    /// True for a message about a text of the user, false for one about the text of a call.
    pub fn is_in_text(error: &Diagnostic) -> bool {
        error.place.as_ref().is_some_and(|place| !place.source.starts_with(CALL))
    }

    /// Returns a value as shown at the prompt.
    pub fn shown(&self, value: &Dynamic) -> String {
        shown(&self.registry, value, None)
    }

    /// Returns a value as shown by `print`.
    pub fn printed(&self, value: &Dynamic) -> String {
        self.registry.types().print(value).unwrap_or_else(|| value.to_string())
    }

    /// Calls a function by its place in [`Self::functions`]; the object of a method is the first value.
    ///
    /// # Errors
    /// The message with which a script would end.
    pub fn call(&self, function: usize, values: Vec<Dynamic>) -> Result<Dynamic, Box<Diagnostic>> {
        match catch_unwind(AssertUnwindSafe(|| self.evaluate(function, values))) {
            Ok(outcome) => outcome,
            Err(panic) => Err(defect(&*panic)),
        }
    }

    fn evaluate(&self, function: usize, values: Vec<Dynamic>) -> Result<Dynamic, Box<Diagnostic>> {
        let (engine, host) = {
            let session = self.session.borrow();
            (session.engine.clone(), session.host.clone())
        };
        let engine = engine.borrow();
        let prepared = self.prepared(function, values.len())?;
        let mut scope = Scope::with_capacity(values.len());
        for (variable, value) in prepared.variables.iter().zip(values) {
            scope.push_dynamic(variable.as_str(), value);
        }
        let outcome = engine.eval_ast_with_scope::<Dynamic>(&mut scope, &prepared.tree);
        outcome.map(Dynamic::flatten).map_err(|error| Box::new(explain(&host, &engine, &error, &prepared.source)))
    }

    fn prepared(&self, function: usize, count: usize) -> Result<Rc<Prepared>, Box<Diagnostic>> {
        if let Some(known) = self.prepared.borrow().get(&(function, count)) {
            return Ok(known.clone());
        }
        let session = self.session.borrow();
        let description = &self.registry.functions()[function];
        let variables: Vec<String> = (0..count).map(|index| format!("a{index}")).collect();
        let text = text_of(description, &variables);
        let source = format!("{CALL}{function} of {count}");
        let mut scope = Scope::new();
        for variable in &variables {
            scope.push(variable.as_str(), ());
        }
        session.host.sources.insert(&source, &text);
        let engine = session.engine.borrow();
        let tree = compile(&engine, &scope, &source, &text);
        let tree = tree.map_err(|error| Box::new(explain(&session.host, &engine, &error, &source)))?;
        let prepared = Rc::new(Prepared { source, tree, variables });
        self.prepared.borrow_mut().insert((function, count), prepared.clone());
        Ok(prepared)
    }

    /// Error with which a native function called by the engine passes on an interrupt.
    pub fn interrupted() -> Box<EvalAltResult> {
        interrupted("interrupted").into()
    }

    /// Ends the session like a run: warnings, and the files of its folder, if there is one.
    pub fn finish(&self, error: Option<Box<Diagnostic>>) -> Report {
        let finished = catch_unwind(AssertUnwindSafe(|| self.session.borrow_mut().finish(error)));
        finished.unwrap_or_else(|panic| Report::failed(*defect(&*panic)))
    }
}

/// The text of a call with these variables.
fn text_of(function: &Function, variables: &[String]) -> String {
    let (first, rest) = variables.split_first().map_or(("", variables), |(first, rest)| (first.as_str(), rest));
    match function.form {
        Form::Function => format!("{}({})", function.name, variables.join(", ")),
        Form::Method(_) => format!("{first}.{}({})", function.name, rest.join(", ")),
        Form::Property(_) => format!("{first}.{}", function.name),
        Form::Column(_) => format!("{first}[{}]", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::language::observer::Silent;

    fn calls() -> Calls {
        Calls::new(Settings::default(), Path::new("."), Rc::new(Silent)).unwrap()
    }

    fn place(calls: &Calls, name: &str) -> usize {
        calls.functions().iter().position(|function| function.name == name).unwrap()
    }

    #[test]
    fn functions_methods_and_properties_are_called_with_values() {
        let calls = calls();
        let options: rhai::Map = [
            ("size".into(), vec![Dynamic::from(2.0), Dynamic::from(1.0)].into()),
            ("cells".into(), { vec![Dynamic::from(4_i64), Dynamic::from(2_i64)].into() }),
        ]
        .into();
        let mesh = calls.call(place(&calls, "rectangle"), vec![options.into()]).unwrap();
        assert_eq!(calls.type_name(&mesh), Some("Mesh"));
        let fine = calls.call(place(&calls, "refine"), vec![mesh, 1_i64.into()]).unwrap();
        assert_eq!(calls.call(place(&calls, "cells"), vec![fine]).unwrap().as_int(), Ok(32));
    }

    #[test]
    fn a_wrong_call_gives_the_message_of_a_script() {
        let calls = calls();
        let error = calls.call(place(&calls, "rectangle"), vec![rhai::Map::new().into()]).unwrap_err();
        let in_script = Session::new(Settings::default(), Path::new("."), Rc::new(Silent)).unwrap().evaluate("a", "rectangle(#{})");
        let in_script = in_script.unwrap_err();
        assert_eq!((error.code, error.title, error.hints), (in_script.code, in_script.title, in_script.hints));
    }
}
