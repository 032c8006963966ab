//! `conserva new`: starts a scenario from a commented template, or from a deck of Abaqus or CalculiX.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::console::{Console, complain, ink};
use super::deck_script::script_of;
use super::process::exit_code;
use crate::mesh::{ReadOptions, below_folder_of, read_deck};
use crate::script::{Class, Diagnostic};

/// Arguments of `conserva new`.
#[derive(Args)]
pub struct Arguments {
    /// Name of the scenario; the script NAME.rhai is written
    #[arg(required_unless_present = "from")]
    name: Option<PathBuf>,
    /// An input file of Abaqus or CalculiX: the script has its bodies, materials, supports and contacts
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
}

/// Template of a scenario; `NAME` is replaced by the scenario's name.
const TEMPLATE: &str = include_str!("template.rhai");

/// Writes a new scenario; returns the exit code.
pub fn new(arguments: Arguments) -> u8 {
    let name = arguments.name.or_else(|| arguments.from.as_ref()?.file_stem().map(PathBuf::from)).unwrap_or_default();
    let file = if name.extension().is_some_and(|ending| ending == "rhai") {
        name
    } else {
        let mut name = name.into_os_string();
        name.push(".rhai");
        PathBuf::from(name)
    };
    let name: String = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    // the name is used in a string and a comment of the script
    let plain: String = name.chars().map(|letter| if letter.is_alphanumeric() || "-_. ".contains(letter) { letter } else { '_' }).collect();
    let text = match &arguments.from {
        None => TEMPLATE.replace("NAME", &plain),
        Some(deck) => match from_deck(deck, &file, &plain) {
            Ok(text) => text,
            Err(error) => {
                complain(&error.render(ink()));
                return exit_code(error.class);
            }
        },
    };
    let written = std::fs::OpenOptions::new().write(true).create_new(true).open(&file).and_then(|mut file| file.write_all(text.as_bytes()));
    match written {
        Ok(()) => {
            let path = file.display().to_string();
            // text in backticks can be pasted into a shell
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

/// Returns the script of a deck, to be written to the file `script`.
fn from_deck(path: &Path, script: &Path, name: &str) -> Result<String, Box<Diagnostic>> {
    let find = below_folder_of(path);
    let deck = read_deck(path, ReadOptions::default(), Some(&find)).map_err(|error| {
        let message = Diagnostic::error(Class::Script, format!("\"{}\": {error}", path.display())).code(error.code());
        let message = error.place().into_iter().fold(message, |message, place| message.cause(format!("it shows {place}")));
        Box::new(message.hint(error.hint()))
    })?;
    // a script refers to files below its own folder by relative paths
    let folder = script.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let below = match (path.canonicalize(), folder.canonicalize()) {
        (Ok(path), Ok(folder)) => path.strip_prefix(folder).map(Path::to_path_buf).ok(),
        _ => None,
    };
    let found = below.or_else(|| path.canonicalize().ok()).unwrap_or_else(|| path.to_path_buf());
    Ok(script_of(&deck, &found.to_string_lossy(), name))
}
