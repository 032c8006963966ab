//! Mutated scripts: whatever a user types, the program answers with a message. No panic, no hang, no exhausted memory.
//!
//! The shipped scripts and the examples of the reference are cut into tokens, and some of these are swapped, deleted, doubled or replaced:
//! numbers by extreme ones, names by other names of the language, texts by strange ones. Each result runs in a session of its own with
//! tight limits, or at the prompt. A seed makes every script again:
//! `FUZZ_SEED=7 FUZZ_MINUTES=10 cargo test --release --test fuzz_scripts -- --ignored --nocapture`.
//! Before a script runs it is written to a file, so that it is known even when the process dies.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

#[path = "common/splitmix.rs"]
mod splitmix;

use conserva::script::{Class, Diagnostic, Ink, Interactive, Kind, Mode, Observer, Parameter, Session, Settings};
use splitmix::SplitMix;

/// Time after which a script is interrupted, as by Ctrl-C.
const PATIENCE: Duration = Duration::from_millis(400);
const HANG: Duration = Duration::from_secs(60);
/// Time that a script may take to stop; scripts that take longer are stored, because the machine may be busy.
const STOPPED: Duration = Duration::from_secs(1);
/// Limit of operations of a script: no example needs a hundredth of it.
const OPERATIONS: u64 = 300_000;

/// An observer that draws every message, because drawing may fail, too.
struct Drawing;

impl Observer for Drawing {
    fn warn(&self, warning: &Diagnostic) {
        let _ = warning.render(Ink::Colored);
    }
}

/// Splits a text into words, numbers, strings, signs and white space.
fn tokens(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let mut letters = text.chars().peekable();
    while let Some(first) = letters.next() {
        let mut token = String::from(first);
        let mut take_while = |token: &mut String, accept: &dyn Fn(char) -> bool| {
            while let Some(letter) = letters.next_if(|letter| accept(*letter)) {
                token.push(letter);
            }
        };
        match first {
            _ if first.is_alphabetic() || first == '_' => take_while(&mut token, &|letter| letter.is_alphanumeric() || letter == '_'),
            '0'..='9' => take_while(&mut token, &|letter| letter.is_alphanumeric() || letter == '.' || letter == '_'),
            '"' => {
                take_while(&mut token, &|letter| letter != '"' && letter != '\n');
                take_while(&mut token, &|letter| letter == '"');
            }
            _ if first.is_whitespace() => take_while(&mut token, &char::is_whitespace),
            '/' => {
                take_while(&mut token, &|letter| letter == '/');
                if token.len() > 1 {
                    take_while(&mut token, &|letter| letter != '\n');
                }
            }
            _ => {}
        }
        found.push(token);
    }
    found
}

/// Unusual values in place of a number.
const NUMBERS: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "0.0",
    "-0.0",
    "1e-300",
    "-1e300",
    "1e300",
    "9223372036854775807",
    "-9223372036854775807",
    "1000000",
    "100000000",
    "0.5",
    "1e9",
    "(1.0/0.0)",
    "(0.0/0.0)",
    "1e-12",
    "3",
    "4294967296",
    "65536",
    "()",
    "true",
    "[]",
    "[1, 2, 3]",
    "#{}",
    "|x| x",
    "'c'",
];
const TEXTS: &[&str] = &[
    "\"\"",
    "\"../x\"",
    "\"/etc/passwd\"",
    "\"ä€𝄞\"",
    "\"\\u{0}\\x1b[31m\"",
    "`a\n${1 + 1}`",
    "`${`",
    "\"a.vtu\"",
    "\"x.svg\"",
    "\"con/../../y.svg\"",
    "\"energy\"",
    "\"left\"",
    "\"\\\"",
    "\"punch_22.msh\"",
    "\".\"",
];
const SIGNS: &[&str] = &[
    "(", ")", "[", "]", "{", "}", "#{", ",", ";", ".", ":", "=", "==", "+", "-", "*", "/", "%", "**", "|", "||", "&&", "!", "?.", "??",
    "..", "..=", "=>", "::", "+=", "<", ">", "<<", ">>", "\n", "/*", "*/", "//", "`", "\"", "\\", "$", "@", "\u{feff}", "\u{0}", "𝄞",
];
const WORDS: &[&str] = &[
    "let",
    "const",
    "fn",
    "if",
    "else",
    "for",
    "in",
    "while",
    "loop",
    "do",
    "until",
    "return",
    "throw",
    "try",
    "catch",
    "import",
    "as",
    "export",
    "switch",
    "break",
    "continue",
    "private",
    "this",
    "global",
    "eval",
    "is_def_fn",
    "Fn",
    "call",
    "curry",
    "print",
    "debug",
    "type_of",
    "len",
    "pad",
    "push",
    "range",
    "parse_float",
    "sort",
    "map",
    "filter",
    "reduce",
    "split",
    "chunk",
    "to_string",
    "ans",
];

/// Scripts and names that mutations use.
struct Corpus {
    scripts: Vec<String>,
    names: Vec<String>,
}

fn read_scripts(folder: &Path, scripts: &mut Vec<String>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            read_scripts(&path, scripts);
        } else if path.extension().is_some_and(|ending| ending == "rhai") {
            scripts.extend(std::fs::read_to_string(path));
        }
    }
}

impl Corpus {
    fn new(home: &Path) -> Self {
        let session = Session::new(Settings::default(), home, Rc::new(Drawing)).unwrap();
        let registry = session.registry();
        let mut names: Vec<String> = registry.functions().iter().map(|function| function.name.to_string()).collect();
        names.extend(registry.functions().iter().flat_map(|function| function.parameters.iter()).flat_map(names_of));
        names.extend(WORDS.iter().map(ToString::to_string));
        names.sort();
        names.dedup();
        let mut scripts = Vec::new();
        for folder in ["scripts", "tests/scripts", "tests/errors/cases"] {
            read_scripts(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut scripts);
        }
        // Examples are short and many; together they have the same weight as the files.
        scripts.extend(registry.functions().iter().map(|function| function.example.to_string()));
        Corpus { scripts, names }
    }

    /// A script of a seed.
    fn script(&self, random: &mut SplitMix) -> String {
        let mut parts = tokens(random.pick(&self.scripts).as_str());
        for _ in 0..1 + random.below(6) {
            self.mutate(&mut parts, random);
        }
        parts.concat()
    }

    fn mutate(&self, parts: &mut Vec<String>, random: &mut SplitMix) {
        if parts.is_empty() {
            parts.push(random.pick(WORDS).to_string());
        }
        let solid: Vec<usize> = (0..parts.len()).filter(|&index| !parts[index].trim().is_empty()).collect();
        let at = if solid.is_empty() { 0 } else { *random.pick(&solid) };
        let of_kind = |wanted: fn(char) -> bool| -> Vec<usize> {
            solid.iter().copied().filter(|&index| parts[index].chars().next().is_some_and(wanted)).collect()
        };
        match random.below(10) {
            0 => {
                let other = random.below(parts.len());
                parts.swap(at, other);
            }
            1 => drop(parts.remove(at)),
            2 => parts.insert(at, parts[at].clone()),
            3 | 4 => {
                let numbers = of_kind(|first| first.is_ascii_digit());
                if !numbers.is_empty() {
                    let at = *random.pick(&numbers);
                    parts[at] = random.pick(NUMBERS).to_string();
                }
            }
            5 | 6 => {
                let words = of_kind(|first| first.is_alphabetic());
                if !words.is_empty() {
                    let at = *random.pick(&words);
                    parts[at] = random.pick(&self.names).clone();
                }
            }
            7 => {
                let texts = of_kind(|first| first == '"');
                if !texts.is_empty() {
                    let at = *random.pick(&texts);
                    parts[at] = random.pick(TEXTS).to_string();
                }
            }
            8 => parts.insert(at, random.pick(SIGNS).to_string()),
            _ => {
                // Part of another script, at line ends or not.
                let other = tokens(random.pick(&self.scripts).as_str());
                let from = random.below(other.len());
                let until = (from + 1 + random.below(20)).min(other.len());
                parts.splice(at..at, other[from.min(until)..until].iter().cloned());
            }
        }
    }
}

/// Names of a parameter and of its keys.
fn names_of(parameter: &Parameter) -> Vec<String> {
    let inner = match &parameter.kind {
        Kind::Options(keys) => keys.iter().flat_map(names_of).collect(),
        _ => Vec::new(),
    };
    [vec![parameter.name.to_string()], inner].concat()
}

/// Runs a script, or enters it at the prompt.
fn run(script: &str, random: &mut SplitMix, folder: &Path, interrupt: &Arc<AtomicBool>) -> Option<Diagnostic> {
    let settings = Settings {
        mode: if random.below(8) == 0 { Mode::Check } else { Mode::Run },
        output: Some(folder.join("out")),
        max_operations: OPERATIONS,
        interrupt: interrupt.clone(),
        interactive: false,
        ..Settings::default()
    };
    let home = folder.join("home");
    if random.below(4) > 0 {
        let mut session = Session::new(settings, &home, Rc::new(Drawing)).unwrap();
        return session.run_test("fuzz.rhai", script, None).error;
    }
    let mut session = Interactive::new(Settings { mode: Mode::Run, interactive: true, ..settings }, &home, Rc::new(Drawing)).unwrap();
    let mut worst = None;
    // Several lines at a time, with completions between them.
    let lines: Vec<&str> = script.lines().collect();
    for entry in lines.chunks(1 + random.below(12)) {
        let entry = entry.join("\n");
        let cut = (0..=random.below(entry.len() + 1)).rev().find(|&at| entry.is_char_boundary(at)).unwrap_or(0);
        let typed = &entry[..cut];
        let _ = (session.is_incomplete(typed), session.complete(typed), session.hint(typed), session.styles(typed), session.help(typed));
        if let Err(error) = session.evaluate(&entry) {
            let _ = error.render(Ink::Plain);
            if error.class == Class::Internal {
                worst = Some(*error);
            }
        }
        if interrupt.load(Ordering::Relaxed) {
            break;
        }
    }
    let _ = (session.script(), session.variables());
    worst.or(session.finish().error)
}

/// State that the watching thread reads.
struct Watch {
    begun: Mutex<Instant>,
    interrupt: Arc<AtomicBool>,
    is_over: AtomicBool,
    script: Mutex<String>,
    seed: AtomicU64,
}

/// Interrupts scripts after [`PATIENCE`]; ends the process if a script does not stop.
fn watch(watch: &Watch) {
    while !watch.is_over.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(20));
        let elapsed = watch.begun.lock().unwrap().elapsed();
        if elapsed > PATIENCE {
            watch.interrupt.store(true, Ordering::Relaxed);
        }
        if elapsed > HANG {
            eprintln!("seed {} does not stop:\n{}", watch.seed.load(Ordering::Relaxed), watch.script.lock().unwrap());
            std::process::exit(3);
        }
    }
}

/// Runs scripts of consecutive seeds until the time is up; returns those that caused a panic.
fn fuzz(first_seed: u64, time: Duration, name: &str) -> Result<u64, String> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{name}"));
    let home = folder.join("home");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(home.join("lib")).unwrap();
    let repository = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::fs::copy(repository.join("tests/meshes/punch_22.msh"), home.join("punch_22.msh")).unwrap();
    std::fs::write(home.join("lib/rings.rhai"), "fn ramp_of(k) { |t| k * t }\nconst K = 3.0;\n").unwrap();
    let corpus = Corpus::new(&home);
    let state = Arc::new(Watch {
        begun: Mutex::new(Instant::now()),
        interrupt: Arc::default(),
        is_over: AtomicBool::new(false),
        script: Mutex::default(),
        seed: AtomicU64::new(0),
    });
    let watchman = std::thread::spawn({
        let state = state.clone();
        move || watch(&state)
    });
    let begun = Instant::now();
    let mut found = Vec::new();
    let (mut seed, mut slowest, mut late) = (first_seed, Duration::ZERO, 0);
    while begun.elapsed() < time {
        let mut random = SplitMix(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
        let script = corpus.script(&mut random);
        std::fs::write(folder.join("current.rhai"), format!("// seed {seed}\n{script}")).unwrap();
        *state.script.lock().unwrap() = script.clone();
        state.seed.store(seed, Ordering::Relaxed);
        state.interrupt.store(false, Ordering::Relaxed);
        *state.begun.lock().unwrap() = Instant::now();
        let outcome = run(&script, &mut random, &folder, &state.interrupt);
        let elapsed = state.begun.lock().unwrap().elapsed();
        slowest = elapsed.max(slowest);
        if elapsed > PATIENCE + STOPPED {
            late += 1;
            std::fs::write(folder.join(format!("late_{seed}.rhai")), format!("// seed {seed}, {elapsed:?}\n{script}")).unwrap();
        }
        if let Some(error) = outcome {
            let drawn = error.render(Ink::Plain);
            if error.class == Class::Internal {
                let text = format!("seed {seed}:\n{script}\n----\n{drawn}");
                eprintln!("{text}");
                found.push(text);
            }
        }
        seed += 1;
        if seed % 200 == 0 {
            let _ = std::fs::remove_dir_all(folder.join("out"));
        }
    }
    state.is_over.store(true, Ordering::Relaxed);
    let _ = watchman.join();
    let memory = conserva::output::peak_memory_bytes().unwrap_or(0) >> 20;
    eprintln!(
        "{} scripts, the slowest {slowest:?}, {late} stopped later than a second, peak memory {memory} MiB: {}",
        seed - first_seed,
        folder.display()
    );
    if found.is_empty() { Ok(seed - first_seed) } else { Err(found.join("\n====\n")) }
}

fn number(name: &str, otherwise: f64) -> f64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn some_seconds_of_mutated_scripts_find_no_panic() {
    let tried = fuzz(1, Duration::from_secs(5), "short").unwrap_or_else(|found| panic!("{found}"));
    assert!(tried > 20, "{tried} scripts");
}

#[test]
#[ignore = "takes ten minutes"]
fn minutes_of_mutated_scripts_find_no_panic() {
    let minutes = number("FUZZ_MINUTES", 10.0);
    let seed = number("FUZZ_SEED", 1e6) as u64;
    fuzz(seed, Duration::from_secs_f64(60.0 * minutes), "long").unwrap_or_else(|found| panic!("{found}"));
}
