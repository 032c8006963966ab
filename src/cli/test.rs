//! `conserva test`: runs script tests, several at a time, each in an engine of its own.
//!
//! Lines come in the order of files and tests, whatever finishes first. A folder that is named is searched for `.rhai` files; without any
//! path, the current folder is searched for files with functions `test_…`.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use clap::Args;

use super::console::{Console, complain, ink};
use super::junit::{Tested, junit};
use super::memory::MemoryArguments;
use super::process::{STACK, exit_code};
use super::script_arguments::threads;
use super::signals::interrupt;
use crate::script::{
    Class, Diagnostic, Ink, MAX_OPERATIONS, Settings, TestCase, TestOutcome, processors, script_files, tests_of, worthwhile,
};

/// Arguments of `conserva test`.
#[derive(Args)]
pub struct Arguments {
    /// Scripts or folders of scripts [default: scripts below the current folder that have functions `test_…`]
    paths: Vec<PathBuf>,
    /// Run only tests whose name (`file::function`) contains this text
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,
    /// List the tests without running any
    #[arg(long)]
    list: bool,
    /// Write the results as JUnit XML, too
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Tests run at a time [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<u16>,
    /// Let tests read files below this folder, too (each may read those below its own)
    #[arg(long, value_name = "DIR")]
    allow_read: Vec<PathBuf>,
    /// Operations after which a test counts as endless
    #[arg(long, value_name = "N", default_value_t = MAX_OPERATIONS)]
    max_operations: u64,
    #[command(flatten)]
    memory: MemoryArguments,
}

/// Number of slowest tests listed at the end.
const SLOWEST: usize = 3;
/// Least time of a test to be listed among the slowest.
const SLOW: Duration = Duration::from_millis(100);

/// Runs tests; returns the exit code: 0 all passed, 1 one failed, 2 a file does not parse or there is nothing to test.
pub fn test(arguments: Arguments) -> u8 {
    let begun = Instant::now();
    let interrupt = match interrupt() {
        Ok(interrupt) => interrupt,
        Err(error) => {
            complain(&format!("error: the interrupt key cannot be watched\n= cause: {error}\n"));
            return exit_code(Class::Internal);
        }
    };
    let Arguments { paths, filter, list, junit: report, threads, allow_read, max_operations, memory } = arguments;
    memory.apply();
    let threads = threads.map_or_else(processors, |count| worthwhile(usize::from(count)));
    // Processors left beside the simultaneous tests.
    let workers = (processors() / threads).max(1);
    let settings = Settings { allow_read, max_operations, interrupt: interrupt.clone(), workers, ..Settings::default() };
    let console = Console::new(true);
    let (mut cases, broken) = collect(&paths, &settings);
    for (_, error) in &broken {
        complain(&error.render(ink()));
    }
    let found = cases.len();
    if let Some(text) = &filter {
        cases.retain(|case| case.title().contains(text.as_str()));
    }
    if cases.is_empty() && broken.is_empty() {
        let error = Diagnostic::error(Class::Script, "there is nothing to test");
        complain(
            &if found > 0 { error.cause(format!("none of {found} tests has the text of `--filter` in its name")) } else { error }
                .hint("a test is a function `test_…` without parameters, or a whole script that is named")
                .render(ink()),
        );
        return exit_code(Class::Script);
    }
    if list {
        cases.iter().for_each(|case| console.say(&case.title()));
        return if broken.is_empty() { 0 } else { exit_code(Class::Script) };
    }
    let tested = run_all(cases, threads, &settings, &console);
    let failed: Vec<&Tested> = tested.iter().filter(|test| test.outcome.error.is_some()).collect();
    for test in &failed {
        show_failure(test, &console);
    }
    summarize(&tested, failed.len(), broken.len(), threads, begun.elapsed(), &console);
    if let Some(file) = report {
        let mut suites: Vec<(String, Vec<&Tested>)> = Vec::new();
        for test in &tested {
            let file = test.case.file.display().to_string();
            match suites.last_mut().filter(|(last, _)| *last == file) {
                Some((_, tests)) => tests.push(test),
                None => suites.push((file, vec![test])),
            }
        }
        let broken: Vec<(String, String)> = broken.iter().map(|(file, error)| (file.clone(), error.render(Ink::Plain))).collect();
        if let Err(error) = std::fs::write(&file, junit(&suites, &broken, begun.elapsed().as_secs_f64())) {
            let message = Diagnostic::error(Class::Script, format!("{} cannot be written", file.display()));
            complain(&message.cause(error.to_string()).hint("name a file in an existing folder").render(ink()));
            return exit_code(Class::Script);
        }
    }
    if interrupt.load(Ordering::Relaxed) {
        exit_code(Class::Interrupted)
    } else if !broken.is_empty() {
        exit_code(Class::Script)
    } else {
        u8::from(!failed.is_empty())
    }
}

/// Returns the tests of all paths, and files that cannot be read or do not parse.
fn collect(paths: &[PathBuf], settings: &Settings) -> (Vec<TestCase>, Vec<(String, Diagnostic)>) {
    let (mut cases, mut broken) = (Vec::new(), Vec::new());
    let named = !paths.is_empty();
    let here = [PathBuf::from(".")];
    for path in if named { paths } else { &here } {
        let files = if path.is_dir() { script_files(path) } else { Ok(vec![path.clone()]) };
        let files = match files {
            Ok(files) => files,
            Err(error) => {
                let message = Diagnostic::error(Class::Script, format!("the folder {} cannot be read", path.display()));
                broken.push((path.display().to_string(), message.cause(error.to_string())));
                continue;
            }
        };
        for file in files {
            let file = file.strip_prefix("./").map(Path::to_path_buf).unwrap_or(file);
            match tests_of(&file, settings) {
                Ok(found) => {
                    found.warnings.iter().for_each(|warning| complain(&warning.render(ink())));
                    cases.extend(found.cases.into_iter().filter(|case| named || case.function.is_some()));
                }
                Err(error) => broken.push((file.display().to_string(), *error)),
            }
        }
    }
    (cases, broken)
}

/// Runs tests on threads; reports each test as soon as it and all before it have ended.
fn run_all(cases: Vec<TestCase>, threads: usize, settings: &Settings, console: &Console) -> Vec<Tested> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<Option<TestOutcome>>> = Mutex::new(vec![None; cases.len()]);
    let (sender, receiver) = std::sync::mpsc::channel::<()>();
    std::thread::scope(|scope| {
        for number in 0..threads.min(cases.len()) {
            let (next, done, cases, sender) = (&next, &done, &cases, sender.clone());
            let work = move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(index) else { break };
                    if settings.interrupt.load(Ordering::Relaxed) {
                        break;
                    }
                    let outcome = case.run(settings);
                    if let Ok(mut done) = done.lock() {
                        done[index] = Some(outcome);
                    }
                    let _ = sender.send(());
                }
            };
            if std::thread::Builder::new().name(format!("test-{number}")).stack_size(STACK).spawn_scoped(scope, work).is_err() {
                break;
            }
        }
        drop(sender);
        let mut said = 0;
        while receiver.recv().is_ok() {
            let Ok(done) = done.lock() else { break };
            while let Some(Some(outcome)) = done.get(said) {
                let word = if outcome.error.is_some() { "FAIL" } else { "ok  " };
                console.say(&format!("{word}  {}  ({})", cases[said].title(), duration(outcome.time)));
                said += 1;
            }
        }
    });
    let outcomes = done.into_inner().unwrap_or_default();
    cases.into_iter().zip(outcomes).filter_map(|(case, outcome)| outcome.map(|outcome| Tested { case, outcome })).collect()
}

fn show_failure(test: &Tested, console: &Console) {
    let Some(error) = &test.outcome.error else { return };
    console.say(&format!("\nFAIL  {}", test.case.title()));
    console.say(error.render(Ink::Plain).trim_end());
    if !test.outcome.output.is_empty() {
        console.say("output:");
        for line in &test.outcome.output {
            console.say(&format!("  {line}"));
        }
    }
}

fn summarize(tested: &[Tested], failed: usize, broken: usize, threads: usize, time: Duration, console: &Console) {
    let mut slowest: Vec<&Tested> = tested.iter().filter(|test| test.outcome.time >= SLOW).collect();
    slowest.sort_by_key(|test| std::cmp::Reverse(test.outcome.time));
    if !slowest.is_empty() && tested.len() > SLOWEST {
        let named = slowest.iter().take(SLOWEST).map(|test| format!("{} ({})", test.case.title(), duration(test.outcome.time)));
        console.say(&format!("\nslowest: {}", named.collect::<Vec<_>>().join(", ")));
    }
    let mut files: Vec<&Path> = tested.iter().map(|test| test.case.file.as_path()).collect();
    files.dedup();
    let wrong = match broken {
        0 => String::new(),
        1 => ", 1 file does not parse".into(),
        count => format!(", {count} files do not parse"),
    };
    let passed = tested.len() - failed;
    console.say(&format!(
        "\n{} in {}: {passed} passed, {failed} failed{wrong} ({} on {})",
        counted(tested.len(), "test"),
        counted(files.len(), "file"),
        duration(time),
        counted(threads, "thread")
    ));
}

fn counted(count: usize, word: &str) -> String {
    format!("{count} {word}{}", if count == 1 { "" } else { "s" })
}

fn duration(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    if seconds < 1.0 { format!("{:.0} ms", 1e3 * seconds) } else { format!("{seconds:.2} s") }
}
