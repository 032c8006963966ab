//! Rules of the project, checked on the source text: floors, owners of crates, no printing in kernels, headers, line width. Cycles of
//! files, sizes and small numbers have files of their own.
//!
//! Files are split into tokens, so that comments and strings may name anything. Rules examine tokens, not resolved paths: a crate or module
//! that is reached through a re-export is found where it is re-exported. The last tests show that every rule can fail.

use std::collections::{BTreeMap, BTreeSet};

mod circles;
mod documents;
mod exceptions;
mod prose;
mod script_words;
mod sizes;
mod source;
mod tolerances;

use source::{Source, repository, sources};

/// Modules by floor, the lowest first.
const FLOORS: &[&[&str]] = &[
    &["machine", "math"],
    &["elements", "linear"],
    &["integrators"],
    &["materials", "mesh"],
    &["bodies", "contact"],
    &["dynamics"],
    &["output"],
    &["script"],
    &["studies"],
    &["cli"],
];

/// Libraries of the packages, from the lowest floor upwards.
const LIBRARIES: [&str; 9] = [
    "packages/base/lib.rs",
    "packages/materials/lib.rs",
    "packages/mesh/lib.rs",
    "packages/bodies/lib.rs",
    "packages/contact/lib.rs",
    "packages/dynamics/lib.rs",
    "packages/output/lib.rs",
    "packages/language/lib.rs",
    "src/lib.rs",
];

/// Modules that may name a crate; an empty list permits all.
const OWNERS: &[(&str, &[&str])] = &[
    ("annotate-snippets", &["script"]),
    ("clap", &["cli"]),
    ("crc32fast", &["output"]),
    ("base64", &["mesh", "output", "studies"]),
    ("bobyqa", &["math"]),
    ("csv", &["output", "studies"]),
    ("getrandom", &["cli"]),
    ("gif", &["output"]),
    ("httparse", &["cli"]),
    ("png", &["output"]),
    ("faer", &["linear"]),
    ("pulp", &["math", "linear"]),
    ("feral-metis", &["linear"]),
    ("flate2", &["mesh", "output"]),
    ("postcard", &["output"]),
    ("clap_complete", &["cli"]),
    ("clap_mangen", &["cli"]),
    ("hdf5-pure", &["output"]),
    ("hmac-sha256", &["script", "studies"]),
    ("indicatif", &["cli"]),
    ("lsp-server", &["cli"]),
    // its matrices are part of the interfaces of the kernels
    ("nalgebra", &["math", "elements", "linear", "materials", "mesh", "integrators", "bodies", "contact", "dynamics", "output"]),
    ("num-dual", &["contact"]),
    ("parquet", &["output"]),
    ("rayon", &["math"]),
    ("rhai", &["script", "cli"]),
    ("spade", &["mesh"]),
    ("roxmltree", &["mesh"]),
    ("rstar", &["mesh", "contact"]),
    ("rustyline", &["cli"]),
    // a state is serialized as a whole
    ("serde", &["linear", "contact", "dynamics", "output", "script", "studies", "cli"]),
    ("serde_json", &["output", "script", "studies", "cli"]),
    ("signal-hook", &["cli"]),
    ("rand_pcg", &["studies"]),
    ("sobol_burley", &["studies"]),
    ("strsim", &["mesh", "script", "cli"]),
    ("toml", &["studies"]),
    ("thiserror", &[]),
    // listed for their features only
    ("bitflags", &[]),
    ("nix", &[]),
    ("once_cell", &[]),
    ("tiny-skia", &["output"]),
    ("ttf-parser", &["output"]),
];

/// Files that may use `unsafe`, each with its reason.
const UNSAFE: &[(&str, &str)] = &[("src/math/simd.rs", "calls a kernel that was compiled for the instructions that the processor has")];

/// Modules that may print to the terminal.
const PRINTING: &[&str] = &["cli", "main"];

/// Widest line, in characters; the formatter does not break comments and strings. Rows of numbers in a table may be wider.
const WIDTH: usize = 140;

/// Top-level modules that a file names, with the place of each: `crate::x`, `conserva::x`, and `super::…::x` that reaches the root.
fn named_modules(source: &Source) -> Vec<(String, String)> {
    let mut named = Vec::new();
    // open braces; true if the brace opens the body of a module
    let mut braces: Vec<bool> = Vec::new();
    let mut index = 0;
    while index < source.tokens.len() {
        match source.text_at(index) {
            "{" => braces.push(index >= 2 && source.text_at(index - 2) == "mod"),
            "}" => drop(braces.pop()),
            root @ ("crate" | "conserva")
                if source.text_at(index + 1) == "::" && !(root == "conserva" && index > 0 && source.text_at(index - 1) == "::") =>
            {
                named.extend(first_segments(source, index + 2));
            }
            "super" if index == 0 || source.text_at(index - 1) != "::" => {
                let mut depth = source.module_path().len() + braces.iter().filter(|module| **module).count();
                let mut next = index;
                while source.text_at(next) == "super" && source.text_at(next + 1) == "::" {
                    depth = depth.saturating_sub(1);
                    next += 2;
                }
                if depth == 0 {
                    named.extend(first_segments(source, next));
                }
            }
            _ => {}
        }
        index += 1;
    }
    named
}

/// Names after `crate::`: one name, or the first names of the paths in braces.
fn first_segments(source: &Source, index: usize) -> Vec<(String, String)> {
    if source.text_at(index) != "{" {
        return vec![(source.text_at(index).into(), source.at(index))];
    }
    let mut segments = Vec::new();
    let mut depth = 0;
    for place in index..source.tokens.len() {
        match source.text_at(place) {
            "{" => depth += 1,
            "}" => depth -= 1,
            name if depth == 1 && matches!(source.text_at(place - 1), "{" | ",") => segments.push((name.into(), source.at(place))),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    segments
}

/// Position in the order of `lib.rs`; files outside of it (`main`, `lib`) may name everything.
fn rank(module: &str) -> usize {
    FLOORS.concat().iter().position(|known| *known == module).unwrap_or(usize::MAX)
}

/// Modules of higher floors that a file names.
fn floor_violations(source: &Source) -> Vec<String> {
    let own = source.floor_module();
    let above = |name: &str| name == "*" || (rank(name) != usize::MAX && rank(name) > rank(own));
    let named = named_modules(source).into_iter().filter(|(name, _)| above(name));
    named.map(|(name, place)| format!("{place}: `{own}` names `{name}`, which stands below it in src/lib.rs")).collect()
}

/// Crates that are named outside of the folders that own them.
fn owner_violations(source: &Source) -> Vec<String> {
    let own = source.floor_module();
    let mut violations = Vec::new();
    for (index, token) in source.tokens.iter().enumerate() {
        let before = if index > 0 { source.text_at(index - 1) } else { "" };
        let is_root =
            before != "::" || index < 2 || !source.text_at(index - 2).chars().all(|c| c.is_alphanumeric() || c == '_' || c == '>');
        let is_path = source.text_at(index + 1) == "::" && is_root || matches!(before, "use" | "crate");
        let owners = OWNERS.iter().find(|(name, _)| is_path && name.replace('-', "_") == token.text);
        if let Some((name, owners)) = owners.filter(|(_, owners)| !owners.is_empty() && !owners.contains(&own)) {
            violations.push(format!("{}: `{own}` uses {name}, which belongs to {owners:?}", source.at(index)));
        }
    }
    violations
}

/// Output to the terminal from a kernel.
fn printing_violations(source: &Source) -> Vec<String> {
    if PRINTING.contains(&source.floor_module()) {
        return Vec::new();
    }
    let prints = |index: &usize| {
        matches!(source.text_at(*index), "print" | "println" | "eprint" | "eprintln" | "dbg")
            && source.text_at(index + 1) == "!"
            && matches!(source.text_at(index + 2), "(" | "[" | "{")
    };
    let found = (0..source.tokens.len()).filter(prints);
    found.map(|index| format!("{}: `{}!` outside `cli`", source.at(index), source.text_at(index))).collect()
}

/// `unsafe` outside of the listed files.
fn unsafe_violations(source: &Source) -> Vec<String> {
    if UNSAFE.iter().any(|(path, _)| *path == source.path) {
        return Vec::new();
    }
    let found = (0..source.tokens.len()).filter(|&index| source.text_at(index) == "unsafe");
    found.map(|index| format!("{}: `unsafe` in a file that is not listed for it", source.at(index))).collect()
}

/// Violations of rules about the text of a file: header, width, unfinished marks.
fn text_violations(source: &Source) -> Vec<String> {
    let path = &source.path;
    let mut violations = Vec::new();
    if !source.text.starts_with("//! ") {
        violations.push(format!("{path}:1: does not open with `//!` and what the file is"));
    }
    for (number, line) in (1..).zip(source.text.lines()) {
        let length = line.chars().count();
        let is_table = line.chars().filter(char::is_ascii_digit).count() * 2 > length;
        if length > WIDTH && !is_table {
            violations.push(format!("{path}:{number}: {length} characters, more than {WIDTH}"));
        }
        // in two pieces, or this line would violate its own rule
        if [concat!("TO", "DO"), concat!("FIX", "ME")].iter().any(|mark| line.contains(mark)) {
            violations.push(format!("{path}:{number}: an open end; write an issue instead"));
        }
    }
    violations
}

/// Modules on a cycle of the dependency graph.
fn modules_on_cycles(graph: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    // modules whose dependencies were all removed are removed; the remaining ones are on a cycle or lead to one
    let mut left = graph.clone();
    loop {
        let free = left.iter().find(|(module, names)| names.iter().all(|name| name == *module || !left.contains_key(name)));
        match free.map(|(module, _)| module.clone()) {
            Some(module) => left.remove(&module),
            None => return left.into_keys().collect(),
        };
    }
}

/// Asserts that all files of `src/` satisfy a rule.
fn assert_kept(folders: &[&str], rule: fn(&Source) -> Vec<String>) {
    let sources = sources(folders);
    assert!(sources.len() > 10, "the source was not found");
    let violations: Vec<String> = sources.iter().flat_map(rule).collect();
    assert!(violations.is_empty(), "\n{}\n", violations.join("\n"));
}

#[test]
fn the_library_lists_its_modules_in_floor_order() {
    let texts = LIBRARIES.map(|file| std::fs::read_to_string(repository().join(file)).unwrap());
    let lines = texts.iter().flat_map(|text| text.lines());
    let modules: Vec<&str> = lines.filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    assert_eq!(modules, FLOORS.concat());
    // every folder of src/ is on a floor
    for source in sources(&["src"]) {
        let module = source.floor_module();
        assert!(rank(module) != usize::MAX || matches!(module, "lib" | "main"), "{} is on no floor", source.path);
    }
}

#[test]
fn no_module_names_a_higher_floor() {
    assert_kept(&["src"], floor_violations);
}

#[test]
fn there_is_no_cycle_between_modules() {
    let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for source in sources(&["src"]) {
        let names = named_modules(&source).into_iter().map(|(name, _)| name);
        graph.entry(source.floor_module().into()).or_default().extend(names);
    }
    assert!(graph["dynamics"].contains("contact"), "the graph is empty");
    assert_eq!(modules_on_cycles(&graph), Vec::<String>::new());
}

#[test]
fn crates_stay_in_the_folders_that_own_them() {
    assert_kept(&["src"], owner_violations);
}

#[test]
fn every_dependency_has_an_owner() {
    let files = LIBRARIES.map(|file| file.replace("src/lib.rs", "Cargo.toml").replace("lib.rs", "Cargo.toml"));
    let manifests = files.map(|file| std::fs::read_to_string(repository().join(file)).unwrap());
    let sections = manifests.iter().flat_map(|manifest| manifest.split("\n[").find(|section| section.starts_with("dependencies]")));
    let lines = sections.flat_map(|section| section.lines().skip(1).filter_map(|line| line.split_once('=')));
    let names: Vec<&str> = lines.map(|(name, _)| name.trim().trim_end_matches(".workspace")).collect();
    assert!(names.contains(&"faer") && names.contains(&"rhai"));
    for name in names.into_iter().filter(|name| !name.starts_with("conserva-")) {
        assert!(OWNERS.iter().any(|(known, _)| *known == name), "{name} has no owner: add it to OWNERS in tests/architecture/main.rs");
    }
}

/// The overview page names every crate in the first folder that owns it.
#[test]
fn the_architecture_page_lists_the_crates() {
    let page = std::fs::read_to_string(repository().join("src/README.md")).unwrap();
    for module in FLOORS.concat() {
        let row = page.lines().find(|line| line.contains(&format!("| `{module}/` |"))).unwrap_or_else(|| panic!("{module} has no row"));
        let cell = row.trim_end_matches('|').rsplit('|').next().unwrap();
        let mut listed: Vec<&str> = cell.split(',').map(str::trim).filter(|name| !name.is_empty()).collect();
        let mut owned: Vec<&str> = OWNERS.iter().filter(|(_, owners)| owners.first() == Some(&module)).map(|(name, _)| *name).collect();
        listed.sort_unstable();
        owned.sort_unstable();
        assert_eq!(listed, owned, "the crates of `{module}` in src/README.md");
    }
}

#[test]
fn only_the_command_line_prints() {
    assert_kept(&["src"], printing_violations);
}

#[test]
fn unsafe_code_stays_where_it_is_listed() {
    assert_kept(&["src"], unsafe_violations);
}

#[test]
fn files_open_with_what_they_are_and_keep_the_width() {
    assert_kept(&["src", "tests", "benches", "examples"], text_violations);
}

#[test]
fn public_items_must_be_documented() {
    for file in LIBRARIES {
        let lib = std::fs::read_to_string(repository().join(file)).unwrap();
        assert!(lib.lines().any(|line| line == "#![deny(missing_docs)]"), "{file} does not deny missing docs");
    }
}

#[test]
fn the_floor_rule_sees_every_way_to_name_a_module() {
    let names = |path: &str, text: &str| floor_violations(&Source::new(path, text)).len();
    assert_eq!(names("src/mesh/gmsh.rs", "use crate::script::Engine;"), 1);
    assert_eq!(names("src/mesh/mod.rs", "fn f() { crate::contact::search(); }"), 1);
    assert_eq!(names("src/mesh/mod.rs", "use crate::{elements::{Quad4, cli}, dynamics, math, output::x};"), 2);
    assert_eq!(names("src/mesh/mod.rs", "use crate::*;"), 1);
    assert_eq!(names("src/linear/mod.rs", "use crate::materials;"), 1);
    assert_eq!(names("src/mesh/mod.rs", "use super::contact::X;"), 1);
    assert_eq!(names("src/mesh/gmsh/lines.rs", "use super::super::super::contact::X;"), 1);
    assert_eq!(names("src/mesh/gmsh.rs", "mod tests { use super::super::super::{contact, math}; }"), 1);
    assert_eq!(names("src/mesh/gmsh.rs", "macro_rules! m { () => { $crate::cli::run() } }"), 1);
    // no other names
    assert_eq!(names("src/mesh/gmsh.rs", "use super::contact; use super::super::math; mod tests { use super::super::contact; }"), 0);
    assert_eq!(names("src/mesh/gmsh.rs", "//! [`crate::script`]\nconst X: &str = \"crate::script\"; // crate::cli"), 0);
    assert_eq!(names("src/cli/run.rs", "use crate::{script, math}; use crate::cli::x;"), 0);
    assert_eq!(names("src/main.rs", "fn main() { conserva::cli::main() }"), 0);
    assert_eq!(names("src/contact/mod.rs", "use crate::bodies;"), 0);
}

#[test]
fn the_owner_rule_sees_paths_only() {
    let uses = |path: &str, text: &str| owner_violations(&Source::new(path, text)).len();
    assert_eq!(uses("src/mesh/mod.rs", "use faer::Mat;"), 1);
    assert_eq!(uses("src/mesh/mod.rs", "use {faer::Mat, std::fmt};"), 1);
    assert_eq!(uses("src/mesh/mod.rs", "use rayon as threads;"), 1);
    assert_eq!(uses("src/mesh/mod.rs", "fn f() { ::rhai::Engine::new(); }"), 1);
    assert_eq!(uses("src/output/mod.rs", "use annotate_snippets::Level;"), 1);
    assert_eq!(uses("src/mesh/mod.rs", "#[derive(thiserror::Error)] struct E;"), 0);
    assert_eq!(uses("src/linear/mod.rs", "use faer::Mat;"), 0);
    assert_eq!(uses("src/script/mod.rs", "use crate::output::csv::Writer; let csv = 1; // faer::Mat"), 0);
}

#[test]
fn the_other_rules_can_fail() {
    let source = |text: &str| Source::new("src/mesh/mod.rs", text);
    for printing in ["println!(\"\")", "eprintln!(\"x\")", "print! {\"x\"}", "dbg!(1)", "std::eprint!(\"x\")"] {
        assert_eq!(printing_violations(&source(&format!("fn f() {{ {printing}; }}"))).len(), 1, "{printing}");
    }
    assert!(printing_violations(&source("fn f(print: u8) -> bool { print != 1 } // println!(\"x\")")).is_empty());
    assert_eq!(unsafe_violations(&source("fn f() { unsafe { g() } }")).len(), 1);
    assert!(unsafe_violations(&source("#![forbid(unsafe_code)] // unsafe\n")).is_empty());
    assert_eq!(text_violations(&source("use std::fmt;")).len(), 1);
    assert_eq!(text_violations(&source(&format!("//! x\n// {}: y", concat!("TO", "DO")))).len(), 1);
    assert_eq!(text_violations(&source(&format!("//! {}", "ü".repeat(137)))).len(), 1);
    assert!(text_violations(&source(&format!("//! {}", "ü".repeat(136)))).is_empty());
    let graph = |edges: &[(&str, &str)]| {
        let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (from, to) in edges {
            graph.entry((*from).into()).or_default().insert((*to).into());
        }
        graph
    };
    assert_eq!(modules_on_cycles(&graph(&[("a", "b"), ("b", "c"), ("c", "a"), ("d", "e")])), ["a", "b", "c"]);
    assert!(modules_on_cycles(&graph(&[("a", "b"), ("b", "c"), ("a", "c"), ("c", "c")])).is_empty());
}
