//! Floor 9 of `ARCHITECTURE.md`: the command line. Terminal, signals and exit codes are handled here; the language is in `script/`.

mod check;
mod columns;
mod complaint;
mod console;
mod deck_script;
mod diff;
mod doc;
mod drawn_files;
mod export;
mod info;
mod junit;
mod list;
mod live;
mod log;
mod lsp;
mod memory;
mod mesh_files;
mod new;
mod process;
mod ranks;
mod repl;
mod report;
mod resume;
mod run;
mod script_arguments;
mod signals;
mod sweep;
mod test;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::math::simd::is_supported;
use crate::script::{Class, Diagnostic};
use console::{judge, with_loss, write_out};
use process::{STACK, exit_code};

/// Message if the processor lacks instructions for which the program was compiled.
const UNSUPPORTED: &str = "error: this processor has no AVX2 and FMA, for which the program was compiled\n\
    = hint: compile it with `cargo build --release --locked --features portable`, for every x86-64 processor\n";

/// Contact dynamics that conserves energy and momentum, from scripts.
#[derive(Parser)]
#[command(name = "conserva", version, about, max_term_width = 100)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a script and write its results
    Run(run::Arguments),
    /// Continue an interrupted run, to the same results
    Resume(resume::Arguments),
    /// Run a script for many values of its parameters, and make a table of the results
    Sweep(Box<sweep::Arguments>),
    /// Build a script's models, and report their faults and what a run would do; takes no step
    Check(check::Arguments),
    /// Run every function `test_…` of scripts, and scenarios as tests of their own checks
    Test(test::Arguments),
    /// Show the reference of the language, or one entry of it
    Doc(doc::Arguments),
    /// Start a scenario from a commented template, or from a deck of Abaqus or CalculiX
    New(new::Arguments),
    /// List the runs below a folder: parameters, outcome, steps, energy drift
    List(list::Arguments),
    /// Describe a run, any of its files, a mesh file or a script
    Info(info::Arguments),
    /// Compare two runs: which columns and fields differ, from which step, by how much
    Diff(diff::Arguments),
    /// Show two to six runs side by side on one page: pictures, curves, what differs
    Report(report::Arguments),
    /// Convert a run's files to Parquet, CSV, plain VTU or XDMF
    Export(export::Arguments),
    /// Start a prompt, after running a script if one is given
    Repl(repl::Arguments),
    /// Serve an editor: messages while typing, completion, help, renaming (see docs/editor.md)
    Lsp(lsp::Arguments),
    /// Write the completion script of a shell for commands and options
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual page, or that of a command, for `man`
    Man {
        /// The command
        command: Option<String>,
    },
}

/// Writes the manual page of the program or of a command; returns the exit code.
fn manual(command: Option<&str>) -> u8 {
    let mut program = CommandLine::command();
    program.build();
    let page = match command {
        None => Some(program),
        Some(name) => program.find_subcommand(name).cloned(),
    };
    let Some(page) = page else {
        let error = Diagnostic::error(Class::Script, format!("there is no command `{}`", command.unwrap_or_default()));
        console::complain(&error.hint("`conserva help` lists all commands").render(console::ink()));
        return exit_code(Class::Script);
    };
    let mut text = Vec::new();
    // Writing to memory does not fail.
    let _ = clap_mangen::Man::new(page).render(&mut text);
    write_out(&String::from_utf8_lossy(&text));
    0
}

/// Reports wrong arguments, or shows the requested help; returns the exit code.
fn told(error: &clap::Error) -> u8 {
    let (written, code) = (error.print(), u8::try_from(error.exit_code()).unwrap_or(exit_code(Class::Script)));
    // A failed write to standard error cannot be reported.
    if error.use_stderr() {
        return code;
    }
    judge(written.and_then(|()| std::io::Write::flush(&mut std::io::stdout())));
    with_loss(code)
}

/// Runs the command of this process's arguments.
pub fn main() -> ExitCode {
    ExitCode::from(run_command(std::env::args_os()))
}

/// Runs the command of a program that is not this process's executable, such as a script of an interpreter; returns the exit code. Studies
/// start `program` for their points.
pub fn main_of(program: std::path::PathBuf, arguments: impl IntoIterator<Item = std::ffi::OsString>) -> u8 {
    process::set_program(program.clone());
    run_command(std::iter::once(program.into_os_string()).chain(arguments))
}

/// Runs the command of arguments, the first of which is the name of the program; returns the exit code.
fn run_command(arguments: impl IntoIterator<Item = std::ffi::OsString>) -> u8 {
    let arguments = match CommandLine::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        // Only the first process of an MPI job prints messages.
        Err(error) if ranks::is_served() => return u8::try_from(error.exit_code()).unwrap_or(exit_code(Class::Script)),
        Err(error) => return told(&error),
    };
    if !is_supported() {
        console::complain(UNSUPPORTED);
        return exit_code(Class::Internal);
    }
    // A defect is reported as a message of its own, not by the default hook.
    std::panic::set_hook(Box::new(|_| {}));
    let work = move || match arguments.command {
        Command::Run(arguments) => run::run(arguments),
        Command::Resume(arguments) => resume::resume(arguments),
        Command::Sweep(arguments) => sweep::sweep(*arguments),
        Command::Check(arguments) => check::check(arguments),
        Command::Test(arguments) => test::test(arguments),
        Command::Doc(arguments) => doc::doc(arguments),
        Command::New(arguments) => new::new(arguments),
        Command::List(arguments) => list::list(arguments),
        Command::Info(arguments) => info::info(arguments),
        Command::Diff(arguments) => diff::diff(arguments),
        Command::Report(arguments) => report::report(arguments),
        Command::Export(arguments) => export::export_run(arguments),
        Command::Repl(arguments) => repl::repl(arguments),
        Command::Lsp(arguments) => lsp::serve(arguments),
        Command::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut CommandLine::command(), "conserva", &mut text);
            write_out(&String::from_utf8_lossy(&text));
            0
        }
        Command::Man { command } => manual(command.as_deref()),
    };
    let ended = std::thread::Builder::new().name("script".into()).stack_size(STACK).spawn(work).map(|thread| thread.join());
    ranks::end();
    match ended {
        Ok(Ok(code)) => with_loss(code),
        Ok(Err(_)) => {
            console::complain("error: the program has a defect and had to stop\n= hint: please report it together with the script\n");
            exit_code(Class::Internal)
        }
        Err(error) => {
            console::complain(&format!("error: no thread could be started\n= cause: {error}\n"));
            exit_code(Class::Internal)
        }
    }
}
