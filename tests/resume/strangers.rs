//! Foreign files in the folder of a run, and missing ones: they are refused or left alone, never written through, never followed.

use std::path::Path;
use std::process::Command;

use super::program::{folder, stderr};
use super::{assert_same, begun, interrupted, newest, run, signal, wait_for_lines};

/// A short run with frames.
const SHORT: &str = r#"
let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });
let sky = model("sky");
let plate = sky.add_body("plate", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), rubber);
sky.initial_velocity(plate, #{ angular: 1.0 });
let sim = simulate(sky, #{ integrator: energy_momentum(), dt: 0.01, fields_every: 0.03 });
sim.step(9);
"#;

#[test]
fn frames_that_were_replaced_are_refused() {
    let home = interrupted("garbage");
    let frame = home.join("k/fields/fields_000001.vtu");
    let content = std::fs::read(&frame).unwrap();
    let mut other = content.clone();
    *other.last_mut().unwrap() ^= 1;
    for garbage in [&b"garbage"[..], &other, &[]] {
        std::fs::write(&frame, garbage).unwrap();
        let output = run(&home, &["resume", "k"]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("t = 0.02 (fields/fields_000001.vtu) has another content"), "{message}");
    }
    std::fs::write(&frame, content).unwrap();
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]).status.code(), Some(0));
    let output = run(&home, &["resume", "k", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_same(&home.join("whole"), &home.join("k"), "with the frame back");
}

#[test]
fn a_checkpoint_of_another_run_is_refused() {
    let home = interrupted("foreign");
    std::fs::write(home.join("short.rhai"), SHORT.replace("step(9)", "step(9000)")).unwrap();
    let mut child = begun(&home, &["run", "short.rhai", "--quiet", "--out", "short", "--checkpoint", "5"]);
    wait_for_lines(&home.join("short"), &mut child, 30);
    signal(&child, "-KILL");
    child.wait().unwrap();
    let foreign = newest(&home.join("short"));
    let place = home.join("k/checkpoints/000999.checkpoint");
    std::fs::copy(foreign, &place).unwrap();
    for arguments in [vec!["resume", "k"], vec!["resume", "k/checkpoints/000999.checkpoint"]] {
        let output = run(&home, &arguments);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("those of another run") && message.contains("the one before it is sound"), "{message}");
    }
    // The whole folder of checkpoints replaced by that of another run.
    std::fs::remove_dir_all(home.join("k/checkpoints")).unwrap();
    std::fs::rename(home.join("short/checkpoints"), home.join("k/checkpoints")).unwrap();
    let output = run(&home, &["resume", "k"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("has another content than the run had written"), "{}", stderr(&output));
}

#[test]
fn a_result_never_takes_the_place_of_what_the_run_reads() {
    let home = folder("inputs", SHORT);
    std::fs::rename(home.join("main.rhai"), home.join("history.csv")).unwrap();
    let output = run(&home, &["run", "history.csv", "--quiet", "--out", "."]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("history.csv\" is read by this run"), "{}", stderr(&output));
    assert_eq!(std::fs::read_to_string(home.join("history.csv")).unwrap(), SHORT);
    // A file that the run reads is not replaced, even if the record of files names it.
    std::fs::write(home.join(".files"), "history.csv\ntable.csv\n").unwrap();
    std::fs::write(home.join("table.csv"), "t,a\n0,1\n").unwrap();
    std::fs::write(home.join("main.rhai"), format!("let a = read_csv(\"table.csv\");{SHORT}sim.table(\"table.csv\", [\"time\"]);"))
        .unwrap();
    let output = run(&home, &["run", "main.rhai", "--quiet", "--out", "."]);
    assert!(stderr(&output).contains("table.csv\" is read by this run"), "{}", stderr(&output));
    assert_eq!(std::fs::read_to_string(home.join("table.csv")).unwrap(), "t,a\n0,1\n");
}

#[test]
#[cfg(unix)]
fn links_and_pipes_are_replaced_not_written_through() {
    use std::os::unix::fs::symlink;
    let home = folder("links", SHORT);
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]).status.code(), Some(0));
    let out = home.join("k");
    std::fs::create_dir_all(out.join("fields")).unwrap();
    std::fs::write(home.join("precious"), "theirs").unwrap();
    for name in ["history.csv", "fields.pvd", "fields/fields_000000.vtu", ".files", "report.html"] {
        std::fs::hard_link(home.join("precious"), out.join(name)).unwrap();
    }
    symlink("fields.pvd", out.join("summary.json")).unwrap();
    assert!(Command::new("mkfifo").arg(out.join("history.svg")).status().unwrap().success());
    let output = run(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "2"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(std::fs::read_to_string(home.join("precious")).unwrap(), "theirs");
    assert_same(&home.join("whole"), &out, "over links");
    // A pipe in the place of the history, the record and the checkpoints.
    std::fs::remove_dir_all(&out).unwrap();
    std::fs::create_dir_all(out.join("checkpoints")).unwrap();
    for name in ["history.csv", ".files", "checkpoints/journal", "checkpoints/000003.checkpoint"] {
        assert!(Command::new("mkfifo").arg(out.join(name)).status().unwrap().success());
    }
    assert_eq!(run(&home, &["resume", "k"]).status.code(), Some(2));
    assert_eq!(run(&home, &["info", "k/history.csv"]).status.code(), Some(2));
    let output = run(&home, &["run", "main.rhai", "--quiet", "--out", "k"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_same(&home.join("whole"), &out, "over pipes");
}

#[test]
fn frames_of_others_stay_and_lists_are_not_followed_out_of_their_folder() {
    let home = folder("lists", SHORT);
    std::fs::create_dir_all(home.join("k/fields")).unwrap();
    std::fs::write(home.join("k/fields/fields_000777.vtu"), "theirs").unwrap();
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "k"]).status.code(), Some(0));
    assert_eq!(std::fs::read_to_string(home.join("k/fields/fields_000777.vtu")).unwrap(), "theirs");
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "other"]).status.code(), Some(0));
    let list = std::fs::read_to_string(home.join("k/fields.pvd")).unwrap();
    std::fs::write(home.join("k/fields.pvd"), list.replace("fields/fields_000001.vtu", "../other/fields/fields_000001.vtu")).unwrap();
    for arguments in [&["diff", "k", "other"][..], &["info", "k/fields.pvd"], &["export", "k", "--format", "csv"]] {
        let output = run(&home, arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains("names a file outside of its folder"), "{arguments:?}: {}", stderr(&output));
    }
}

/// After a return to a saved state, frames on disk match the history table; none of the discarded steps remain.
#[test]
fn frames_follow_the_history_when_a_simulation_goes_back() {
    let script = SHORT
        .replace("sim.step(9);", "sim.step(2); let v = sim.save(); sim.step(8); sim.restore(v); sim.set(#{ dt: 0.007 }); sim.run_to(0.2);");
    let home = folder("back", &script);
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "k"]).status.code(), Some(0));
    let frames = conserva::output::read_frames(&home.join("k/fields.pvd")).unwrap();
    let table = conserva::output::read_table(&home.join("k/history.csv")).unwrap().table;
    let times = &table.column("time").unwrap().values;
    assert!(frames.len() >= 6 && frames.iter().all(|frame| times.contains(&Some(frame.time))), "{frames:?}");
    assert_eq!(std::fs::read_dir(home.join("k/fields")).unwrap().count(), frames.len());
    // `diff` compares frames before the last one, too.
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "other"]).status.code(), Some(0));
    assert_eq!(run(&home, &["diff", "k", "other"]).status.code(), Some(0));
    let frame = |number: usize| home.join(format!("k/fields/fields_{number:06}.vtu"));
    std::fs::copy(frame(2), frame(1)).unwrap();
    let output = run(&home, &["diff", "k", "other"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains("displacement"), "{}", String::from_utf8_lossy(&output.stdout));
}

/// The state to which `back` returns is part of the checkpoint, also if the script goes back behind the checkpoint.
#[test]
fn a_script_that_goes_back_by_steps_is_resumed() {
    let script =
        SHORT.replace("sim.step(9);", "for k in 0..40 { sim.step(12); sim.back(9); if k % 7 == 0 { print(sim.body(plate).center); } }");
    let home = folder("steps-back", &script);
    let whole = run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]);
    assert_eq!(whole.status.code(), Some(0), "{}", stderr(&whole));
    for until in ["0.15", "0.4", "0.85"] {
        let _ = std::fs::remove_dir_all(home.join("k"));
        let mut child = begun(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "1"]);
        let reached: f64 = until.parse().unwrap();
        wait_for_lines(&home.join("k"), &mut child, (reached / 0.01) as usize);
        signal(&child, "-KILL");
        child.wait().unwrap();
        let is_done = !has_checkpoint(&home.join("k"));
        let output = if is_done { whole.clone() } else { run(&home, &["resume", "k", "--quiet"]) };
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert_eq!(output.stdout, whole.stdout);
        assert_same(&home.join("whole"), &home.join("k"), until);
    }
}

fn has_checkpoint(run: &Path) -> bool {
    run.join("checkpoints").exists()
}
