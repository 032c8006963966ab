//! Documents: links have targets, scripts run, the site has every page, and terms of the field are in the glossary or in a heading.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Mutex;

use conserva::script::{Ink, Session, Settings, Silent, meant};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

fn add_documents(folder: &Path, found: &mut Vec<PathBuf>) {
    for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            add_documents(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "md") {
            found.push(path);
        }
    }
}

/// All documents with their texts.
fn documents() -> BTreeMap<PathBuf, String> {
    let mut paths: Vec<PathBuf> =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "src/README.md", "examples/README.md"]
            .map(|name| repository().join(name))
            .to_vec();
    add_documents(&repository().join("docs"), &mut paths);
    paths.into_iter().map(|path| (path.clone(), std::fs::read_to_string(&path).unwrap())).collect()
}

/// A text without its code.
fn without_code(text: &str) -> String {
    let prose: String = text.split("\n```").step_by(2).collect::<Vec<_>>().join("\n");
    prose.split('`').step_by(2).collect::<Vec<_>>().join("x")
}

/// Targets of the links of a text.
fn links(text: &str) -> Vec<String> {
    // Code in the name of a link is not part of its target.
    let mut found = Vec::new();
    let prose: String = text.split("\n```").step_by(2).collect::<Vec<_>>().join("\n");
    for rest in prose.split("](").skip(1) {
        let target = rest.split(')').next().unwrap_or_default();
        if !target.contains([' ', '`', '\n', '|']) {
            found.push(target.to_string());
        }
    }
    found
}

/// Anchors of the headings of a text, as GitHub and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let outside = text.split("\n```").step_by(2).flat_map(str::lines);
    for heading in outside.filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim().to_lowercase()) {
        let kept: String = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | ' ')).collect();
        let slug = kept.replace(' ', "-");
        let free =
            (0..).map(|number| if number == 0 { slug.clone() } else { format!("{slug}-{number}") }).find(|slug| !found.contains(slug));
        found.extend(free);
    }
    found
}

/// Links of a document without a target.
fn broken(path: &Path, text: &str, documents: &BTreeMap<PathBuf, String>) -> Vec<String> {
    let is_broken = |target: &String| {
        let (file, anchor) = target.split_once('#').map_or((target.as_str(), None), |(file, anchor)| (file, Some(anchor)));
        let wanted = if file.is_empty() { path.to_path_buf() } else { path.parent().unwrap().join(file) };
        let Ok(wanted) = wanted.canonicalize() else { return true };
        let other = documents.iter().find(|(known, _)| known.canonicalize().is_ok_and(|known| known == wanted));
        anchor.is_some_and(|anchor| other.is_none_or(|(_, text)| !anchors(text).contains(anchor)))
    };
    links(text).into_iter().filter(|target| !target.contains("://")).filter(is_broken).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let documents = documents();
    let mut count = 0;
    for (path, text) in &documents {
        count += links(text).len();
        let broken = broken(path, text, &documents);
        assert!(broken.is_empty(), "{}: {broken:?}", path.display());
    }
    assert!(count > 500, "the links are not read");
}

#[test]
fn broken_links_are_found() {
    let path = repository().join("docs/a.md");
    let documents = BTreeMap::from([(repository().join("README.md"), "# A b\n\n# A b\n".to_string())]);
    let text = "[a](../README.md#a-b) [`b`](../README.md#a-b-1) [c](../README.md#c) [d](none.md) [e](https://x/y)\n```\n[f](f.md)\n```\n";
    assert_eq!(broken(&path, text, &documents), ["../README.md#c", "none.md"]);
}

#[test]
fn every_page_stands_in_the_site() {
    let summary = std::fs::read_to_string(repository().join("docs/SUMMARY.md")).unwrap();
    let listed: BTreeSet<String> = links(&summary).into_iter().collect();
    let mut pages = Vec::new();
    add_documents(&repository().join("docs"), &mut pages);
    for page in pages.iter().filter(|page| !page.ends_with("SUMMARY.md")) {
        let name = page.strip_prefix(repository().join("docs")).unwrap().to_string_lossy().into_owned();
        assert!(listed.contains(&name), "docs/SUMMARY.md does not list {name}");
    }
}

#[test]
fn every_script_runs() {
    let mut scripts = Vec::new();
    for (path, text) in documents() {
        // Examples of functions and messages run in `tests/reference.rs`.
        if path.ends_with("docs/reference.md") || path.ends_with("docs/errors.md") {
            continue;
        }
        let blocks = text.split("\n```rhai\n").skip(1).map(|rest| rest.split("\n```").next().unwrap_or_default().to_string());
        scripts.extend(blocks.enumerate().map(|(number, block)| (format!("{}, script {}", path.display(), number + 1), block)));
    }
    assert!(scripts.len() > 30, "the scripts are not read");
    let (waiting, failures) = (Mutex::new(scripts), Mutex::new(Vec::new()));
    let work = || {
        while let Some((name, text)) = {
            let mut waiting = waiting.lock().unwrap();
            waiting.pop()
        } {
            let folder = name.replace(|letter: char| !letter.is_ascii_alphanumeric(), "_");
            let output = Path::new(env!("CARGO_TARGET_TMPDIR")).join("documents").join(folder);
            let settings = Settings { output: Some(output), ..Settings::default() };
            let mut session = Session::new(settings, &repository(), Rc::new(Silent)).unwrap();
            if let Some(error) = session.run_test(&name, &text, None).error {
                failures.lock().unwrap().push(error.render(Ink::Plain));
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            std::thread::Builder::new().stack_size(conserva::script::STACK).spawn_scoped(scope, work).unwrap();
        }
    });
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Terms of the field and of other programs.
const WORDS: [&str; 87] = [
    "abaqus",
    "adhesion",
    "amplitude",
    "analytical rigid",
    "arc length",
    "augmented Lagrange",
    "axisymmetric",
    "backlash",
    "ball joint",
    "beam",
    "boundary condition",
    "buckling",
    "bushing",
    "calibration",
    "cam",
    "checkpoint",
    "clearance",
    "coefficient of restitution",
    "cohesive",
    "convergence study",
    "conveyor",
    "Coulomb",
    "crack",
    "creep",
    "damage",
    "damping",
    "dashpot",
    "Dirichlet",
    "eigenfrequency",
    "energy balance",
    "explicit dynamics",
    "fatigue",
    "finite strain",
    "follower load",
    "fracture",
    "frequency response",
    "friction",
    "gap",
    "gear",
    "generalized alpha",
    "Gmsh",
    "hardening",
    "hexahedron",
    "hinge",
    "hourglass",
    "hybrid element",
    "hyperelastic",
    "impact",
    "incompressible",
    "interference fit",
    "Lagrange multiplier",
    "locking",
    "lubrication",
    "mass scaling",
    "modal analysis",
    "moment of inertia",
    "Mooney-Rivlin",
    "mortar",
    "motor",
    "Neumann",
    "ParaView",
    "penalty",
    "periodic boundary",
    "plane stress",
    "plasticity",
    "preload",
    "press fit",
    "pretension",
    "Prony",
    "quasi-static",
    "reaction force",
    "restart",
    "rigid body",
    "roughness",
    "safety factor",
    "seal",
    "self-contact",
    "shell",
    "shrink fit",
    "spring",
    "stress concentration",
    "stroke",
    "submodel",
    "symmetry",
    "turntable",
    "weak form",
    "wear",
];

/// Pages for a term: the page named in the glossary, or pages with the term in a heading.
fn pages_of(word: &str, documents: &BTreeMap<PathBuf, String>) -> Vec<String> {
    let word = word.to_lowercase();
    let glossary = &documents[&repository().join("docs/glossary.md")];
    let rows = glossary.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| word"));
    let rows = rows.filter(|row| row.split('|').take(3).any(|cell| cell.to_lowercase().contains(&word)));
    let mut found: Vec<String> = rows.flat_map(links).collect();
    let has_heading = |text: &str| without_code(text).lines().any(|line| line.starts_with('#') && line.to_lowercase().contains(&word));
    found.extend(documents.iter().filter(|(_, text)| has_heading(text)).map(|(path, _)| path.display().to_string()));
    found
}

#[test]
fn words_of_the_field_find_a_page() {
    let documents = documents();
    let missing: Vec<&str> = WORDS.into_iter().filter(|word| pages_of(word, &documents).is_empty()).collect();
    assert!(missing.is_empty(), "docs/glossary.md lacks {missing:?}");
    assert!(pages_of("zebra", &documents).is_empty());
}

#[test]
fn what_help_looks_up_stands_in_the_glossary() {
    let glossary = std::fs::read_to_string(repository().join("docs/glossary.md")).unwrap();
    let words =
        glossary.lines().filter(|line| line.starts_with("| ")).filter_map(|line| line.split('|').nth(1)).flat_map(|cell| cell.split(','));
    let known = words.filter(|word| !meant(word).is_empty()).count();
    assert!(known > 30, "only {known} words of the glossary are known to `help`");
}
