//! Floor 8: the command line. Terminal, signals and exit codes live here; everything about scripts in the floor above.

mod check;
mod console;
mod doc;
mod junit;
mod new;
mod repl;
mod run;
mod test;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use crate::script::{Class, MAX_OPERATIONS};

/// Contact dynamics that conserves energy and momentum, from scripts.
#[derive(Parser)]
#[command(name = "conserva", version, about, max_term_width = 100, disable_help_subcommand = true)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a script and write its results
    Run(run::Arguments),
    /// Build a script's models and report what it would do and what is wrong; takes no step
    Check(check::Arguments),
    /// Run every function `test_…` of scripts, and scenarios as tests of their own checks
    Test(test::Arguments),
    /// Show the reference of the language, or one entry of it
    Doc(doc::Arguments),
    /// Start a scenario from a commented template
    New(new::Arguments),
    /// Try things out at a prompt, after running a script or not
    Repl(repl::Arguments),
}

/// What every command that runs a script takes.
#[derive(Args)]
struct ScriptArguments {
    /// The script
    script: PathBuf,
    /// Value of a parameter that the script asks for with `param(name, default)`
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    overrides: Vec<(String, String)>,
    /// Let the script read files below this folder, too (it may read those below its own)
    #[arg(long, value_name = "DIR")]
    allow_read: Vec<PathBuf>,
    /// Operations after which a script counts as endless (time spent in the solver does not count)
    #[arg(long, value_name = "N", default_value_t = MAX_OPERATIONS)]
    max_operations: u64,
}

fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => Ok((name.trim().to_string(), value.to_string())),
        _ => Err("write it as NAME=VALUE, such as --set dt=0.01".into()),
    }
}

/// Stack of the thread that runs scripts: deep recursion must end with a message, not with a crash.
const STACK: usize = 256 << 20;

/// Runs the command of this process's arguments.
pub fn main() -> ExitCode {
    let arguments = CommandLine::parse();
    // A defect is reported as a message of its own, not by the default hook.
    std::panic::set_hook(Box::new(|_| {}));
    let work = move || match arguments.command {
        Command::Run(arguments) => run::run(arguments),
        Command::Check(arguments) => check::check(arguments),
        Command::Test(arguments) => test::test(arguments),
        Command::Doc(arguments) => doc::doc(arguments),
        Command::New(arguments) => new::new(arguments),
        Command::Repl(arguments) => repl::repl(arguments),
    };
    match std::thread::Builder::new().name("script".into()).stack_size(STACK).spawn(work).map(|thread| thread.join()) {
        Ok(Ok(code)) => ExitCode::from(code),
        Ok(Err(_)) => {
            console::complain("error: the program has a defect and had to stop\n= hint: please report it together with the script\n");
            ExitCode::from(exit_code(Class::Internal))
        }
        Err(error) => {
            console::complain(&format!("error: no thread could be started\n= cause: {error}\n"));
            ExitCode::from(exit_code(Class::Internal))
        }
    }
}

/// The exit code of an error.
fn exit_code(class: Class) -> u8 {
    match class {
        Class::Check => 1,
        Class::Script => 2,
        Class::Numerics | Class::Internal => 3,
        Class::Interrupted => 130,
        Class::ResultUsed => 0,
    }
}
