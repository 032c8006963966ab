//! A script run without interruption, and again with kills at random moments and resumed until it completes.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use super::super::run_files::difference;
use super::super::splitmix::SplitMix;
use super::generator::{TABLE, script};

/// Rows of the killed run.
const ROWS: &str = "k/history.csv";
/// Signals that end a run, as `kill` names them; `timeout` sends each to the process and to its group.
const SIGNALS: [&str; 5] = ["-KILL", "-KILL", "-TERM", "-INT", "-HUP"];
/// Largest time between two signals of `timeout`.
const APART: Duration = Duration::from_millis(30);
/// Largest number of kills of a run.
const MOST_KILLS: usize = 4;
/// Time after which a run counts as hanging.
const PATIENCE: Duration = Duration::from_secs(300);

/// Outcome of a script.
#[derive(Default)]
pub struct Course {
    /// Description of a fault.
    pub fault: Option<String>,
    /// Number of kills.
    pub kills: usize,
    /// Number of kills by two signals of which the first ended the run.
    pub doubled: usize,
    /// Number of processes that continued from a checkpoint.
    pub resumed: usize,
    /// Exit code of the uninterrupted run.
    pub code: Option<i32>,
}

/// Runs the script of a seed in an empty folder; `program` is the binary.
pub fn course(program: &Path, home: &Path, seed: u64) -> Course {
    let _ = std::fs::remove_dir_all(home);
    std::fs::create_dir_all(home).unwrap();
    std::fs::write(home.join("main.rhai"), script(seed)).unwrap();
    std::fs::write(home.join("table.csv"), TABLE).unwrap();
    let mut random = SplitMix(seed ^ 0x6b69_6c6c);
    let begun = Instant::now();
    let whole = command(program, home, &["run", "main.rhai", "--quiet", "--out", "whole"]).output().unwrap();
    let took = begun.elapsed();
    let mut found = Course { code: whole.status.code(), ..Course::default() };
    let every = ["1", "2", "5", "20", "1min"][random.below(5)];
    let mut kills = 1 + random.below(MOST_KILLS);
    for _ in 0..4 * MOST_KILLS {
        let has_checkpoint = has_checkpoint(home);
        let rows_before = std::fs::read(home.join(ROWS)).ok();
        let threads = ["1", "2"][random.below(2)];
        let arguments: &[&str] = if has_checkpoint {
            &["resume", "k", "--quiet", "--checkpoint", every, "--threads", threads]
        } else {
            &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", every, "--threads", threads]
        };
        found.resumed += usize::from(has_checkpoint);
        let mut child = command(program, home, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut is_doubled = false;
        let is_killed = kills > 0 && {
            std::thread::sleep(took.mul_f64(random.below(1000) as f64 / 900.0));
            kills -= 1;
            child.try_wait().unwrap().is_none()
        };
        if is_killed {
            found.kills += 1;
            let name = SIGNALS[random.below(SIGNALS.len())];
            signal(&child, name);
            is_doubled = random.below(2) == 0 && name != "-KILL";
            if is_doubled {
                std::thread::sleep(APART.mul_f64(random.below(1000) as f64 / 1000.0));
                signal(&child, name);
            }
        }
        let output = ended(child);
        let code = output.status.code();
        if is_doubled && code == Some(130) {
            found.doubled += 1;
            let has_steps = has_checkpoint || std::fs::read(home.join(ROWS)).ok() != rows_before;
            if let Some(fault) = unfinished(home, &output, has_steps) {
                found.fault = Some(fault);
                return found;
            }
        }
        if is_killed && (code.is_none() || code == Some(130)) {
            continue;
        }
        found.fault = fault(home, &whole, &output, has_checkpoint);
        return found;
    }
    found.fault = Some("it does not come to its end".into());
    found
}

/// True if the killed run has a checkpoint.
fn has_checkpoint(home: &Path) -> bool {
    let entries = std::fs::read_dir(home.join("k/checkpoints")).into_iter().flatten().flatten();
    entries.into_iter().any(|entry| entry.path().extension().is_some_and(|ending| ending == "checkpoint"))
}

/// Fault of a run that was interrupted: no message, or no checkpoint where a simulation has taken steps.
fn unfinished(home: &Path, output: &Output, has_steps: bool) -> Option<String> {
    let told = String::from_utf8_lossy(&output.stderr);
    let steps = std::fs::read_to_string(home.join(ROWS)).map_or(0, |text| text.lines().count());
    match (told.contains("interrupted"), has_checkpoint(home) || !has_steps || steps < 3) {
        (false, _) => Some(format!("two signals in a moment ended the run at once: {told}")),
        (_, false) => Some(format!("two signals in a moment left no checkpoint: {told}")),
        _ => None,
    }
}

/// Fault of a completed run.
fn fault(home: &Path, whole: &Output, output: &Output, is_resumed: bool) -> Option<String> {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.code() != whole.status.code() {
        let how = if is_resumed { "resumed" } else { "run again" };
        return Some(format!("{how}: exit code {:?}, not {:?}\n{}", output.status.code(), whole.status.code(), text(&output.stderr)));
    }
    if output.stdout != whole.stdout {
        let (expected, found) = (text(&whole.stdout), text(&output.stdout));
        let line = expected.lines().zip(found.lines()).position(|(a, b)| a != b).unwrap_or(0);
        let at = |text: &str| text.lines().nth(line).unwrap_or_default().to_string();
        return Some(format!("printed line {line} is another one:\n  {}\n  {}", at(&expected), at(&found)));
    }
    // A run that ends with an error keeps its checkpoints, which differ.
    for run in ["whole", "k"].iter().filter(|_| !matches!(whole.status.code(), Some(0 | 1 | 4))) {
        let _ = std::fs::remove_dir_all(home.join(run).join("checkpoints"));
        let _ = std::fs::remove_file(home.join(run).join(".files"));
    }
    difference(&home.join("whole"), &home.join("k"))
}

fn command(program: &Path, home: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.current_dir(home).args(arguments);
    command
}

fn signal(child: &Child, name: &str) {
    // A signal to a run that has ended fails.
    let _ = Command::new("kill").args([name, &child.id().to_string()]).stderr(Stdio::null()).status();
}

/// Waits for the end of a process; kills it after [`PATIENCE`].
fn ended(mut child: Child) -> Output {
    let (begun, id) = (Instant::now(), child.id());
    let watch = std::thread::scope(|scope| {
        let (mut out, mut errors) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
        let stderr = scope.spawn(move || all(&mut errors));
        let stdout = scope.spawn(move || all(&mut out));
        while child.try_wait().unwrap().is_none() {
            if begun.elapsed() > PATIENCE {
                eprintln!("process {id} takes too long");
                child.kill().unwrap();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        (stdout.join().unwrap(), stderr.join().unwrap())
    });
    Output { status: child.wait().unwrap(), stdout: watch.0, stderr: watch.1 }
}

fn all(from: &mut impl std::io::Read) -> Vec<u8> {
    let mut bytes = Vec::new();
    let _ = from.read_to_end(&mut bytes);
    bytes
}
