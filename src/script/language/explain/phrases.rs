//! Words and types of the engine in terms of the language.

use crate::script::language::limits::{MAX_ARRAY, MAX_MAP, MAX_STRING};
use crate::script::language::sources::SourceSpan;
use crate::script::language::wording::with_article;

/// Names in order, each once.
pub(super) fn distinct<'a>(names: &[&'a str]) -> Vec<&'a str> {
    let mut names = names.to_vec();
    names.sort_unstable();
    names.dedup();
    names
}

/// Splits the engine's text of a call, such as `ring (map, i64)`, into name and types.
pub(super) fn split_signature(signature: &str) -> (&str, Vec<String>) {
    let Some((name, rest)) = signature.split_once(" (") else { return (signature.trim(), Vec::new()) };
    let types = rest.strip_suffix(')').unwrap_or(rest);
    let types = if types.is_empty() { Vec::new() } else { types.split(", ").map(short_type).collect() };
    (name.trim(), types)
}

/// Shortens the engine's name of a type to one word.
pub(super) fn short_type(name: &str) -> String {
    let name = name.trim();
    match name {
        "&str | ImmutableString | String" | "ImmutableString" | "&str" | "String" | "string" => "string".into(),
        "INT" | "i64" | "int" => "i64".into(),
        "FLOAT" | "f64" | "float" | "number" => "f64".into(),
        "Array" | "array" => "array".into(),
        "Map" | "map" => "map".into(),
        "FnPtr" | "Fn" => "Fn".into(),
        other => other.rsplit("::").next().unwrap_or(other).to_string(),
    }
}

/// True if a shortened type name is that of strings.
pub(super) fn is_string(name: &str) -> bool {
    name == "string"
}

/// Returns a type in terms of the language, with its article.
pub(super) fn type_phrase(name: &str) -> String {
    match short_type(name).as_str() {
        "string" => "a string".into(),
        "i64" => "a whole number".into(),
        "f64" => "a number with a fraction".into(),
        "bool" => "`true` or `false`".into(),
        "array" => "an array".into(),
        "map" => "a map".into(),
        "Fn" => "a closure".into(),
        "()" => "nothing, `()`".into(),
        "a boolean expression" => "`true` or `false`".into(),
        phrase if phrase.starts_with("a ") || phrase.starts_with("an ") => phrase.to_string(),
        "char" => "a character".into(),
        "Dynamic" | "?" | "_" | "any" | "T" | "" => "any value".into(),
        "Failure" => "an error".into(),
        other if other.starts_with("Range") || other.starts_with("ExclusiveRange") || other.starts_with("InclusiveRange") => {
            "a range".into()
        }
        other => with_article(other),
    }
}

/// Returns a hint how to convert a value of type `given` to `expected`.
pub(super) fn type_hint(expected: &str, given: &str) -> &'static str {
    match (short_type(expected).as_str(), short_type(given).as_str()) {
        ("bool" | "a boolean expression", _) => "compare, such as `x > 0`: a condition is `true` or `false`",
        ("i64", "f64") => "convert it: `x.to_int()`",
        ("f64", "i64") => "write it with a decimal point, such as `2.0`",
        _ => "convert the value, or use another",
    }
}

/// Returns a hint for a missing token.
pub(super) fn missing_hint(token: &str) -> String {
    match token {
        ";" => "write `;` after it".into(),
        ")" | "]" | "}" => format!("close the bracket with `{token}`"),
        "," => "separate the entries with `,`".into(),
        _ => format!("write `{token}`"),
    }
}

/// Returns a hint for an arithmetic error.
pub(super) fn arithmetic_hint(text: &str) -> &'static str {
    if text.contains("zero") {
        "check the divisor"
    } else if text.contains("overflow") || text.contains("Overflow") || text.contains("power") {
        "use numbers with a decimal point, such as `2.0`"
    } else {
        "check the numbers"
    }
}

/// Returns the kind of value that exceeded its size limit.
pub(super) fn size_subject(what: &str) -> &'static str {
    match what {
        text if text.contains("String") || text.contains("string") => "a string",
        text if text.contains("array") => "an array",
        text if text.contains("map") => "a map",
        _ => "a value",
    }
}

/// Returns the limit that was exceeded.
pub(super) fn size_limit(what: &str) -> String {
    match size_subject(what) {
        "a string" => format!("strings have at most {} characters", MAX_STRING),
        "an array" => format!("arrays have at most {} entries", MAX_ARRAY),
        "a map" => format!("maps have at most {} entries", MAX_MAP),
        _ => "there is a limit on the size of values".into(),
    }
}

/// Returns the description of a call in the chain of calls.
pub(super) fn call_title(name: &str, place: Option<&SourceSpan>) -> String {
    if !name.starts_with("anon$") {
        return format!("in the call of `{name}`");
    }
    let word = place.map(|place| &place.text[place.range.clone()]).unwrap_or("");
    match word {
        "" | "call" => "in the closure called here".into(),
        word => format!("in the closure given to `{word}`"),
    }
}

/// Count with its noun in singular or plural: `1 entry`, `2 entries`.
pub(super) fn count_of(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// Returns a text of the engine in lower case, without the places at its end.
pub(super) fn lower(text: &str) -> String {
    let text = text.lines().next().unwrap_or(text);
    let text = text.split(" (line ").next().unwrap_or(text);
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect())
}
