//! The reference of the language, from the registered functions and the catalogues, as text, Markdown or JSON.
//!
//! Functions are described only in the registry: summary, parameters, example and related functions. Words other than functions (update
//! rules, cell kinds, fields, columns of the history, keys of `summary.json`, findings) are described in their catalogues.

use std::fmt::Write;
use std::rc::Rc;

use serde_json::{Value, json};

use super::codes::{Explanation, explanation, explanations};
use super::pages::{PAGES, Page, page};
use super::words::{Word, words};
use crate::materials;
use crate::math::catalogue::Interval;
use crate::script::language::function::{Form, Function, Topic};
use crate::script::language::parameter::{Absent, Kind, Parameter};
use crate::script::language::registry::Registry;
use crate::script::language::wording::{did_you_mean, listed, with_article};

/// Topics in the order of the reference, with their titles.
pub const TOPICS: [(Topic, &str); 12] = [
    (Topic::Meshes, "Meshes"),
    (Topic::Materials, "Materials"),
    (Topic::Model, "Model"),
    (Topic::TimeFunctions, "Time functions"),
    (Topic::Contact, "Contact"),
    (Topic::Simulation, "Simulation"),
    (Topic::Results, "Results"),
    (Topic::Checks, "Checks"),
    (Topic::Studies, "Studies"),
    (Topic::Parameters, "Parameters"),
    (Topic::Numbers, "Numbers and text"),
    (Topic::Arrays, "Arrays"),
];

/// Entry of the reference.
#[derive(Clone)]
pub enum Entry {
    /// A function, method or property.
    Function(Rc<Function>),
    /// A word that is no function.
    Word(Word),
    /// A page on the language itself.
    Page(&'static Page),
    /// A code of messages.
    Code(Explanation),
    /// A topic with its functions.
    Topic(&'static str, Vec<Rc<Function>>),
    /// A type with its members.
    Type(&'static str, Vec<Rc<Function>>),
}

/// The reference.
pub struct Reference {
    functions: Vec<Rc<Function>>,
    words: Vec<Word>,
}

impl Reference {
    /// The reference of the functions of a registry.
    pub fn new(registry: &Registry) -> Self {
        Reference { functions: registry.functions().to_vec(), words: words() }
    }

    /// All words that are no functions.
    pub fn words(&self) -> &[Word] {
        &self.words
    }

    /// All functions.
    pub(super) fn functions(&self) -> &[Rc<Function>] {
        &self.functions
    }

    fn of_topic(&self, topic: Topic) -> Vec<Rc<Function>> {
        self.functions.iter().filter(|function| function.topic == topic).cloned().collect()
    }

    fn types(&self) -> Vec<&'static str> {
        let mut names: Vec<&str> = self.functions.iter().filter_map(|function| function.form.receiver()).map(|of| of.name).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// Returns a type with its members, if it has any.
    pub fn members(&self, type_name: &str) -> Option<Entry> {
        let name = self.types().into_iter().find(|known| *known == type_name)?;
        let members = self.functions.iter().filter(|function| function.form.receiver().is_some_and(|receiver| receiver.name == name));
        Some(Entry::Type(name, members.cloned().collect()))
    }

    /// Returns all entries with a name: functions (also written `Type.name`, `object.name` or `name()`), words, a topic, a type.
    ///
    /// # Errors
    /// No entry of that name; with a suggestion if a name is similar.
    pub fn find(&self, name: &str) -> Result<Vec<Entry>, Option<String>> {
        let wanted = name.trim().trim_end_matches("()").trim_end();
        match explanation(wanted) {
            None => {}
            Some(Ok(known)) => return Ok(vec![Entry::Code(known)]),
            Some(Err(near)) => return Err(Some(format!("no message has this code; the nearest is `{near}`"))),
        }
        let (owner, last) = wanted.rsplit_once('.').map_or((None, wanted), |(owner, last)| (Some(owner.to_lowercase()), last));
        let mut functions: Vec<&Rc<Function>> = self.functions.iter().filter(|function| function.name == last).collect();
        // An owner that is no type is the name of an object, which may be of any type.
        let is_owned = |function: &Function| function.form.receiver().is_some_and(|of| Some(of.name.to_lowercase()) == owner);
        if functions.iter().any(|function| is_owned(function)) {
            functions.retain(|function| is_owned(function));
        }
        let mut found: Vec<Entry> = functions.into_iter().cloned().map(Entry::Function).collect();
        found.extend(self.words.iter().filter(|word| word.name == wanted).cloned().map(Entry::Word));
        found.extend(page(wanted).map(Entry::Page));
        let lower = wanted.to_lowercase();
        let alone = found.is_empty();
        let of_title = |title: &str| title == lower || (alone && title.starts_with(&format!("{lower} ")));
        for (topic, title) in TOPICS.iter().filter(|(_, title)| of_title(&title.to_lowercase())) {
            found.push(Entry::Topic(title, self.of_topic(*topic)));
        }
        let type_name = self.types().into_iter().find(|name| *name == wanted || (alone && name.to_lowercase() == lower));
        found.extend(type_name.and_then(|name| self.members(name)));
        if !found.is_empty() {
            return Ok(found);
        }
        let pages = PAGES.iter().flat_map(|page| page.names.iter().copied());
        let names = self.functions.iter().map(|function| function.name).chain(pages).chain(self.words.iter().map(|word| word.name));
        let names = names.chain(TOPICS.iter().map(|(_, title)| *title)).chain(self.types());
        let names: Vec<&str> = names.collect();
        let mut longer: Vec<&str> = names.iter().copied().filter(|name| begins(name, &last.to_lowercase())).collect();
        longer.sort_unstable();
        longer.dedup();
        longer.truncate(LONGER);
        if longer.is_empty() { Err(did_you_mean(last, names)) } else { Err(Some(format!("did you mean {}?", listed(&longer, "or")))) }
    }

    /// Returns all entries whose name or text has all words of a text.
    pub fn search(&self, text: &str) -> Vec<Entry> {
        let wanted: Vec<String> = text.to_lowercase().split_whitespace().map(Into::into).collect();
        let has_all = |text: String| !wanted.is_empty() && wanted.iter().all(|word| text.contains(word.as_str()));
        let of_function = |function: &&Rc<Function>| has_all(function_text(function).to_lowercase());
        let pages = PAGES.iter().filter(|page| has_all(format!("{} {} {}", page.names.join(" "), page.title, page.about).to_lowercase()));
        let functions = self.functions.iter().filter(of_function).cloned().map(Entry::Function);
        let words = self.words.iter().filter(|word| has_all(format!("{} {} {}", word.name, word.group, word.summary).to_lowercase()));
        let codes = explanations().filter(|code| has_all(format!("{} {} {}", code.code, code.title, code.text).to_lowercase()));
        functions.chain(pages.map(Entry::Page)).chain(words.cloned().map(Entry::Word)).chain(codes.map(Entry::Code)).collect()
    }

    /// Returns the list of functions and words by topic, one per line.
    pub(crate) fn overview(&self) -> String {
        let mut text = String::new();
        for (topic, title) in TOPICS {
            let _ = writeln!(text, "{title}\n{}\n", listing(&self.of_topic(topic)));
        }
        for (group, words) in self.groups() {
            let rows: Vec<String> = words.iter().map(|word| format!("  {}\n      {}", word.name, word.summary)).collect();
            let _ = writeln!(text, "{}\n{}\n", plural(group), rows.join("\n"));
        }
        let pages: Vec<&str> = PAGES.iter().map(|page| page.names[0]).collect();
        let _ = writeln!(text, "The language itself\n  {}\n", pages.join(", "));
        text.push_str(
            "`conserva doc NAME` tells more of a function, word, topic or type, or of the code of a message; `conserva doc --search TEXT` \
             searches everything\n",
        );
        text
    }

    fn groups(&self) -> Vec<(&'static str, Vec<&Word>)> {
        let mut groups: Vec<(&str, Vec<&Word>)> = Vec::new();
        for word in &self.words {
            match groups.last_mut().filter(|(group, _)| *group == word.group) {
                Some((_, words)) => words.push(word),
                None => groups.push((word.group, vec![word])),
            }
        }
        groups
    }

    /// The page `docs/reference.md`.
    pub fn markdown(&self) -> String {
        let mut page = String::from(
            "# Reference\n\nEvery function of the language, from the descriptions it is registered with. This page is written by\n\
             `conserva doc --format markdown`; a test fails when it is not current, and another one runs every example.\n\n\
             `name?` may be left out. Dimensions stand in brackets; any consistent set of units will do. `any`\n\
             depends on what the number is used for.\n\n",
        );
        for (topic, title) in TOPICS {
            let entries: Vec<String> = self.of_topic(topic).iter().map(|function| linked(&heading(function))).collect();
            let _ = writeln!(page, "- **{}**: {}", linked(title), entries.join(", "));
        }
        let pages: Vec<String> = PAGES.iter().map(|page| linked(&page.heading())).collect();
        let _ = writeln!(page, "- **{}**: {}", linked(LANGUAGE), pages.join(", "));
        let groups: Vec<String> = self.groups().into_iter().map(|(group, _)| linked(&plural(group))).collect();
        let _ = writeln!(page, "- **{}**: {}\n", linked(WORDS), groups.join(", "));
        for (topic, title) in TOPICS {
            let _ = writeln!(page, "## {title}\n");
            for function in self.of_topic(topic) {
                page.push_str(&self.function_markdown(&function));
            }
        }
        let _ = writeln!(page, "## {LANGUAGE}\n");
        PAGES.iter().for_each(|entry| page.push_str(&entry.markdown()));
        let _ = writeln!(page, "## {WORDS}\n");
        for (group, words) in self.groups() {
            let _ = writeln!(page, "### {}\n\n| name | is |\n|---|---|", plural(group));
            for word in words {
                let _ = writeln!(page, "| `{}` | {} |", word.name, cell(&word.summary));
            }
            page.push('\n');
        }
        page.truncate(page.trim_end().len());
        page.push('\n');
        page
    }

    /// Returns an entry in Markdown.
    pub(crate) fn entry_markdown(&self, entry: &Entry) -> String {
        match entry {
            Entry::Function(function) => self.function_markdown(function),
            Entry::Page(page) => page.markdown(),
            Entry::Code(code) => code.markdown(),
            Entry::Word(word) => format!("### {}\n\n{} ({}).\n", word.name, sentence(&word.summary), word.group),
            Entry::Topic(title, functions) | Entry::Type(title, functions) => {
                let all: Vec<String> = functions.iter().map(|function| self.function_markdown(function)).collect();
                format!("## {title}\n\n{}", all.concat())
            }
        }
    }

    fn function_markdown(&self, function: &Function) -> String {
        let mut text = format!("### {}\n\n`{}`", heading(function), function.signature());
        if !function.returns.is_empty() {
            let _ = write!(text, " gives {}", with_article(function.returns));
        }
        let _ = writeln!(text, "\n\n{}.\n", sentence(function.summary));
        if let Some(formula) = formula(function) {
            let _ = writeln!(text, "{formula}\n");
        }
        let rows = parameters(function);
        if !rows.is_empty() {
            text.push_str("| parameter | what it is | takes | default |\n|---|---|---|---|\n");
            for (name, parameter) in rows {
                let absent = match parameter.absent {
                    Absent::Refused => "required".into(),
                    Absent::Means(words) => words.to_string(),
                    absent => format!("`{absent}`"),
                };
                let _ = writeln!(text, "| `{name}` | {} | {} | {} |", cell(parameter.summary), cell(&takes(parameter)), cell(&absent));
            }
            text.push('\n');
        }
        let _ = writeln!(text, "```rhai\n{}\n```\n", function.example);
        let links: Vec<String> = function.see_also.iter().map(|name| self.link(name)).collect();
        if !links.is_empty() {
            let _ = writeln!(text, "See also {}.\n", links.join(", "));
        }
        text
    }

    fn link(&self, name: &str) -> String {
        match self.functions.iter().find(|function| function.name == name) {
            Some(function) => format!("[{name}](#{})", anchor(&heading(function))),
            None => name.to_string(),
        }
    }

    /// Returns the whole reference as JSON.
    pub fn json(&self) -> String {
        let functions: Vec<Value> = self.functions.iter().map(|function| function_json(function)).collect();
        let words: Vec<Value> = self.words.iter().map(word_json).collect();
        let pages: Vec<Value> = PAGES.iter().map(Page::json).collect();
        pretty(&json!({ "version": env!("CARGO_PKG_VERSION"), "functions": functions, "words": words, "pages": pages }))
    }

    /// Some entries as JSON.
    pub(crate) fn entries_json(&self, entries: &[Entry]) -> String {
        let values: Vec<Value> = entries
            .iter()
            .flat_map(|entry| match entry {
                Entry::Function(function) => vec![function_json(function)],
                Entry::Page(page) => vec![page.json()],
                Entry::Code(code) => vec![code.json()],
                Entry::Word(word) => vec![word_json(word)],
                Entry::Topic(_, functions) | Entry::Type(_, functions) => {
                    functions.iter().map(|function| function_json(function)).collect()
                }
            })
            .collect();
        pretty(&Value::Array(values))
    }
}

impl Entry {
    /// Returns name and first sentence in one line.
    pub fn line(&self) -> String {
        match self {
            Entry::Function(function) => format!("{}: {}", heading(function), function.summary),
            Entry::Page(page) => format!("{}: a page on {}", page.names[0], page.title),
            Entry::Word(word) => format!("\"{}\", {}: {}", word.name, word.group, word.summary),
            Entry::Code(code) => format!("{}: {}", code.code, code.title),
            Entry::Topic(title, _) | Entry::Type(title, _) => (*title).to_string(),
        }
    }

    /// The entry as text for a terminal.
    pub fn text(&self) -> String {
        match self {
            Entry::Function(function) => function_text(function),
            Entry::Page(page) => page.text(),
            Entry::Code(code) => code.terminal(),
            Entry::Word(word) => format!("\"{}\", {}\n  {}", word.name, word.group, word.summary),
            Entry::Topic(title, functions) | Entry::Type(title, functions) => format!("{title}\n{}", listing(functions)),
        }
    }
}

fn listing(functions: &[Rc<Function>]) -> String {
    functions.iter().map(|function| format!("  {}\n      {}", function.signature(), function.summary)).collect::<Vec<_>>().join("\n")
}

fn function_text(function: &Function) -> String {
    let value = if function.returns.is_empty() { String::new() } else { format!("  ->  {}", function.returns) };
    let mut lines = vec![format!("{}{value}", function.signature()), format!("  {}", function.summary)];
    lines.extend(formula(function).map(|formula| format!("  {formula}")));
    for (name, parameter) in parameters(function) {
        let absent = if parameter.is_optional() { format!("; default: {}", parameter.absent) } else { String::new() };
        lines.push(format!("  {name}: {}; {}{absent}", parameter.summary, takes(parameter)));
    }
    lines.push("  example:".into());
    lines.extend(function.example.lines().map(|line| format!("    {}", line.trim_end())));
    if !function.see_also.is_empty() {
        lines.push(format!("  see also: {}", function.see_also.join(", ")));
    }
    lines.join("\n")
}

/// Returns the parameters, with the keys of options after their map, each under its full name.
fn parameters(function: &Function) -> Vec<(String, &Parameter)> {
    fn keys<'a>(of: &'a Parameter, prefix: &str, rows: &mut Vec<(String, &'a Parameter)>) {
        if let Some(inner) = of.kind.keys() {
            for key in inner {
                rows.push((format!("{prefix}{}", key.name), key));
                keys(key, &format!("{prefix}{}.", key.name), rows);
            }
        }
    }
    let mut rows = Vec::new();
    for parameter in &function.parameters {
        // an options map that is the only parameter needs no row of its own
        if function.parameters.len() > 1 || parameter.kind.keys().is_none() {
            rows.push((parameter.name.to_string(), parameter));
        }
        keys(parameter, "", &mut rows);
    }
    rows
}

/// Accepted values of a parameter: kind, range and dimension.
fn takes(parameter: &Parameter) -> String {
    let ranged = matches!(parameter.kind, Kind::Number | Kind::Integer);
    let each = if !ranged && parameter.range != Interval::Finite { format!(", each {}", parameter.range) } else { String::new() };
    let dimension = if parameter.dimension.is_empty() || parameter.requirement().ends_with(']') {
        String::new()
    } else {
        format!(" [{}]", parameter.dimension)
    };
    format!("{}{each}{dimension}", parameter.requirement())
}

/// Heading of a function: its name, of a method with its type, such as `ring` or `Model.add_body`.
fn heading(function: &Function) -> String {
    match (function.form, function.form.receiver()) {
        (Form::Column(_), Some(receiver)) => format!("{}[{}]", receiver.name, function.name),
        (_, Some(receiver)) => format!("{}.{}", receiver.name, function.name),
        (_, None) => function.name.to_string(),
    }
}

fn formula(function: &Function) -> Option<&'static str> {
    let row =
        materials::CATALOGUE.iter().chain(materials::LINEAR).find(|row| function.topic == Topic::Materials && row.name == function.name);
    row.map(|row| row.formula)
}

/// Capitalizes the first letter.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

fn plural(group: &str) -> String {
    let (first, rest) = group.split_once(' ').map_or((group, String::new()), |(first, rest)| (first, format!(" {rest}")));
    let text = match group {
        "cell kind" => "cell kinds".to_string(),
        "update rule of a contact pair" => "update rules of a contact pair".into(),
        "key of summary.json" => "keys of `summary.json`".into(),
        _ => format!("{first}s{rest}"),
    };
    sentence(&text)
}

/// Escapes a text for a cell of a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn parameter_json(parameter: &Parameter) -> Value {
    let keys: Vec<Value> = parameter.kind.keys().into_iter().flatten().map(parameter_json).collect();
    let default = match parameter.absent {
        Absent::Refused => Value::Null,
        Absent::Number(value) => json!(value),
        Absent::Integer(value) => json!(value),
        Absent::Flag(value) => json!(value),
        Absent::Text(value) => json!(value),
        Absent::Means(words) => json!({ "means": words }),
    };
    json!({
        "name": parameter.name,
        "kind": parameter.kind.word(),
        "summary": parameter.summary,
        "dimension": parameter.dimension,
        "range": if parameter.range == Interval::Finite { Value::Null } else { json!(parameter.range.to_string()) },
        "required": !parameter.is_optional(),
        "default": default,
        "choices": match &parameter.kind { Kind::Choice(words) => json!(words), _ => Value::Null },
        "keys": keys,
    })
}

fn function_json(function: &Function) -> Value {
    let form = match function.form {
        Form::Function => "function",
        Form::Method(_) => "method",
        Form::Property(_) => "property",
        Form::Column(_) => "column",
    };
    let topic = TOPICS.iter().find(|(topic, _)| *topic == function.topic).map_or("", |(_, title)| title);
    json!({
        "name": function.name,
        "form": form,
        "of": function.form.receiver().map(|receiver| receiver.name),
        "topic": topic,
        "signature": function.signature(),
        "summary": function.summary,
        "parameters": function.parameters.iter().map(parameter_json).collect::<Vec<_>>(),
        "returns": function.returns,
        "example": function.example,
        "see_also": function.see_also,
    })
}

fn word_json(word: &Word) -> Value {
    json!({ "name": word.name, "form": "word", "group": word.group, "summary": word.summary })
}

fn pretty(value: &Value) -> String {
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}

/// Largest number of names suggested for an unknown one that is their beginning.
const LONGER: usize = 6;
/// Smallest number of letters of an unknown name for which longer names are suggested.
const BEGINNING: usize = 3;

/// True if a name begins with `with` (at least `BEGINNING` bytes), in lower case.
fn begins(name: &str, with: &str) -> bool {
    with.len() >= BEGINNING && name.to_lowercase().starts_with(with)
}

/// Titles of the last two chapters.
const LANGUAGE: &str = "The language itself";
const WORDS: &str = "Words";

/// Returns the anchor of a Markdown heading.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().chars().filter(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | ' ')).collect::<String>();
    kept.replace(' ', "-")
}

fn linked(heading: &str) -> String {
    format!("[{heading}](#{})", anchor(heading))
}
