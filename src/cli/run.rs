//! `conserva run`: runs a script, shows progress, writes results, and reports the outcome by its exit code.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;

use super::console::{Console, complain, ink, with_loss};
use super::live::{LiveObserver, LivePage};
use super::log::{self, JsonLog, LogTarget};
use super::process::{DOUBTFUL, exit_code};
use super::ranks::{SolverArguments, told_by_launcher};
use super::script_arguments::{ScriptArguments, threads};
use super::signals::interrupt;
use crate::output::{LiveReport, checkpoint};
use crate::script::{Checkpoints, Class, Diagnostic, Mode, Observer, Report, Session, Settings, home, processors};

/// Arguments of `conserva run`.
#[derive(Args)]
#[command(after_long_help = log::help())]
pub struct Arguments {
    #[command(flatten)]
    script: ScriptArguments,
    /// Folder of the results [default: out/<script name>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    course: RunControlArguments,
}

/// Common arguments of `run` and `resume`: threads, solver, output, checkpoints.
#[derive(Args)]
pub struct RunControlArguments {
    /// Threads of the element loop; results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = threads)]
    pub threads: u16,
    #[command(flatten)]
    pub solver: SolverArguments,
    /// No progress
    #[arg(long)]
    pub quiet: bool,
    /// Log events for programs, one JSON object per line: to standard error in place of progress and messages (`json`), or to a file
    /// besides them (`json:FILE`)
    #[arg(long, value_name = "json[:FILE]", value_parser = LogTarget::parse)]
    pub log: Option<LogTarget>,
    /// Interval between checkpoints, from which `resume` continues: a number of steps (`100`), a time (`30s`, `5min`, `2h`), or `never`
    #[arg(long, value_name = "EVERY", default_value = "1min", value_parser = every)]
    pub checkpoint: Checkpoints,
    /// Serve a page that follows the run, on this machine only; its address is printed at the start. A port may be given
    #[arg(long, value_name = "PORT", num_args = 0..=1, require_equals = true, default_missing_value = "0", value_parser = port)]
    pub watch: Option<u16>,
}

/// Parses the interval between checkpoints.
///
/// # Errors
/// The text is not of the expected form; the message describes the form.
fn every(text: &str) -> Result<Checkpoints, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic()).trim_end();
    let seconds = match text[digits.len()..].trim() {
        "never" | "off" if digits.is_empty() => return Ok(Checkpoints::Never),
        "" | "step" | "steps" => 0.0,
        "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => f64::NAN,
    };
    let how = "write a number of steps (100), a time (30s, 5min, 2h), or never";
    if seconds == 0.0 {
        return digits.parse().ok().filter(|&count| count > 0).map(Checkpoints::Steps).ok_or_else(|| how.into());
    }
    let time = digits.parse::<f64>().ok().map(|count| Duration::try_from_secs_f64(count * seconds));
    time.and_then(Result::ok).map(Checkpoints::Time).ok_or_else(|| how.into())
}

/// Parses a port of this machine.
///
/// # Errors
/// The text is not of the expected form; the message describes the form.
fn port(text: &str) -> Result<u16, String> {
    text.parse().map_err(|_| "write `--watch` for any port that is free, or one from 1 to 65535 such as `--watch=8000`".into())
}

/// Runs a script; returns the exit code.
pub fn run(arguments: Arguments) -> u8 {
    if let Err(code) = arguments.course.solver.join_job() {
        return code;
    }
    let ScriptArguments { script, overrides, allow_read, max_operations, memory } = arguments.script;
    memory.apply();
    let stem = script.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_else(|| "script".into());
    let out = arguments.out.unwrap_or_else(|| Path::new("out").join(stem));
    let interrupt = match interrupt() {
        Ok(interrupt) => interrupt,
        Err(error) => {
            complain(&format!("error: the interrupt key cannot be watched\n= cause: {error}\n"));
            return exit_code(Class::Internal);
        }
    };
    let watch = match RunObservers::new(&arguments.course, &out) {
        Ok(watch) => watch,
        Err(error) => {
            complain(&error.render(ink()));
            return exit_code(error.class);
        }
    };
    watch.begin(&script, &out, arguments.course.threads, &overrides);
    let settings = Settings {
        mode: Mode::Run,
        overrides,
        allow_read,
        output: Some(out.clone()),
        threads: usize::from(arguments.course.threads),
        solver: arguments.course.solver.choice(),
        workers: processors(),
        max_operations,
        interrupt,
        factorization: watch.console.factorization(),
        checkpoints: arguments.course.checkpoint,
        until: None,
        live: watch.live(),
        interactive: false,
    };
    let report = match Session::new(settings, home(&script), watch.observer()) {
        Ok(mut session) => session.run_file(&script),
        Err(error) => Report::failed(*error),
    };
    watch.end(&report, &out)
}

/// Observers of a run: the terminal, a log for programs, and a page.
pub struct RunObservers {
    pub console: Rc<Console>,
    log: Option<Rc<JsonLog>>,
    page: Option<LivePage>,
}

impl RunObservers {
    /// Returns the observers requested by the arguments, for results in the folder `out`.
    ///
    /// # Errors
    /// A log that cannot be written, a page that cannot be served.
    pub fn new(course: &RunControlArguments, out: &Path) -> Result<Self, Box<Diagnostic>> {
        let console = Rc::new(Console::new(course.quiet || course.log == Some(LogTarget::StandardError)));
        let log = course.log.as_ref().map(|target| JsonLog::open(target, console.clone())).transpose()?.map(Rc::new);
        let page = course.watch.map(|port| LivePage::open(port, out.display().to_string())).transpose()?;
        Ok(RunObservers { console, log, page })
    }

    /// Returns the report behind the page; `None` without a page.
    pub fn live(&self) -> Option<Arc<LiveReport>> {
        self.page.as_ref().map(|page| page.report.clone())
    }

    /// Returns the observer of the session.
    pub fn observer(&self) -> Rc<dyn Observer> {
        let observer: Rc<dyn Observer> = self.log.clone().map_or(self.console.clone(), |log| log);
        match self.live() {
            Some(live) => Rc::new(LiveObserver::new(live, observer)),
            None => observer,
        }
    }

    /// Reports the start of a run, and the address of its page.
    pub fn begin(&self, script: &Path, out: &Path, threads: u16, overrides: &[(String, String)]) {
        self.log.iter().for_each(|log| log.start(script, out, threads, overrides));
        let Some(page) = &self.page else { return };
        self.log.iter().for_each(|log| log.shown(&page.address()));
        if self.log.as_ref().is_none_or(|log| !log.is_alone()) {
            complain(&format!("watch the run at {}\n", page.address()));
        }
    }

    /// Reports the end of a run; returns the exit code.
    pub fn end(&self, report: &Report, out: &Path) -> u8 {
        let code = self.tell_end(report, out);
        self.show_end(report);
        let lost = self.log.as_ref().is_some_and(|log| log.is_broken());
        if lost && (code == 0 || code == DOUBTFUL) { exit_code(Class::Output) } else { code }
    }

    /// Shows the outcome on the page.
    pub fn show_end(&self, report: &Report) {
        self.page.iter().for_each(|page| page.end(report));
    }

    fn tell_end(&self, report: &Report, out: &Path) -> u8 {
        let fine = if report.is_doubtful { DOUBTFUL } else { 0 };
        let code = with_loss(report.error.as_ref().map_or(fine, |error| exit_code(error.class)));
        self.log.iter().for_each(|log| log.end(report, code));
        let Some(error) = &report.error else {
            let checks = match report.checks {
                0 => String::new(),
                1 => ", 1 check passed".into(),
                count => format!(", {count} checks passed"),
            };
            report.energy.iter().for_each(|line| self.console.note(line));
            let kept = match report {
                Report { is_doubtful: true, .. } => "ended, not to be trusted",
                Report { is_conserving: false, .. } => "ended, not conserving",
                _ => "done",
            };
            self.console.note(&format!("{kept}{checks}; results in {}", out.display()));
            return code;
        };
        if self.log.as_ref().is_none_or(|log| !log.is_alone()) {
            self.console.report(error);
            told_by_launcher(error).iter().for_each(|line| complain(line));
        }
        if error.class == Class::Interrupted && !checkpoint::places(out).is_empty() {
            self.console.note(&format!("go on with `conserva resume {}`", out.display()));
        }
        code
    }
}
