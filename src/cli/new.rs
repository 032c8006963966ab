//! `conserva new`: starts a scenario from a commented template.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::console::{Console, complain, ink};
use super::process::exit_code;
use crate::script::{Class, Diagnostic};

/// Arguments of `conserva new`.
#[derive(Args)]
pub struct Arguments {
    /// Name of the scenario; the script NAME.rhai is written
    name: PathBuf,
}

/// The template; `NAME` stands for the scenario's name.
const TEMPLATE: &str = include_str!("template.rhai");

/// Writes a new scenario; the exit code.
pub fn new(arguments: Arguments) -> u8 {
    let file = if arguments.name.extension().is_some_and(|ending| ending == "rhai") {
        arguments.name
    } else {
        let mut name = arguments.name.into_os_string();
        name.push(".rhai");
        PathBuf::from(name)
    };
    let name: String = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    // the name stands inside a string and a comment of the script
    let plain: String = name.chars().map(|letter| if letter.is_alphanumeric() || "-_. ".contains(letter) { letter } else { '_' }).collect();
    let text = TEMPLATE.replace("NAME", &plain);
    let written = std::fs::OpenOptions::new().write(true).create_new(true).open(&file).and_then(|mut file| file.write_all(text.as_bytes()));
    match written {
        Ok(()) => {
            let path = file.display().to_string();
            // what stands between backticks can be pasted into a shell
            let word = if path.contains(char::is_whitespace) { format!("\"{path}\"") } else { path.clone() };
            Console::new(true).say(&format!("{path} is written; `conserva run {word}` runs it, `conserva test {word}` tests it"));
            0
        }
        Err(error) => {
            let taken = error.kind() == std::io::ErrorKind::AlreadyExists;
            let title =
                if taken { format!("there already is a file {}", file.display()) } else { format!("{} cannot be written", file.display()) };
            let message = Diagnostic::error(Class::Script, title);
            let message = if taken { message } else { message.cause(error.to_string()) };
            complain(&message.hint("choose another name, in a folder that exists").render(ink()));
            exit_code(Class::Script)
        }
    }
}
