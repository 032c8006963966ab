//! Length of files and functions; longer ones are listed with a reason.

use super::exceptions::LONG;
use super::source::{Source, program, sources};

/// Largest number of lines of a file, without its tests.
const FILE: usize = 500;

/// Largest number of lines of a function.
const FUNCTION: usize = 80;

/// Functions of a file with their lines.
fn functions(source: &Source) -> Vec<(String, usize)> {
    let mut functions = Vec::new();
    for index in 0..source.tokens.len() {
        let name = source.text_at(index + 1);
        if source.text_at(index) != "fn" || !name.starts_with(|letter: char| letter.is_alphabetic() || letter == '_') {
            continue;
        }
        let mut place = index + 2;
        let body = loop {
            match source.text_at(place) {
                "{" => break Some(source.closing(place)),
                ";" => break None,
                "(" | "[" => place = source.closing(place) + 1,
                _ if place >= source.tokens.len() => break None,
                _ => place += 1,
            }
        };
        if let Some(end) = body.and_then(|end| source.tokens.get(end)) {
            functions.push((name.to_string(), end.line - source.tokens[index].line + 1));
        }
    }
    functions
}

/// Files and functions above the limits, named as in the list of exceptions, with their lines.
fn too_long(sources: &[Source]) -> Vec<(String, String, usize)> {
    let mut found = Vec::new();
    for source in program(sources) {
        let tests = sources.iter().find(|other| other.path == source.path).map_or(0, |whole| whole.without_tests().1);
        let lines = source.text.lines().count() - tests;
        if lines > FILE {
            found.push((source.path.clone(), String::new(), lines));
        }
        let functions = functions(&source).into_iter().filter(|(_, lines)| *lines > FUNCTION);
        found.extend(functions.map(|(name, lines)| (source.path.clone(), name, lines)));
    }
    found
}

fn violations(sources: &[Source], exceptions: &[(&str, &str, &str)]) -> Vec<String> {
    let found = too_long(sources);
    let is_listed = |path: &str, name: &str| exceptions.iter().any(|(other, function, _)| *other == path && *function == name);
    let mut violations = Vec::new();
    for (path, name, lines) in &found {
        if !is_listed(path, name) {
            let limit = if name.is_empty() { FILE } else { FUNCTION };
            violations.push(format!("{path} {name}: {lines} lines, more than {limit}"));
        }
    }
    for (path, function, _) in exceptions {
        if !found.iter().any(|(other, name, _)| other == path && name == function) {
            violations.push(format!("{path} {function}: not too long; take it off the list in tests/architecture/exceptions.rs"));
        }
    }
    violations
}

#[test]
fn files_and_functions_can_be_read_at_once() {
    let sources = sources(&["src"]);
    assert!(sources.len() > 10, "the source was not found");
    let violations = violations(&sources, LONG);
    assert!(violations.is_empty(), "\n{}\n", violations.join("\n"));
}

#[test]
fn what_is_too_long_is_found() {
    let found = |text: &str, exceptions: &[(&str, &str, &str)]| violations(&[Source::new("src/mesh/a.rs", text)], exceptions).len();
    let function = |lines: usize| {
        format!(
            "impl X {{\n    pub fn long<T>(x: [u8; 2]) -> T\n    where\n        T: Y,\n    {{\n{}    }}\n}}\n",
            "f();\n".repeat(lines - 5)
        )
    };
    assert_eq!(found(&function(80), &[]), 0);
    assert_eq!(found(&function(81), &[]), 1);
    assert_eq!(found(&function(81), &[("src/mesh/a.rs", "long", "known")]), 0);
    assert_eq!(found(&function(80), &[("src/mesh/a.rs", "long", "known")]), 1);
    assert_eq!(found("trait X { fn f(); fn g() -> u8; }\ntype F = fn(u8);\n", &[]), 0);
    let file = "const X: u8 = 1;\n";
    let tests = format!("#[cfg(test)]\nmod tests {{\n{}}}\n", file.repeat(200));
    assert_eq!(found(&format!("{}{tests}", file.repeat(500)), &[]), 0);
    assert_eq!(found(&format!("{}{tests}", file.repeat(501)), &[]), 1);
    assert_eq!(found(&file.repeat(501), &[("src/mesh/a.rs", "", "known")]), 0);
    assert_eq!(found(&file.repeat(500), &[("src/mesh/a.rs", "", "known")]), 1);
}
