//! Turns the engine's errors into messages in the words of the language.
//!
//! The innermost error in the chain of calls has the message; the calls around it become the frames. Failures of the program's own
//! functions are complete; errors of the engine are reworded (`runtime.rs`, `syntax.rs`), with the names that may have been meant
//! (`names.rs`, `calls.rs`).

use rhai::{Engine, EvalAltResult, ParseErrorType};

use super::diagnostics::{CallFrame, Diagnostic};
use super::failure::{Class, Failure};
use super::host::Host;
use super::sources::SourceSpan;
use crate::script::language::scan;
use context::Explainer;
use phrases::call_title;

mod calls;
mod context;
mod names;
mod phrases;
mod runtime;
mod syntax;

/// Returns the message of an error with which a script of the given source ended.
pub fn explain(host: &Host, engine: &Engine, error: &EvalAltResult, source: &str) -> Diagnostic {
    let mut frames = Vec::new();
    let mut diagnostic = Explainer { host, engine }.walk(error, source, &mut frames);
    frames.reverse();
    let relocate = |place: &mut Option<SourceSpan>| *place = place.take().map(|place| host.sources.relocate(place));
    frames.iter_mut().for_each(|frame| relocate(&mut frame.place));
    relocate(&mut diagnostic.place);
    diagnostic.frames = frames;
    diagnostic
}

/// Returns the message of a failure outside of any script, such as a script file that cannot be read.
pub fn explain_failure(failure: &Failure) -> Diagnostic {
    Diagnostic {
        place: failure.origin.clone(),
        code: failure.code.clone(),
        causes: failure.causes.clone(),
        hints: failure.hints.clone(),
        ..Diagnostic::error(failure.class, failure.title.clone())
    }
}

/// Returns the stable code of an error of the engine, by its kind.
fn code_of(error: &EvalAltResult) -> &'static str {
    use EvalAltResult::*;
    match error {
        ErrorParsing(kind, _) if !matches!(kind, ParseErrorType::VariableUndefined(_) | ParseErrorType::ModuleUndefined(_)) => "C1001",
        ErrorParsing(..)
        | ErrorVariableNotFound(..)
        | ErrorForbiddenVariable(..)
        | ErrorPropertyNotFound(..)
        | ErrorIndexNotFound(..)
        | ErrorModuleNotFound(..)
        | ErrorDotExpr(..) => "C1002",
        ErrorFunctionNotFound(..) => "C1003",
        ErrorMismatchDataType(..) | ErrorMismatchOutputType(..) | ErrorIndexingType(..) | ErrorFor(_) => "C1004",
        ErrorArrayBounds(..) | ErrorStringBounds(..) | ErrorBitFieldBounds(..) => "C1005",
        ErrorArithmetic(..) => "C1006",
        ErrorVariableExists(..)
        | ErrorUnboundThis(_)
        | ErrorDataRace(..)
        | ErrorNonPureMethodCallOnConstant(..)
        | ErrorAssignmentToConstant(..) => "C1007",
        ErrorTooManyOperations(_) | ErrorTooManyVariables(_) | ErrorTooManyModules(_) | ErrorStackOverflow(_) | ErrorDataTooLarge(..) => {
            "C1008"
        }
        ErrorRuntime(..) => "C1009",
        ErrorTerminated(..) => Class::Interrupted.usual_code(),
        _ => "C1010",
    }
}

impl Explainer<'_> {
    fn walk(&self, error: &EvalAltResult, source: &str, frames: &mut Vec<CallFrame>) -> Diagnostic {
        use EvalAltResult::{ErrorInFunctionCall, ErrorInModule, ErrorRuntime, ErrorTerminated};
        match error {
            ErrorInFunctionCall(name, inner_source, inner, position) => {
                let place = self.place(source, *position);
                frames.push(CallFrame { title: call_title(name, place.as_ref()), place });
                self.walk(inner, if inner_source.is_empty() { source } else { inner_source }, frames)
            }
            ErrorInModule(path, inner, position) => {
                let inner_source = format!("{path}.rhai");
                if matches!(**inner, EvalAltResult::ErrorModuleNotFound(..)) {
                    return self.walk(inner, source, frames);
                }
                frames.push(CallFrame { title: "in the module imported here".into(), place: self.place(source, *position) });
                self.walk(inner, &inner_source, frames)
            }
            ErrorRuntime(value, position) | ErrorTerminated(value, position) if value.is::<Failure>() => {
                let failure = value.clone_cast::<Failure>();
                let place = failure.origin.clone();
                let place = place.or_else(|| self.host.place(self.engine, source, *position, &failure.target, failure.method));
                if let Some(inner) = &failure.inner {
                    frames.push(CallFrame { title: failure.title.clone(), place });
                    return self.walk(&inner.error, &inner.source, frames);
                }
                Diagnostic { place, label: failure.label.clone(), ..explain_failure(&failure) }
            }
            other => {
                let place = self.place(source, other.position());
                let diagnostic = self.reword(other, source, place.as_ref());
                let better = self.better_place(other, source, place.as_ref());
                let is_loop = better.is_some() && matches!(other, EvalAltResult::ErrorTooManyOperations(_));
                let label = if is_loop { "a loop that runs here" } else { "" };
                Diagnostic { place: better.or(place), ..diagnostic }.code(code_of(other)).label(label)
            }
        }
    }

    /// Returns a more precise place than that of the engine.
    fn better_place(&self, error: &EvalAltResult, source: &str, place: Option<&SourceSpan>) -> Option<SourceSpan> {
        let main = self.host.main.borrow().clone();
        let source = if source.is_empty() { main.as_str() } else { source };
        let text = self.host.sources.text(source)?;
        let lexemes = scan::lexemes(self.engine, &text);
        let range = match error {
            EvalAltResult::ErrorParsing(ParseErrorType::MissingToken(token, _), _) if token == ";" => {
                scan::end_before(&lexemes, place?.range.start)?
            }
            // A `,` without a further entry of the list means a bracket that is not closed.
            EvalAltResult::ErrorParsing(ParseErrorType::MissingToken(token, _), _)
                if token == "," && place?.text[place?.range.clone()] == *";" =>
            {
                scan::end_before(&lexemes, place?.range.start)?
            }
            // The engine gives the place of the call that did not return; the loop is in the function.
            EvalAltResult::ErrorTooManyOperations(_) => scan::loop_in(&lexemes, &text[place?.range.clone()])?,
            // The engine reports the position of the bracket for registered indexers, that of the index for arrays.
            EvalAltResult::ErrorArrayBounds(..) => scan::behind_bracket(&lexemes, place?.range.start)?,
            EvalAltResult::ErrorDataRace(what, position) if position.is_none() => scan::self_use(&lexemes, what.split('\'').nth(1)?)?,
            _ => return None,
        };
        Some(SourceSpan { source: source.to_string(), text, range })
    }
}
