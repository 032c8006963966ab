//! Reference of the language: complete, current, with examples that run.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use conserva::output::Dimension;
use conserva::script::{
    Absent, Entry, Explanation, Form, Function, Kind, PAGES, Parameter, Reference, Session, Settings, Silent, explanations,
};

fn session() -> Session {
    let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts");
    Session::new(Settings::default(), &home, Rc::new(Silent)).unwrap()
}

fn functions() -> Vec<Rc<Function>> {
    session().registry().functions().to_vec()
}

/// Parameters and keys of options, including nested keys.
fn parameters(of: &[Parameter]) -> Vec<&Parameter> {
    of.iter()
        .flat_map(|parameter| {
            let keys = match &parameter.kind {
                Kind::Options(keys) => parameters(keys),
                _ => Vec::new(),
            };
            std::iter::once(parameter).chain(keys)
        })
        .collect()
}

#[test]
fn every_function_says_what_it_is() {
    let all = functions();
    assert!(all.len() > 90, "the registry is not filled");
    for function in &all {
        let title = function.signature();
        assert!(function.summary.len() > 10 && !function.summary.ends_with('.'), "{title}: one sentence without its full stop");
        assert!(
            function.example.contains(function.name) || matches!(function.form, Form::Column(_)),
            "{title}: its example does not use it"
        );
        for parameter in parameters(&function.parameters) {
            assert!(parameter.summary.len() > 4, "{title}: `{}` has no text", parameter.name);
            let number = matches!(parameter.kind, Kind::Number | Kind::Vector);
            assert!(
                !number || !parameter.dimension.is_empty(),
                "{title}: `{}` has no dimension (`1` or `any` where it fits)",
                parameter.name
            );
            let known = matches!(parameter.dimension, "" | "any" | "pixels" | "seconds") || Dimension::parse(parameter.dimension).is_some();
            assert!(known, "{title}: `{}` has the unknown dimension {}", parameter.name, parameter.dimension);
            if let Absent::Number(value) = parameter.absent {
                assert!(parameter.range.contains(value), "{title}: the default of `{}` is out of its range", parameter.name);
            }
        }
        for name in function.see_also {
            assert!(all.iter().any(|other| other.name == *name), "{title}: see also {name}, which does not exist");
        }
    }
}

#[test]
fn every_registered_name_is_in_the_reference() {
    let session = session();
    let definitions = session.definitions();
    let names = definitions.lines().filter_map(|line| line.strip_prefix("fn ")).map(|line| line.strip_prefix("get ").unwrap_or(line));
    let mut count = 0;
    for name in names.filter_map(|line| line.split('(').next()) {
        let known = session.registry().named(name).next().is_some();
        let stands_for_the_engines = matches!(name, "push" | "sort" | "sort_desc" | "sorted" | "sorted_desc");
        let of_every_object = matches!(name, "to_string" | "to_debug" | "index$get$");
        assert!(known || stands_for_the_engines || of_every_object, "{name} is registered without a description");
        count += 1;
    }
    assert!(count > 80, "the definitions are not read");
}

#[test]
fn every_example_runs() {
    let mut failures = Vec::new();
    // Examples of functions run as files, with a folder for what they write.
    let home = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reference-examples");
    let _ = std::fs::remove_dir_all(&home);
    std::fs::create_dir_all(&home).expect("the folder can be made");
    let script = home.join("main.rhai");
    for function in functions() {
        std::fs::write(&script, function.example.as_bytes()).expect("the script can be written");
        let settings = Settings { output: Some(home.join("out")), ..Settings::default() };
        let report = Session::new(settings, &home, Rc::new(Silent)).expect("the session begins").run_file(&script);
        if let Some(error) = report.error {
            failures.push(format!("{}:\n{}", function.signature(), error.render(conserva::script::Ink::Plain)));
        }
    }
    for page in PAGES {
        if let Err(error) = session().evaluate("example", page.example) {
            failures.push(format!("{}:\n{}", page.title, error.render(conserva::script::Ink::Plain)));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_word_has_its_sentence_and_is_found() {
    let session = session();
    let reference = Reference::new(&session.registry());
    for word in reference.words() {
        assert!(word.summary.len() > 4, "`{}`, a {}, has no text", word.name, word.group);
        assert!(reference.find(word.name).is_ok());
    }
    for function in functions() {
        let found = reference.find(function.name).unwrap_or_default();
        assert!(found.iter().any(|entry| matches!(entry, Entry::Function(_))), "{} is not found", function.name);
    }
    assert!(matches!(reference.find("Model").as_deref(), Ok([Entry::Topic(..), Entry::Type(..)])));
    assert!(matches!(reference.find("Body.mass").as_deref(), Ok([Entry::Function(_)])));
    for page in PAGES {
        for name in page.names {
            let found = reference.find(name).unwrap_or_default();
            assert!(found.iter().any(|entry| matches!(entry, Entry::Page(found) if *found == page)), "{name} is not found");
        }
    }
    assert!(reference.search("angular velocity").iter().any(|entry| entry.line().starts_with("Model.initial_velocity")));
    assert!(reference.search("zebra quagga").is_empty());
    assert!(reference.find("rectangel").err().flatten().unwrap().contains("rectangle"));
    let json: serde_json::Value = serde_json::from_str(&reference.json()).unwrap();
    assert_eq!(json["functions"].as_array().unwrap().len(), functions().len());
}

#[test]
fn the_files_of_the_reference_are_current() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let session = session();
    let files = [
        ("reference.md", "markdown", Reference::new(&session.registry()).markdown()),
        ("../editors/vscode/syntaxes/conserva.tmLanguage.json", "grammar", Reference::new(&session.registry()).grammar()),
        ("definitions/conserva.d.rhai", "definitions", format!("{}\n", session.definitions().trim_end())),
    ];
    for (file, format, text) in files {
        let kept = std::fs::read_to_string(docs.join(file)).unwrap_or_default();
        assert!(kept == text, "docs/{file} is not current: write it with `conserva doc --format {format} > docs/{file}`");
    }
}

/// Files below a folder with an extension.
fn files_below(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let below = |path: PathBuf| match path.is_dir() {
        true => files_below(&path, ending),
        false => Some(path).into_iter().filter(|path| path.to_string_lossy().ends_with(ending)).collect(),
    };
    entries.flat_map(below).collect()
}

/// Codes such as `C0123` between two of the given characters, in numerical order.
fn codes_between(text: &str, signs: &[char]) -> Vec<String> {
    let is_code = |part: &&str| part.len() == 5 && part.starts_with('C') && part[1..].bytes().all(|byte| byte.is_ascii_digit());
    let mut codes: Vec<String> = text.split(signs).filter(is_code).map(Into::into).collect();
    codes.sort();
    codes
}

#[test]
fn every_code_stands_once_in_the_source_and_is_explained() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let source: String = files_below(&root.join("src"), ".rs").iter().map(|file| std::fs::read_to_string(file).unwrap()).collect();
    let given = codes_between(&source, &['"']);
    let known: Vec<Explanation> = explanations().collect();
    let explained: Vec<&str> = known.iter().map(|of| of.code).collect();
    assert!(given.len() > 200, "the source is not read");
    assert!(given.windows(2).all(|two| two[0] != two[1]), "a code is given twice: {given:?}");
    assert_eq!(given, explained, "docs/errors.md explains each code once, in the order of their numbers");
    for Explanation { code, title, text } in &known {
        assert!(title.len() > 5 && !title.ends_with('.') && text.len() > 20, "{code} is not explained");
    }
    for snapshot in files_below(&root.join("tests/errors/snapshots"), ".snap") {
        let shown = codes_between(&std::fs::read_to_string(&snapshot).unwrap(), &['[', ']']);
        assert!(shown.iter().all(|code| explained.contains(&code.as_str())), "{}: {shown:?}", snapshot.display());
    }
}

/// Names of error types in a text.
fn errors_in(text: &str) -> Vec<&str> {
    let word = |text: &str| text.find(|letter: char| !letter.is_alphanumeric()).unwrap_or(text.len());
    let mut names = Vec::new();
    for after in text.split("#[derive(").skip(1).filter(|after| after.split(")]").next().is_some_and(|derived| derived.contains("Error"))) {
        let definition = after.lines().find_map(|line| line.strip_prefix("pub enum ").or(line.strip_prefix("pub struct ")));
        names.extend(definition.map(|line| &line[..word(line)]));
    }
    names.extend(text.split("impl std::error::Error for ").skip(1).map(|after| &after[..word(after)]));
    names
}

#[test]
fn every_error_below_the_language_has_codes() {
    let mut source = String::new();
    for folder in ["machine", "math", "elements", "linear", "materials", "mesh", "integrators", "bodies", "contact", "dynamics", "output"] {
        let files = files_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(folder), ".rs");
        files.iter().for_each(|file| source += &std::fs::read_to_string(file).unwrap());
    }
    let blocks: Vec<&str> = source.split("\nimpl").filter(|block| block.contains("pub fn code(")).collect();
    let names = errors_in(&source);
    assert!(names.len() > 15, "the source is not read: {names:?}");
    for name in names {
        let is_of = |block: &&str| block.starts_with(&format!(" {name} {{")) || block.starts_with(&format!("<E> {name}<E> {{"));
        assert!(blocks.iter().any(is_of), "{name} has no method `code`");
    }
}

#[test]
fn a_code_is_found_and_an_unknown_one_is_told_with_the_nearest() {
    let reference = Reference::new(&session().registry());
    assert!(matches!(reference.find("C0101").as_deref(), Ok([Entry::Code(Explanation { code: "C0101", .. })])));
    assert!(reference.find("c0504").is_ok());
    assert!(reference.find("C0199").err().flatten().unwrap().contains("`C0201`"));
    assert!(reference.search("newton converge").iter().any(|entry| entry.line().starts_with("C0504")));
}

#[test]
fn the_examples_of_codes_run() {
    for Explanation { code, text, .. } in explanations() {
        for example in text.split("```rhai\n").skip(1) {
            let script = example.split("```").next().unwrap_or_default();
            if let Err(error) = session().evaluate("example", script) {
                panic!("{code}:\n{}", error.render(conserva::script::Ink::Plain));
            }
        }
    }
}
