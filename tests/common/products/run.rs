//! Execution of a product in this process, in a session with a folder; only the trial `process` starts a child process.

use std::cell::{Cell, RefCell};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use conserva::output::RunLock;
use conserva::output::checkpoint::{self, Checkpoint};
use conserva::script::{Checkpoints, Class, Diagnostic, Observer, Progress, Session, Settings};

use super::super::run_files::difference;
use super::numbers::Numbers;
use super::oracle::{self, Fault};
use super::script::{self, Variant};
use super::{Named, oracle::compare_histories};

/// Time after which a run is stopped and counts as endless.
const PATIENCE: Duration = Duration::from_secs(60);

/// Difference of a moved or renumbered model, relative to that of a model whose numbers change by round-off, that is admitted.
const MARGIN: f64 = 10.0;

/// Change of the numbers, in units of [`script::NUDGE`], for a translated model with steps that choose their size: a first touch is
/// resolved to a millionth of the largest coordinate.
const TOUCH: i32 = 1_000_000;

/// Pairs of changes by round-off that measure the sensitivity of a model.
const NUDGES: i32 = 5;

/// Relative change by round-off above which a model is chaotic, and a tolerance that admits every change.
const CHAOTIC: f64 = 1e-3;
const UNLIMITED: f64 = 1e9;

/// Code of the message that a joint contradicts a support: such a model has no motion, which is detected only when it should move.
const CONTRADICTION: &str = "C0511";

/// End of a run.
#[derive(Clone, Debug)]
pub struct Ended {
    /// Exit code of the program, by the class of its error.
    pub code: i32,
    /// The error.
    pub error: Option<Diagnostic>,
    /// Lines printed by the script.
    pub printed: Vec<String>,
    /// Titles of the warnings.
    pub warnings: Vec<String>,
    /// True if the run exceeded its time limit.
    pub is_endless: bool,
}

/// Verdict on a product.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The product ran without a violation.
    Sound,
    /// The program refused the product: code and title.
    Refused(String, String),
    /// The product ran, or failed, with these faults.
    Wrong(Vec<Fault>),
}

/// Observer of a session that stops the session after a number of steps or a time.
struct Listener {
    printed: RefCell<Vec<String>>,
    warnings: RefCell<Vec<String>>,
    steps: Cell<usize>,
    stop_after: Option<usize>,
    interrupt: Arc<AtomicBool>,
    begun: Instant,
    is_endless: Cell<bool>,
}

impl Observer for Listener {
    fn print(&self, line: &str) {
        self.printed.borrow_mut().push(line.into());
    }
    fn passed(&self, _: &str) {}
    fn warn(&self, warning: &Diagnostic) {
        self.warnings.borrow_mut().push(warning.title.clone());
    }
    fn advanced(&self, _: &Progress) {
        self.steps.set(self.steps.get() + 1);
        let is_late = self.begun.elapsed() > PATIENCE;
        if is_late {
            self.is_endless.set(true);
        }
        if is_late || self.stop_after.is_some_and(|steps| self.steps.get() >= steps) {
            self.interrupt.store(true, Ordering::Relaxed);
        }
    }
    fn began(&self, _: &str) {}
    fn ended(&self) {}
}

/// Variation of a run relative to the plain one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Manner {
    /// Threads of the element loop.
    pub threads: usize,
    /// Number of steps after which the run is interrupted, with checkpoints.
    pub stop_after: Option<usize>,
    /// True if the run is resumed from a checkpoint of its folder.
    pub is_resumed: bool,
    /// True if only the first step is run.
    pub is_probe: bool,
}

/// Exit code of the program for a class of errors, as in `docs/errors.md`.
fn exit_code(class: Class) -> i32 {
    match class {
        Class::Check => 1,
        Class::Script => 2,
        Class::Numerics | Class::Output | Class::Internal => 3,
        Class::Interrupted => 130,
        Class::ResultUsed => 0,
    }
}

/// Runs a script file with results in a folder.
pub fn run(script: &Path, out: &Path, manner: Manner) -> Ended {
    let interrupt: Arc<AtomicBool> = Arc::default();
    let listener = Rc::new(Listener {
        printed: RefCell::default(),
        warnings: RefCell::default(),
        steps: Cell::new(0),
        stop_after: if manner.is_probe { Some(1) } else { manner.stop_after },
        interrupt: interrupt.clone(),
        begun: Instant::now(),
        is_endless: Cell::new(false),
    });
    let has_checkpoints = manner.stop_after.is_some() || manner.is_resumed;
    let settings = Settings {
        output: Some(out.to_path_buf()),
        threads: manner.threads.max(1),
        workers: 1,
        interrupt,
        checkpoints: if has_checkpoints { Checkpoints::Steps(2) } else { Checkpoints::Never },
        ..Settings::default()
    };
    let home = script.parent().expect("a script has a folder");
    let mut session = Session::new(settings, home, listener.clone()).expect("the folder is there");
    if manner.is_resumed
        && let Err(error) = go_on(&mut session, out)
    {
        let error = Diagnostic::error(Class::Output, format!("cannot be resumed: {error}"));
        return Ended { code: 3, error: Some(error), printed: Vec::new(), warnings: Vec::new(), is_endless: false };
    }
    let report = session.run_file(script);
    let doubt = if report.is_doubtful { 4 } else { 0 };
    Ended {
        code: report.error.as_ref().map_or(doubt, |error| exit_code(error.class)),
        error: report.error,
        printed: listener.printed.take(),
        warnings: listener.warnings.take(),
        is_endless: listener.is_endless.get(),
    }
}

/// Takes a session to the last checkpoint of a run, as `conserva resume` does.
fn go_on(session: &mut Session, out: &Path) -> Result<(), String> {
    let place = checkpoint::places(out).pop().ok_or("no checkpoint")?;
    let lock = RunLock::take(out).map_err(|error| error.to_string())?;
    let found = Checkpoint::read(&place).map_err(|error| error.to_string())?;
    let aside = found.belongs_to(out).map_err(|error| error.to_string())?;
    checkpoint::restore_files(out, &aside).map_err(|error| error.to_string())?;
    session.resume(out, found, lock).map_err(|error| error.to_string())
}

/// Runs products and judges them.
pub struct Bench {
    /// Folder of the scripts and results, emptied before each product.
    pub home: PathBuf,
    /// Path of the program, for the trial `process`.
    pub program: PathBuf,
}

impl Bench {
    /// Verdict on a product.
    pub fn judge(&self, product: Named) -> Verdict {
        let script = script::text(product, Variant::Plain);
        let _ = std::fs::remove_dir_all(&self.home);
        std::fs::create_dir_all(&self.home).expect("the folder can be made");
        let place = self.home.join("main.rhai");
        std::fs::write(&place, script).expect("the script can be written");
        let out = self.home.join("out");
        let ended = run(&place, &out, Manner::default());
        if let Some(error) = &ended.error
            && (error.class == Class::Script || error.code == CONTRADICTION)
        {
            return Verdict::Refused(error.code.clone(), error.title.clone());
        }
        let mut faults = oracle::judge(product, &ended, &out);
        // Two faults with one cause are reported once.
        if faults.is_empty() {
            faults.extend(self.trial(product, &place, &ended));
        }
        if faults.is_empty() { Verdict::Sound } else { Verdict::Wrong(faults) }
    }

    /// Verdict on a product without its trial, and without a check of its faults.
    pub fn judge_once(&self, product: Named) -> Verdict {
        match self.refusal(product) {
            Some((code, title)) => Verdict::Refused(code, title),
            None => self.judge(product),
        }
    }

    /// Code and title with which the program refuses a product before its first step.
    pub fn refusal(&self, product: Named) -> Option<(String, String)> {
        let _ = std::fs::remove_dir_all(&self.home);
        std::fs::create_dir_all(&self.home).expect("the folder can be made");
        let place = self.home.join("main.rhai");
        std::fs::write(&place, script::text(product, Variant::Plain)).expect("the script can be written");
        let error = run(&place, &self.home.join("out"), Manner { is_probe: true, ..Manner::default() }).error?;
        (error.class == Class::Script).then_some((error.code, error.title))
    }

    /// Admitted difference of a moved or renumbered model; of chaotic models, whose differences no longer grow, any.
    fn admitted(&self, product: Named, ended: &Ended, size: i32) -> f64 {
        let sensitivity = self.sensitivity(product, ended, size);
        if sensitivity > CHAOTIC { UNLIMITED } else { MARGIN * sensitivity }
    }

    /// Largest relative change of energies, displacements and velocities at the end of a run when its numbers change by `size` times
    /// [`script::NUDGE`]; 0 if the changed model ends otherwise. Impacts and steps that choose their size amplify round-off a million
    /// times.
    fn sensitivity(&self, product: Named, ended: &Ended, size: i32) -> f64 {
        let (place, other) = (self.home.join("nudged.rhai"), self.home.join("nudged"));
        let change = |by: i32| {
            std::fs::write(&place, script::text(product, Variant::Nudged(by))).expect("the script can be written");
            let again = run(&place, &other, Manner::default());
            if again.code == ended.code { oracle::largest_change(&ended.printed, &again.printed) } else { 0.0 }
        };
        // Where an iteration decides between solutions, most changes lead to the same one.
        let mut largest = 0.0f64;
        for by in (1..=NUDGES).flat_map(|by| [-by * size, by * size]) {
            largest = largest.max(change(by));
            if largest > CHAOTIC {
                break;
            }
        }
        largest
    }

    /// Fault found by the trial of the product.
    fn trial(&self, product: Named, script: &Path, ended: &Ended) -> Option<Fault> {
        let [out, other] = ["out", "other"].map(|name| self.home.join(name));
        let numbers = Numbers::new(product.product.seed);
        let same = |kind: &'static str, again: &Ended| {
            if again.code != ended.code || again.printed != ended.printed {
                let place = again.printed.iter().zip(&ended.printed).find(|(a, b)| a != b);
                let title = again.error.as_ref().map(|error| error.title.clone()).unwrap_or_default();
                return Some(Fault::new(kind, format!("code {} and {}, {title}, printed {place:?}", ended.code, again.code)));
            }
            difference(&out, &other).map(|difference| Fault::new(kind, difference))
        };
        let moved = |kind: &'static str, how: String| {
            let place = self.home.join("moved.rhai");
            let ends = |how: &str| {
                std::fs::write(&place, script::moved(product, how)).expect("the script can be written");
                run(&place, &other, Manner::default()).error
            };
            let mut error = ends(&how)?;
            if error.class == Class::Check {
                // Round-off of the rotated model may have the consequences that a change of the input by round-off has, not larger ones.
                let is_touch_moved = kind == "translated" && product.is("steps", &["auto"]);
                let tolerance = self.admitted(product, ended, if is_touch_moved { TOUCH } else { 1 });
                if tolerance > oracle::INVARIANT {
                    error = ends(&format!("{how}, tolerance: {tolerance:?}"))?;
                }
            }
            let title = error.title.clone();
            // A refusal of the rotated model is no fault.
            (error.class != Class::Script).then(|| Fault::new(kind, format!("{} {title} {}", error.code, error.causes.join("; "))))
        };
        match product.row("trial") {
            "threads" => same("threads", &run(script, &other, Manner { threads: 2, ..Manner::default() })),
            "resume" => {
                let manner = Manner { stop_after: Some(numbers.interrupted), ..Manner::default() };
                let first = run(script, &other, manner);
                if first.code != 130 {
                    return None;
                }
                let again = run(script, &other, Manner { is_resumed: true, ..Manner::default() });
                same("resume", &again)
            }
            "rotate" => moved("rotated", format!("rotate: {:?}", numbers.angle)),
            "translate" => moved(
                "translated",
                format!("translate: {}", if script::dimension(product) == 2 { "[0.0, 0.7]" } else { "[0.4, 0.7, -0.3]" }),
            ),
            "units" => moved("units", "units: #{ mass: 1e3, length: 1e-2, time: 10.0 }".into()),
            "renumber" => {
                let place = self.home.join("renumbered.rhai");
                std::fs::write(&place, script::text(product, Variant::Renumbered)).expect("the script can be written");
                let again = run(&place, &other, Manner::default());
                compare_histories("renumbered", (ended, &out), (&again, &other), &|| self.admitted(product, ended, 1))
            }
            "process" => {
                let mut command = Command::new(&self.program);
                command.current_dir(&self.home).arg("run").arg(script).args(["--quiet", "--checkpoint", "never", "--out"]).arg(&other);
                let output = command.output().expect("the program can be started");
                let printed = String::from_utf8_lossy(&output.stdout).lines().map(String::from).collect();
                let code = output.status.code().unwrap_or(-1);
                same("process", &Ended { code, printed, error: None, warnings: Vec::new(), is_endless: false })
            }
            _ => None,
        }
    }
}
