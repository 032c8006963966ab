//! Failure of a script function: all parts of the message except the place, which the engine adds.
//!
//! A failure passes through the engine as the payload of a run-time error, so that the engine adds the position of the call and the chain
//! of enclosing script functions; the diagnostics unpack the failure at the end. Failures that a script cannot catch (an interrupt, the end
//! of a check) are passed as terminations.

use std::ops::Deref;
use std::rc::Rc;

use rhai::{Dynamic, EvalAltResult, Position};
use serde::{Deserialize, Serialize};

use super::handle::Handle;
use super::scan::Target;
use super::sources::SourceSpan;
use crate::dynamics::StepError;

/// Class of a failure; determines the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Class {
    /// A check of the script does not hold.
    Check,
    /// The script, a file that it reads, or an argument is wrong.
    Script,
    /// The script is right, but the computation failed.
    Numerics,
    /// A file of the results could not be written.
    Output,
    /// The user interrupted the run.
    Interrupted,
    /// `conserva check` came to the first use of a result.
    ResultUsed,
    /// Internal error of the program.
    Internal,
}

impl Class {
    /// Returns the stable code of a failure of this class without a code of its own; empty if the class is not specific enough.
    pub(super) fn usual_code(self) -> &'static str {
        match self {
            Class::Script => "C1020",
            Class::Check => "C1031",
            Class::Internal => "C1041",
            Class::Interrupted => StepError::Interrupted { time: 0.0 }.code(),
            Class::Numerics | Class::Output | Class::ResultUsed => "",
        }
    }
}

/// Error of script code called by the solver, to be passed through its layers.
#[derive(Clone, Debug)]
pub struct ScriptError {
    /// Error of the engine.
    pub error: Rc<EvalAltResult>,
    /// Source of the error's outermost position.
    pub source: String,
}

impl std::fmt::Display for ScriptError {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}", self.error)
    }
}

impl std::error::Error for ScriptError {}

/// Parts of a message: class, code, title, place, causes, hints.
#[derive(Clone, Debug)]
pub struct Details {
    /// Kind of failure.
    pub class: Class,
    /// Stable code of the message, such as `C0123`; empty without a code.
    pub code: String,
    /// Description of the fault, one sentence.
    pub title: String,
    /// Part of the call at which the message points.
    pub target: Target,
    /// True if the called function is a method.
    pub method: bool,
    /// Short label at the place of the failure.
    pub label: String,
    /// Numbers and causes that explain the fault.
    pub causes: Vec<String>,
    /// Hints how to mend the fault.
    pub hints: Vec<String>,
    /// Error in script code that caused this failure.
    pub inner: Option<ScriptError>,
    /// Place of the failure, if more precise than the position of the engine.
    pub origin: Option<SourceSpan>,
}

/// A failure of a script function.
#[derive(Clone, Debug)]
pub struct Failure(Box<Details>);

impl Deref for Failure {
    type Target = Details;
    fn deref(&self) -> &Details {
        &self.0
    }
}

impl Failure {
    /// Returns a failure of a class with a title.
    pub fn new(class: Class, title: impl Into<String>) -> Self {
        Failure(Box::new(Details {
            class,
            code: class.usual_code().into(),
            title: title.into(),
            target: Target::Call,
            method: false,
            label: String::new(),
            causes: Vec::new(),
            hints: Vec::new(),
            inner: None,
            origin: None,
        }))
    }

    /// Failure of the class `Script`: the script, a file that it reads, or an argument is wrong.
    pub fn script(title: impl Into<String>) -> Self {
        Failure::new(Class::Script, title)
    }

    /// Returns the failure with the class `class`.
    pub(crate) fn of_class(mut self, class: Class) -> Self {
        self.0.class = class;
        self
    }

    /// Returns the failure with a stable code.
    pub fn code(mut self, code: impl Into<String>) -> Self {
        self.0.code = code.into();
        self
    }

    /// Returns the failure, pointing at a part of the call.
    pub fn at(mut self, target: Target) -> Self {
        self.0.target = target;
        self
    }

    /// Returns the failure with a short text at the place.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.0.label = label.into();
        self
    }

    /// Returns the failure with one more cause.
    pub fn cause(mut self, cause: impl Into<String>) -> Self {
        self.0.causes.push(cause.into());
        self
    }

    /// Returns the failure with one more hint.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.0.hints.push(hint.into());
        self
    }

    /// Returns the failure, caused by an error in script code.
    pub(crate) fn caused_by(mut self, inner: ScriptError) -> Self {
        self.0.inner = Some(inner);
        self
    }

    /// Returns the failure with a given place, in place of the position that the engine adds.
    pub fn placed(mut self, place: Option<SourceSpan>) -> Self {
        self.0.origin = place;
        self
    }

    /// Returns the failure, marked as raised in a method or not.
    pub(crate) fn in_method(mut self, method: bool) -> Self {
        self.0.method = method;
        self
    }

    /// The engine's error at a position.
    pub fn raise(self, position: Position) -> Box<EvalAltResult> {
        let catchable = matches!(self.class, Class::Check | Class::Script | Class::Numerics | Class::Output);
        let payload = Dynamic::from(self);
        Box::new(if catchable { EvalAltResult::ErrorRuntime(payload, position) } else { EvalAltResult::ErrorTerminated(payload, position) })
    }
}

impl Handle for Failure {
    const NAME: &'static str = "Error";

    fn describe(&self) -> String {
        let inner = self.inner.as_ref().map(|inner| inner.to_string()).unwrap_or_default();
        [self.title.as_str(), &inner]
            .into_iter()
            .chain(self.causes.iter().map(String::as_str))
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join("; ")
    }
}

impl From<Failure> for Box<EvalAltResult> {
    fn from(failure: Failure) -> Self {
        failure.raise(Position::NONE)
    }
}

/// The failure of an interrupted call.
pub fn interrupted(title: impl Into<String>) -> Failure {
    Failure::new(Class::Interrupted, title)
}
