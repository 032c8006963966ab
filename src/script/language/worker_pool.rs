//! What passes between a session and those that work for it on other threads: plain data, and how one is hired.
//!
//! Engines, closures and objects stay on their thread. A closure whose captured values are plain data can be carried over by its name: the
//! other session compiles the same texts and finds it there. The language knows neither sessions nor studies, so who makes a session
//! ([`NewWorker`]) is put into a slot by the room above.

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

/// A text whose functions a session knows, as it was compiled.
#[derive(Clone, Debug)]
pub struct Unit {
    /// The text.
    pub text: String,
    /// Variables that were there when it was compiled.
    pub names: Vec<String>,
}

/// The texts of the running script; of a prompt all entries, the later ones behind the earlier.
#[derive(Default)]
pub struct Program(pub std::cell::RefCell<Vec<Unit>>);

/// What it takes to make a session that knows the same functions.
#[derive(Clone)]
pub struct Blueprint {
    /// How it runs.
    pub settings: Settings,
    /// The folder of the script.
    pub home: PathBuf,
    /// Name of the main source.
    pub main: String,
    /// The texts to show in messages.
    pub sources: Sources,
    /// The texts with the functions.
    pub program: Vec<Unit>,
    /// Imported modules: the name that the script gives each, empty where it gives none, and its path.
    pub imports: Vec<(String, String)>,
    /// Constants of the script.
    pub constants: Vec<(String, Plain)>,
}

/// A closure by its name, with what it captures.
#[derive(Clone, Debug)]
pub struct Carried {
    /// Its name.
    pub name: String,
    /// Values of captured variables.
    pub captured: Vec<Plain>,
    /// How the value that it gives becomes data.
    pub reading: Reading,
}

/// Makes data of what a closure gave.
///
/// # Errors
/// It gave something that is none.
pub type Reading = fn(&Engine, &Dynamic) -> Result<Plain, Failure>;

/// Something that a script said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Told {
    /// A printed line.
    Line(String),
    /// A check that holds: what tells it from others, and the line.
    Passed(String, String),
    /// A warning.
    Warning(Message),
}

/// How a call of a closure ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    /// It gave this.
    Done(Plain),
    /// It failed.
    Failed(Message),
    /// The closure is wrong in itself: it gives what is no result, or changes what is not its own.
    Refused(Message),
}

/// A call of a closure with everything that came of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Computed {
    /// How it ended.
    pub outcome: Outcome,
    /// What it said.
    pub told: Vec<Told>,
    /// Parameters that it asked for, with their values.
    pub asked: Vec<(String, Plain)>,
    /// Files that it read.
    pub read: Vec<PathBuf>,
    /// Texts of modules that it imported, by name.
    pub modules: Vec<(String, String)>,
}

impl Computed {
    /// One that nothing came of but this.
    pub fn only(outcome: Outcome) -> Self {
        Computed { outcome, told: Vec::new(), asked: Vec::new(), read: Vec::new(), modules: Vec::new() }
    }
}

/// A session that calls closures for another one.
pub trait Hand {
    /// Whether it knows a closure.
    fn knows(&self, closure: &Carried) -> bool;

    /// Calls a closure as if nothing had been called before.
    fn compute(&mut self, closure: &Carried, arguments: &[Plain]) -> Computed;
}

/// Makes a session on the thread that calls it; `None` where the texts do not make one, such as a module that is gone by now.
pub type NewWorker = fn(&Blueprint) -> Option<Box<dyn Hand>>;

/// How a session hires, where it can.
#[derive(Default)]
pub struct MakeWorker(pub Option<NewWorker>);

/// What came of a call of a closure.
pub fn outcome_of(host: &Host, engine: &Engine, value: Result<Result<Dynamic, Failure>, Box<EvalAltResult>>, reading: Reading) -> Outcome {
    match value.map(|value| value.and_then(|value| reading(engine, &value))) {
        Ok(Ok(plain)) => Outcome::Done(plain),
        Ok(Err(failure)) => Outcome::Refused(Message::of(&explain_failure(&failure).label(failure.label.clone()))),
        Err(error) => Outcome::Failed(Message::of(&explain(host, engine, &error, &host.main.borrow()))),
    }
}
