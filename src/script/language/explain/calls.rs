//! Calls without a matching function: an unknown name, a wrong number of arguments, values that an operator does not accept.

use std::rc::Rc;

use super::context::{Explainer, Signature};
use super::phrases::{count_of, distinct, is_string, split_signature, type_phrase};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::failure::Class;
use crate::script::language::function::{Form, Function};
use crate::script::language::habits;
use crate::script::language::handle::Types;
use crate::script::language::parameter::Kind;
use crate::script::language::registry::Registry;
use crate::script::language::sources::SourceSpan;
use crate::script::language::wording::{did_you_mean, joined, listed, with_article};

/// Returns a corrected call if the called name is a variable of the script.
fn call_of_variable(name: &str, place: &SourceSpan) -> Option<String> {
    let text: &str = &place.text;
    let is_word = |letter: char| letter.is_alphanumeric() || letter == '_';
    let is_bound = |(at, _): (usize, &str)| {
        let (before, after) = (&text[..at], &text[at + name.len()..]);
        let is_whole = !before.ends_with(is_word) && !after.starts_with(is_word);
        let (before, after) = (before.trim_end(), after.trim_start());
        let is_declared = ["let", "const", "for"].iter().any(|word| before.ends_with(word));
        let is_parameter = before.ends_with(['|', ',', '(']) && after.starts_with([',', '|', ')']);
        is_whole && (is_declared || is_parameter)
    };
    let called = text.get(place.range.start..)?.strip_prefix(name)?.trim_start().strip_prefix('(')?;
    let mut open = 1;
    let end = called.find(|letter| {
        open += i32::from(letter == '(') - i32::from(letter == ')');
        open == 0
    });
    let arguments = end.map_or("…", |end| &called[..end]);
    let arguments = if arguments.len() > LONG || arguments.contains('\n') { "…" } else { arguments };
    text.match_indices(name).any(is_bound).then(|| format!("{name}.call({arguments})"))
}

/// Number of bytes of arguments above which a hint does not repeat the arguments.
const LONG: usize = 40;

impl Explainer<'_> {
    /// Message on a call whose name and argument types match no function.
    pub(super) fn unknown_function(&self, signature: &str, source: &str, place: Option<&SourceSpan>) -> Diagnostic {
        let (name, given) = split_signature(signature);
        if !name.chars().next().is_some_and(|first| first.is_alphabetic() || first == '_') {
            return self.unknown_operator(name, &given);
        }
        let name = name.rsplit("::").next().unwrap_or(name);
        if name.starts_with("anon$") {
            return wrong_closure(given.len());
        }
        let after_dot = place.is_some_and(|place| place.text[..place.range.start].trim_end().ends_with('.'));
        let known: Vec<_> = Registry::of(self.host).named(name).cloned().collect();
        let defined = self.defined_functions(source);
        let own: Vec<&Signature> = defined.iter().filter(|(function, _)| function == name).collect();
        // A function of the script hides a property of the same name, except in a call on an object.
        if !own.is_empty() && (known.is_empty() || !after_dot) {
            return wrong_own_call(name, given.len(), &own);
        }
        if !known.is_empty() {
            return self.wrong_call(name, &given, &known, after_dot);
        }
        let mut builtin = self.builtin_functions();
        // Functions for number types that scripts do not have are not suggested.
        builtin.retain(|(_, types)| !types.iter().any(|name| FOREIGN_NUMBERS.contains(&name.as_str())));
        let same: Vec<&Signature> = builtin.iter().filter(|(function, _)| function == name).collect();
        if !same.is_empty() {
            return self.wrong_builtin_call(name, &given, &same);
        }
        if let Some(call) = place.filter(|_| !after_dot).and_then(|place| call_of_variable(name, place)) {
            let title = format!("`{name}` is a variable, and no function of that name is defined");
            return Diagnostic::error(Class::Script, title).hint(format!("a function in a variable is called by `call`: `{call}`"));
        }
        let others: Vec<&str> = defined.iter().chain(&builtin).map(|(name, _)| name.as_str()).collect();
        self.nothing_of_that_name(name, &given, &others, after_dot)
    }

    /// Returns the message of a call of an unknown name; `others` are the functions of the script and of the engine.
    fn nothing_of_that_name(&self, name: &str, given: &[String], others: &[&str], after_dot: bool) -> Diagnostic {
        let script = |title: String| Diagnostic::error(Class::Script, title);
        let registry = Registry::of(self.host);
        let given_words: Vec<String> = given.iter().map(|name| type_phrase(name)).collect();
        let object = given.first().filter(|_| after_dot);
        let title = match object {
            Some(type_name) => format!("{} has no function `{name}`", type_phrase(type_name)),
            None => format!("there is no function `{name}`"),
        };
        let of_language = object.filter(|type_name| registry.types().contains(type_name));
        let candidates: Vec<&str> = match of_language {
            Some(type_name) => registry
                .members(type_name)
                .filter(|function| !matches!(function.form, Form::Column(_)))
                .map(|function| function.name)
                .collect(),
            None => registry
                .functions()
                .iter()
                .filter(|function| object.is_some() || function.form.receiver().is_none())
                .map(|function| function.name)
                .chain(others.iter().copied())
                .collect(),
        };
        let diagnostic = match of_language {
            Some(_) => script(title).cause(format!("it has {}", listed(&distinct(&candidates), "and"))),
            None if given.is_empty() => script(title),
            None => script(title).cause(format!("it was called with {}", joined(&given_words, "and"))),
        };
        let habit = habits::instead_of_call(name).map(String::from);
        match habit.or_else(|| did_you_mean(name, candidates.iter().copied())) {
            Some(suggestion) => diagnostic.hint(suggestion),
            None => diagnostic.hint("functions are defined with `fn name(parameters) { … }`"),
        }
    }

    /// A call of a function of the language on the wrong object, or with the wrong number of arguments.
    fn wrong_call(&self, name: &str, given: &[String], known: &[Rc<Function>], after_dot: bool) -> Diagnostic {
        let script = |title: String| Diagnostic::error(Class::Script, title);
        let receivers: Vec<&str> = known.iter().filter_map(|function| function.form.receiver().map(|receiver| receiver.name)).collect();
        let object = given.first().map(String::as_str).unwrap_or("");
        let fitting: Vec<&Rc<Function>> =
            known.iter().filter(|function| function.form.receiver().is_none_or(|receiver| receiver.name == object)).collect();
        if fitting.is_empty() {
            let phrases: Vec<String> = receivers.iter().map(|receiver| with_article(receiver)).collect();
            let diagnostic = match given.first() {
                Some(object) if after_dot => script(format!("{} has no function `{name}`", type_phrase(object))),
                _ => script(format!("`{name}` must be called on {}", joined(&phrases, "or"))),
            };
            let diagnostic = diagnostic.cause(format!("`{name}` belongs to {}", joined(&phrases, "and")));
            let signatures: Vec<String> = known.iter().map(|function| function.signature()).collect();
            return diagnostic.hint(format!("write {}", listed(&signatures, "or")));
        }
        let function = fitting[0];
        if matches!(function.form, Form::Property(_)) {
            return script(format!("`{name}` is a property, not a function")).hint("leave out the parentheses");
        }
        // The object of a method is written once, in front of a dot or as the first argument.
        let object = usize::from(function.form.receiver().is_some());
        let (counted, more) = if after_dot { (given.len() - object, 0) } else { (given.len(), object) };
        let least = more + function.parameters.iter().filter(|parameter| !parameter.is_optional()).count();
        let most = more + function.parameters.len();
        let wanted = if least == most {
            count_of(most, "argument", "arguments")
        } else {
            format!("{least} to {}", count_of(most, "argument", "arguments"))
        };
        let error = script(format!("`{name}` takes {wanted}, not {counted}")).cause(format!("`{name}`: {}", function.summary));
        match function.parameters.as_slice() {
            [only] if only.kind == Kind::Vector && (2..=3).contains(&counted) => {
                let vector = if counted == 2 { "[x, y]" } else { "[x, y, z]" };
                error.hint(format!("a vector stands in brackets: `{name}({vector})`"))
            }
            _ if function.returns == "Integrator" && given.first().is_some_and(|first| first == "Model") => {
                error.hint(format!("integrators are options of a simulation: `simulate(model, #{{ integrator: {name}(), dt: 0.01 }})`"))
            }
            _ => error.hint(format!("write `{}`", function.signature())),
        }
    }

    /// Returns the message of a call of a function of the engine with wrong values.
    fn wrong_builtin_call(&self, name: &str, given: &[String], known: &[&Signature]) -> Diagnostic {
        let given_words: Vec<String> = given.iter().map(|name| type_phrase(name)).collect();
        let title = match given.len() {
            0 => format!("`{name}` needs arguments"),
            _ => format!("`{name}` does not work on {}", joined(&given_words, "and")),
        };
        if name == "range" {
            let error =
                Diagnostic::error(Class::Script, title).cause("it takes the first number and the one after the last, and maybe a step");
            return error.hint("write `0..3`, as in `for i in 0..3`; `linspace(0.0, 1.0, 11)` gives fractions");
        }
        let mut ways: Vec<String> = known
            .iter()
            .map(|(_, types)| {
                if types.is_empty() {
                    "no arguments".to_string()
                } else {
                    joined(&types.iter().map(|name| type_phrase(name)).collect::<Vec<_>>(), "and")
                }
            })
            .collect();
        ways.sort();
        ways.dedup();
        ways.truncate(6);
        let diagnostic = Diagnostic::error(Class::Script, title).cause(format!("it works on {}", joined(&ways, "or on")));
        let whole_for_fraction = known.iter().any(|(_, types)| {
            types.len() == given.len()
                && types.iter().zip(given).all(|(wanted, given)| wanted == given || (wanted == "f64" && given == "i64"))
        });
        if whole_for_fraction {
            return diagnostic.hint("write the whole number with a decimal point, `2.0` instead of `2`, or convert it: `x.to_float()`");
        }
        match name {
            "print" | "debug" => diagnostic.hint("`print` takes one value; join several: `` print(`x = ${x}, y = ${y}`) ``"),
            _ => diagnostic.hint("convert the arguments first"),
        }
    }

    /// Returns the message of an operator between wrong values.
    fn unknown_operator(&self, operator: &str, given: &[String]) -> Diagnostic {
        let words: Vec<String> = given.iter().map(|name| type_phrase(name)).collect();
        let diagnostic = Diagnostic::error(Class::Script, format!("`{operator}` does not work on {}", joined(&words, "and")));
        if let Some(hint) = habits::operator(operator) {
            return diagnostic.hint(hint);
        }
        if given.iter().any(|name| is_string(name)) && given.iter().any(|name| name == "i64" || name == "f64") {
            return diagnostic.hint("a string is not a number: leave out the quotes, or convert it with `parse_float(text)`");
        }
        let types = self.host.slots.get::<Types>();
        if let Some(hint) = given.iter().find_map(|name| types.instead_of_operator(name)) {
            return diagnostic.hint(hint);
        }
        if given.iter().any(|name| name == "array") {
            return diagnostic
                .hint("arrays of numbers take `+ - * / % **`, with arrays of the same length and with numbers, entry by entry");
        }
        if given.iter().any(|name| name == "()") {
            return diagnostic.hint("one of the two has no value: a function without a result, or a variable that was never set");
        }
        diagnostic.hint("convert one of the two")
    }
}

/// Returns the message of a closure that is called with a wrong number of values.
fn wrong_closure(count: usize) -> Diagnostic {
    let parameters = ["x", "y", "z"].into_iter().take(count).collect::<Vec<_>>().join(", ");
    Diagnostic::error(Class::Script, "the closure has the wrong number of parameters")
        .cause(format!("it is called with {}", count_of(count, "value", "values")))
        .hint(format!("write `|{parameters}| …`"))
}

/// Message on a call of a script function with other parameters.
fn wrong_own_call(name: &str, count: usize, own: &[&Signature]) -> Diagnostic {
    let ways: Vec<String> = own.iter().map(|(function, parameters)| format!("`{function}({})`", parameters.join(", "))).collect();
    Diagnostic::error(Class::Script, format!("`{name}` does not take {}", count_of(count, "argument", "arguments")))
        .cause(format!("it is defined as {}", joined(&ways, "and")))
        .hint("give as many arguments as it has parameters")
}

/// Number types with functions in the engine that scripts do not have.
const FOREIGN_NUMBERS: [&str; 12] = ["f32", "i8", "i16", "i32", "i128", "u8", "u16", "u32", "u64", "u128", "isize", "usize"];
