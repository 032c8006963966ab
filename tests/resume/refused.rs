//! Results that cannot be written, or are removed: exit code 3 with the file and a hint; computed steps are available for resuming.

use std::path::Path;
use std::process::Command;

use super::program::{conserva, folder, stderr, stdout};
use super::run_files::assert_same;
use super::{LOOKS, begun, run, wait_for_lines};

/// A short run with all kinds of files.
const FILES: &str = r#"
let rubber = neo_hookean(#{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 });
let drop = model("drop");
let ball = drop.add_body("ball", disk(#{ radius: 0.5, cells: [3, 12], center: [0.0, 0.55] }), rubber);
drop.gravity([0.0, -10.0]);
drop.add_contact("ground", #{ secondary: ball.boundary("outer"), primary: rigid_plane(#{ point: [0.0, 0.0], normal: [0.0, 1.0] }) });
let sim = simulate(drop, #{ integrator: energy_momentum(), dt: 0.005, fields_every: 0.05 });
sim.run_to(0.05);
sim.picture("now.svg", #{ field: "von_mises" });
sim.movie("drop.gif", #{ width: 240 });
sim.table("all.parquet");
sim.write_fields("now.vtu");
sim.run_to(0.3);
"#;

#[test]
fn a_checkpoint_that_cannot_be_written_is_told_once_and_the_run_comes_to_its_end() {
    let home = folder("removed", LOOKS);
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]).status.code(), Some(0));
    // A folder in the place of every checkpoint.
    std::fs::create_dir(home.join("k")).unwrap();
    std::fs::write(home.join("k/checkpoints"), "in the way").unwrap();
    let output = run(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "3"]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert_eq!(message.matches("a checkpoint could not be written").count(), 1, "{message}");
    assert!(message.contains("= hint: the run goes on"), "{message}");
    std::fs::remove_file(home.join("k/checkpoints")).unwrap();
    assert_same(&home.join("whole"), &home.join("k"), "without checkpoints");
}

#[test]
fn a_folder_that_is_removed_is_missed() {
    let home = folder("gone", LOOKS);
    let mut child = begun(&home, &["run", "main.rhai", "--out", "k"]);
    wait_for_lines(&home.join("k"), &mut child, 30);
    while home.join("k").exists() && std::fs::remove_dir_all(home.join("k")).is_err() {}
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let message = stderr(&output);
    assert!(message.contains("is gone") || message.contains("could not be written"), "{message}");
    assert!(message.contains("= hint: "), "{message}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_log_that_does_not_fit_is_told_and_the_run_goes_to_its_end() {
    let home = folder("log", FILES);
    let output = run(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--log", "json:/dev/full"]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(stderr(&output).contains("the log /dev/full ends here") && stderr(&output).contains("= hint: "), "{}", stderr(&output));
    assert!(std::fs::read_to_string(home.join("k/summary.json")).unwrap().contains("\"completed\""));
    let output = run(&home, &["run", "main.rhai", "--out", "other", "--log", "json:nowhere/log.jsonl"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
}

/// Runs the program with a limit of `blocks` blocks of 512 bytes for files: larger ones fail as on a full disk, for any user.
#[cfg(target_os = "linux")]
fn limited(folder: &Path, blocks: usize, arguments: &[&str]) -> std::process::Output {
    let program = conserva(folder, arguments);
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
    let mut command = Command::new("sh");
    command.arg("-c").arg(script).arg("sh").arg(program.get_program()).args(program.get_args()).current_dir(folder);
    command.output().unwrap()
}

#[test]
#[cfg(target_os = "linux")]
fn what_fits_is_whole_and_the_run_goes_on_when_there_is_room() {
    let home = folder("full", FILES);
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]).status.code(), Some(0));
    let whole = std::fs::read_to_string(home.join("whole/history.csv")).unwrap();
    let largest = std::fs::metadata(home.join("whole/report.html")).unwrap().len() as usize / 512;
    let mut refused = Vec::new();
    for blocks in [3, 6, 12, 20, 30, 45, 60, 90, 120, 180, 260, largest, largest + 400] {
        let _ = std::fs::remove_dir_all(home.join("k"));
        let output = limited(&home, blocks, &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "5"]);
        let message = stderr(&output);
        if output.status.success() {
            assert_same(&home.join("whole"), &home.join("k"), "all fits");
            continue;
        }
        assert_eq!(output.status.code(), Some(3), "{blocks}: {message}");
        assert!(message.contains("could not be written: ") && message.contains("= hint: raise the limit"), "{blocks}: {message}");
        let refusal = message.lines().find(|line| line.contains("could not be written")).unwrap_or_default();
        refused.push(refusal.rsplit(['/', '"']).nth(1).unwrap_or_default().to_string());
        // No temporary files remain, and all files can be read.
        let history = std::fs::read_to_string(home.join("k/history.csv")).unwrap_or_default();
        assert!(whole.starts_with(&history) && (history.is_empty() || history.ends_with('\n')), "{blocks}");
        let listed = run(&home, &["list", "k"]);
        assert_eq!(listed.status.code(), Some(0), "{blocks}: {}", stderr(&listed));
        let told = run(&home, &["info", "k"]);
        assert_eq!(told.status.code(), Some(0), "{blocks}: {}", stderr(&told));
        if home.join("k/summary.json").exists() {
            assert!(!stdout(&told).contains("completed"), "{blocks}: the run is not as it should be: {}", stdout(&told));
        }
        if std::fs::read_dir(home.join("k/checkpoints"))
            .is_ok_and(|all| all.flatten().any(|entry| entry.path().extension().is_some_and(|ending| ending == "checkpoint")))
        {
            let resumed = run(&home, &["resume", "k", "--quiet"]);
            assert_eq!(resumed.status.code(), Some(0), "{blocks}: {}", stderr(&resumed));
            assert_same(&home.join("whole"), &home.join("k"), &format!("{blocks} blocks"));
        }
    }
    assert!(refused.len() >= 8, "{refused:?}");
    assert!(refused.contains(&"report.html".into()), "{refused:?}");
}
