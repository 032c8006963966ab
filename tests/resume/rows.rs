//! Long histories: memory does not grow with the number of rows, and a resumed run continues its `history.csv`.

use std::path::Path;

use super::{begun, folder, run, run_files::assert_same, signal, stderr, wait_for_lines};

const PENDULUM: &str = r#"
    let m = model("pendulum");
    let rod = m.add_rigid_body("rod", rectangle(#{ size: [1.0, 0.1], cells: [2, 1] }), #{ mass: 1.0 });
    m.gravity([0.0, -9.81]);
    m.add_joint("pin", #{ kind: "point", from: rod, point: [0.0, 0.0] });
    let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.001 });
    sim.step(param("steps", 1500));
"#;

#[test]
#[cfg(target_os = "linux")]
fn memory_does_not_grow_with_the_steps() {
    let home = folder("memory", PENDULUM);
    let peak = |steps: &str| {
        let output = run(&home, &["run", "main.rhai", "--quiet", "--out", steps, "--set", &format!("steps={steps}")]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let summary = std::fs::read_to_string(home.join(steps).join("summary.json")).unwrap();
        let peak = summary.split("\"peak_memory_bytes\":").nth(1).unwrap().split(',').next().unwrap();
        peak.trim().parse::<f64>().unwrap() / 1e6
    };
    // A row in memory takes 0.5 kB: these rows took 10 MB.
    let [short, long] = ["6000", "26000"].map(peak);
    assert!(long - short < 4.0, "{short} MB, then {long} MB");
    assert!(!home.join("26000/checkpoints").exists());
}

/// A run killed after some checkpoints, and an uninterrupted one beside it.
fn killed(name: &str) -> std::path::PathBuf {
    let home = folder(name, PENDULUM);
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]).status.code(), Some(0));
    let mut child = begun(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "100"]);
    wait_for_lines(&home.join("k"), &mut child, 500);
    signal(&child, "-KILL");
    child.wait().unwrap();
    home
}

fn resumed(home: &Path, when: &str) {
    let output = run(home, &["resume", "k", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{when}: {}", stderr(&output));
    assert_same(&home.join("whole"), &home.join("k"), when);
}

#[test]
#[cfg(unix)]
fn a_resumed_run_goes_on_with_its_rows() {
    use std::os::unix::fs::MetadataExt;
    let home = killed("rows");
    if !home.join("k/checkpoints").exists() {
        return; // the run completed before the signal
    }
    let file = || std::fs::metadata(home.join("k/history.csv")).unwrap().ino();
    let before = file();
    resumed(&home, "taken over");
    assert_eq!(file(), before, "it was written again");
}

#[test]
fn rows_that_are_not_those_of_the_checkpoint_are_written_again() {
    for damage in ["a digit", "an end", "a file"] {
        let home = killed(&format!("rows-{}", damage.replace(' ', "-")));
        if !home.join("k/checkpoints").exists() {
            return; // the run completed before the signal
        }
        let path = home.join("k/history.csv");
        let mut bytes = std::fs::read(&path).unwrap();
        match damage {
            "a digit" => bytes[2000] ^= 1,
            "an end" => bytes.truncate(1000),
            _ => bytes.clear(),
        }
        std::fs::write(&path, bytes).unwrap();
        if damage == "a file" {
            std::fs::remove_file(&path).unwrap();
        }
        resumed(&home, damage);
    }
}
