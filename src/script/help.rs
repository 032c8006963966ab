//! `help`: what the functions of the language say about themselves, as text for a terminal.
//!
//! Everything comes from the descriptions in the registry, so that help, argument checks and errors cannot disagree.

use rhai::Dynamic;

use super::arguments::Arguments;
use super::failure::did_you_mean;
use super::registry::{Absent, Form, Function, Kind, Parameter, Registry, Topic, body};

/// Topics in the order of the reference, with their names.
const TOPICS: [(Topic, &str); 10] = [
    (Topic::Meshes, "meshes"),
    (Topic::Materials, "materials"),
    (Topic::Model, "model"),
    (Topic::TimeFunctions, "time functions"),
    (Topic::Contact, "contact"),
    (Topic::Simulation, "simulation"),
    (Topic::Results, "results"),
    (Topic::Checks, "checks"),
    (Topic::Parameters, "parameters"),
    (Topic::Numbers, "numbers"),
];

/// Names of the topics.
pub fn topics() -> impl Iterator<Item = &'static str> {
    TOPICS.iter().map(|(_, name)| *name)
}

/// Help on a topic, a function, a method (also written `object.method`) or a type; an overview without a name.
pub fn help(registry: &Registry, name: &str) -> String {
    let name = name.trim().trim_end_matches("()").trim();
    if name.is_empty() {
        return overview(registry);
    }
    let last = name.rsplit('.').next().unwrap_or(name);
    let found: Vec<String> = registry.named(last).map(|function| describe(function)).collect();
    let topic = TOPICS.iter().find(|(_, title)| *title == name.to_lowercase());
    let of_topic = topic.map(|(topic, title)| of_topic(registry, *topic, title));
    if !found.is_empty() || of_topic.is_some() {
        return found.into_iter().chain(of_topic).collect::<Vec<_>>().join("\n\n");
    }
    let type_name = registry.types().iter().find(|known| known.to_lowercase() == last.to_lowercase());
    if let Some(type_name) = type_name {
        return of_type(registry, type_name);
    }
    let known = registry.functions().iter().map(|function| function.name).chain(topics()).chain(registry.types().iter().copied());
    let suggestion = did_you_mean(last, known).unwrap_or_else(|| "`help()` lists the topics".into());
    format!("there is no function, topic or type `{name}`; {suggestion}")
}

/// Members of a type.
pub fn of_type(registry: &Registry, type_name: &str) -> String {
    let rows: Vec<(String, &str)> = registry.members(type_name).map(|function| (function.signature(), function.summary)).collect();
    if rows.is_empty() { format!("{type_name} has no members") } else { format!("{type_name}\n{}", listing(&rows)) }
}

fn overview(registry: &Registry) -> String {
    let mut lines = vec!["help(\"topic\") or ?name tells more.".to_string()];
    for (topic, title) in TOPICS {
        let mut names: Vec<&str> = registry.functions().iter().filter(|function| function.topic == topic).map(|f| f.name).collect();
        names.dedup();
        lines.push(format!("\n{title}"));
        lines.extend(wrapped(&names, 96).into_iter().map(|line| format!("  {line}")));
    }
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

fn of_topic(registry: &Registry, topic: Topic, title: &str) -> String {
    let functions = registry.functions().iter().filter(|function| function.topic == topic);
    let rows: Vec<(String, &str)> = functions.map(|function| (function.signature(), function.summary)).collect();
    format!("{title}\n{}", listing(&rows))
}

fn listing(rows: &[(String, &str)]) -> String {
    rows.iter().map(|(signature, summary)| format!("  {signature}\n      {summary}")).collect::<Vec<_>>().join("\n")
}

/// One function in full: signature, sentence, parameters with dimension, range and default, example, see also.
pub fn describe(function: &Function) -> String {
    let value = match (function.returns, function.form) {
        ("", _) => String::new(),
        (returns, _) => format!("  ->  {returns}"),
    };
    let mut lines = vec![format!("{}{value}", function.signature()), format!("  {}", function.summary)];
    for parameter in &function.parameters {
        if function.parameters.len() > 1 || !matches!(parameter.kind, Kind::Options(_)) {
            lines.push(parameter_line(parameter, "  "));
        }
        if let Kind::Options(keys) = &parameter.kind {
            lines.extend(keys.iter().map(|key| parameter_line(key, "    ")));
        }
    }
    lines.push("  example".into());
    lines.extend(function.example.lines().map(|line| format!("    {}", line.trim_end())));
    if !function.see_also.is_empty() {
        lines.push(format!("  see also {}", function.see_also.join(", ")));
    }
    lines.join("\n")
}

fn parameter_line(parameter: &Parameter, indent: &str) -> String {
    let absent = match parameter.absent {
        Absent::Refused => String::new(),
        absent => format!("; without it: {absent}"),
    };
    format!("{indent}{}: {}, {}{absent}", parameter.name, parameter.summary, parameter.requirement())
}

/// The function `help`.
pub fn functions() -> Vec<Function> {
    vec![Function {
        name: "help",
        form: Form::Function,
        topic: Topic::Numbers,
        summary: "prints what a topic, a function, a type or an object offers",
        parameters: vec![
            Parameter::new("about", Kind::Any, "the name of a topic, a function or a type, or an object").or(Absent::Means("all topics")),
        ],
        returns: "",
        example: "help(\"run_to\");".into(),
        see_also: &[],
        body: body(|call| {
            let argument = call.argument("about");
            let registry = call.host.registry.borrow();
            let value = argument.value();
            let text = match value.clone().into_string() {
                Ok(name) => help(&registry, &name),
                Err(_) if !argument.is_given() => help(&registry, ""),
                Err(_) => of_type(&registry, call.engine().map_type_name(value.type_name())),
            };
            call.host.observer.print(&text);
            Ok(Dynamic::UNIT)
        }),
    }]
}
