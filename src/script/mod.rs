//! Floor 7 of `ARCHITECTURE.md`: the script language: engine, functions, argument checking, messages, the files of a run.
//!
//! Three folders, with dependencies in one direction: `session` on `api`, both on `language`. A [`Session`] is one engine with its scope
//! and its host; it runs a script, and prompt and test runner use its methods. Script types are cheap handles around `Rc`, so a session
//! stays on its thread.

mod api;
mod language;
mod session;

pub use language::diagnostics::{CallFrame, Diagnostic, Ink, Severity};
pub use language::failure::Class;
pub use language::function::{Form, Function, Topic};
pub use language::handle::Receiver;
pub use language::limits::{MAX_ARRAY, MAX_CALL_LEVELS, MAX_MAP, MAX_OPERATIONS, MAX_STRING, STACK};
pub use language::observer::{ContactChange, Event, Observer, Progress, Silent};
pub use language::parameter::{Absent, Kind, Parameter};
pub use language::registry::Registry;
pub use language::settings::{Checkpoints, Mode, Settings, processors, worthwhile};
pub use language::sources::SourceSpan;
pub use session::calls::Calls;
pub use session::codes::{Explanation, explanations};
pub use session::completion::Candidate;
pub use session::declarations::Role;
pub use session::document::{Checked, Document, Explained, Signature, imports_of};
pub use session::interactive::{Answer, Interactive, Style, Variable, indentation};
pub use session::pages::{PAGES, Page};
pub use session::ranking::ranked;
pub use session::reference::{Entry, Reference};
pub use session::session::{Outline, Report, Session, read_script};
pub use session::synonyms::{meant, missing};
pub use session::testing::{TestCase, TestFile, TestOutcome, home, script_files, tests_of};
pub use session::words::Word;
