//! Floor 7: the script language: engine, functions, argument checking, messages, the files of a run.
//!
//! A [`Session`] is one engine with its scope and its host. It runs a script now; a prompt and a test runner use the same three calls
//! (`evaluate`, `finish`, `host`). Script types are cheap handles around `Rc`, so a session stays on its thread. The architecture of this
//! floor: `registry` describes functions, `arguments` reads what they are called with, one file for each topic implements them,
//! `failure` carries what went wrong, `explain` gives it a place and words, `diagnostics` draws it.

mod arguments;
mod callback;
mod checks;
mod completion;
mod contacts;
mod cursor;
mod diagnostics;
mod explain;
mod failure;
mod forensics;
mod habits;
mod help;
mod host;
mod interactive;
mod materials;
mod meshes;
mod models;
mod modules;
mod motion;
mod numbers;
mod overrides;
mod probes;
mod record;
mod reference;
mod registry;
mod results;
mod run;
mod sandbox;
mod scan;
mod session;
mod simulations;
mod sources;
mod states;
mod studies;
mod tables;
mod testing;
mod time_functions;
mod units;
mod values;

pub use completion::Candidate;
pub use diagnostics::{Diagnostic, Frame, Ink, Severity};
pub use failure::Class;
pub use host::{MAX_OPERATIONS, Mode, Observer, Progress, Settings, Silent};
pub use interactive::{Answer, Interactive, Style, Variable};
pub use reference::{Entry, Reference, Word};
pub use registry::{Absent, Form, Function, Kind, Parameter, Receiver, Registry, Topic};
pub use session::{Outline, Report, Session};
pub use sources::Place;
pub use testing::{TestCase, TestOutcome, home, script_files, tests_of};
pub use units::Dimension;

use rhai::Scope;

/// Calls that may be open at a time.
pub const MAX_CALL_LEVELS: usize = 64;
/// Characters of a string.
pub const MAX_STRING: usize = 16_000_000;
/// Entries of an array.
pub const MAX_ARRAY: usize = 10_000_000;
/// Entries of a map.
pub const MAX_MAP: usize = 1_000_000;

/// A scope with the constants of the language.
fn constants() -> Scope<'static> {
    let mut scope = Scope::new();
    scope.push_constant("PI", std::f64::consts::PI);
    scope
}
