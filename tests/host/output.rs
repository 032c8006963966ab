//! Standard output that cannot be written: it is reported, and the exit code shows it; a reader that closes its pipe is no error.

use std::fs::File;
use std::path::Path;
use std::process::Stdio;

use crate::program::{conserva, folder, stderr};

const SCRIPT: &str = "print(\"begun\");\n\
    let m = model(\"flight\");\n\
    let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: param(\"density\", 1.0) });\n\
    let plate = m.add_body(\"plate\", rectangle(#{ size: [2.0, 1.0], cells: [2, 1] }), rubber);\n\
    let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.01 });\n\
    sim.run_to(0.05);\n\
    expect(sim.time > 0.0);\n\
    fn test_a() { expect(true); }\n";

/// All commands that print, in a folder with a script, two of its runs and a study.
const COMMANDS: &[&[&str]] = &[
    &["run", "main.rhai", "--quiet", "--out", "again"],
    &["check", "main.rhai"],
    &["test", "main.rhai"],
    &["test", "main.rhai", "--list"],
    &["doc", "rectangle"],
    &["doc", "--format", "markdown"],
    &["doc", "--search", "mesh"],
    &["list"],
    &["list", "--format", "json"],
    &["info", "out/main"],
    &["info", "out/main/history.csv", "--format", "json"],
    &["diff", "out/main", "out/main"],
    &["diff", "out/main", "out/other", "--format", "json"],
    &["export", "out/main", "--format", "csv"],
    &["sweep", "out/main-sweep"],
    &["sweep", "point", "out/main-sweep", "--index", "0"],
    &["sweep", "collect", "out/main-sweep"],
    &["completions", "bash"],
    &["man"],
    &["man", "run"],
    &["--help"],
    &["run", "--help"],
    &["--version"],
];

fn prepared(name: &str) -> std::path::PathBuf {
    let home = folder(name, SCRIPT);
    let prepare: [&[&str]; 3] = [
        &["run", "main.rhai", "--quiet"],
        &["run", "main.rhai", "--quiet", "--out", "out/other", "--set", "density=2.0"],
        &["sweep", "main.rhai", "--vary", "density=1.0,2.0", "--quiet"],
    ];
    for arguments in prepare {
        let output = conserva(&home, arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    }
    home
}

#[test]
fn output_that_cannot_be_written_is_told_by_every_command() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let home = prepared("full");
    for arguments in COMMANDS {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let output = conserva(&home, arguments).stdout(full).output().unwrap();
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {message}");
        assert_eq!(message.matches("error: standard output cannot be written").count(), 1, "{arguments:?}: {message}");
        assert!(message.contains("No space left on device"), "{arguments:?}: {message}");
    }
    let summary = std::fs::read_to_string(home.join("again/summary.json")).unwrap();
    assert!(summary.contains("\"outcome\": \"completed\""), "{summary}");
}

#[test]
fn a_closed_pipe_is_no_error_of_any_command() {
    let home = prepared("closed");
    for arguments in COMMANDS {
        let mut child = conserva(&home, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let differs = arguments[0] == "diff" && arguments[2] == "out/other";
        assert_eq!(output.status.code(), Some(i32::from(differs)), "{arguments:?}: {}", stderr(&output));
        assert!(!stderr(&output).contains("error"), "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn a_log_on_standard_error_that_cannot_be_written_is_in_the_exit_code() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let home = folder("full-log", SCRIPT);
    let full = File::options().write(true).open("/dev/full").unwrap();
    let output = conserva(&home, &["run", "main.rhai", "--log", "json"]).stderr(full).output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    assert!(home.join("out/main/report.html").is_file());
}
