//! Data exchanged between a session and its workers on other threads, and the creation of workers.
//!
//! Engines, closures and objects stay on their thread. A closure whose captured values are plain data can be transferred by its name: the
//! other session compiles equal texts and finds the closure in these. The language is independent of sessions and studies, so the session
//! puts the function that makes workers ([`NewWorker`]) into a slot.

use std::path::PathBuf;

use rhai::{Dynamic, Engine, EvalAltResult};
use serde::{Deserialize, Serialize};

use super::explain::{explain, explain_failure};
use super::failure::Failure;
use super::host::Host;
use super::message::Message;
use super::plain::Plain;
use super::settings::Settings;
use super::sources::Sources;

/// A compiled text whose functions a session has.
#[derive(Clone, Debug)]
pub struct Unit {
    /// Source text that was compiled.
    pub text: String,
    /// Variables in scope when the text was compiled.
    pub names: Vec<String>,
}

/// Texts of the running script; at a prompt the texts of all entries, earlier ones first.
#[derive(Default)]
pub struct Program(pub std::cell::RefCell<Vec<Unit>>);

/// Data to create a session with equal functions.
#[derive(Clone)]
pub struct Blueprint {
    /// Settings of the run.
    pub settings: Settings,
    /// The folder of the script.
    pub home: PathBuf,
    /// Name of the main source.
    pub main: String,
    /// The texts to show in messages.
    pub sources: Sources,
    /// The texts with the functions.
    pub program: Vec<Unit>,
    /// Imported modules: the alias in the script (empty if there is none), and the path.
    pub imports: Vec<(String, String)>,
    /// Constants of the script.
    pub constants: Vec<(String, Plain)>,
    /// Units that the script has declared.
    pub units: Vec<String>,
}

/// A closure by its name, with its captured values.
#[derive(Clone, Debug)]
pub struct PortableClosure {
    /// Name of the closure.
    pub name: String,
    /// Values of captured variables.
    pub captured: Vec<Plain>,
    /// Conversion of the closure's value into data.
    pub reading: Reading,
}

/// Converts the value of a closure into data.
///
/// # Errors
/// The value cannot be converted.
pub type Reading = fn(&Engine, &Dynamic) -> Result<Plain, Failure>;

/// Message of a script.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ScriptOutput {
    /// A printed line.
    Line(String),
    /// A check that holds: its key, and its message.
    Passed(String, String),
    /// A warning.
    Warning(Message),
}

/// Outcome of a call of a closure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    /// Value of the closure.
    Done(Plain),
    /// Error of the call.
    Failed(Message),
    /// Error of the closure itself: its value is no result, or it changes objects that are not its own.
    Refused(Message),
}

/// Outcome of a call of a closure, with its messages, parameters and files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Computed {
    /// Outcome of the call.
    pub outcome: Outcome,
    /// Messages of the call.
    pub told: Vec<ScriptOutput>,
    /// Parameters that the closure requested, with their values.
    pub asked: Vec<(String, Plain)>,
    /// Files that the closure read.
    pub read: Vec<PathBuf>,
    /// Texts of imported modules, by name.
    pub modules: Vec<(String, String)>,
}

impl Computed {
    /// Returns a result without messages, parameters and files.
    pub fn only(outcome: Outcome) -> Self {
        Computed { outcome, told: Vec::new(), asked: Vec::new(), read: Vec::new(), modules: Vec::new() }
    }
}

/// Session that calls closures for another session.
pub trait ClosureCaller {
    /// True if the session has the closure.
    fn knows(&self, closure: &PortableClosure) -> bool;

    /// Calls a closure independently of earlier calls.
    fn compute(&mut self, closure: &PortableClosure, arguments: &[Plain]) -> Computed;
}

/// Makes a session on the calling thread; `None` if the texts cannot be compiled, or a module no longer exists.
pub type NewWorker = fn(&Blueprint) -> Option<Box<dyn ClosureCaller>>;

/// Function that creates workers; `None` where the session has none.
#[derive(Default)]
pub struct MakeWorker(pub Option<NewWorker>);

/// Converts the value of a closure call into an outcome.
pub fn outcome_of(host: &Host, engine: &Engine, value: Result<Result<Dynamic, Failure>, Box<EvalAltResult>>, reading: Reading) -> Outcome {
    match value.map(|value| value.and_then(|value| reading(engine, &value))) {
        Ok(Ok(plain)) => Outcome::Done(plain),
        Ok(Err(failure)) => Outcome::Refused(Message::of(&explain_failure(&failure).label(failure.label.clone()))),
        Err(error) => Outcome::Failed(Message::of(&explain(host, engine, &error, &host.main.borrow()))),
    }
}
