//! Writes THIRD-PARTY-LICENSES.md: every crate in the program, with its license and the license texts of the crate.
//!
//! `cargo run --example licenses` writes the file, `-- --check` reports if it is out of date. The list follows `cargo metadata` for this
//! machine's target; crates of tests and tools are left out, because they are not shipped.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

const FILE: &str = "THIRD-PARTY-LICENSES.md";
const HEAD: &str = "# Licenses of the crates in Conserva\n\nMade by `cargo run --example licenses` from `cargo metadata`; do not edit. \
    Conserva itself is under MIT or Apache-2.0, at your choice. Where a crate gives a choice, any of its licenses may be taken.\n\n";

/// License texts of a crate, found by the beginnings of their names.
fn texts(folder: &Path) -> Vec<String> {
    let is_license =
        |name: &str| ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"].iter().any(|begin| name.to_uppercase().starts_with(begin));
    let mut files: Vec<_> = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    files.retain(|path| path.is_file() && path.file_name().is_some_and(|name| is_license(&name.to_string_lossy())));
    files.sort();
    let clean = |text: String| text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n").trim().to_string();
    files.iter().filter_map(|path| std::fs::read_to_string(path).ok()).map(clean).collect()
}

/// Identifiers of the packages that are built into the program.
fn shipped(metadata: &Value) -> BTreeSet<String> {
    let nodes = metadata["resolve"]["nodes"].as_array().cloned().unwrap_or_default();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    let (mut waiting, mut found) = (vec![text(&metadata["resolve"]["root"])], BTreeSet::new());
    while let Some(id) = waiting.pop() {
        if !found.insert(id.clone()) {
            continue;
        }
        for dependency in nodes.iter().filter(|node| node["id"] == id.as_str()).filter_map(|node| node["deps"].as_array()).flatten() {
            // Neither tests nor build scripts are part of the program.
            let is_built_in = dependency["dep_kinds"].as_array().is_some_and(|kinds| kinds.iter().any(|kind| kind["kind"].is_null()));
            if is_built_in {
                waiting.push(text(&dependency["pkg"]));
            }
        }
    }
    found
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let target = String::from_utf8(Command::new("rustc").args(["--print", "host-tuple"]).output()?.stdout)?;
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let output =
        Command::new(cargo).args(["metadata", "--format-version", "1", "--locked", "--filter-platform", target.trim()]).output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
    }
    let metadata: Value = serde_json::from_slice(&output.stdout)?;
    let (shipped, mut rows, mut by_text) = (shipped(&metadata), Vec::new(), BTreeMap::<String, Vec<String>>::new());
    for package in metadata["packages"].as_array().into_iter().flatten() {
        let field = |key: &str| package[key].as_str().unwrap_or_default();
        if package["source"].is_null() || !shipped.contains(field("id")) {
            continue;
        }
        let name = format!("{} {}", field("name"), field("version"));
        rows.push(format!("| {name} | {} | {} |", field("license").replace('/', " OR "), field("repository")));
        let folder = Path::new(field("manifest_path")).parent().unwrap_or(Path::new("."));
        for text in texts(folder) {
            by_text.entry(text).or_default().push(name.clone());
        }
    }
    rows.sort();
    let mut page = format!("{HEAD}| crate | license | source |\n|---|---|---|\n{}\n\n", rows.join("\n"));
    let mut all: Vec<(Vec<String>, String)> = by_text.into_iter().map(|(text, names)| (names, text)).collect();
    all.sort();
    for (names, text) in all {
        page += &format!("## {}\n\n````text\n{text}\n````\n\n", names.join(", "));
    }
    let page = page.trim_end().to_string() + "\n";
    if std::env::args().any(|argument| argument == "--check") {
        let is_current = std::fs::read_to_string(FILE).is_ok_and(|known| known == page);
        return if is_current { Ok(()) } else { Err(format!("{FILE} is not current: `cargo run --example licenses` writes it").into()) };
    }
    std::fs::write(FILE, page)?;
    println!("{} crates in {FILE}", rows.len());
    Ok(())
}
