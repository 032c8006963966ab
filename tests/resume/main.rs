//! Runs that are killed or interrupted and resumed: every file ends with the bytes of an uninterrupted run.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

#[path = "../common/splitmix.rs"]
mod splitmix;

#[path = "../common/program.rs"]
mod program;

#[path = "../common/kills/mod.rs"]
mod kills;
mod locked;
mod refused;
mod rows;
#[path = "../common/run_files.rs"]
mod run_files;
mod strangers;
mod studies;

use program::{conserva, folder, stderr};
use run_files::assert_same;
use splitmix::SplitMix;

/// Script with rings on a block and on a plane, and all ways to read results.
const LOOKS: &str = include_str!("looks.rhai");

fn run(folder: &Path, arguments: &[&str]) -> Output {
    conserva(folder, arguments).output().unwrap()
}

fn begun(folder: &Path, arguments: &[&str]) -> Child {
    conserva(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until the histories of a run have a total number of lines, or it has ended.
fn wait_for_lines(run: &Path, child: &mut Child, count: usize) {
    let begun = Instant::now();
    let lines = |folder: &Path| std::fs::read_to_string(folder.join("history.csv")).map_or(0, |text| text.lines().count());
    let folders = ["", "on a plane", "on_a_plane", "on_a_block-2", "on a block-2"];
    while folders.iter().map(|folder| lines(&run.join(folder))).sum::<usize>() < count {
        assert!(begun.elapsed() < Duration::from_secs(120), "the run does not come to {count} lines");
        if child.try_wait().unwrap().is_some() {
            return;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn signal(child: &Child, name: &str) {
    // A signal to a run that has ended fails.
    let _ = Command::new("kill").args([name, &child.id().to_string()]).stderr(Stdio::null()).status();
}

/// The newest checkpoint of a run.
fn newest(run: &Path) -> PathBuf {
    let mut all: Vec<PathBuf> = std::fs::read_dir(run.join("checkpoints")).unwrap().map(|entry| entry.unwrap().path()).collect();
    all.retain(|path| path.extension().is_some_and(|ending| ending == "checkpoint"));
    all.sort();
    all.pop().unwrap()
}

#[test]
fn a_run_that_was_killed_at_any_moment_ends_as_if_it_had_not_been() {
    let home = folder("killed", LOOKS);
    assert_eq!(run(&home, &["run", "main.rhai", "--out", "whole"]).status.code(), Some(0));
    let (mut random, mut resumed) = (SplitMix(14), 0);
    for round in 0..4 {
        let when = format!("round {round}");
        let _ = std::fs::remove_dir_all(home.join("k"));
        let mut child = begun(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "10"]);
        wait_for_lines(&home.join("k"), &mut child, 40 + random.below(450));
        signal(&child, "-KILL");
        child.wait().unwrap();
        if !home.join("k/checkpoints").exists() {
            continue;
        }
        if round % 2 == 0 {
            // Killed once more, at an arbitrary time.
            let mut child = begun(&home, &["resume", "k", "--checkpoint", "10"]);
            std::thread::sleep(Duration::from_millis(random.below(300) as u64));
            signal(&child, "-KILL");
            child.wait().unwrap();
        }
        if home.join("k/checkpoints").exists() {
            let output = run(&home, &["resume", "k", "--checkpoint", "10", "--threads", "2"]);
            assert_eq!(output.status.code(), Some(0), "{when}: {}", stderr(&output));
        }
        assert_same(&home.join("whole"), &home.join("k"), &when);
        resumed += 1;
    }
    assert!(resumed >= 2, "hardly any run was resumed");
}

#[test]
fn interrupts_and_stops_change_nothing() {
    let home = folder("interrupted", LOOKS);
    assert_eq!(run(&home, &["run", "main.rhai", "--out", "whole"]).status.code(), Some(0));
    let mut child = begun(&home, &["run", "main.rhai", "--out", "k"]);
    wait_for_lines(&home.join("k"), &mut child, 60);
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    if output.status.code() == Some(0) {
        return; // the run completed before the signal
    }
    assert!(stderr(&output).contains("go on with `conserva resume k`"), "{}", stderr(&output));
    for until in ["0.22", "0.5"] {
        let output = run(&home, &["resume", "k", "--until", until]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert!(stderr(&output).contains("stopped at t ="), "{}", stderr(&output));
    }
    // Resumed from another folder, by another path.
    let output = run(home.parent().unwrap(), &["resume", &home.join("k").to_string_lossy()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_same(&home.join("whole"), &home.join("k"), "interrupted");
    let output = run(&home, &["resume", "k"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("there is nothing to resume in k"), "{}", stderr(&output));
}

#[test]
fn the_frame_of_an_interrupt_does_not_replace_one_on_which_a_checkpoint_counts() {
    // Two rows at one time: that of the step, and that of the following equilibrium, at which the interrupt arrives.
    let script = r#"
        let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });
        let sky = model("sky");
        let plate = sky.add_body("plate", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), rubber);
        sky.fix(plate.boundary("left"));
        sky.gravity([0.0, -2.0]);
        let sim = simulate(sky, #{ integrator: energy_momentum(), dt: 0.01, fields_every: 0.03 });
        sim.step(3);
        sim.settle();
        let x = 0;
        for i in 0..5_000_000 { x += i; }
        sim.step(9);
    "#;
    let home = folder("settled", script);
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]).status.code(), Some(0));
    let mut child = begun(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "1"]);
    wait_for_lines(&home.join("k"), &mut child, 6);
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let output = run(&home, &["resume", "k", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_same(&home.join("whole"), &home.join("k"), "interrupted at the equilibrium");
}

#[test]
fn joints_of_a_resumed_run_are_those_of_their_time() {
    let script = r#"
        let m = model("pendulum");
        let rod = m.add_rigid_body("rod", rectangle(#{ size: [1.0, 0.1], cells: [2, 2], origin: [0.0, -0.05] }), #{ density: 1.0 });
        m.gravity([0.0, -9.81]);
        m.add_joint("pin", #{ kind: "point", from: rod, point: [0.0, 0.0], friction: 0.2, radius: 0.01, friction_moment: 0.01 });
        m.add_motor("motor", #{ from: rod, to: "ground", torque: |t| sin(20.0 * t) });
        let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.001 });
        let sum = 0.0;
        for k in 1..=10 { sim.run_to(0.01 * k); sum += sim.joint("pin").angle; print(sim.joint("pin")); }
        result("mean angle", sum / 10.0);
        sim.run_to(0.3);
    "#;
    assert_resumes("joints", script, 130);
}

#[test]
fn a_check_of_a_resumed_run_prints_what_the_first_run_printed() {
    let script = r#"
        let m = model("pendulum");
        let rod = m.add_rigid_body("rod", rectangle(#{ size: [1.0, 0.1], cells: [2, 2], origin: [0.0, -0.05] }), #{ density: 1.0 });
        m.gravity([0.0, -9.81]);
        m.add_joint("pin", #{ kind: "point", from: rod, point: [0.0, 0.0] });
        let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.001 });
        sim.run_to(0.02);
        expect_conserved(sim, "ledger", #{ tolerance: 1e-9 });
        sim.run_to(0.3);
    "#;
    assert_resumes("checks", script, 130);
}

/// Kills a run of a script once its history has a number of lines, resumes it, and asserts that it prints and writes what an undisturbed
/// run does.
fn assert_resumes(name: &str, script: &str, lines: usize) {
    let home = folder(name, script);
    let whole = run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]);
    assert_eq!(whole.status.code(), Some(0), "{}", stderr(&whole));
    let mut child = begun(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "20"]);
    wait_for_lines(&home.join("k"), &mut child, lines);
    signal(&child, "-KILL");
    if child.wait().unwrap().code().is_some() {
        return; // the run completed before the signal
    }
    let resumed = run(&home, &["resume", "k", "--quiet"]);
    assert_eq!(String::from_utf8_lossy(&resumed.stdout), String::from_utf8_lossy(&whole.stdout));
    assert_same(&home.join("whole"), &home.join("k"), name);
}

#[test]
fn a_closure_of_time_that_is_interrupted_ends_the_step() {
    // The closure waits, so that the signal arrives during it; a row without its force would be wrong.
    let script = r#"
        let m = model("pushed");
        let box = m.add_rigid_body("box", rectangle(#{ size: [1.0, 1.0], cells: [1, 1] }), #{ density: 1.0 });
        let push = |t| { let f = sin(20.0 * t); for k in 0..200 { f = f * 1.0; } f };
        m.add_actuator("push", #{ from: box, from_point: [0.5, 0.5], to: "ground", to_point: [3.0, 0.5], force: push });
        m.add_motor("motor", #{ from: box, to: "ground", torque: push });
        let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.001 });
        sim.run_to(0.4);
    "#;
    let home = folder("actuator", script);
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]).status.code(), Some(0));
    let whole = std::fs::read_to_string(home.join("whole/history.csv")).unwrap();
    for round in 0..4 {
        let mut child = begun(&home, &["run", "main.rhai", "--quiet", "--out", "k"]);
        wait_for_lines(&home.join("k"), &mut child, 20 + 70 * round);
        signal(&child, "-INT");
        child.wait().unwrap();
        let rows = std::fs::read_to_string(home.join("k/history.csv")).unwrap();
        assert!(whole.starts_with(&rows), "round {round}: {}", rows.lines().last().unwrap_or_default());
    }
}

#[test]
fn a_run_that_goes_on_is_not_resumed_beside_it() {
    let home = folder("beside", LOOKS);
    let mut child = begun(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "5"]);
    wait_for_lines(&home.join("k"), &mut child, 60);
    if child.try_wait().unwrap().is_some() {
        return; // the run completed before the signal
    }
    let output = run(&home, &["resume", "k"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("a run is under way here"), "{}", stderr(&output));
    signal(&child, "-KILL");
    child.wait().unwrap();
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]).status.code(), Some(0));
    assert_eq!(run(&home, &["resume", "k", "--quiet"]).status.code(), Some(0));
    assert_same(&home.join("whole"), &home.join("k"), "beside");
}

/// A run interrupted after some checkpoints.
fn interrupted(name: &str) -> PathBuf {
    let home = folder(name, LOOKS);
    let mut child = begun(&home, &["run", "main.rhai", "--out", "k", "--checkpoint", "5"]);
    wait_for_lines(&home.join("k"), &mut child, 60);
    signal(&child, "-KILL");
    child.wait().unwrap();
    home
}

#[test]
fn a_checkpoint_that_is_no_good_is_refused_with_its_reason_and_the_one_before_it_is_offered() {
    let home = interrupted("damaged");
    let newest = newest(&home.join("k"));
    let sound = std::fs::read(&newest).unwrap();
    let told = run(&home, &["info", &newest.to_string_lossy()]);
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    assert!(told.contains("main.rhai") && told.contains("on a block") && told.contains("unknowns"), "{told}");
    let mut flipped = sound.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 1;
    let mut future = sound.clone();
    future[12] = 200;
    let cases = [
        (flipped, "it is damaged: its content does not agree with its checksum"),
        (sound[..sound.len() / 3].to_vec(), "it is cut off"),
        (b"step,time,dt\n0,0,0\n".to_vec(), "it is not a checkpoint of Conserva"),
        (future, "is newer than the format"),
    ];
    for (content, reason) in cases {
        std::fs::write(&newest, content).unwrap();
        let output = run(&home, &["resume", "k"]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(reason) && message.contains("the one before it is sound"), "{message}");
    }
    // The suggested command works.
    let message = stderr(&run(&home, &["resume", "k"]));
    let offered = message.split("`conserva resume ").nth(1).and_then(|rest| rest.split('`').next()).unwrap().to_string();
    let output = run(&home, &["resume", &offered]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(run(&home, &["run", "main.rhai", "--out", "whole"]).status.code(), Some(0));
    assert_same(&home.join("whole"), &home.join("k"), "from the one before");
}

#[test]
fn what_a_run_depends_on_must_be_as_it_was() {
    let home = interrupted("changed");
    std::fs::write(home.join("main.rhai"), LOOKS.replace("cells: [2, 32]", "cells: [2, 40]")).unwrap();
    let output = run(&home, &["resume", "k"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("the script main.rhai has another line 9"), "{}", stderr(&output));
    std::fs::remove_file(home.join("main.rhai")).unwrap();
    let output = run(&home, &["resume", "k"]);
    assert!(stderr(&output).contains("the script main.rhai is gone"), "{}", stderr(&output));
    std::fs::write(home.join("main.rhai"), LOOKS).unwrap();
    // A frame that was written before the checkpoint.
    std::fs::remove_file(home.join("k/fields/fields_000001.vtu")).unwrap();
    let output = run(&home, &["resume", "k"]);
    let message = stderr(&output);
    assert!(message.contains("the frame of the fields at t = 0.02 (fields/fields_000001.vtu) is gone"), "{message}");
    assert!(newest(&home.join("k")).exists(), "nothing is lost");
}

#[test]
fn random_scripts_call_every_function_of_the_language() {
    let all = kills::generator::examples();
    let mut called = vec![false; all.len()];
    (0..all.len() as u64).flat_map(kills::generator::examples_of).for_each(|example| called[example] = true);
    let text: String = (0..all.len() as u64).map(kills::generator::script).collect();
    for ((signature, example), called) in all.iter().zip(called) {
        assert!(called && text.contains(example), "{signature} is called by no random script");
    }
    for scene in kills::scenes::SCENES {
        let part = scene.model.lines().next().unwrap().split("{b} = {m}").nth(1).unwrap();
        assert!(text.contains(part), "no random script has the scene {part}");
    }
}

/// A part of the runs of `cargo example kills`.
#[test]
fn random_scripts_end_as_if_nobody_had_killed_them() {
    let home = program::empty_folder("kills");
    let program = Path::new(env!("CARGO_BIN_EXE_conserva"));
    let (mut kills, mut resumed) = (0, 0);
    for seed in 0..12 {
        let found = kills::course::course(program, &home.join(seed.to_string()), seed);
        assert!(found.fault.is_none(), "seed {seed}: {}", found.fault.unwrap_or_default());
        assert!(found.code.is_some(), "seed {seed}: the undisturbed run ends by itself");
        kills += found.kills;
        resumed += found.resumed;
    }
    assert!(kills >= 6 && resumed >= 3, "hardly any run was resumed: {kills} kills, {resumed} resumed");
}
