//! Turns the engine's errors into messages in the words of the language.
//!
//! Walks the chain of calls to the innermost error, which has the message; the calls around it become the frames. Failures of our own
//! functions bring everything with them; the engine's own errors are reworded here, with the names that may have been meant.

use rhai::{Engine, EvalAltResult, LexError, ParseErrorType, Position};

use super::diagnostics::{Diagnostic, Frame};
use super::failure::{Class, Failure, did_you_mean, joined, listed};
use super::habits;
use super::host::Host;
use super::meshes::MeshHandle;
use super::models::BodyHandle;
use super::registry::{Form, Function, Handle, with_article};
use super::scan::{self, Target};
use super::sources::Place;

/// The message of an error that a script of the given source ended with.
pub fn explain(host: &Host, engine: &Engine, error: &EvalAltResult, source: &str) -> Diagnostic {
    let mut frames = Vec::new();
    let mut diagnostic = Explainer { host, engine }.walk(error, source, &mut frames);
    frames.reverse();
    let relocate = |place: &mut Option<Place>| *place = place.take().map(|place| host.sources.relocate(place));
    frames.iter_mut().for_each(|frame| relocate(&mut frame.place));
    relocate(&mut diagnostic.place);
    diagnostic.frames = frames;
    diagnostic
}

/// The message of a failure outside of any script, such as a script file that cannot be read.
pub fn explain_failure(failure: &Failure) -> Diagnostic {
    Diagnostic {
        place: failure.origin.clone(),
        causes: failure.causes.clone(),
        hints: failure.hints.clone(),
        ..Diagnostic::error(failure.class, failure.title.clone())
    }
}

struct Explainer<'a> {
    host: &'a Host,
    engine: &'a Engine,
}

impl Explainer<'_> {
    fn place(&self, source: &str, position: Position) -> Option<Place> {
        self.host.place(self.engine, source, position, &Target::Call, false)
    }

    fn walk(&self, error: &EvalAltResult, source: &str, frames: &mut Vec<Frame>) -> Diagnostic {
        use EvalAltResult::{ErrorInFunctionCall, ErrorInModule, ErrorRuntime, ErrorTerminated};
        match error {
            ErrorInFunctionCall(name, inner_source, inner, position) => {
                let place = self.place(source, *position);
                frames.push(Frame { title: call_title(name, place.as_ref()), place });
                self.walk(inner, if inner_source.is_empty() { source } else { inner_source }, frames)
            }
            ErrorInModule(path, inner, position) => {
                let inner_source = format!("{path}.rhai");
                if matches!(**inner, EvalAltResult::ErrorModuleNotFound(..)) {
                    return self.walk(inner, source, frames);
                }
                frames.push(Frame { title: "in the module imported here".into(), place: self.place(source, *position) });
                self.walk(inner, &inner_source, frames)
            }
            ErrorRuntime(value, position) | ErrorTerminated(value, position) if value.is::<Failure>() => {
                let failure = value.clone_cast::<Failure>();
                let place = failure.origin.clone();
                let place = place.or_else(|| self.host.place(self.engine, source, *position, &failure.target, failure.method));
                if let Some(inner) = &failure.inner {
                    frames.push(Frame { title: failure.title.clone(), place });
                    return self.walk(&inner.error, &inner.source, frames);
                }
                Diagnostic { place, label: failure.label.clone(), ..explain_failure(&failure) }
            }
            other => {
                let place = self.place(source, other.position());
                let diagnostic = self.reword(other, source, place.as_ref());
                let place = self.better_place(other, source, place.as_ref()).or(place);
                Diagnostic { place, ..diagnostic }
            }
        }
    }

    /// A place that says more than the one the engine gives.
    fn better_place(&self, error: &EvalAltResult, source: &str, place: Option<&Place>) -> Option<Place> {
        let main = self.host.main.borrow().clone();
        let source = if source.is_empty() { main.as_str() } else { source };
        let text = self.host.sources.text(source)?;
        let lexemes = scan::lexemes(self.engine, &text);
        let range = match error {
            EvalAltResult::ErrorParsing(ParseErrorType::MissingToken(token, _), _) if token == ";" => {
                scan::end_before(&lexemes, place?.range.start)?
            }
            EvalAltResult::ErrorDataRace(what, position) if position.is_none() => scan::self_use(&lexemes, what.split('\'').nth(1)?)?,
            _ => return None,
        };
        Some(Place { source: source.to_string(), text, range })
    }

    fn reword(&self, error: &EvalAltResult, source: &str, place: Option<&Place>) -> Diagnostic {
        use EvalAltResult::*;
        let script = |title: String| Diagnostic::error(Class::Script, title);
        match error {
            ErrorParsing(kind, _) => self.reword_syntax(kind, source, place),
            ErrorVariableNotFound(name, _) | ErrorForbiddenVariable(name, _) => self.unknown_variable(name, source, place),
            ErrorVariableExists(name, _) => script(format!("there already is a variable `{name}`")).hint("choose another name"),
            ErrorPropertyNotFound(name, _) => script(format!("the map has no entry `{name}`"))
                .hint("`print` the map to see its entries; `map.contains(\"name\")` asks for one"),
            ErrorIndexNotFound(index, _) => script(format!("there is no entry `{index}`")).hint("`print` the object to see its entries"),
            ErrorFunctionNotFound(signature, _) => self.unknown_function(signature, source, place),
            ErrorModuleNotFound(path, _) => script(format!("there is no module `{path}`"))
                .cause("a module is used under the name that `import \"path\" as name` gives it")
                .hint("import it before its first use"),
            ErrorUnboundThis(_) => script("`this` means nothing here".into())
                .cause("`this` is the object of a function that is called like a method")
                .hint("pass the object as a parameter"),
            ErrorMismatchDataType(expected, given, _) => {
                script(format!("this must be {}, not {}", type_phrase(expected), type_phrase(given))).hint(type_hint(expected, given))
            }
            ErrorMismatchOutputType(expected, given, _) => {
                script(format!("the result must be {}, not {}", type_phrase(expected), type_phrase(given)))
                    .hint("let the last expression be the result")
            }
            ErrorIndexingType(name, _) => {
                script(format!("{} has no entries to index", type_phrase(name.split(' ').next().unwrap_or(name))))
                    .hint("arrays are indexed by numbers, maps by strings")
            }
            ErrorArrayBounds(count, index, _) => script(format!("the array has no entry {index}"))
                .cause(format!("it has {}, counted from 0", count_of(*count, "entry", "entries")))
                .hint("negative numbers count from the end: `array[-1]` is the last"),
            ErrorStringBounds(count, index, _) => script(format!("the string has no character {index}"))
                .cause(format!("it has {}", count_of(*count, "character", "characters"))),
            ErrorBitFieldBounds(count, index, _) => script(format!("there is no bit {index}")).cause(format!("there are {count} bits")),
            ErrorFor(_) => {
                script("this cannot be looped over".into()).hint("loop over an array, a map's `keys()`, or a range such as `0..10`")
            }
            ErrorDataRace(what, _) => {
                let function = what.split('\'').nth(1).unwrap_or("");
                let title = if function.is_empty() {
                    "a closure uses the object that it is given to".into()
                } else {
                    format!("the closure given to `{function}` uses the object that `{function}` is called on")
                };
                script(title)
                    .cause("the object is in use while its method runs, so the closure cannot hold it")
                    .hint("use the closure's parameter, such as `sim.on_step(|s| print(s.time))`, or a second name: `let other = object;`")
            }
            ErrorNonPureMethodCallOnConstant(name, _) => {
                script(format!("`{name}` changes its object, but this one is a constant")).hint("declare it with `let` instead of `const`")
            }
            ErrorAssignmentToConstant(name, _) => script(format!("`{name}` is a constant and cannot be assigned to"))
                .hint("declare it with `let` instead of `const`, or choose another name"),
            ErrorDotExpr(text, _) => self.unknown_property(text),
            ErrorArithmetic(text, _) => script(lower(text)).hint(arithmetic_hint(text)),
            ErrorTooManyOperations(_) => script("the script does not come to an end".into())
                .cause(format!("it was stopped after {} operations", self.host.settings.max_operations))
                .hint("look for a loop that never ends; `--max-operations` raises the limit"),
            ErrorTooManyVariables(_) => script("the script has too many variables".into()).hint("keep many values in an array or a map"),
            ErrorTooManyModules(_) => script("the script imports too many modules".into()).hint("import each module once"),
            ErrorStackOverflow(_) => script("functions call each other too deeply".into())
                .cause(format!("at most {} calls may be open at a time", super::MAX_CALL_LEVELS))
                .hint("look for a function that calls itself without end, or use a loop"),
            ErrorDataTooLarge(what, _) => script(format!("{} becomes too large", size_subject(what)))
                .cause(size_limit(what))
                .hint("keep fewer values, or work on them step by step"),
            ErrorTerminated(..) => Diagnostic::error(Class::Interrupted, "interrupted"),
            ErrorRuntime(value, _) if value.is_unit() => script("the script threw an error".into()),
            ErrorRuntime(value, _) => script(value.to_string()),
            ErrorSystem(text, inner) => script(if text.is_empty() { lower(&inner.to_string()) } else { lower(text) }),
            ErrorCustomSyntax(text, ..) => script(lower(text)),
            LoopBreak(is_break, ..) => {
                script(format!("`{}` is not inside a loop", if *is_break { "break" } else { "continue" })).hint("remove it")
            }
            other => script(lower(&other.to_string())),
        }
    }

    fn reword_syntax(&self, kind: &ParseErrorType, source: &str, place: Option<&Place>) -> Diagnostic {
        let word = place.map_or("", |place| &place.text[place.range.clone()]);
        let script = |title: String| Diagnostic::error(Class::Script, title);
        match kind {
            ParseErrorType::UnexpectedEOF => {
                script("the script ends in the middle of something".into()).hint("close the open bracket, string or block")
            }
            ParseErrorType::BadInput(LexError::UnterminatedString) => {
                script("the string has no end".into()).hint("close it with `\"` in the same line")
            }
            ParseErrorType::BadInput(LexError::UnexpectedInput(text)) if text == "fn" => {
                script("`fn` means nothing here".into()).hint("write a closure as `|x| …`; `fn name(x) { … }` stands by itself")
            }
            ParseErrorType::BadInput(LexError::UnexpectedInput(text)) => {
                script(format!("`{text}` means nothing here")).hint("remove it; strings stand in double quotes")
            }
            ParseErrorType::BadInput(LexError::MalformedChar(text)) => {
                script(format!("'{text}' is not a single character")).hint("write strings in double quotes")
            }
            ParseErrorType::BadInput(LexError::MalformedNumber(text)) => {
                script(format!("`{text}` is not a number")).hint("write numbers such as `12`, `0.5` or `1e-3`")
            }
            ParseErrorType::BadInput(LexError::ImproperSymbol(text, _)) if habits::operator(text).is_some() => {
                script(format!("there is no operator `{text}`")).hint(habits::operator(text).unwrap_or_default())
            }
            ParseErrorType::BadInput(error) if error.to_string().contains("typo of '=='") => {
                script("`=` gives a variable a value; it does not compare".into()).hint("write `==`")
            }
            ParseErrorType::BadInput(error) => script(lower(&error.to_string())),
            ParseErrorType::UnknownOperator(text) => {
                let error = script(format!("there is no operator `{text}`"));
                error.hint(habits::operator(text).unwrap_or("the operators are `+ - * / % **`, comparisons, `&&`, `||` and `!`"))
            }
            ParseErrorType::MissingToken(token, purpose) => {
                let hint = habits::instead_of(word).map(String::from).unwrap_or_else(|| missing_hint(token));
                script(format!("`{token}` is missing {}", lower(purpose))).hint(hint)
            }
            ParseErrorType::VariableExpected | ParseErrorType::PropertyExpected | ParseErrorType::FnMissingName
                if word.chars().all(char::is_alphabetic) && !word.is_empty() =>
            {
                script(format!("`{word}` is a word of the language and cannot be a name")).hint("choose another name")
            }
            ParseErrorType::Reserved(word) => {
                script(format!("`{word}` is a reserved word")).hint(habits::instead_of(word).unwrap_or("choose another name"))
            }
            ParseErrorType::VariableUndefined(name) => self.unknown_variable(name, source, place),
            ParseErrorType::ModuleUndefined(name) => {
                script(format!("there is no module `{name}`")).hint(format!("import it first: `import \"path\" as {name};`"))
            }
            ParseErrorType::DuplicatedProperty(name) => script(format!("the map has two entries `{name}`")).hint("remove one of them"),
            ParseErrorType::DuplicatedVariable(name) => script(format!("the name `{name}` is there twice")).hint("choose another name"),
            ParseErrorType::AssignmentToConstant(name) => {
                script(format!("`{name}` is a constant and cannot be assigned to")).hint("declare it with `let` instead of `const`")
            }
            ParseErrorType::MismatchedType(expected, given) => {
                script(format!("this must be {}, not {}", type_phrase(expected), type_phrase(given))).hint(type_hint(expected, given))
            }
            ParseErrorType::FnDuplicatedDefinition(name, count) => {
                script(format!("there are two functions `{name}` with {}", count_of(*count, "parameter", "parameters")))
                    .hint("rename one of them")
            }
            ParseErrorType::WrongDocComment => {
                script("a `///` comment must stand in front of a function".into()).hint("write `//` for other comments")
            }
            ParseErrorType::WrongFnDefinition => script("a function cannot be defined inside a block or another function".into())
                .hint("move it to the top level, or use a closure: `let f = |x| …;`"),
            ParseErrorType::ExprTooDeep => script("the expression is nested too deeply".into()).hint("split it with `let`"),
            ParseErrorType::LoopBreak => script("`break` is not inside a loop".into()).hint("remove it"),
            ParseErrorType::LiteralTooLarge(what, limit) => {
                script(format!("{} is too large", lower(what))).cause(format!("the limit is {limit}"))
            }
            other => script(lower(&other.to_string())),
        }
    }

    fn unknown_variable(&self, name: &str, source: &str, place: Option<&Place>) -> Diagnostic {
        let mut diagnostic = Diagnostic::error(Class::Script, format!("there is no variable `{name}`"));
        let declared = self.lexemes(source).map(|lexemes| scan::declared(&lexemes)).unwrap_or_default();
        let registry = self.host.registry.borrow();
        let meant = place.and_then(|place| habits::meant(&place.text[..place.range.start], name, &place.text[place.range.end..]));
        // Names of one letter are all alike.
        let near = did_you_mean(name, declared.iter().map(String::as_str)).filter(|_| name.chars().count() > 1);
        if let Some(hint) = meant {
            diagnostic = diagnostic.hint(hint);
        } else if let Some(hint) = habits::instead_of(name) {
            diagnostic = diagnostic.hint(hint);
        } else if let Some(suggestion) = near {
            diagnostic = diagnostic.hint(suggestion);
        } else if self.lexemes(source).is_some_and(|lexemes| scan::has_variable(&lexemes, name)) {
            diagnostic = diagnostic
                .cause("a function sees its parameters and constants of its own, not the variables around it")
                .hint(format!("pass `{name}` as a parameter"));
        } else if registry.named(name).next().is_some() {
            diagnostic = diagnostic.cause(format!("`{name}` is a function")).hint(format!("call it: `{name}(…)`"));
        } else {
            diagnostic = diagnostic.hint(format!("declare it first: `let {name} = …;`"));
        }
        diagnostic
    }

    fn lexemes(&self, source: &str) -> Option<Vec<scan::Lexeme>> {
        let source = if source.is_empty() { self.host.main.borrow().clone() } else { source.to_string() };
        self.host.sources.text(&source).map(|text| scan::lexemes(self.engine, &text))
    }

    fn unknown_property(&self, text: &str) -> Diagnostic {
        let mut words = text.split('\'').skip(1).step_by(2);
        let (Some(name), Some(type_name)) = (words.next(), words.next()) else {
            return Diagnostic::error(Class::Script, lower(text));
        };
        let registry = self.host.registry.borrow();
        if text.contains("setter") {
            let title = format!("`{name}` of {} cannot be assigned to", type_phrase(type_name));
            return Diagnostic::error(Class::Script, title).hint("give the value when the object is made");
        }
        let members: Vec<&str> = registry
            .members(type_name)
            .filter(|function| !matches!(function.form, Form::Column(_)))
            .map(|function| function.name)
            .collect();
        let diagnostic = Diagnostic::error(Class::Script, format!("{} has no property `{name}`", type_phrase(type_name)));
        if members.contains(&name) {
            return diagnostic.cause(format!("`{name}` is a function")).hint(format!("call it: `.{name}(…)`"));
        }
        let diagnostic =
            if members.is_empty() { diagnostic } else { diagnostic.cause(format!("it has {}", listed(&distinct(&members), "and"))) };
        let is_function = || self.builtin_functions().iter().any(|(function, types)| function == name && types.len() == 1);
        match did_you_mean(name, members.iter().copied()) {
            Some(suggestion) => diagnostic.hint(suggestion),
            None if type_name == BodyHandle::NAME || type_name == MeshHandle::NAME => {
                diagnostic.hint(format!("write `.boundary(\"{name}\")` for a boundary of that name"))
            }
            None if members.is_empty() && is_function() => diagnostic.hint(format!("call it: `{name}(x)` or `x.{name}()`")),
            None => diagnostic,
        }
    }

    fn unknown_function(&self, signature: &str, source: &str, place: Option<&Place>) -> Diagnostic {
        let (name, given) = split_signature(signature);
        let script = |title: String| Diagnostic::error(Class::Script, title);
        if !name.chars().next().is_some_and(|first| first.is_alphabetic() || first == '_') {
            return self.unknown_operator(name, &given);
        }
        let name = name.rsplit("::").next().unwrap_or(name);
        if name.starts_with("anon$") {
            let parameters = ["x", "y", "z"].into_iter().take(given.len()).collect::<Vec<_>>().join(", ");
            return script("the closure has the wrong number of parameters".into())
                .cause(format!("it is called with {}", count_of(given.len(), "value", "values")))
                .hint(format!("write `|{parameters}| …`"));
        }
        let after_dot = place.is_some_and(|place| place.text[..place.range.start].trim_end().ends_with('.'));
        let registry = self.host.registry.borrow();
        let known: Vec<_> = registry.named(name).cloned().collect();
        let given_words: Vec<String> = given.iter().map(|name| type_phrase(name)).collect();
        let defined = self.defined_functions(source);
        let own: Vec<&(String, Vec<String>)> = defined.iter().filter(|(function, _)| function == name).collect();
        // A function of the script hides a property of that name, unless it is called on an object.
        if !own.is_empty() && (known.is_empty() || !after_dot) {
            let ways: Vec<String> = own.iter().map(|(function, parameters)| format!("`{function}({})`", parameters.join(", "))).collect();
            return script(format!("`{name}` does not take {}", count_of(given.len(), "argument", "arguments")))
                .cause(format!("it is defined as {}", joined(&ways, "and")))
                .hint("give as many arguments as it has parameters");
        }
        if !known.is_empty() {
            return self.wrong_call(name, &given, &known, after_dot);
        }
        let mut builtin = self.builtin_functions();
        // Numbers that no script has.
        builtin.retain(|(_, types)| !types.iter().any(|name| FOREIGN_NUMBERS.contains(&name.as_str())));
        let same: Vec<&(String, Vec<String>)> = builtin.iter().filter(|(function, _)| function == name).collect();
        if !same.is_empty() {
            return self.wrong_builtin_call(name, &given, &same);
        }
        let object = given.first().filter(|_| after_dot);
        let title = match object {
            Some(type_name) => format!("{} has no function `{name}`", type_phrase(type_name)),
            None => format!("there is no function `{name}`"),
        };
        let candidates: Vec<&str> = match object.filter(|type_name| registry.has_type(type_name)) {
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
                .chain(defined.iter().map(|(name, _)| name.as_str()))
                .chain(builtin.iter().map(|(name, _)| name.as_str()))
                .collect(),
        };
        let diagnostic = match object.filter(|type_name| registry.has_type(type_name)) {
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

    fn wrong_call(&self, name: &str, given: &[String], known: &[std::rc::Rc<Function>], after_dot: bool) -> Diagnostic {
        let script = |title: String| Diagnostic::error(Class::Script, title);
        let receivers: Vec<&str> = known.iter().filter_map(|function| function.form.receiver().map(|receiver| receiver.name)).collect();
        let object = given.first().map(String::as_str).unwrap_or("");
        let fitting: Vec<&std::rc::Rc<Function>> =
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
        let counted = given.len() - usize::from(function.form.receiver().is_some());
        let least = function.parameters.iter().filter(|parameter| !parameter.is_optional()).count();
        let most = function.parameters.len();
        let wanted = if least == most {
            count_of(most, "argument", "arguments")
        } else {
            format!("{least} to {}", count_of(most, "argument", "arguments"))
        };
        script(format!("`{name}` takes {wanted}, not {counted}"))
            .cause(format!("`{name}`: {}", function.summary))
            .hint(format!("write `{}`", function.signature()))
    }

    fn wrong_builtin_call(&self, name: &str, given: &[String], known: &[&(String, Vec<String>)]) -> Diagnostic {
        let given_words: Vec<String> = given.iter().map(|name| type_phrase(name)).collect();
        let title = match given.len() {
            0 => format!("`{name}` needs arguments"),
            _ => format!("`{name}` does not work on {}", joined(&given_words, "and")),
        };
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

    fn unknown_operator(&self, operator: &str, given: &[String]) -> Diagnostic {
        let words: Vec<String> = given.iter().map(|name| type_phrase(name)).collect();
        let diagnostic = Diagnostic::error(Class::Script, format!("`{operator}` does not work on {}", joined(&words, "and")));
        if let Some(hint) = habits::operator(operator) {
            return diagnostic.hint(hint);
        }
        if given.iter().any(|name| is_string(name)) && given.iter().any(|name| name == "i64" || name == "f64") {
            return diagnostic.hint("a string is not a number: leave out the quotes, or convert it with `parse_float(text)`");
        }
        if given.iter().any(|name| name == "TimeFunction") {
            return diagnostic.hint("write a closure instead, such as `|t| 2.0 * f(t)`");
        }
        if given.iter().any(|name| name == "array") {
            return diagnostic.hint("compute with the entries, such as `[a[0] + b[0], a[1] + b[1]]`");
        }
        if given.iter().any(|name| name == "()") {
            return diagnostic.hint("one of the two has no value: a function without a result, or a variable that was never set");
        }
        diagnostic.hint("convert one of the two")
    }

    /// Functions that a script defines: names and parameters.
    fn defined_functions(&self, source: &str) -> Vec<(String, Vec<String>)> {
        use rhai::Token::{Comma, Fn, Identifier, LeftParen, RightParen};
        let lexemes = self.lexemes(source).unwrap_or_default();
        let mut found = Vec::new();
        for (index, window) in lexemes.windows(2).enumerate() {
            if let (Fn, Identifier(name)) = (&window[0].token, &window[1].token) {
                let parameters = lexemes[index + 2..].iter().take_while(|lexeme| !matches!(lexeme.token, RightParen));
                let parameters = parameters.filter_map(|lexeme| match &lexeme.token {
                    LeftParen | Comma => None,
                    Identifier(parameter) => Some(parameter.to_string()),
                    _ => None,
                });
                found.push((name.to_string(), parameters.collect()));
            }
        }
        found
    }

    /// Functions of the engine: names and types of their parameters.
    fn builtin_functions(&self) -> Vec<(String, Vec<String>)> {
        self.engine.collect_fn_metadata(
            None,
            |function| {
                let name = function.metadata.name.to_string();
                let plain = name.chars().all(|letter| letter.is_alphanumeric() || letter == '_');
                let types =
                    function.metadata.params_info.iter().map(|parameter| parameter.split(": ").last().unwrap_or("").replace("&mut ", ""));
                plain.then(|| (name, types.map(|name| short_type(&name)).collect()))
            },
            true,
        )
    }
}

/// Types of numbers for which the engine brings functions, though scripts have whole numbers and fractions only.
const FOREIGN_NUMBERS: [&str; 12] = ["f32", "i8", "i16", "i32", "i128", "u8", "u16", "u32", "u64", "u128", "isize", "usize"];

fn distinct<'a>(names: &[&'a str]) -> Vec<&'a str> {
    let mut names = names.to_vec();
    names.sort_unstable();
    names.dedup();
    names
}

/// `ring (map, i64)` as name and types.
fn split_signature(signature: &str) -> (&str, Vec<String>) {
    let Some((name, rest)) = signature.split_once(" (") else { return (signature.trim(), Vec::new()) };
    let types = rest.strip_suffix(')').unwrap_or(rest);
    let types = if types.is_empty() { Vec::new() } else { types.split(", ").map(short_type).collect() };
    (name.trim(), types)
}

/// The engine's name of a type, shortened to one word.
fn short_type(name: &str) -> String {
    let name = name.trim();
    match name {
        "&str | ImmutableString | String" | "ImmutableString" | "&str" | "String" | "string" => "string".into(),
        "INT" | "i64" | "int" => "i64".into(),
        "FLOAT" | "f64" | "float" | "number" => "f64".into(),
        "Array" | "array" => "array".into(),
        "Map" | "map" => "map".into(),
        "FnPtr" | "Fn" => "Fn".into(),
        other => other.rsplit("::").next().unwrap_or(other).to_string(),
    }
}

fn is_string(name: &str) -> bool {
    name == "string"
}

/// A type in the words of the language, with its article.
fn type_phrase(name: &str) -> String {
    match short_type(name).as_str() {
        "string" => "a string".into(),
        "i64" => "a whole number".into(),
        "f64" => "a number with a fraction".into(),
        "bool" => "`true` or `false`".into(),
        "array" => "an array".into(),
        "map" => "a map".into(),
        "Fn" => "a closure".into(),
        "()" => "nothing, `()`".into(),
        "a boolean expression" => "`true` or `false`".into(),
        phrase if phrase.starts_with("a ") || phrase.starts_with("an ") => phrase.to_string(),
        "char" => "a character".into(),
        "Dynamic" | "?" | "_" | "any" | "T" | "" => "any value".into(),
        "Failure" => "an error".into(),
        other if other.starts_with("Range") || other.starts_with("ExclusiveRange") || other.starts_with("InclusiveRange") => {
            "a range".into()
        }
        other => with_article(other),
    }
}

fn type_hint(expected: &str, given: &str) -> &'static str {
    match (short_type(expected).as_str(), short_type(given).as_str()) {
        ("bool" | "a boolean expression", _) => "compare, such as `x > 0`: a condition is `true` or `false`",
        ("i64", "f64") => "convert it: `x.to_int()`",
        ("f64", "i64") => "write it with a decimal point, such as `2.0`",
        _ => "convert the value, or use another",
    }
}

fn missing_hint(token: &str) -> String {
    match token {
        ";" => "write `;` after it".into(),
        ")" | "]" | "}" => format!("close the bracket with `{token}`"),
        "," => "separate the entries with `,`".into(),
        _ => format!("write `{token}`"),
    }
}

fn arithmetic_hint(text: &str) -> &'static str {
    if text.contains("zero") {
        "check the divisor"
    } else if text.contains("overflow") || text.contains("Overflow") || text.contains("power") {
        "use numbers with a decimal point, such as `2.0`"
    } else {
        "check the numbers"
    }
}

fn size_subject(what: &str) -> &'static str {
    match what {
        text if text.contains("String") || text.contains("string") => "a string",
        text if text.contains("array") => "an array",
        text if text.contains("map") => "a map",
        _ => "a value",
    }
}

fn size_limit(what: &str) -> String {
    match size_subject(what) {
        "a string" => format!("strings have at most {} characters", super::MAX_STRING),
        "an array" => format!("arrays have at most {} entries", super::MAX_ARRAY),
        "a map" => format!("maps have at most {} entries", super::MAX_MAP),
        _ => "there is a limit on the size of values".into(),
    }
}

fn call_title(name: &str, place: Option<&Place>) -> String {
    if !name.starts_with("anon$") {
        return format!("in the call of `{name}`");
    }
    let word = place.map(|place| &place.text[place.range.clone()]).unwrap_or("");
    match word {
        "" | "call" => "in the closure called here".into(),
        word => format!("in the closure given to `{word}`"),
    }
}

fn count_of(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// A text of the engine in lower case and without the places that follow it.
fn lower(text: &str) -> String {
    let text = text.lines().next().unwrap_or(text);
    let text = text.split(" (line ").next().unwrap_or(text);
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect())
}
