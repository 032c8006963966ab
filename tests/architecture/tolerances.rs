//! Small numbers have a name and a reason in `src/math/tolerances.rs`; others are listed with a reason.

use super::exceptions::SMALL_NUMBERS;
use super::source::{Source, program, sources};

/// File or folder of the tolerances.
const HOME: &str = "src/math/tolerances";

/// Numbers with a negative power of ten, with their lines.
fn small_numbers(source: &Source) -> Vec<(String, usize)> {
    let is_small = |literal: &str| literal.starts_with(|first: char| first.is_ascii_digit()) && literal.to_lowercase().contains("e-");
    source.tokens.iter().filter(|token| is_small(&token.literal)).map(|token| (token.literal.clone(), token.line)).collect()
}

fn violations(sources: &[Source], exceptions: &[(&str, &str, &str)]) -> Vec<String> {
    let mut violations = Vec::new();
    let mut used = vec![false; exceptions.len()];
    for source in program(sources).iter().filter(|source| !source.path.starts_with(HOME)) {
        for (literal, line) in small_numbers(source) {
            match exceptions.iter().position(|(path, number, _)| *path == source.path && *number == literal) {
                Some(index) => used[index] = true,
                None => violations.push(format!("{}:{line}: {literal} has no name in {HOME}", source.path)),
            }
        }
    }
    let unused = exceptions.iter().zip(used).filter(|(_, used)| !used).map(|(exception, _)| exception);
    violations.extend(
        unused.map(|(path, number, _)| format!("{path}: {number} is gone; take it off the list in tests/architecture/exceptions.rs")),
    );
    violations
}

#[test]
fn small_numbers_have_a_name() {
    let sources = sources(&["src"]);
    let is_home = |source: &Source| source.path.starts_with(HOME) && !small_numbers(source).is_empty();
    assert!(sources.iter().any(is_home), "the tolerances were not found");
    let violations = violations(&sources, SMALL_NUMBERS);
    assert!(violations.is_empty(), "\n{}\n", violations.join("\n"));
}

#[test]
fn a_bare_tolerance_is_found() {
    let found = |path: &str, text: &str, exceptions: &[(&str, &str, &str)]| violations(&[Source::new(path, text)], exceptions).len();
    let text = "fn f(x: f64) -> bool { x < 1e-9 }";
    assert_eq!(found("src/mesh/a.rs", text, &[]), 1);
    assert_eq!(found("src/mesh/a.rs", "const SMALL: f64 = 2.5E-9_f64;", &[]), 1);
    assert_eq!(found("src/mesh/a.rs", text, &[("src/mesh/a.rs", "1e-9", "known")]), 0);
    assert_eq!(found("src/mesh/a.rs", "", &[("src/mesh/a.rs", "1e-9", "known")]), 1);
    assert_eq!(found(HOME, text, &[]), 0);
    assert_eq!(found("src/mesh/a.rs", "/// 1e-9\nfn f() -> (f64, &'static str) { (1e9, \"1e-9\") } // 1e-9", &[]), 0);
    assert_eq!(found("src/mesh/a.rs", "#[cfg(test)] mod tests { const X: f64 = 1e-9; }", &[]), 0);
}
