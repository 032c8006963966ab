//! The engine's own errors while a script runs.

use rhai::EvalAltResult;

use super::context::Explainer;
use super::phrases::{arithmetic_hint, count_of, lower, size_limit, size_subject, type_hint, type_phrase};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::failure::Class;
use crate::script::language::limits::MAX_CALL_LEVELS;
use crate::script::language::sources::SourceSpan;

impl Explainer<'_> {
    /// Message on a run-time error of the engine.
    pub(super) fn reword(&self, error: &EvalAltResult, source: &str, place: Option<&SourceSpan>) -> Diagnostic {
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
            // Arrays have entries; a column object only returns single cells.
            ErrorIndexingType(name, _) if name.split(' ').next().map(type_phrase).as_deref() == Some("an array") => {
                script("a column of a history cannot be changed where it stands".into())
                    .hint("change a copy: `let column = sim.history.total; column[0] = 1.0;`")
            }
            ErrorIndexingType(name, _) => {
                script(format!("{} has no entries to index", type_phrase(name.split(' ').next().unwrap_or(name))))
                    .hint("arrays are indexed by numbers, maps by strings")
            }
            ErrorArrayBounds(count, index, _) => script(format!("the array has no entry {index}"))
                .cause(match *count {
                    0 => "it is empty; columns of a history have no entries before the first step".into(),
                    count => format!("it has {}, counted from 0", count_of(count, "entry", "entries")),
                })
                .hint(match place {
                    Some(place) if *count <= 1 && is_of_history(place) => {
                        "no step has been taken: `run_to`, `step` and `settle` add entries to a history"
                    }
                    _ => "negative numbers count from the end: `array[-1]` is the last",
                }),
            ErrorStringBounds(count, index, _) => script(format!("the string has no character {index}"))
                .cause(format!("it has {}", count_of(*count, "character", "characters"))),
            ErrorBitFieldBounds(count, index, _) => script(format!("there is no bit {index}")).cause(format!("there are {count} bits")),
            ErrorFor(_) => {
                script("this cannot be looped over".into()).hint("loop over an array, a map's `keys()`, or a range such as `0..10`")
            }
            ErrorDataRace(what, _) => object_in_use(what),
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
                .cause(format!("at most {} calls may be open at a time", MAX_CALL_LEVELS))
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
}

/// True if the indexed expression at a place is a column of a history.
fn is_of_history(place: &SourceSpan) -> bool {
    let before = place.text.get(..place.range.start).unwrap_or("").trim_end_matches('[');
    before.rsplit(|letter: char| !(letter.is_alphanumeric() || letter == '_' || letter == '.')).next().unwrap_or("").contains(".history")
}

/// Returns the message of a closure that uses the object of the method to which it was given.
fn object_in_use(what: &str) -> Diagnostic {
    let function = what.split('\'').nth(1).unwrap_or("");
    let title = if function.is_empty() {
        "a closure uses the object that it is given to".into()
    } else {
        format!("the closure given to `{function}` uses the object that `{function}` is called on")
    };
    Diagnostic::error(Class::Script, title)
        .cause("the object is in use while its method runs, so the closure cannot hold it")
        .hint("use the closure's parameter, such as `sim.on_step(|s| print(s.time))`, or a second name: `let other = object;`")
}
