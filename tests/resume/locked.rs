//! Lock of a run folder: one process at a time writes into it; others report the lock, and nothing is damaged.

use std::path::Path;

use super::program::{folder, stderr};
use super::splitmix::SplitMix;
use super::{LOOKS, assert_same, begun, interrupted, run, signal, wait_for_lines};

/// Starts two commands at once; returns how many reported a running process.
fn both(home: &Path, first: &[&str], second: &[&str]) -> usize {
    let children = [begun(home, first), begun(home, second)];
    let outputs = children.map(|child| child.wait_with_output().unwrap());
    let told = outputs.iter().filter(|output| {
        let message = stderr(output);
        let is_told =
            output.status.code() == Some(2) && message.contains("a run is under way here") && message.contains("= hint: wait until");
        assert!(is_told || output.status.code() == Some(0), "{:?}: {message}", output.status.code());
        is_told
    });
    told.count()
}

#[test]
fn of_two_programs_in_one_folder_one_tells_and_nothing_is_damaged() {
    let home = folder("locked", LOOKS);
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]).status.code(), Some(0));
    let mut random = SplitMix(3);
    let anew = ["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "5"];
    let further = ["resume", "k", "--quiet", "--checkpoint", "5"];
    for round in 0..3 {
        let _ = std::fs::remove_dir_all(home.join("k"));
        let pair: [&[&str]; 2] = [[&anew[..], &anew], [&anew, &further], [&further, &further]][round];
        if round > 0 {
            let mut child = begun(&home, &anew);
            wait_for_lines(&home.join("k"), &mut child, 40 + random.below(60));
            signal(&child, "-KILL");
            child.wait().unwrap();
        }
        assert_eq!(both(&home, pair[0], pair[1]), 1, "{round}");
        assert_same(&home.join("whole"), &home.join("k"), &format!("round {round}"));
    }
}

#[test]
fn who_is_under_way_is_told() {
    let home = folder("under-way", LOOKS);
    let mut child = begun(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--checkpoint", "5"]);
    wait_for_lines(&home.join("k"), &mut child, 30);
    for arguments in [&["run", "main.rhai", "--out", "k"][..], &["resume", "k"]] {
        let output = run(&home, arguments);
        let process = format!("a run is under way here (process {})", child.id());
        if child.try_wait().unwrap().is_none() {
            assert_eq!(output.status.code(), Some(2));
            assert!(stderr(&output).contains(&process), "{}", stderr(&output));
        }
    }
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(!home.join("k/.lock").exists());
}

#[test]
fn a_script_that_fails_at_once_leaves_a_killed_run_as_it_is() {
    let home = interrupted("failing");
    assert_eq!(run(&home, &["run", "main.rhai", "--quiet", "--out", "whole"]).status.code(), Some(0));
    for script in ["let x = ;", "throw \"no\";", "let m = model(\"m\"); m.bodies[0];"] {
        std::fs::write(home.join("fails.rhai"), script).unwrap();
        assert_eq!(run(&home, &["run", "fails.rhai", "--quiet", "--out", "k"]).status.code(), Some(2), "{script}");
    }
    let output = run(&home, &["resume", "k", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_same(&home.join("whole"), &home.join("k"), "after scripts that failed");
}
