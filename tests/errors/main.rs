//! Catalogue of mistakes: each script in `cases/` with the messages that a user gets, script and messages together in one snapshot.
//!
//! A first line `// --set name=value` gives parameters. Everything runs in this process, without files; paths are relative to `cases/`.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use conserva::script::{Diagnostic, Ink, Observer, Progress, Session, Settings};

#[derive(Default)]
struct Recorder {
    lines: RefCell<String>,
}

impl Recorder {
    fn add(&self, text: &str) {
        self.lines.borrow_mut().push_str(text);
    }
}

impl Observer for Recorder {
    fn print(&self, line: &str) {
        self.add(&format!("{line}\n"));
    }
    fn passed(&self, line: &str) {
        self.print(line);
    }
    fn warn(&self, warning: &Diagnostic) {
        self.add(&warning.render(Ink::Plain));
    }
    fn advanced(&self, _: &Progress) {}
    fn began(&self, _: &str) {}
    fn ended(&self) {}
}

/// Messages of a record with numbers such as `-1.8e-6` replaced by `#`.
fn without_magnitudes(record: &str) -> String {
    let Some((script, messages)) = record.split_once("\n----\n") else { return record.into() };
    let is_part = |letter: char| letter.is_ascii_digit() || matches!(letter, '.' | 'e' | '-');
    let is_magnitude = |piece: &str| piece.parse::<f64>().is_ok() && piece.contains('e');
    let mut masked = String::new();
    for piece in messages.split_inclusive(|letter| !is_part(letter)) {
        let number = piece.trim_end_matches(|letter| !is_part(letter));
        masked += &if is_magnitude(number) { piece.replacen(number, "#", 1) } else { piece.into() };
    }
    let mut parts = masked.split("det F = ");
    let first = parts.next().unwrap_or_default().to_string();
    let masked = parts.fold(first, |text, part| text + "det F = #" + part.trim_start_matches(|letter| is_part(letter) || letter == '#'));
    format!("{script}\n----\n{masked}")
}

/// Record of a script: text, printed lines, messages, and the class of its error.
fn record(script: &Path, output: &Path) -> String {
    let text = std::fs::read_to_string(script).unwrap();
    let arguments = text.lines().next().and_then(|line| line.strip_prefix("// --set ")).unwrap_or("");
    let overrides = arguments.split_once('=').map(|(name, value)| (name.to_string(), value.to_string()));
    // Short limits for endless scripts; no other case needs a hundredth of them.
    let settings = Settings {
        overrides: overrides.into_iter().collect(),
        max_operations: 1_000_000,
        output: Some(output.to_path_buf()),
        ..Settings::default()
    };
    let recorder = Rc::new(Recorder::default());
    let mut session = Session::new(settings, Path::new("."), recorder.clone()).unwrap();
    let report = session.run_file(script);
    let mut record = format!("{}\n----\n{}", text.trim_end(), recorder.lines.borrow());
    match report.error {
        Some(error) => {
            let _ = write!(record, "{}({:?})", error.render(Ink::Plain), error.class);
        }
        None => record.push_str("(no error)"),
    }
    // Paths of this machine are replaced. Residuals of failed steps depend on the round-off of the processor.
    let is_step = script.file_stem().is_some_and(|stem| stem.to_string_lossy().starts_with("step_"));
    let record = if is_step { without_magnitudes(&record) } else { record };
    record.replace(&output.display().to_string(), "OUT").replace(env!("CARGO_MANIFEST_DIR"), "HERE")
}

#[test]
fn every_mistake_has_its_message() {
    std::env::set_current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors/cases")).unwrap();
    let output = std::env::temp_dir().join(format!("conserva-errors-{}", std::process::id()));
    let mut scripts: Vec<PathBuf> = std::fs::read_dir(".").unwrap().map(|entry| PathBuf::from(entry.unwrap().file_name())).collect();
    scripts.retain(|path| path.extension().is_some_and(|ending| ending == "rhai"));
    scripts.sort();
    // What issue 2 lists, and more.
    assert!(scripts.len() >= 60);
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_snapshot_path(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors/snapshots"));
    settings.set_omit_expression(true);
    let records: Vec<(String, String)> =
        scripts.iter().map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), record(path, &output))).collect();
    let _ = std::fs::remove_dir_all(output);
    settings.bind(|| {
        for (name, record) in &records {
            insta::assert_snapshot!(name.as_str(), record);
        }
    });
    for (name, record) in &records {
        for word in
            ["i64", "f64", "f32", "i128", "u8", "anon$", "&str", "ImmutableString", "rhai", "Dynamic", "Handle", "alloc::", "::script::"]
        {
            let messages = record.split("\n----\n").nth(1).unwrap().replace(".rhai", "");
            assert!(!messages.contains(word), "{name} shows the word {word}:\n{messages}");
        }
    }
}
