//! `conserva run`: runs a script, shows progress, writes results, and says by its exit code how it went.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::console::{Console, complain, ink};
use super::log::{self, JsonLog, LogTarget};
use super::process::exit_code;
use super::script_arguments::ScriptArguments;
use crate::script::{Class, Mode, Observer, Report, Session, Settings, home};

/// Arguments of `conserva run`.
#[derive(Args)]
#[command(after_long_help = log::help())]
pub struct Arguments {
    #[command(flatten)]
    script: ScriptArguments,
    /// Folder of the results [default: out/<script name>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Threads of the element loop; results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// No progress
    #[arg(long)]
    quiet: bool,
    /// Tell programs what happens, one JSON object per line: to standard error in place of progress and messages (`json`), or to a file
    /// besides them (`json:FILE`)
    #[arg(long, value_name = "json[:FILE]", value_parser = LogTarget::parse)]
    log: Option<LogTarget>,
}

/// A flag that becomes true at the first interrupt; the second one ends the process.
pub fn interrupt() -> std::io::Result<Arc<AtomicBool>> {
    let interrupt = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        flag::register_conditional_shutdown(signal, i32::from(exit_code(Class::Interrupted)), interrupt.clone())?;
        flag::register(signal, interrupt.clone())?;
    }
    Ok(interrupt)
}

/// Runs a script; the exit code.
pub fn run(arguments: Arguments) -> u8 {
    let ScriptArguments { script, overrides, allow_read, max_operations } = arguments.script;
    let stem = script.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_else(|| "script".into());
    let out = arguments.out.unwrap_or_else(|| Path::new("out").join(stem));
    let interrupt = match interrupt() {
        Ok(interrupt) => interrupt,
        Err(error) => {
            complain(&format!("error: the interrupt key cannot be watched\n= cause: {error}\n"));
            return exit_code(Class::Internal);
        }
    };
    let console = Rc::new(Console::new(arguments.quiet || arguments.log == Some(LogTarget::StandardError)));
    let json = match arguments.log.map(|target| JsonLog::open(&target, console.clone())).transpose() {
        Ok(json) => json.map(Rc::new),
        Err(error) => {
            complain(&error.render(ink()));
            return exit_code(error.class);
        }
    };
    let observer: Rc<dyn Observer> = json.clone().map_or(console.clone(), |json| json);
    if let Some(json) = &json {
        json.start(&script, &out, arguments.threads, &overrides);
    }
    let settings = Settings {
        mode: Mode::Run,
        overrides,
        allow_read,
        output: Some(out.clone()),
        threads: usize::from(arguments.threads),
        max_operations,
        interrupt,
        factorization: console.factorization(),
        interactive: false,
    };
    let report = match Session::new(settings, home(&script), observer) {
        Ok(mut session) => session.run_file(&script),
        Err(error) => Report::failed(*error),
    };
    if let Some(json) = &json {
        json.end(&report, report.error.as_ref().map_or(0, |error| exit_code(error.class)));
    }
    match report.error {
        None => {
            let checks = match report.checks {
                0 => String::new(),
                1 => ", 1 check passed".into(),
                count => format!(", {count} checks passed"),
            };
            report.energy.iter().for_each(|line| console.note(line));
            let kept = if report.is_conserving { "done" } else { "ended, not conserving" };
            console.note(&format!("{kept}{checks}; results in {}", out.display()));
            0
        }
        Some(error) => {
            if json.is_none_or(|json| !json.is_alone()) {
                console.report(&error);
            }
            exit_code(error.class)
        }
    }
}
