//! Studies that are killed or interrupted: finished points are not computed again, and files and lines equal those of an uninterrupted run.

use std::path::Path;
use std::time::{Duration, Instant};

use super::program::{folder, stderr};
use super::splitmix::SplitMix;
use super::{assert_same, begun, run, signal};

const STUDIES: &str = include_str!("studies.rhai");

fn prepared(name: &str) -> std::path::PathBuf {
    let home = folder(name, STUDIES);
    std::fs::write(home.join("until.csv"), "0.0,0.5\n").unwrap();
    home
}

/// Rows of the tables of all studies.
fn rows(run: &Path) -> usize {
    let lines =
        |name: &str| std::fs::read_to_string(run.join("studies").join(name)).map_or(0, |text| text.lines().count().saturating_sub(1));
    lines("sweep.csv") + lines("speed.csv")
}

#[test]
fn points_are_not_computed_again_whenever_a_run_is_killed() {
    let home = prepared("studies-killed");
    let whole = run(&home, &["run", "main.rhai", "--out", "whole", "--set", "until=2.5"]);
    assert_eq!(whole.status.code(), Some(0), "{}", stderr(&whole));
    let all = rows(&home.join("whole"));
    assert!(all > 12);
    let (mut random, mut resumed) = (SplitMix(5), 0);
    for round in 0..6 {
        let when = format!("round {round}");
        let _ = std::fs::remove_dir_all(home.join("k"));
        let mut child = begun(&home, &["run", "main.rhai", "--quiet", "--out", "k", "--set", "until=2.5"]);
        let (wanted, begin) = (random.below(all), Instant::now());
        while rows(&home.join("k")) < wanted && child.try_wait().unwrap().is_none() {
            assert!(begin.elapsed() < Duration::from_secs(120), "the run does not come to {wanted} rows");
            std::thread::sleep(Duration::from_millis(1));
        }
        signal(&child, if round % 2 == 0 { "-KILL" } else { "-INT" });
        child.wait().unwrap();
        // The partial table consists of complete lines of the whole table.
        let table = std::fs::read_to_string(home.join("k/studies/sweep.csv")).unwrap_or_default();
        let complete = std::fs::read_to_string(home.join("whole/studies/sweep.csv")).unwrap();
        assert!(table.is_empty() || table.ends_with('\n') && table.lines().skip(1).all(|line| complete.contains(line)), "{when}: {table}");
        if !home.join("k/checkpoints").exists() {
            continue;
        }
        if round % 3 == 0 {
            let mut child = begun(&home, &["resume", "k"]);
            std::thread::sleep(Duration::from_millis(random.below(200) as u64));
            signal(&child, "-KILL");
            child.wait().unwrap();
        }
        if home.join("k/checkpoints").exists() {
            let output = run(&home, &["resume", "k"]);
            assert_eq!(output.status.code(), Some(0), "{when}: {}", stderr(&output));
            assert_eq!(String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&whole.stdout), "{when}");
        }
        assert_same(&home.join("whole"), &home.join("k"), &when);
        resumed += 1;
    }
    assert!(resumed >= 3, "hardly any run was resumed");
}

#[test]
fn what_points_read_is_part_of_what_a_run_depends_on() {
    let home = prepared("studies-read");
    let mut child = begun(&home, &["run", "main.rhai", "--quiet", "--out", "k"]);
    let begin = Instant::now();
    while rows(&home.join("k")) < 2 && begin.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    signal(&child, "-KILL");
    child.wait().unwrap();
    std::fs::write(home.join("until.csv"), "0.0,0.6\n").unwrap();
    let output = run(&home, &["resume", "k"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("until.csv has another content"), "{}", stderr(&output));
    // A run from the start reuses nothing.
    let output = run(&home, &["run", "main.rhai", "--quiet", "--out", "k"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(!home.join("k/checkpoints").exists());
}
