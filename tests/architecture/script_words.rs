//! Messages below `src/script/` contain no words of the script language, because programs in Rust show them, too: no call of a script
//! function, no function or key in backticks, no options map. Words for scripts are in `src/script/api/remedies/`.
//!
//! A kernel may name its own terms: rows of catalogues, fields of results, and functions of an energy text.

use std::collections::BTreeSet;

use super::exceptions::SCRIPT_WORDS;
use super::source::{Source, program, repository, sources};

/// Folders on floors below the script's.
const BELOW: &[&str] =
    &["machine", "math", "elements", "linear", "materials", "mesh", "integrators", "bodies", "contact", "dynamics", "output"];

/// Names of catalogue rows, which kernels use, too, although scripts have functions of these names.
fn rows() -> impl Iterator<Item = &'static str> {
    let laws = conserva::materials::CATALOGUE.iter().chain(conserva::materials::LINEAR).map(|row| row.name);
    laws.chain(conserva::contact::METHODS.iter().map(|row| row.name)).chain(conserva::integrators::CATALOGUE.iter().map(|row| row.name))
}

/// Names of script functions.
fn functions() -> BTreeSet<String> {
    let path = repository().join("docs/definitions/conserva.d.rhai");
    let text = std::fs::read_to_string(path).expect("the definitions are there");
    let declared = text.lines().filter_map(|line| line.strip_prefix("fn ")?.split_once('('));
    declared.map(|(name, _)| name.to_string()).chain(["print".to_string()]).collect()
}

/// Keys of options that Rust has as well; scripts write them as keys.
const KEYS: &[&str] = &["accept_overlap", "dt", "max_halvings", "penalty", "reach"];

fn is_word(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// Words of a text, each with the text that follows it.
fn words(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let starts = text.char_indices().filter(|&(at, letter)| is_word(letter) && !text[..at].ends_with(is_word));
    starts.map(|(at, _)| {
        let end = text[at..].find(|letter| !is_word(letter)).map_or(text.len(), |length| at + length);
        (&text[at..end], &text[end..])
    })
}

/// Words of the script language in a literal of a folder. Laws have formulas, files have columns and keys in backticks that are named like
/// functions, and drawings have transformations.
fn script_words(literal: &str, folder: &str, functions: &BTreeSet<String>) -> Vec<String> {
    let is_formula = |word: &str| folder == "materials" && conserva::materials::functions_of_energies().any(|(name, _)| name == word);
    let mut found = Vec::new();
    if !literal.starts_with('"') && !literal.starts_with("r") {
        return found;
    }
    if literal.contains("#{ ") {
        found.push("#{".to_string());
    }
    if literal.contains("}()") {
        found.push("{…}()".to_string());
    }
    for (index, part) in literal.split('`').enumerate() {
        // text between an odd and an even backtick is code
        let is_code = index % 2 == 1;
        for (word, rest) in words(part) {
            let is_function = functions.contains(word) && !is_formula(word);
            let is_called = is_function && rest.starts_with('(') && (is_code || folder != "output");
            let is_own = part.contains("::") || rows().any(|row| row == word) || (folder == "output" && !part.contains('.'));
            let is_named = is_function && is_code && !is_own;
            let is_key = is_code && (KEYS.contains(&word) || (part.starts_with(word) && rest.starts_with(": ") && word != part));
            if is_called || is_named || is_key {
                found.push(word.to_string());
            }
        }
    }
    found
}

fn violations(sources: &[Source], functions: &BTreeSet<String>, exceptions: &[(&str, &str)]) -> Vec<String> {
    let mut violations = Vec::new();
    let mut used = vec![false; exceptions.len()];
    for source in program(sources).iter().filter(|source| BELOW.contains(&source.floor_module())) {
        // documentation comments are attributes with a text
        let is_said = |&index: &usize| index < 2 || source.text_at(index - 2) != "doc" || source.text_at(index - 1) != "=";
        for token in (0..source.tokens.len()).filter(is_said).map(|index| &source.tokens[index]) {
            for word in script_words(&token.literal, source.floor_module(), functions) {
                match exceptions.iter().position(|(path, _)| *path == source.path) {
                    Some(index) => used[index] = true,
                    None => violations.push(format!(
                        "{}:{}: `{word}` is of the script language; say it plainly, and in src/script/api/remedies/ for scripts",
                        source.path, token.line
                    )),
                }
            }
        }
    }
    let unused = exceptions.iter().zip(used).filter(|(_, used)| !used).map(|(exception, _)| exception);
    violations.extend(
        unused.map(|(path, _)| format!("{path} names nothing of scripts; take it off the list in tests/architecture/exceptions.rs")),
    );
    violations
}

#[test]
fn the_engine_knows_every_object_of_the_language() {
    let engine = std::fs::read_to_string(repository().join("src/script/session/engine.rs")).expect("the engine is there");
    let objects: Vec<String> = sources(&["src/script"])
        .iter()
        .flat_map(|source| {
            source.text.lines().filter_map(|line| Some(line.strip_prefix("impl Handle for ")?.split(' ').next()?.to_string()))
        })
        .collect();
    assert!(objects.len() > 15, "the objects were not found");
    let unknown: Vec<&String> = objects.iter().filter(|name| !engine.contains(&format!("types.add::<{name}>"))).collect();
    assert!(unknown.is_empty(), "without their texts and without hints where they are mistaken for others: {unknown:?}");
}

#[test]
fn kernels_speak_of_no_script() {
    let functions = functions();
    assert!(functions.len() > 100 && functions.contains("settle"), "the functions were not found");
    let violations = violations(&sources(&["src"]), &functions, SCRIPT_WORDS);
    assert!(violations.is_empty(), "\n{}\n", violations.join("\n"));
}

#[test]
fn a_script_word_in_a_kernel_is_found() {
    let functions = functions();
    let found = |path: &str, literal: &str, exceptions: &[(&str, &str)]| {
        violations(&[Source::new(path, &format!("/// `settle`\nfn hint() -> &'static str {{ {literal:?} }}"))], &functions, exceptions)
            .len()
    };
    let path = "src/dynamics/a.rs";
    for planted in ["begin with `settle`", "use sim.settle() before", "allow more `max_halvings`", "give `#{ x: 1 }`", "{name}() took 3"] {
        assert_eq!(found(path, planted, &[]), 1, "{planted}");
        assert_eq!(found("src/script/a.rs", planted, &[]), 0, "{planted}");
        assert_eq!(found(path, planted, &[(path, "known")]), 0, "{planted}");
    }
    assert_eq!(found(path, "leave out `plane: \"strain\"`", &[]), 1);
    for plain in ["settle the bodies", "mortar", "take `neo_hookean`", "cells of `quad8`", "a force (of contact)", "`Mesh::boundary_where`"]
    {
        assert_eq!(found(path, plain, &[]), 0, "{plain}");
    }
    assert_eq!(found("src/materials/energy/a.rs", "write `ln(x)`", &[]), 0);
    assert_eq!(found(path, "plain", &[(path, "known")]), 1, "a row that is no longer needed");
}
