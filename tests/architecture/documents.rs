//! Documents: names in backticks exist (paths as files or folders, types as identifiers of the source), and cells of tables are short.

use std::collections::HashSet;
use std::path::Path;

use super::source::{repository, sources};

/// Documents of the structure.
const DOCUMENTS: [&str; 3] = ["ARCHITECTURE.md", "src/README.md", "CONTRIBUTING.md"];

/// Folders in which paths are looked for.
const FOLDERS: [&str; 9] = ["src", "tests", "examples", "benches", "docs", "scripts", "packages", "python", "editors"];

/// Largest number of words of a table cell; longer text is a section.
const CELL: usize = 40;

/// Places of table cells with more words.
fn long_cells(document: &str, text: &str) -> Vec<String> {
    let (mut is_code, mut found) = (false, Vec::new());
    for (index, line) in text.lines().enumerate() {
        is_code ^= line.starts_with("```");
        if is_code || !line.starts_with('|') {
            continue;
        }
        let words = |cell: &str| cell.split_whitespace().count();
        let cells = line.replace("\\|", " ");
        let longest = cells.split('|').map(words).max().unwrap_or(0);
        if longest > CELL {
            found.push(format!("{document}:{}: {longest} words in a cell, more than {CELL}", index + 1));
        }
    }
    found
}

#[test]
fn cells_of_tables_can_be_read_at_once() {
    let mut paths = vec![];
    add_paths(&repository().join("docs"), &mut paths);
    paths.extend(["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "examples/README.md"].map(String::from));
    // The reference is generated from the registry.
    paths.retain(|path| path.ends_with(".md") && path != "docs/reference.md");
    assert!(paths.len() > 20, "the documents were not found");
    let read = |path: &String| std::fs::read_to_string(repository().join(path)).expect("the document is there");
    let violations: Vec<String> = paths.iter().flat_map(|path| long_cells(path, &read(path))).collect();
    assert!(violations.is_empty(), "\n{}\n", violations.join("\n"));
}

#[test]
fn long_cells_are_found() {
    let row = format!("| a | {} |", "word ".repeat(CELL + 1));
    assert_eq!(long_cells("a.md", &row).len(), 1);
    assert!(long_cells("a.md", &format!("```\n{row}\n```")).is_empty());
    assert!(long_cells("a.md", &format!("| {} |", "word ".repeat(CELL))).is_empty());
}

/// Files and folders below a folder, from the repository.
fn add_paths(folder: &Path, paths: &mut Vec<String>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        let inner = path.strip_prefix(repository()).unwrap_or(&path);
        paths.push(inner.to_string_lossy().replace('\\', "/"));
        if path.is_dir() {
            add_paths(&path, paths);
        }
    }
}

/// Texts in single backticks outside of code blocks.
fn quoted(text: &str) -> Vec<&str> {
    let outside = text.split("```").step_by(2);
    outside.flat_map(|part| part.split('`').skip(1).step_by(2)).collect()
}

fn is_path(name: &str) -> bool {
    let is_plain = name.chars().all(|c| c.is_alphanumeric() || "_-./".contains(c));
    is_plain && (name.ends_with('/') || name.ends_with(".rs") || name.ends_with(".md") || name.ends_with(".rhai"))
}

fn is_type(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(char::is_uppercase)
        && letters.next().is_some_and(char::is_lowercase)
        && name.chars().all(|c| c.is_alphanumeric() || "_:".contains(c))
}

/// Names in a document that are neither paths nor identifiers of the source.
fn unknown(text: &str, paths: &[String], identifiers: &HashSet<String>) -> Vec<String> {
    let exists = |name: &str| paths.iter().any(|path| path == name || path.strip_suffix(name).is_some_and(|rest| rest.ends_with('/')));
    let is_unknown = |name: &&str| {
        if is_path(name) {
            return !exists(name.trim_end_matches('/'));
        }
        is_type(name) && name.split("::").any(|part| !identifiers.contains(part))
    };
    quoted(text).into_iter().filter(is_unknown).map(String::from).collect()
}

/// Largest number of words of the overview `ARCHITECTURE.md`.
const OVERVIEW: usize = 1200;

#[test]
fn the_overview_is_short() {
    let text = std::fs::read_to_string(repository().join("ARCHITECTURE.md")).expect("the document is there");
    let words = text.split_whitespace().count();
    assert!(words <= OVERVIEW, "ARCHITECTURE.md has {words} words, at most {OVERVIEW}: details belong into src/README.md");
}

#[test]
fn documents_of_the_structure_name_what_exists() {
    let mut paths: Vec<String> =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "THIRD-PARTY-LICENSES.md"].map(String::from).to_vec();
    paths.extend(FOLDERS.map(String::from));
    FOLDERS.iter().for_each(|folder| add_paths(&repository().join(folder), &mut paths));
    let sources = sources(&["src", "tests", "examples", "benches"]);
    let identifiers: HashSet<String> = sources.iter().flat_map(|source| source.tokens.iter().map(|token| token.text.clone())).collect();
    let violations: Vec<String> = DOCUMENTS
        .iter()
        .flat_map(|document| {
            let text = std::fs::read_to_string(repository().join(document)).expect("the document is there");
            unknown(&text, &paths, &identifiers).into_iter().map(move |name| format!("{document}: `{name}` does not exist"))
        })
        .collect();
    assert!(violations.is_empty(), "\n{}\n", violations.join("\n"));
}

#[test]
fn names_that_do_not_exist_are_found() {
    let (paths, identifiers) = (["src/mesh/cell.rs".to_string(), "src/mesh".into()], HashSet::from(["Cell".to_string()]));
    let found = |text: &str| unknown(text, &paths, &identifiers);
    assert!(found("`mesh/cell.rs`, `mesh/`, `Cell` and `x y`").is_empty());
    assert_eq!(found("`mesh/cells.rs` `esh/cell.rs` `Cells`"), ["mesh/cells.rs", "esh/cell.rs", "Cells"]);
    assert!(found("```\n`Cells`\n```").is_empty());
}
