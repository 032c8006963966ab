//! Cyclic dependencies between the files of one folder and between folders.
//!
//! A file depends on another one through a path that begins with `crate`, `self`, `super` or a module of its own. The path is resolved to
//! the file that defines the name: a re-export in a `mod.rs` counts as the file that it comes from, and re-exporting is no dependency. A
//! `mod.rs` that only re-exports is therefore in no cycle; one that defines items for its files and also uses these files is.

use std::collections::{BTreeMap, BTreeSet};

use super::exceptions::CIRCLES;
use super::source::{Source, program, sources};

/// Path as a list of its names, including the initial keyword, and the name that a `use` gives it.
struct Named {
    path: Vec<String>,
    name: String,
    /// Visibility of the `use` that contains the path; `None` outside of a `use`.
    import: Option<Visibility>,
}

#[derive(Clone, Copy, PartialEq)]
enum Visibility {
    Private,
    Public,
}

type Module = Vec<String>;

/// Dependency graph of the files of a folder.
struct Folder {
    modules: BTreeMap<Module, Vec<Named>>,
}

impl Folder {
    fn new(sources: &[&Source]) -> Folder {
        let modules: BTreeSet<Module> = sources.iter().map(|source| module_of(source)).collect();
        let named = |source: &&Source| {
            let own = module_of(source);
            let children: Vec<&str> = modules
                .iter()
                .filter(|module| module.len() == own.len() + 1 && module.starts_with(&own))
                .map(|module| &module[own.len()][..])
                .collect();
            let paths = paths(source, &own, &children);
            (own, paths)
        };
        Folder { modules: sources.iter().map(named).collect() }
    }

    /// File that defines what a path names, followed from the root of the crate; `None` if the path leaves the folder.
    fn holder(&self, path: &[String]) -> Option<Module> {
        let mut module: Module =
            path.first().filter(|first| self.modules.contains_key(&vec![(*first).clone()])).map(|first| vec![first.clone()])?;
        for name in &path[1..] {
            let child = [module.clone(), vec![name.clone()]].concat();
            if self.modules.contains_key(&child) {
                module = child;
                continue;
            }
            // Re-exported from a file below.
            let passed = self.modules[&module].iter().filter(|named| named.import.is_some() && named.name == *name);
            let below = |path: &Module| path.len() > module.len() && path.starts_with(&module) && *path != child;
            return match passed.map(|named| &named.path).find(|path| below(path)) {
                Some(path) => self.holder(path),
                None => Some(module),
            };
        }
        Some(module)
    }

    fn graph(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let edges = |(module, named): (&Module, &Vec<Named>)| {
            let is_use = |named: &&Named| named.import != Some(Visibility::Public) || !named.path.starts_with(module);
            let mut reached: BTreeSet<Module> = named.iter().filter(is_use).filter_map(|named| self.holder(&named.path)).collect();
            reached.remove(module);
            (module.clone(), reached)
        };
        self.modules.iter().map(edges).collect()
    }
}

fn module_of(source: &Source) -> Module {
    source.module_path().into_iter().map(String::from).collect()
}

/// Paths of a file that may lead to another file of its crate, from the root on.
fn paths(source: &Source, own: &Module, children: &[&str]) -> Vec<Named> {
    let mut found = Vec::new();
    // Open braces; with the module name if the brace opens the body of a module.
    let mut braces: Vec<Option<String>> = Vec::new();
    let mut import: Option<Visibility> = None;
    let mut index = 0;
    while index < source.tokens.len() {
        let text = source.text_at(index);
        let before = if index > 0 { source.text_at(index - 1) } else { "" };
        match text {
            "{" => braces.push((index >= 2 && source.text_at(index - 2) == "mod").then(|| before.to_string())),
            "}" => drop(braces.pop()),
            "use" => import = Some(if before == "pub" || before == ")" { Visibility::Public } else { Visibility::Private }),
            ";" => import = None,
            _ => {}
        }
        let here = || [own.clone(), braces.iter().flatten().cloned().collect()].concat();
        let is_root = before != "::" && before != "." && source.text_at(index + 1) == "::";
        let start = match text {
            "crate" | "self" | "super" => is_root,
            name => is_root && braces.iter().flatten().count() == 0 && children.contains(&name),
        };
        if !start {
            index += 1;
            continue;
        }
        let mut base: Module = match text {
            "crate" => Vec::new(),
            "super" => {
                let mut base = here();
                base.pop();
                base
            }
            "self" => here(),
            child => [here(), vec![child.to_string()]].concat(),
        };
        index += 2;
        while source.text_at(index) == "super" && source.text_at(index + 1) == "::" {
            base.pop();
            index += 2;
        }
        index = tree_into(source, index, &base, import, &mut found);
    }
    found
}

/// Adds a path, or a tree of paths in braces, that continues `base`; returns the index behind it.
fn tree_into(source: &Source, mut index: usize, base: &Module, import: Option<Visibility>, found: &mut Vec<Named>) -> usize {
    let mut path = base.clone();
    loop {
        match source.text_at(index) {
            "{" => {
                let end = source.closing(index);
                index += 1;
                while index < end {
                    index = if source.text_at(index) == "," {
                        index + 1
                    } else {
                        tree_into(source, index, &path, import, found).max(index + 1)
                    };
                }
                return end + 1;
            }
            "*" | "<" | "self" => {}
            name => path.push(name.to_string()),
        }
        index += 1;
        if source.text_at(index) != "::" {
            break;
        }
        index += 1;
    }
    let mut name = path.last().cloned().unwrap_or_default();
    if source.text_at(index) == "as" {
        name = source.text_at(index + 1).to_string();
        index += 2;
    }
    found.push(Named { path, name, import });
    index
}

/// Subgraph of the nodes that are on a cycle or between two cycles.
fn on_circles(graph: &BTreeMap<Module, BTreeSet<Module>>) -> BTreeMap<Module, BTreeSet<Module>> {
    let mut left = graph.clone();
    loop {
        let named: BTreeSet<Module> = left.values().flatten().cloned().collect();
        let free = left.iter().find(|(module, names)| !named.contains(*module) || !names.iter().any(|name| left.contains_key(name)));
        match free.map(|(module, _)| module.clone()) {
            Some(module) => left.remove(&module),
            None => break,
        };
        let kept: BTreeSet<Module> = left.keys().cloned().collect();
        left.values_mut().for_each(|names| names.retain(|name| kept.contains(name)));
    }
    left
}

/// Description of a cycle between files; `None` without a cycle.
fn circle(sources: &[&Source]) -> Option<String> {
    circle_in(&Folder::new(sources).graph())
}

/// Description of a cycle between folders, or between folders and files beside them; a folder counts as one node.
fn circle_of_folders(sources: &[&Source]) -> Option<String> {
    let graph = Folder::new(sources).graph();
    let above: BTreeSet<&[String]> = graph.keys().filter_map(|module| module.split_last().map(|(_, above)| above)).collect();
    above.into_iter().find_map(|above| {
        let member = |module: &Module| -> Option<Module> {
            (module.len() > above.len() && module.starts_with(above)).then(|| module[..above.len() + 1].to_vec())
        };
        let mut members: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
        for (module, reached) in &graph {
            let Some(own) = member(module) else { continue };
            let others = reached.iter().filter_map(member).filter(|other| *other != own);
            members.entry(own.clone()).or_default().extend(others.clone());
            for other in others {
                members.entry(other).or_default();
            }
        }
        circle_in(&members)
    })
}

fn circle_in(graph: &BTreeMap<Module, BTreeSet<Module>>) -> Option<String> {
    let left = on_circles(graph);
    let mut walk = vec![left.keys().next()?];
    loop {
        // Any neighbor on a cycle leads back; the circle found need not be the shortest.
        let next = left[*walk.last()?].iter().next()?;
        if let Some(start) = walk.iter().position(|module| *module == next) {
            let names: Vec<String> = walk[start..].iter().chain([&next]).map(|module| module.join("::")).collect();
            return Some(names.join(" -> "));
        }
        walk.push(next);
    }
}

fn violations(sources: &[Source], exceptions: &[(&str, &str)]) -> Vec<String> {
    let sources = program(sources);
    let folders: BTreeSet<&str> = sources.iter().map(|source| source.floor_module()).collect();
    let mut violations = Vec::new();
    for folder in folders {
        let own: Vec<&Source> = sources.iter().filter(|source| source.floor_module() == folder).collect();
        let listed = exceptions.iter().any(|(name, _)| *name == folder);
        match circle(&own).or_else(|| circle_of_folders(&own)) {
            Some(circle) if !listed => violations.push(format!("src/{folder}: {circle}")),
            None if listed => {
                violations.push(format!("src/{folder}: no circle is left; take it off the list in tests/architecture/exceptions.rs"))
            }
            _ => {}
        }
    }
    violations
}

#[test]
fn there_is_no_circle_between_the_files_of_a_folder() {
    let sources = sources(&["src"]);
    assert!(sources.len() > 10, "the source was not found");
    let violations = violations(&sources, CIRCLES);
    assert!(violations.is_empty(), "\n{}\n", violations.join("\n"));
}

#[test]
fn a_planted_circle_is_found() {
    let found = |files: &[(&str, &str)], exceptions: &[(&str, &str)]| {
        let sources: Vec<Source> = files.iter().map(|(path, text)| Source::new(&format!("src/mesh/{path}"), text)).collect();
        violations(&sources, exceptions).len()
    };
    let circles = |files: &[(&str, &str)]| found(files, &[]);
    assert_eq!(circles(&[("a.rs", "use super::b::B;"), ("b.rs", "use super::a::A;"), ("mod.rs", "mod a; mod b;")]), 1);
    assert_eq!(
        circles(&[("a.rs", "fn f() { crate::mesh::b::g() }"), ("b.rs", "use crate::mesh::{c, a::A};"), ("c.rs", ""), ("mod.rs", "")]),
        1
    );
    assert_eq!(
        circles(&[("a.rs", "use super::{b::{self, X}, c};"), ("b.rs", "use super::c;"), ("c.rs", "use super::a;"), ("mod.rs", "")]),
        1
    );
    // Through the re-exports of the folder.
    let passing = "mod a; mod b; pub use a::{A, inner::I as J}; pub(super) use self::b::B;";
    assert_eq!(circles(&[("a.rs", "use super::B;"), ("b.rs", "use crate::mesh::A;"), ("mod.rs", passing)]), 1);
    assert_eq!(circles(&[("a.rs", ""), ("a/inner.rs", "use crate::mesh::B;"), ("b.rs", "use super::J;"), ("mod.rs", passing)]), 1);
    // Through definitions in the folder's own `mod.rs`.
    assert_eq!(circles(&[("a.rs", "use super::Mesh;"), ("mod.rs", "mod a; pub struct Mesh; fn f() { a::g() }")]), 1);
    assert_eq!(circles(&[("gmsh.rs", "mod lines; use lines::L;"), ("gmsh/lines.rs", "use super::G;"), ("mod.rs", "mod gmsh;")]), 1);
    // Between folders whose files are in no cycle.
    let folders = |a: &str, b: &str| {
        circles(&[
            ("a/mod.rs", "mod x; mod y;"),
            ("a/x.rs", a),
            ("a/y.rs", ""),
            ("b/mod.rs", "mod z; mod w;"),
            ("b/z.rs", b),
            ("b/w.rs", ""),
            ("mod.rs", "mod a; mod b;"),
        ])
    };
    assert_eq!(folders("use crate::mesh::b::z::Z;", "use crate::mesh::a::y::Y;"), 1);
    assert_eq!(folders("use crate::mesh::b::z::Z;", "use super::w::W;"), 0);
    // No other findings.
    assert_eq!(
        circles(&[("a.rs", "use super::{Mesh, B};"), ("b.rs", "use super::Mesh;"), ("mod.rs", "pub use b::B; pub use a::A; struct Mesh;")]),
        0
    );
    assert_eq!(
        circles(&[("a.rs", "use super::b::B; use crate::math::a;"), ("b.rs", "use crate::output::a::A; // super::a"), ("mod.rs", "")]),
        0
    );
    assert_eq!(circles(&[("a.rs", "use super::b::B;"), ("b.rs", "#[cfg(test)] mod tests { use super::super::a::A; }"), ("mod.rs", "")]), 0);
    assert_eq!(circles(&[("a.rs", "use super::t::B;"), ("t.rs", "use super::a::A;"), ("mod.rs", "mod a; #[cfg(test)] mod t;")]), 0);
    assert_eq!(circles(&[("a.rs", "mod inner { use super::X; } struct X;"), ("mod.rs", "mod a; use a::X; fn f() {}")]), 0);
    // The list of exceptions shrinks.
    let circle = [("a.rs", "use super::b::B;"), ("b.rs", "use super::a::A;"), ("mod.rs", "")];
    assert_eq!(found(&circle, &[("mesh", "known")]), 0);
    assert_eq!(found(&circle[1..], &[("mesh", "known")]), 1);
}
