//! The log of a run for programs: one JSON object per line, written immediately.
//!
//! Every line has the key `event`; [`EVENTS`] lists its values with their keys, which later versions keep and may extend. Lines contain no
//! wall-clock times except `wall_seconds` at the end, so that logs of equal runs are equal. A failed write is reported once; the run
//! continues, and its exit code reports the missing output.

use std::cell::{Cell, RefCell};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Instant;

use serde_json::{Value, json};

use super::console::{Console, complain, ink, write_error};
use crate::dynamics::LedgerRow;
use crate::output::is_count;
use crate::script::{Class, ContactChange, Diagnostic, Event, Ink, Observer, Progress, Report};

/// Returns the description of the log for the long help of `conserva run`.
pub fn help() -> String {
    let events: Vec<String> = EVENTS.iter().map(|(event, keys)| format!("  {event:<8} {keys}")).collect();
    format!("Events of the log, by the key `event` of each line:\n{}", events.join("\n"))
}

/// Events with their keys.
const EVENTS: &[(&str, &str)] = &[
    ("start", "the run begins: `version`, `script`, `out`, `threads`, `set` (the values of `--set`)"),
    ("watch", "with `--watch`: `address` of the page that follows the run"),
    ("step", "an accepted step: `simulation` and the columns of the ledger as in history.csv"),
    ("halving", "a step is halved: `simulation`, `cause`, `contact` (or null), `count`, `step` and `time` before it"),
    ("contact", "a contact closes or opens as a whole: `simulation`, `contact`, `change` (`closed`, `opened`), `active`, `step`, `time`"),
    (
        "settled",
        "`settle` found equilibrium: `simulation`, `steps`, `newton_iterations`, `time`, `kinetic`, `strain`, `potential`, `total`, \
         `active`, `max_penetration`",
    ),
    ("begin", "a computation without steps begins, or a study has come further: `what`"),
    ("print", "a line of the script's: `text`"),
    ("check", "a check that holds: `text`"),
    ("warning", "`code` (as `C0123`, or null), `message`, `causes`, `hints`, and `file`, `line`, `column` (or null)"),
    ("failure", "the error that ends the run: `class` (`script`, `check`, `numerics`, `interrupted`, `internal`) and what a warning has"),
    ("end", "the run has ended: `outcome` (`completed`, `interrupted`, `failed`), `exit_code`, `checks`, `conserving`, `wall_seconds`"),
];

/// Target of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LogTarget {
    /// Standard error, without other output.
    StandardError,
    /// A file.
    File(PathBuf),
}

impl LogTarget {
    /// Parses `json` or `json:FILE`.
    ///
    /// # Errors
    /// The text is not of the expected form; the message describes the form.
    pub fn parse(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "json" => Ok(LogTarget::StandardError),
            Some(("json", file)) if !file.is_empty() => Ok(LogTarget::File(file.into())),
            _ => Err("write `--log json` for standard error, or `--log json:run.jsonl` for a file".into()),
        }
    }
}

/// Observer that writes the log, and passes other output on to the console.
pub struct JsonLog {
    console: Rc<Console>,
    /// File of the log; `None` for standard error.
    file: Option<(PathBuf, RefCell<File>)>,
    broken: Cell<bool>,
    begun: Instant,
}

impl JsonLog {
    /// Opens the log; an existing file is replaced.
    ///
    /// # Errors
    /// A file that cannot be created.
    pub fn open(target: &LogTarget, console: Rc<Console>) -> Result<Self, Box<Diagnostic>> {
        let file = match target {
            LogTarget::StandardError => None,
            LogTarget::File(path) => {
                let file = File::create(path).map_err(|error| {
                    let is_misnamed = matches!(error.kind(), ErrorKind::NotFound | ErrorKind::IsADirectory | ErrorKind::NotADirectory);
                    let class = if is_misnamed { Class::Script } else { Class::Output };
                    let message = Diagnostic::error(class, format!("the log {} cannot be written", path.display()));
                    let hint = "name a file in a folder that exists and may be written to, such as `--log json:run.jsonl`";
                    Box::new(message.cause(error.to_string()).hint(hint))
                })?;
                Some((path.clone(), RefCell::new(file)))
            }
        };
        Ok(JsonLog { console, file, broken: Cell::new(false), begun: Instant::now() })
    }

    /// True if the log goes to standard error, so that nothing else may be written there.
    pub fn is_alone(&self) -> bool {
        self.file.is_none()
    }

    /// True if a line could not be written.
    pub fn is_broken(&self) -> bool {
        self.broken.get()
    }

    /// Logs the start of the run.
    pub fn start(&self, script: &Path, out: &Path, threads: u16, overrides: &[(String, String)]) {
        let set: serde_json::Map<String, Value> = overrides.iter().map(|(name, value)| (name.clone(), value.clone().into())).collect();
        self.tell(
            "start",
            &[
                ("version", env!("CARGO_PKG_VERSION").into()),
                ("script", script.display().to_string().into()),
                ("out", out.display().to_string().into()),
                ("threads", threads.into()),
                ("set", set.into()),
            ],
        );
    }

    /// Logs the address of the run's page.
    pub fn shown(&self, address: &str) {
        self.tell("watch", &[("address", address.into())]);
    }

    /// Logs the end of the run.
    pub fn end(&self, report: &Report, exit_code: u8) {
        if let Some(error) = &report.error {
            let mut keys = vec![("class", class_name(error.class).into())];
            keys.extend(diagnostic_keys(error));
            self.tell("failure", &keys);
        }
        let outcome = match report.error.as_ref().map(|error| error.class) {
            None => "completed",
            Some(Class::Interrupted) => "interrupted",
            Some(_) => "failed",
        };
        self.tell(
            "end",
            &[
                ("outcome", outcome.into()),
                ("exit_code", exit_code.into()),
                ("checks", report.checks.into()),
                ("conserving", report.is_conserving.into()),
                ("wall_seconds", self.begun.elapsed().as_secs_f64().into()),
            ],
        );
    }

    /// Writes a line by one system call.
    fn tell(&self, event: &str, keys: &[(&str, Value)]) {
        if self.broken.get() {
            return;
        }
        let mut line = format!("{{\"event\":{}", json!(event));
        for (key, value) in keys {
            let _ = write!(line, ",{}:{value}", json!(key));
        }
        line.push_str("}\n");
        let Some((path, file)) = &self.file else {
            // A failed write cannot be reported here.
            let is_lost = write_error(&line).is_err_and(|error| error.kind() != ErrorKind::BrokenPipe);
            return self.broken.set(is_lost);
        };
        if let Err(error) = file.borrow_mut().write_all(line.as_bytes()) {
            self.broken.set(true);
            let warning = Diagnostic::warning(format!("the log {} ends here: it could not be written", path.display()), None);
            let hint = "the run goes on, its results do not depend on the log; at its end the exit code is 3";
            let warning = warning.cause(error.to_string()).hint(hint);
            complain(&warning.render(ink()));
        }
    }
}

/// Name of a class of errors.
fn class_name(class: Class) -> &'static str {
    match class {
        Class::Script | Class::ResultUsed => "script",
        Class::Check => "check",
        Class::Output => "output",
        Class::Numerics => "numerics",
        Class::Interrupted => "interrupted",
        Class::Internal => "internal",
    }
}

/// Returns the keys of a message.
fn diagnostic_keys(diagnostic: &Diagnostic) -> Vec<(&'static str, Value)> {
    let place = diagnostic.place.as_ref();
    let position = place.map(|place| place.line_column());
    vec![
        ("code", Some(&diagnostic.code).filter(|code| !code.is_empty()).cloned().into()),
        ("message", diagnostic.title.clone().into()),
        ("causes", diagnostic.causes.clone().into()),
        ("hints", diagnostic.hints.clone().into()),
        ("file", place.map(|place| place.source.clone()).into()),
        ("line", position.map(|(line, _)| line).into()),
        ("column", position.map(|(_, column)| column).into()),
    ]
}

/// Returns a column of the ledger: whole numbers as such, null for NaN.
fn column(row: &LedgerRow, name: &str) -> Value {
    match row.column(name) {
        Some(value) if is_count(name) => (value as u64).into(),
        value => value.into(),
    }
}

impl Observer for JsonLog {
    fn print(&self, line: &str) {
        self.console.print(line);
        self.tell("print", &[("text", line.into())]);
    }

    fn passed(&self, line: &str) {
        self.console.passed(line);
        self.tell("check", &[("text", line.into())]);
    }

    fn warn(&self, warning: &Diagnostic) {
        if !self.is_alone() {
            self.console.warn(warning);
        }
        self.tell("warning", &diagnostic_keys(warning));
    }

    fn advanced(&self, progress: &Progress) {
        self.console.advanced(progress);
        let mut keys = vec![("simulation", progress.model.into())];
        keys.extend(LedgerRow::columns(progress.dimension).into_iter().map(|of| (of.name, column(progress.row, of.name))));
        self.tell("step", &keys);
    }

    fn noticed(&self, event: &Event) {
        match *event {
            Event::Halved { simulation, cause, contact, count, step, time } => self.tell(
                "halving",
                &[
                    ("simulation", simulation.into()),
                    ("cause", cause.replace(' ', "_").into()),
                    ("contact", contact.into()),
                    ("count", count.into()),
                    ("step", step.into()),
                    ("time", time.into()),
                ],
            ),
            Event::Contact { simulation, contact, change, active, step, time } => self.tell(
                "contact",
                &[
                    ("simulation", simulation.into()),
                    ("contact", contact.into()),
                    ("change", if change == ContactChange::Closed { "closed" } else { "opened" }.into()),
                    ("active", active.into()),
                    ("step", step.into()),
                    ("time", time.into()),
                ],
            ),
            Event::Settled { simulation, steps, newton_iterations, row } => {
                let counts = [("simulation", simulation.into()), ("steps", steps.into()), ("newton_iterations", newton_iterations.into())];
                let values = ["time", "kinetic", "strain", "potential", "total", "active", "max_penetration"];
                let keys: Vec<_> = counts.into_iter().chain(values.map(|name| (name, column(row, name)))).collect();
                self.tell("settled", &keys);
            }
        }
    }

    fn began(&self, what: &str) {
        self.console.began(what);
        self.tell("begin", &[("what", what.into())]);
    }

    fn ended(&self) {
        self.console.ended();
    }

    fn ink(&self) -> Ink {
        self.console.ink()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets() {
        assert_eq!(LogTarget::parse("json"), Ok(LogTarget::StandardError));
        assert_eq!(LogTarget::parse("json:a:b.jsonl"), Ok(LogTarget::File("a:b.jsonl".into())));
        assert!(["", "xml", "json:", "text:x"].iter().all(|text| LogTarget::parse(text).is_err()));
    }
}
