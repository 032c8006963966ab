//! Effects of signals on a run, as in the table of `docs/files.md`.

use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::program::{conserva, folder};

/// A run that does not end by itself.
pub const ENDLESS: &str = "let m = model(\"flight\");\n\
    let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });\n\
    let plate = m.add_body(\"plate\", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), rubber);\n\
    m.initial_velocity(plate, #{ linear: [1.0, 0.0], angular: 2.0 });\n\
    let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.01 });\n\
    sim.run_to(1e6);\n";

/// Command that starts the program from a shell after `before`.
pub fn by_shell(home: &Path, before: &str, arguments: &str) -> Command {
    let mut command = Command::new("sh");
    command.current_dir(home).arg("-c").arg(format!("{before}; exec \"$0\" {arguments}")).arg(env!("CARGO_BIN_EXE_conserva"));
    command
}

fn wait_for_rows(home: &Path, child: &mut Child) {
    let begun = Instant::now();
    while std::fs::read_to_string(home.join("out/main/history.csv")).map_or(0, |text| text.lines().count()) < 10 {
        assert!(begun.elapsed() < Duration::from_secs(60), "the run writes no rows");
        assert!(child.try_wait().unwrap().is_none(), "the run ended early");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn send(child: &Child, signal: &str) {
    assert!(Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap().success());
}

/// Asserts that a run ended with all files of an interrupted run.
fn assert_ended(home: &Path, child: &mut Child, why: &str) {
    assert_eq!(child.wait().unwrap().code(), Some(130), "{why}");
    let summary = std::fs::read_to_string(home.join("out/main/summary.json")).unwrap();
    assert!(summary.contains("\"outcome\": \"interrupted\""), "{why}: {summary}");
    assert!(home.join("out/main/report.html").is_file(), "{why}");
    let checkpoints = std::fs::read_dir(home.join("out/main/checkpoints")).unwrap().count();
    assert!(checkpoints > 0, "{why}: there is nothing to resume from");
}

#[test]
fn signals_that_end_a_run_leave_checkpoint_summary_and_report() {
    for signal in ["HUP", "INT", "TERM", "XCPU", "USR1"] {
        let home = folder(&format!("signal-{signal}"), ENDLESS);
        let mut child = conserva(&home, &["run", "main.rhai", "--quiet"]).stderr(Stdio::null()).spawn().unwrap();
        wait_for_rows(&home, &mut child);
        send(&child, signal);
        if signal != "INT" {
            // These signals are sent repeatedly by their senders.
            send(&child, signal);
        }
        assert_ended(&home, &mut child, signal);
    }
}

#[test]
fn a_second_interrupt_key_ends_the_process_at_once() {
    // Both processes are awaited, so that nothing happens between them.
    let home = folder("signal-twice", ENDLESS);
    let mut child = conserva(&home, &["run", "main.rhai", "--quiet"]).stderr(Stdio::null()).spawn().unwrap();
    wait_for_rows(&home, &mut child);
    send(&child, "STOP");
    send(&child, "INT");
    send(&child, "CONT");
    send(&child, "INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

#[test]
fn a_run_that_was_started_to_outlive_its_terminal_does() {
    let home = folder("signal-nohup", ENDLESS);
    let mut child = by_shell(&home, "trap '' HUP", "run main.rhai --quiet").stderr(Stdio::null()).spawn().unwrap();
    wait_for_rows(&home, &mut child);
    send(&child, "HUP");
    std::thread::sleep(Duration::from_millis(500));
    assert!(child.try_wait().unwrap().is_none(), "it ended");
    send(&child, "TERM");
    assert_ended(&home, &mut child, "nohup");
}

#[test]
fn a_limit_of_processor_time_ends_a_run_with_its_results() {
    let home = folder("signal-limit", ENDLESS);
    let mut child = by_shell(&home, "ulimit -S -t 1", "run main.rhai --quiet").stderr(Stdio::null()).spawn().unwrap();
    assert_ended(&home, &mut child, "ulimit -t");
}

#[test]
fn a_limit_of_file_sizes_is_a_file_that_cannot_be_written() {
    let home = folder("signal-file-size", ENDLESS);
    let mut child = by_shell(&home, "ulimit -f 32", "run main.rhai --quiet").stderr(Stdio::piped()).spawn().unwrap();
    let mut message = String::new();
    child.stderr.take().unwrap().read_to_string(&mut message).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(3), "{message}");
    assert!(message.contains("history.csv\" could not be written"), "{message}");
}

#[test]
fn the_signal_of_a_closed_pipe_changes_nothing() {
    let home = folder("signal-pipe", &ENDLESS.replace("sim.run_to(1e6)", "sim.run_to(8.0); print(`at ${sim.time}`)"));
    let mut child = conserva(&home, &["run", "main.rhai", "--quiet"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    // The program has started: an earlier signal would end it with the default action.
    wait_for_rows(&home, &mut child);
    send(&child, "PIPE");
    let mut message = String::new();
    child.stderr.take().unwrap().read_to_string(&mut message).unwrap();
    assert_eq!((child.wait().unwrap().code(), message.as_str()), (Some(0), ""));
    assert!(std::fs::read_to_string(home.join("out/main/summary.json")).unwrap().contains("\"outcome\": \"completed\""));
}
