//! `conserva doc`: the reference of the language, from the registered functions.

use std::path::Path;
use std::rc::Rc;

use clap::{Args, ValueEnum};

use super::console::{Console, complain, ink};
use super::process::exit_code;
use crate::script::{Class, Diagnostic, Reference, Session, Settings, Silent, meant, missing, ranked};

/// Arguments of `conserva doc`.
#[derive(Args)]
pub struct Arguments {
    /// A function, method, word, topic or type, or the code of a message, such as C0504 [default: everything]
    name: Option<String>,
    /// List all entries that contain these words
    #[arg(long, value_name = "TEXT", conflicts_with = "name")]
    search: Option<String>,
    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Output format of the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Text for a terminal
    Text,
    /// Markdown, like docs/reference.md
    Markdown,
    /// JSON for programs
    Json,
    /// Definition file for the language server of Rhai (always everything)
    Definitions,
    /// TextMate grammar that colors scripts in an editor (always everything)
    Grammar,
}

/// Shows the reference; returns the exit code.
pub fn doc(arguments: Arguments) -> u8 {
    let session = match Session::new(Settings::default(), Path::new("."), Rc::new(Silent)) {
        Ok(session) => session,
        Err(error) => {
            complain(&error.render(ink()));
            return exit_code(error.class);
        }
    };
    let reference = Reference::new(&session.registry());
    if let Some(text) = &arguments.search {
        return search(&reference, text);
    }
    let entries = match arguments.name.as_deref().map(|name| (name, reference.find(name))) {
        None => None,
        Some((_, Ok(entries))) => Some(entries),
        Some((name, Err(suggestion))) => {
            let error = Diagnostic::error(Class::Script, format!("the reference has no entry `{name}`"));
            let suggestion = suggestion
                .unwrap_or_else(|| format!("`conserva doc --search \"{name}\"` searches all texts; `conserva doc` lists everything"));
            complain(&error.hint(suggestion).render(ink()));
            return exit_code(Class::Script);
        }
    };
    let text = match (arguments.format, entries) {
        (Format::Definitions, _) => session.definitions(),
        (Format::Grammar, _) => reference.grammar(),
        (Format::Text, None) => reference.overview(),
        (Format::Text, Some(entries)) => entries.iter().map(|entry| entry.text()).collect::<Vec<_>>().join("\n\n"),
        (Format::Markdown, None) => reference.markdown(),
        (Format::Markdown, Some(entries)) => entries.iter().map(|entry| reference.entry_markdown(entry)).collect(),
        (Format::Json, None) => reference.json(),
        (Format::Json, Some(entries)) => reference.entries_json(&entries),
    };
    Console::new(true).say(text.trim_end());
    0
}

/// Lists entries that mention a text; returns the exit code.
fn search(reference: &Reference, text: &str) -> u8 {
    let (found, meant) = (ranked(reference, text), meant(text));
    let console = Console::new(true);
    for (word, names) in &meant {
        let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        console.say(&format!("\"{word}\": see {}", names.join(", ")));
    }
    let missing = missing(text);
    missing.iter().for_each(|sentence| console.say(&format!("\"{text}\": {sentence}")));
    if found.is_empty() && meant.is_empty() && missing.is_none() {
        let error = Diagnostic::error(Class::Script, format!("nothing in the reference mentions \"{text}\""));
        complain(&error.hint("use fewer or other words; `conserva doc` lists everything").render(ink()));
        return exit_code(Class::Script);
    }
    found.iter().for_each(|entry| console.say(&entry.line()));
    0
}
