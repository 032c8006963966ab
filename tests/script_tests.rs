//! `conserva test` as a process: the script tests and tutorials of the repository pass, failures are reported correctly, and it is fast.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn conserva(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_conserva")).current_dir(folder).args(arguments).output().unwrap()
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A new empty folder.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("conserva-test-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn the_shipped_script_tests_and_tutorials_pass() {
    let output = conserva(repository(), &["test", "tests/scripts", "scripts/tutorials"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let text = said(&output);
    for file in ["tests/scripts/checks.rhai::test_contact_is_invariant", "scripts/tutorials/08_why_a_step_failed.rhai"] {
        assert!(text.contains(&format!("ok    {file}")), "{file} was not run:\n{text}");
    }
}

#[test]
fn failures_are_told_with_their_place_and_output() {
    let folder = folder("failures");
    let text = "fn test_good() { expect(true); }\nfn test_bad() {\n    print(\"seen\");\n    expect(1 > 2, \"a < b & \\\"c\\\"\");\n}\n";
    std::fs::write(folder.join("mixed.rhai"), text).unwrap();
    let output = conserva(&folder, &["test", "mixed.rhai", "--junit", "report.xml"]);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    for part in ["ok    mixed.rhai::test_good", "FAIL  mixed.rhai::test_bad", "mixed.rhai:4:12", "  seen", "1 passed, 1 failed"] {
        assert!(text.contains(part), "{part} is missing:\n{text}");
    }
    let report = std::fs::read_to_string(folder.join("report.xml")).unwrap();
    for part in [
        "<testsuites name=\"conserva\" tests=\"2\" failures=\"1\" errors=\"0\"",
        "<testcase name=\"test_good\" classname=\"mixed.rhai\"",
        "<failure message=\"a &lt; b &amp; &quot;c&quot;\">",
        "<system-out>seen</system-out>",
    ] {
        assert!(report.contains(part), "{part} is missing:\n{report}");
    }
    // a filter chooses by name
    let output = conserva(&folder, &["test", "mixed.rhai", "--filter", "good"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("1 test in 1 file"));
    let output = conserva(&folder, &["test", "mixed.rhai", "--filter", "best"]);
    assert_eq!(output.status.code(), Some(2), "nothing was tested");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_file_that_does_not_parse_is_told_and_the_others_still_run() {
    let folder = folder("parse");
    std::fs::write(folder.join("broken.rhai"), "fn test_a() { let x = ; }\n").unwrap();
    std::fs::write(folder.join("sound.rhai"), "fn test_b() { expect(true); }\n").unwrap();
    // a scenario is a test if it is named, alone or by its folder, but not in a search of the current folder
    std::fs::write(folder.join("scenario.rhai"), "expect(false);\n").unwrap();
    let output = conserva(&folder, &["test"]);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("broken.rhai:1:23") && text.contains("1 file does not parse") && text.contains("1 passed, 0 failed"), "{text}");
    std::fs::remove_file(folder.join("broken.rhai")).unwrap();
    assert_eq!(conserva(&folder, &["test"]).status.code(), Some(0));
    assert_eq!(conserva(&folder, &["test", "."]).status.code(), Some(1));
    assert_eq!(conserva(&folder, &["test", "missing.rhai"]).status.code(), Some(2));
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn two_hundred_small_tests_in_ten_files_pass() {
    let folder = folder("many");
    let test = "{
        let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });
        let sky = model(\"sky\");
        let plate = sky.add_body(\"plate\", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), rubber);
        sky.initial_velocity(plate, #{ linear: [1.0, 0.0], angular: 2.0 });
        let sim = simulate(sky, #{ integrator: energy_momentum(), dt: 0.01 });
        sim.run_to(0.05);
        expect_conserved(sim, \"energy\", #{ tolerance: 1e-10 });
    }";
    for file in 0..10 {
        let tests: Vec<String> = (0..20).map(|number| format!("fn test_{number}() {test}\n")).collect();
        std::fs::write(folder.join(format!("file_{file}.rhai")), tests.concat()).unwrap();
    }
    // Less than 5 s on two idle cores (measured: 1 to 3 s); the time is not tested, because the machine may be busy.
    let output = conserva(&folder, &["test", ".", "--threads", "2"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("200 tests in 10 files: 200 passed, 0 failed"));
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_new_scenario_runs_and_is_not_overwritten() {
    let folder = folder("new");
    let output = conserva(&folder, &["new", "first try"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let output = conserva(&folder, &["run", "first try.rhai", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(folder.join("out/first try/history.csv").is_file());
    let output = conserva(&folder, &["test", "first try.rhai"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(!said(&output).contains("warning"), "{}", said(&output));
    let output = conserva(&folder, &["new", "first try"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("there already is a file"));
    std::fs::remove_dir_all(folder).unwrap();
}
