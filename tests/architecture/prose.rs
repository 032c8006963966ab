//! Documentation comments begin with a noun or a verb that says what an item is, not with a word that refers to the lines around.

use super::source::{Source, sources};

/// Openings of a comment that refer to other lines.
const OPENINGS: [&str; 7] = ["The same", "What", "Whether", "How", "Its", "Those", "Of"];

/// Lines of documentation comments with an opening of [`OPENINGS`], with their places.
fn found(source: &Source) -> Vec<String> {
    let opens =
        |text: &str| OPENINGS.iter().any(|opening| text.strip_prefix(opening).is_some_and(|rest| !rest.starts_with(char::is_alphanumeric)));
    let lines = source.text.lines().enumerate().filter(|(_, line)| line.trim_start().strip_prefix("/// ").is_some_and(opens));
    lines.map(|(index, line)| format!("{}:{}: {}", source.path, index + 1, line.trim())).collect()
}

#[test]
fn comments_begin_with_a_noun() {
    let found: Vec<String> = sources(&["src"]).iter().flat_map(found).collect();
    assert!(found.is_empty(), "comments open with one of {OPENINGS:?}:\n{}", found.join("\n"));
}

#[test]
fn openings_are_found() {
    let count = |text: &str| found(&Source::new("src/mesh/a.rs", text)).len();
    assert_eq!(count("/// What is there.\nfn f() {}"), 1);
    assert_eq!(count("    /// Whether so.\nfn f() {}"), 1);
    assert_eq!(count("/// Offset of a node.\n/// Whatever.\n// What.\nfn f() {}"), 0);
}
