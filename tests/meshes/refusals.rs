//! Every refusal of every reader: `refusals.txt` has small files, a change to one of them for each error path, and what is then said.
//!
//! `@base NAME` begins a file, `@file NAME PATH` names one of `made/`; `@mesh NAME TITLE`, `@deck …` and `@surface …` begin a case that
//! reads it so. Lines of a case: `- TEXT` is replaced by `+ TEXT` (once; `\n`, `\xff`), `! cut N` keeps N bytes, `! skip` refuses elements
//! that are no cells, `! gone` makes the file a folder, `! alone`, `! itself`, `! chain` and `! below` say which included files there are.
//! Then `= CODE PLACE`, `= MESSAGE`, `= HINT`; written anew by `CONSERVA_RENEW_REFUSALS=1 cargo test --release --test meshes refusal`.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use conserva::mesh::{FilePosition, MeshError, ReadOptions, Structural, below_folder_of, read_deck, read_mesh_with, read_surface};

/// Texts of the source that are no messages, each with its reason.
const NO_MESSAGES: &[&str] = &[
    // a count of a binary file that does not fit into a machine of 32 bits
    "other numbers",
];

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes"))
}

/// Bytes of a text in which `\n`, `\t`, `\\` and `\xff` stand for bytes.
fn bytes_of(text: &str) -> Vec<u8> {
    let (mut bytes, mut rest) = (Vec::new(), text);
    while let Some(at) = rest.find('\\') {
        bytes.extend(rest[..at].bytes());
        let (byte, length) = match &rest[at + 1..at + 2] {
            "n" => (b'\n', 2),
            "t" => (b'\t', 2),
            "x" => (u8::from_str_radix(&rest[at + 2..at + 4], 16).unwrap(), 4),
            _ => (b'\\', 2),
        };
        bytes.push(byte);
        rest = &rest[at + length..];
    }
    bytes.extend(rest.bytes());
    bytes
}

struct Case {
    head: String,
    lines: Vec<String>,
}

impl Case {
    fn all<'a>(&'a self, mark: &'a str) -> impl Iterator<Item = &'a str> {
        self.lines
            .iter()
            .filter_map(move |line| line.strip_prefix(mark).filter(|rest| rest.is_empty() || rest.starts_with(' ')))
            .map(|rest| rest.trim_start_matches(' '))
    }

    /// Content of the file with the changes of the case.
    fn content(&self, base: &[u8]) -> Vec<u8> {
        let mut content = base.to_vec();
        for (from, to) in self.all("-").zip(self.all("+")) {
            let (from, to) = (bytes_of(from), bytes_of(to));
            let at = content.windows(from.len()).position(|window| window == from).unwrap_or_else(|| panic!("{}: {from:?}", self.head));
            content.splice(at..at + from.len(), to);
        }
        for length in self.all("!").filter_map(|change| change.strip_prefix("cut ")) {
            content.truncate(length.parse().unwrap());
        }
        content
    }

    /// Lines that say what is refused.
    fn outcome(&self, base: &[u8]) -> (Vec<String>, String) {
        let file = std::env::temp_dir().join(format!("conserva-refusal-{}", std::process::id()));
        std::fs::write(&file, self.content(base)).unwrap();
        let has = |word: &str| self.all("!").any(|change| change == word);
        let structural = if has("skip") { Structural::Refused } else { Structural::Skipped };
        if has("gone") {
            std::fs::remove_file(&file).unwrap();
            std::fs::create_dir(&file).unwrap();
        }
        let options = ReadOptions { structural, ..ReadOptions::default() };
        let (below, copies) = (below_folder_of(&file), RefCell::new(Vec::new()));
        let find = |name: &str| {
            if has("itself") {
                Ok(file.clone())
            } else if has("chain") {
                let copy = file.with_extension(copies.borrow().len().to_string());
                copies.borrow_mut().push(copy.clone());
                std::fs::copy(&file, &copy).map(|_| copy).map_err(|error| error.to_string())
            } else if has("below") {
                below(name)
            } else {
                Err(format!("\"{name}\" is not there"))
            }
        };
        let error: Option<MeshError> = match self.head.split(' ').next() {
            Some("@deck") => read_deck(&file, options, Some(&find)).err(),
            Some("@surface") => read_surface(&file).err(),
            _ if has("alone") => read_mesh_with(&file, options, None).err(),
            _ => read_mesh_with(&file, options, Some(&find)).err(),
        };
        copies.take().iter().chain([&file]).for_each(|file| {
            std::fs::remove_file(file).or_else(|_| std::fs::remove_dir(file)).unwrap();
        });
        let Some(error) = error else { return (vec!["= read".into()], String::new()) };
        let message = error.to_string().replace(&*file.to_string_lossy(), "FILE");
        let place = match error.place() {
            Some(FilePosition::Line(line)) => format!("line {line}"),
            Some(FilePosition::Byte(byte)) => format!("byte {byte}"),
            None => "nowhere".into(),
        };
        (
            vec![format!("= {} {place}", error.code()), format!("= {message}"), format!("= {}", error.hint())],
            format!("{message} {}", error.hint()),
        )
    }
}

/// Sentences in string literals of the readers, cut where values are put in.
fn sentences(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = entry.file_name().unwrap().to_string_lossy().into_owned();
        if entry.is_dir() {
            sentences(&entry, found);
        } else if !name.ends_with("tests.rs") && !["write.rs", "options.rs"].contains(&name.as_str()) {
            let text = std::fs::read_to_string(&entry).unwrap();
            let text = text.split("#[cfg(test)]").next().unwrap();
            let code: Vec<&str> = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
            let code = code.join("\n").replace("\\\n", "\u{1}").replace("\\\"", "\u{2}").replace("'\"'", "");
            for literal in code.split('"').skip(1).step_by(2) {
                let joined: Vec<&str> = literal.split('\u{1}').map(str::trim_start).collect();
                let whole = joined.concat().replace('\u{2}', "\"");
                let pieces = whole.split(['{', '}']).step_by(2).map(str::trim);
                found.extend(
                    pieces
                        .filter(|piece| piece.matches(' ').count() > 0 && piece.starts_with(|c: char| c.is_ascii_lowercase()))
                        .map(String::from),
                );
            }
        }
    }
}

#[test]
fn every_refusal_of_every_reader_names_place_finding_and_cure() {
    let path = folder().join("refusals.txt");
    let text = std::fs::read_to_string(&path).unwrap();
    let (mut bases, mut cases): (BTreeMap<String, Vec<u8>>, Vec<Case>) = Default::default();
    let (mut renewed, mut open) = (String::new(), None);
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[0] {
            "@base" => open = Some(words[1].to_string()),
            "@file" => drop(bases.insert(words[1].into(), std::fs::read(folder().join("made").join(words[2])).unwrap())),
            "@mesh" | "@deck" | "@surface" => {
                open = None;
                cases.push(Case { head: line.into(), lines: Vec::new() });
            }
            _ if open.is_some() => {
                let base = bases.entry(open.clone().unwrap()).or_default();
                base.extend(line.bytes().chain(*b"\n"));
            }
            _ => cases.last_mut().into_iter().filter(|_| !line.is_empty()).for_each(|case| case.lines.push(line.into())),
        }
        if cases.is_empty() {
            renewed.push_str(&format!("{line}\n"));
        }
    }
    let (mut wrong, mut codes, mut said) = (Vec::new(), BTreeSet::new(), String::new());
    for case in &cases {
        let base = case.head.split(' ').nth(1).unwrap();
        let (outcome, words) = case.outcome(bases.get(base).unwrap_or_else(|| panic!("{}: no base {base}", case.head)));
        let expected: Vec<&String> = case.lines.iter().filter(|line| line.starts_with("= ")).collect();
        if expected != outcome.iter().collect::<Vec<_>>() || outcome.len() != 3 || outcome.iter().any(|line| line == "= ") {
            wrong.push(format!("{}: {outcome:#?}", case.head));
        }
        codes.extend(outcome[0].split(' ').nth(1).map(String::from));
        said.push_str(&words);
        let changes = case.lines.iter().filter(|line| !line.starts_with("= "));
        let lines: Vec<String> = std::iter::once(&case.head).chain(changes).chain(&outcome).cloned().collect();
        renewed.push_str(&format!("{}\n\n", lines.join("\n")));
    }
    if std::env::var_os("CONSERVA_RENEW_REFUSALS").is_some() {
        std::fs::write(&path, renewed.trim_end().to_string() + "\n").unwrap();
    } else {
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
    // the codes of all problems of files, and every sentence that a reader has
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/mesh");
    let all = std::fs::read_to_string(source.join("codes.rs")).unwrap();
    let of_files: BTreeSet<String> = all.split('"').filter(|text| text.starts_with("C08")).map(String::from).collect();
    let missing: Vec<&String> = of_files.difference(&codes).collect();
    assert!(missing.is_empty(), "no case has {missing:?}");
    let mut known = BTreeSet::new();
    sentences(&source.join("files"), &mut known);
    let unsaid: Vec<&String> = known.iter().filter(|text| !said.contains(*text) && !NO_MESSAGES.iter().any(|no| text == no)).collect();
    assert!(unsaid.is_empty(), "no case says {unsaid:#?}");
}
