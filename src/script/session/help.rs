//! `help`: descriptions of the functions of the language, in a script and at the prompt.
//!
//! The texts are those of the [reference](super::reference); only the overview, a list of names, is made here.

use super::pages::PAGES;
use super::ranking::{is_meant, ranked};
use super::reference::{Entry, Reference, TOPICS};
use super::synonyms::{meant, missing};
use crate::script::language::prelude::*;
use crate::script::language::registry::Registry;

/// Largest number of entries listed that mention an unknown name.
const MENTIONS: usize = 8;

/// Names of the topics.
pub fn topics() -> impl Iterator<Item = String> {
    TOPICS.iter().map(|(_, title)| title.to_lowercase())
}

/// Help on a topic, a function, a method (also written `object.method`), a word or a type; an overview without a name.
pub fn help(registry: &Registry, name: &str) -> String {
    let name = name.trim();
    if name.is_empty() {
        return overview(registry);
    }
    let reference = Reference::new(registry);
    let suggestion = match reference.find(name) {
        Ok(entries) => return found_text(&reference, name, &entries),
        Err(suggestion) => suggestion.unwrap_or_else(|| "`help()` lists the topics".into()),
    };
    let refusal = format!("there is no function, topic or type `{name}`");
    if let Some(sentence) = missing(name) {
        return format!("{refusal}; {sentence}");
    }
    let found = ranked(&reference, name);
    let listed = |entries: &[Entry]| entries.iter().take(MENTIONS).map(|entry| format!("\n  {}", entry.line())).collect::<String>();
    match found.as_slice() {
        [] => format!("{refusal}; {suggestion}"),
        // The best match is shown first and in full.
        [first, others @ ..] if is_meant(first, name) => {
            let others = if others.is_empty() { String::new() } else { format!("\n\nit is mentioned in{}", listed(others)) };
            format!("{refusal}; it is part of\n\n{}{others}", first.text())
        }
        all => format!("{refusal}; {suggestion}; it is mentioned in{}", listed(all)),
    }
}

/// Text of the entries of a name. If they only read values and the name is a term of the field, the best match of a search comes first.
fn found_text(reference: &Reference, name: &str, entries: &[Entry]) -> String {
    let text = entries.iter().map(Entry::text).collect::<Vec<_>>().join("\n\n");
    let reads = |entry: &Entry| matches!(entry, Entry::Function(function) if function.reads());
    let first = ranked(reference, name).into_iter().next().filter(|first| !reads(first));
    match first.filter(|_| entries.iter().all(reads) && !meant(name).is_empty()) {
        Some(first) => format!("{}\n\n`{name}` is a value, too\n\n{text}", first.text()),
        None => text,
    }
}

/// Members of a type.
pub fn of_type(registry: &Registry, type_name: &str) -> String {
    match Reference::new(registry).members(type_name) {
        Some(entry) => entry.text(),
        None => format!("{type_name} has no members"),
    }
}

fn overview(registry: &Registry) -> String {
    let mut lines = vec!["help(\"topic\") or ?name tells more.".to_string()];
    for (topic, title) in TOPICS {
        let mut names: Vec<&str> = registry.functions().iter().filter(|function| function.topic == topic).map(|f| f.name).collect();
        names.dedup();
        lines.push(format!("\n{}", title.to_lowercase()));
        lines.extend(wrapped(&names, 96).into_iter().map(|line| format!("  {line}")));
    }
    let pages: Vec<&str> = PAGES.iter().map(|page| page.names[0]).collect();
    lines.push(format!("\nthe language itself\n  {}", pages.join(", ")));
    lines.join("\n")
}

fn wrapped(names: &[&str], width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for (index, name) in names.iter().enumerate() {
        let comma = if index + 1 < names.len() { ", " } else { "" };
        let last = lines.len() - 1;
        if lines[last].len() + name.len() > width {
            lines.push(format!("{name}{comma}"));
        } else {
            lines[last] += &format!("{name}{comma}");
        }
    }
    lines
}

/// The function `help`.
pub fn functions() -> Vec<Function> {
    vec![
        function(Topic::Numbers, "help")
            .summary("prints what a topic, a function, a type or an object offers")
            .parameters(vec![Parameter::any("about", "the name of a topic, a function or a type, or an object").otherwise("all topics")])
            .example("help(\"run_to\");")
            .body(|call| {
                let argument = call.argument("about");
                let registry = Registry::of(call.host);
                let value = argument.value();
                let text = match value.clone().into_string() {
                    Ok(name) => help(&registry, &name),
                    Err(_) if !argument.is_given() => help(&registry, ""),
                    Err(_) => of_type(&registry, call.engine().map_type_name(value.type_name())),
                };
                call.host.observer.print(&text);
                Ok(Dynamic::UNIT)
            }),
    ]
}
