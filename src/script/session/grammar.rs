//! The language as a TextMate grammar for syntax highlighting in editors.

use serde_json::{Value, json};

use super::completion::KEYWORDS;
use super::reference::Reference;
use crate::script::language::function::{Form, Function};

/// Words that are neither functions nor control statements.
const CONSTANTS: [&str; 4] = ["true", "false", "PI", "this"];

impl Reference {
    /// Returns the grammar, with all functions of the language, as JSON.
    pub fn grammar(&self) -> String {
        let (functions, members): (Vec<&Function>, Vec<&Function>) =
            self.functions().iter().map(|function| &**function).partition(|function| function.form == Form::Function);
        let keywords: Vec<&str> =
            KEYWORDS.into_iter().filter(|word| !CONSTANTS.contains(word)).chain(["do", "until", "private", "export"]).collect();
        let pattern = |name: &str, matched: String| json!({ "name": format!("{name}.conserva"), "match": matched });
        let inside = |name: &str, begin: &str, end: &str, patterns: Value| {
            let name = format!("{name}.conserva");
            json!({ "name": name, "begin": begin, "end": end, "patterns": patterns })
        };
        let escaped = r#"\\(?:[trn\\"'0]|x[0-9a-fA-F]{2}|u[0-9a-fA-F]{4}|U[0-9a-fA-F]{8})"#;
        let escape = json!([{ "name": "constant.character.escape.conserva", "match": escaped }]);
        let code = json!([{
            "name": "meta.interpolation.conserva",
            "begin": r"\$\{",
            "end": r"\}",
            "beginCaptures": { "0": { "name": "punctuation.section.interpolation.begin.conserva" } },
            "endCaptures": { "0": { "name": "punctuation.section.interpolation.end.conserva" } },
            "patterns": [{ "include": "#braces" }, { "include": "$self" }],
        }]);
        let grammar = json!({
            "name": "Conserva",
            "scopeName": "source.conserva",
            "fileTypes": ["rhai"],
            "patterns": [
                pattern("comment.line.documentation", r"///.*$".into()),
                pattern("comment.line.double-slash", r"//.*$".into()),
                { "include": "#comment" },
                inside("string.quoted.double", "\"", "\"|$", escape),
                inside("string.interpolated", "`", "`", code),
                pattern("constant.character", r"'(?:\\.[^']*|[^'\\])'".into()),
                {
                    "match": r"\b(fn)\s+([A-Za-z_]\w*)",
                    "captures": { "1": { "name": "keyword.declaration.conserva" }, "2": { "name": "entity.name.function.conserva" } },
                },
                pattern("keyword.control", format!(r"(?<!\.)\b(?:{})\b(?!\s*:[^:])", keywords.join("|"))),
                pattern("constant.language", format!(r"(?<!\.)\b(?:{})\b(?!\s*:[^:])", CONSTANTS.join("|"))),
                pattern("constant.numeric", r"\b(?:0x[0-9a-fA-F_]+|0b[01_]+|0o[0-7_]+|\d[\d_]*(?:\.\d[\d_]*)?(?:[eE][+-]?\d+)?)".into()),
                pattern("variable.other.property", r"\b[A-Za-z_]\w*(?=\s*:[^:])".into()),
                pattern("support.function", format!(r"(?<!\.)\b(?:{})(?=\s*\()", names(&functions))),
                pattern("support.function.member", format!(r"(?<=\.)(?:{})\b", names(&members))),
                pattern("entity.name.function.call", r"\b[A-Za-z_]\w*(?=\s*\()".into()),
                pattern("keyword.operator", r"\*\*=?|=>|\.\.=?|\?\?|&&|\|\||[-+*/%=!<>]=?|[|&^!]".into()),
            ],
            "repository": {
                "comment": inside("comment.block", r"/\*", r"\*/", json!([{ "include": "#comment" }])),
                "braces": { "begin": r"\{", "end": r"\}", "patterns": [{ "include": "#braces" }, { "include": "$self" }] },
            },
        });
        let mut text = serde_json::to_string_pretty(&grammar).unwrap_or_default();
        text.push('\n');
        text
    }
}

/// Names as alternatives, longer ones first, so that no name is matched by a prefix.
fn names(functions: &[&Function]) -> String {
    let mut names: Vec<&str> =
        functions.iter().map(|function| function.name).filter(|name| name.starts_with(|first: char| first.is_alphabetic())).collect();
    names.sort_by(|a, b| b.len().cmp(&a.len()).then(a.cmp(b)));
    names.dedup();
    names.join("|")
}
