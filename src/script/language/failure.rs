//! What a script function fails with: everything a message needs except its place, which the engine adds.
//!
//! A failure travels through the engine as the payload of a run-time error, so that the engine fills in the position of the call and
//! the chain of script functions around it; the diagnostics unpack it at the end. Failures that a script must not catch (an interrupt,
//! the end of a check) travel as terminations.

use std::ops::Deref;
use std::rc::Rc;

use rhai::{Dynamic, EvalAltResult, Position};
use serde::{Deserialize, Serialize};

use super::handle::Handle;
use super::scan::Target;
use super::sources::Place;
use crate::dynamics::StepError;

/// What kind of failure it is; decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Class {
    /// A check of the script does not hold.
    Check,
    /// The script (or a file it reads, or an argument) is wrong.
    Script,
    /// The script is right, but the computation failed.
    Numerics,
    /// A file of the results could not be written.
    Output,
    /// The user interrupted the run.
    Interrupted,
    /// `conserva check` came to the first use of a result.
    ResultUsed,
    /// A defect of the program itself.
    Internal,
}

impl Class {
    /// The stable code of a failure of which no more is known than its class; empty where that says nothing.
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

/// An error raised by script code that the solver called, on its way through the kernels.
#[derive(Clone, Debug)]
pub struct ScriptError {
    /// The error as the engine gave it.
    pub error: Rc<EvalAltResult>,
    /// Source in which the outermost of its positions lies.
    pub source: String,
}

impl std::fmt::Display for ScriptError {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}", self.error)
    }
}

impl std::error::Error for ScriptError {}

/// The parts of a message.
#[derive(Clone, Debug)]
pub struct Details {
    /// Kind of failure.
    pub class: Class,
    /// Its stable code, as `C0123`; empty where it has none.
    pub code: String,
    /// What is wrong, one sentence.
    pub title: String,
    /// What the message points at within the call.
    pub target: Target,
    /// Whether the called function is a method.
    pub method: bool,
    /// A few words at the place itself.
    pub label: String,
    /// The numbers that show it.
    pub causes: Vec<String>,
    /// How to mend it.
    pub hints: Vec<String>,
    /// The error in script code that led to this one.
    pub inner: Option<ScriptError>,
    /// Where it happened, when that is known better than from the position the engine keeps.
    pub origin: Option<Place>,
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
    /// A failure of some class with its title.
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

    /// The script is wrong.
    pub fn script(title: impl Into<String>) -> Self {
        Failure::new(Class::Script, title)
    }

    /// The same as another kind of failure.
    pub(crate) fn of_class(mut self, class: Class) -> Self {
        self.0.class = class;
        self
    }

    /// The same with its stable code.
    pub fn code(mut self, code: impl Into<String>) -> Self {
        self.0.code = code.into();
        self
    }

    /// The same, pointing at a part of the call.
    pub fn at(mut self, target: Target) -> Self {
        self.0.target = target;
        self
    }

    /// The same, with a few words at the place.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.0.label = label.into();
        self
    }

    /// The same with one more cause.
    pub fn cause(mut self, cause: impl Into<String>) -> Self {
        self.0.causes.push(cause.into());
        self
    }

    /// The same with one more hint.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.0.hints.push(hint.into());
        self
    }

    /// The same, caused by an error in script code.
    pub(crate) fn caused_by(mut self, inner: ScriptError) -> Self {
        self.0.inner = Some(inner);
        self
    }

    /// The same, with a place that the engine must not choose.
    pub fn placed(mut self, place: Option<Place>) -> Self {
        self.0.origin = place;
        self
    }

    /// The same, raised in a method.
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
