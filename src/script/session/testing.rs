//! Script tests: discovery of tests in a file, and execution of a test in its own engine.
//!
//! Every function `test_…` without parameters is a test; one with parameters gives a warning, because it is never called. A file without
//! such functions but with statements is one test as a whole, so that scenarios and tutorials test their own checks. A file with neither (a
//! module) has no tests.
//!
//! The expected output of a test can be given beside the line that causes it: `//~ error: text` (the test ends at this line with an error
//! that contains the text), `//~ warning: text` (the line gives a warning), `//~ prints: text` (the test prints exactly these lines, in
//! this order). Results are not written to disk.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::session::{Session, read_script};
use crate::script::language::diagnostics::{Diagnostic, Ink};
use crate::script::language::failure::Class;
use crate::script::language::observer::Observer;
use crate::script::language::settings::Settings;
use crate::script::language::sources::SourceSpan;

/// A test of a file.
#[derive(Clone, Debug)]
pub struct TestCase {
    /// Path of the file as given.
    pub file: PathBuf,
    /// The function; none when the whole file is the test.
    pub function: Option<String>,
    text: Arc<str>,
    marks: Vec<Mark>,
}

/// Outcome of a test.
#[derive(Clone, Debug)]
pub struct TestOutcome {
    /// Error with which the test failed.
    pub error: Option<Diagnostic>,
    /// Printed lines, checks and warnings of the test.
    pub output: Vec<String>,
    /// Time of the test, including the creation of its engine.
    pub time: Duration,
}

/// Message or output that a test script expects at one of its lines, written as a comment `//~ …`.
#[derive(Clone, Debug, PartialEq)]
struct Mark {
    kind: MarkKind,
    line: usize,
    text: String,
    /// First byte of the mark in its file.
    start: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum MarkKind {
    Error,
    Warning,
    Prints,
}

impl TestCase {
    /// Returns file and function, such as `rings.rhai::test_mass`.
    pub fn title(&self) -> String {
        match &self.function {
            Some(function) => format!("{}::{function}", self.file.display()),
            None => self.file.display().to_string(),
        }
    }

    /// Runs the test in its own session.
    pub fn run(&self, settings: &Settings) -> TestOutcome {
        let begun = Instant::now();
        let capture = Rc::new(Capture::default());
        let error = match Session::new(settings.clone(), home(&self.file), capture.clone()) {
            Ok(mut session) => session.run_test(&self.file.display().to_string(), &self.text, self.function.as_deref()).error,
            Err(error) => Some(*error),
        };
        let error = match error {
            Some(error) if matches!(error.class, Class::Interrupted | Class::Internal) => Some(error),
            error => self.judge(error, &capture),
        };
        TestOutcome { error, output: capture.lines(), time: begun.elapsed() }
    }

    /// Compares the outcome of a test with the messages that its script expects (`//~` marks).
    fn judge(&self, error: Option<Diagnostic>, capture: &Capture) -> Option<Diagnostic> {
        let (expected, other): (Vec<&Mark>, Vec<&Mark>) = self.marks.iter().partition(|mark| mark.kind == MarkKind::Error);
        let error = match (expected.as_slice(), error) {
            ([], error) => error,
            ([mark, ..], None) => Some(self.missed(mark, "the error that is expected here did not come", None)),
            ([first, ..], Some(error)) => match expected.iter().find(|mark| self.fits(mark, &error)) {
                Some(_) if expected.len() == 1 => None,
                Some(_) => Some(self.missed(expected[1], "a test ends with its first error, so it cannot have two", None)),
                None => Some(self.missed(first, "another error came than the one expected here", Some(&error))),
            },
        };
        if error.is_some() {
            return error;
        }
        let warnings = capture.warnings.borrow();
        for mark in other.iter().filter(|mark| mark.kind == MarkKind::Warning) {
            if !warnings.iter().any(|warning| self.fits(mark, warning)) {
                return Some(self.missed(mark, "the warning that is expected here did not come", warnings.last()));
            }
        }
        let wanted: Vec<&Mark> = other.into_iter().filter(|mark| mark.kind == MarkKind::Prints).collect();
        let (Some(last), printed) = (wanted.last(), capture.printed.borrow()) else { return None };
        for (mark, line) in wanted.iter().zip(printed.iter()) {
            if mark.text != line.trim() {
                return Some(
                    self.missed(mark, "another line is printed than the one expected here", None).cause(format!("printed: {line}")),
                );
            }
        }
        match printed.len() {
            count if count < wanted.len() => Some(self.missed(wanted[count], "the line that is expected here is not printed", None)),
            count if count > wanted.len() => {
                let failure = self.missed(last, "more is printed than expected", None);
                Some(failure.cause(format!("after this line comes: {}", printed[wanted.len()])))
            }
            _ => None,
        }
    }

    /// True if the message refers to the marked line and contains the marked text.
    fn fits(&self, mark: &Mark, message: &Diagnostic) -> bool {
        let source = self.file.display().to_string();
        let places = message.place.iter().chain(message.frames.iter().filter_map(|frame| frame.place.as_ref()));
        let here = places.into_iter().any(|place| place.source == source && place.line_column().0 == mark.line);
        here && message.contains(&mark.text)
    }

    fn missed(&self, mark: &Mark, title: &str, came: Option<&Diagnostic>) -> Diagnostic {
        let end = self.text[mark.start..].find('\n').map_or(self.text.len(), |newline| mark.start + newline);
        let range = mark.start..mark.start + self.text[mark.start..end].trim_end().len();
        let mut diagnostic = Diagnostic::error(Class::Check, title);
        diagnostic.place = Some(SourceSpan { source: self.file.display().to_string(), text: self.text.clone(), range });
        let diagnostic = diagnostic.label("expected here");
        match came {
            Some(came) => {
                let place = came.place.as_ref().map(|place| format!("{place}: ")).unwrap_or_default();
                diagnostic.cause(format!("the message is: {place}{}", came.title))
            }
            None => diagnostic,
        }
    }
}

/// Folder of a script.
pub fn home(script: &Path) -> &Path {
    script.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Tests of a file.
#[derive(Clone, Debug, Default)]
pub struct TestFile {
    /// Tests, in the order of the file.
    pub cases: Vec<TestCase>,
    /// Warnings of functions that are named like tests but are not run.
    pub warnings: Vec<Diagnostic>,
}

/// The tests of a file.
///
/// # Errors
/// A file that cannot be read or does not parse, or a mark that belongs to no test.
pub fn tests_of(file: &Path, settings: &Settings) -> Result<TestFile, Box<Diagnostic>> {
    let text: Arc<str> = read_script(file)?.into();
    let source = file.display().to_string();
    let session = Session::new(settings.clone(), home(file), Rc::new(Capture::default()))?;
    let outline = session.outline(&source, &text)?;
    let marks = marks(&text);
    let case = |function: Option<String>, marks: Vec<Mark>| TestCase { file: file.into(), function, text: text.clone(), marks };
    let is_called = |name: &str| text.matches(&format!("{name}(")).count() > 1;
    let odd = outline.functions.iter().filter(|(name, parameters, _)| name.starts_with("test_") && *parameters > 0 && !is_called(name));
    let warnings: Vec<Diagnostic> = odd.map(|(name, parameters, start)| not_a_test(&source, &text, name, *parameters, *start)).collect();
    let is_test = |(name, parameters, _): &&(String, usize, usize)| name.starts_with("test_") && *parameters == 0;
    if !outline.functions.iter().any(|function| is_test(&function)) {
        let cases = if outline.has_statements { vec![case(None, marks)] } else { Vec::new() };
        return Ok(TestFile { cases, warnings });
    }
    let mut cases = Vec::new();
    let mut placed = 0;
    for (index, function) in outline.functions.iter().enumerate().filter(|(_, function)| is_test(function)) {
        let end = outline.functions.get(index + 1).map_or(usize::MAX, |next| next.2);
        let own: Vec<Mark> = marks.iter().filter(|mark| (function.2..end).contains(&mark.start)).cloned().collect();
        placed += own.len();
        cases.push(case(Some(function.0.clone()), own));
    }
    if placed < marks.len() {
        let free = marks.iter().find(|mark| !cases.iter().any(|case| case.marks.contains(mark)));
        let error = case(None, Vec::new()).missed(free.unwrap_or(&marks[0]), "the expectation belongs to no test", None);
        return Err(Box::new(error.hint("write it inside a function `test_…`")));
    }
    Ok(TestFile { cases, warnings })
}

/// The warning of a function that is named like a test and has parameters.
fn not_a_test(source: &str, text: &Arc<str>, name: &str, parameters: usize, start: usize) -> Diagnostic {
    let end = text[start..].find(')').map_or(text.len(), |end| start + end + 1);
    let place = SourceSpan { source: source.into(), text: text.clone(), range: start..end };
    let count = if parameters == 1 { "a parameter".to_string() } else { format!("{parameters} parameters") };
    let warning = Diagnostic::warning(format!("`{name}` is not run: a test has no parameters"), Some(place));
    let warning = warning.code("C1054").label(format!("it has {count}"));
    warning.hint(format!("set the values inside of it, or call it from a test: `fn {name}_with_one() {{ {name}(…) }}`"))
}

/// All `.rhai` files below a folder, in the order of their names; hidden folders are left out.
///
/// # Errors
/// A folder that cannot be read.
pub fn script_files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    entries.sort();
    for path in entries {
        let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if path.is_dir() && !hidden && !path.is_symlink() {
            found.extend(script_files(&path)?);
        } else if path.is_file() && path.extension().is_some_and(|ending| ending == "rhai") {
            found.push(path);
        }
    }
    Ok(found)
}

/// The marks of a text.
fn marks(text: &str) -> Vec<Mark> {
    let mut found = Vec::new();
    let mut start = 0;
    for (index, line) in text.split_inclusive('\n').enumerate() {
        for (word, kind) in [("error", MarkKind::Error), ("warning", MarkKind::Warning), ("prints", MarkKind::Prints)] {
            if let Some((before, after)) = line.split_once(&format!("//~ {word}:")) {
                found.push(Mark { kind, line: index + 1, text: after.trim().into(), start: start + before.len() });
            }
        }
        start += line.len();
    }
    found
}

/// Observer that collects the output of a test.
#[derive(Default)]
struct Capture {
    all: RefCell<Vec<String>>,
    printed: RefCell<Vec<String>>,
    warnings: RefCell<Vec<Diagnostic>>,
}

impl Capture {
    fn lines(&self) -> Vec<String> {
        self.all.borrow().clone()
    }

    fn say(&self, text: &str) {
        self.all.borrow_mut().extend(text.lines().map(Into::into));
    }
}

impl Observer for Capture {
    fn print(&self, line: &str) {
        self.say(line);
        self.printed.borrow_mut().extend(line.lines().map(Into::into));
    }

    fn passed(&self, line: &str) {
        self.say(line);
    }

    fn warn(&self, warning: &Diagnostic) {
        self.say(&warning.render(Ink::Plain));
        self.warnings.borrow_mut().push(warning.clone());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str, text: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("conserva-testing-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join(name);
        std::fs::write(&file, text).unwrap();
        file
    }

    fn cases(name: &str, text: &str) -> Vec<TestCase> {
        tests_of(&file(name, text), &Settings::default()).unwrap().cases
    }

    fn failure(case: &TestCase) -> String {
        case.run(&Settings::default()).error.map_or("passed".into(), |error| error.title)
    }

    #[test]
    fn functions_without_parameters_are_tests_and_so_is_a_file_of_statements() {
        let text = "const K = 2;\nfn double(x) { x * 2 }\nfn test_b() { expect(double(1) == 2); }\nfn test_of(x) { x }\n\
                    fn test_a() { expect(false); }\n";
        let found = cases("functions.rhai", text);
        assert_eq!(found.iter().map(|case| case.function.as_deref().unwrap()).collect::<Vec<_>>(), ["test_b", "test_a"]);
        assert_eq!(failure(&found[0]), "passed");
        let outcome = found[1].run(&Settings::default());
        assert_eq!(outcome.error.unwrap().place.unwrap().line_column(), (5, 22));
        let warnings = tests_of(&file("functions.rhai", text), &Settings::default()).unwrap().warnings;
        assert_eq!(warnings.len(), 1);
        assert_eq!(warnings[0].title, "`test_of` is not run: a test has no parameters");
        assert_eq!(warnings[0].place.as_ref().unwrap().line_column(), (4, 1));
        let endless = cases("endless.rhai", "fn turns() {\n  while true { }\n}\nfn test_x() { let x = 0; turns(); }\n");
        let error = endless[0].run(&Settings { max_operations: 1000, ..Settings::default() }).error.unwrap();
        assert_eq!(error.place.unwrap().line_column(), (2, 3));
        assert_eq!(cases("statements.rhai", "print(1);").len(), 1);
        assert!(cases("module.rhai", "fn double(x) { x * 2 }").is_empty());
        assert!(tests_of(&file("broken.rhai", "let x = ;"), &Settings::default()).is_err());
    }

    #[test]
    fn what_is_expected_beside_a_line_must_come() {
        let run = |text: &str| failure(&cases("marks.rhai", text)[0]);
        assert_eq!(run("let x = [1];\nx[3]; //~ error: no entry 3"), "passed");
        assert_eq!(run("let x = [1];\nx[3]; //~ error: no entry 4"), "another error came than the one expected here");
        assert_eq!(run("let x = [1];\nx[3];\n//~ error: no entry 3"), "another error came than the one expected here");
        assert_eq!(run("let x = [1]; //~ error: no entry"), "the error that is expected here did not come");
        assert_eq!(run("let x = 1/2; //~ warning: 1/2 is 0"), "passed");
        assert_eq!(run("let x = 1.0/2; //~ warning: 1/2 is 0"), "the warning that is expected here did not come");
        assert_eq!(run("print(1); //~ prints: 1\nprint(2); //~ prints: 2"), "passed");
        assert_eq!(run("print(1); //~ prints: 2"), "another line is printed than the one expected here");
        assert_eq!(run("print(1); //~ prints: 1\nprint(2);"), "more is printed than expected");
        assert_eq!(run("print(1); //~ prints: 1\n//~ prints: 2"), "the line that is expected here is not printed");
        let free = "//~ error: x\nfn test_a() {}\n";
        assert!(tests_of(&file("free.rhai", free), &Settings::default()).unwrap_err().title.contains("belongs to no test"));
    }

    #[test]
    fn each_test_has_its_own_engine_and_its_output_is_kept() {
        let text = "let m = model(\"m\");\nfn test_a() { print(\"a\"); expect(true); }\nfn test_b() { expect_close(1.0, 1.0); }\n";
        let found = cases("fresh.rhai", text);
        let output = found[0].run(&Settings::default()).output;
        assert_eq!(output[0], "a");
        assert!(output[1].starts_with("ok  true"), "{output:?}");
        assert_eq!(found[1].run(&Settings::default()).output.len(), 1);
    }
}
