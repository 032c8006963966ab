//! `conserva check`: builds the models of a script, describes them and their faults, and takes no step.

use std::rc::Rc;

use clap::Args;

use super::console::{Console, complain, ink};
use super::process::exit_code;
use super::script_arguments::ScriptArguments;
use crate::script::{Mode, Session, Settings, home};

/// Arguments of `conserva check`.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    script: ScriptArguments,
}

/// Checks a script; returns the exit code.
pub fn check(arguments: Arguments) -> u8 {
    let ScriptArguments { script, overrides, allow_read, max_operations, memory } = arguments.script;
    memory.apply();
    let console = Rc::new(Console::new(true));
    let settings = Settings { mode: Mode::Check, overrides, allow_read, max_operations, ..Settings::default() };
    let report = match Session::new(settings, home(&script), console.clone()) {
        Ok(mut session) => session.run_file(&script),
        Err(error) => {
            complain(&error.render(ink()));
            return exit_code(error.class);
        }
    };
    for finding in &report.findings {
        console.say(finding);
    }
    match report.error {
        None => {
            console.say(&format!("{}: nothing wrong found", script.display()));
            0
        }
        Some(error) => {
            console.report(&error);
            exit_code(error.class)
        }
    }
}
