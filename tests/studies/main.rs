//! Studies as processes: their points, failing points, and that nothing is lost or computed twice when processes are killed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

#[path = "../common/program.rs"]
mod program;
#[path = "../common/splitmix.rs"]
mod splitmix;

mod slurm;

use program::{conserva, folder, stderr, stdout};
use splitmix::SplitMix;

const BLOCK: &str = include_str!("block.rhai");
/// Script with results by formulas.
const SUM: &str = "let a = param(\"a\", 1.0);\nlet b = param(\"b\", 0);\nlet word = param(\"word\", \"none\");\n\
                   result(\"sum\", a + b);\nresult(\"said\", word + \", \\\"quoted\\\"\");\nresult(\"both\", [a, b]);\n";

fn run(folder: &Path, arguments: &[&str]) -> Output {
    conserva(folder, arguments).output().unwrap()
}

/// Runs a command that must end with an exit code.
fn run_to(folder: &Path, arguments: &[&str], code: i32) -> Output {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
    output
}

/// The rows of a table, without its wall times.
fn table(study: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(study.join("table.csv")).unwrap();
    let names: Vec<String> = reader.headers().unwrap().iter().map(String::from).collect();
    let row = |record: csv::StringRecord| names.iter().cloned().zip(record.iter().map(String::from)).collect();
    let mut rows: Vec<BTreeMap<String, String>> = reader.records().map(|record| row(record.unwrap())).collect();
    for row in &mut rows {
        assert!(row.remove("wall_seconds").is_some());
    }
    rows
}

fn column<'a>(rows: &'a [BTreeMap<String, String>], name: &str) -> Vec<&'a str> {
    rows.iter().map(|row| row[name].as_str()).collect()
}

/// Records of the points of a study, as bytes of the files.
fn records(study: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let points = std::fs::read_dir(study.join("points")).into_iter().flatten().flatten();
    points.filter_map(|point| Some((point.path(), std::fs::read(point.path().join("point.json")).ok()?))).collect()
}

#[test]
fn every_kind_of_design_has_its_points() {
    let folder = folder("designs", SUM);
    run_to(&folder, &["sweep", "main.rhai", "--vary", "a=0.5,1", "--vary", "b=1..3:3", "--set", "word=x"], 0);
    let rows = table(&folder.join("out/main-sweep"));
    assert_eq!(column(&rows, "a"), ["0.5", "0.5", "0.5", "1.0", "1.0", "1.0"]);
    assert_eq!(column(&rows, "sum"), ["1.5", "2.5", "3.5", "2.0", "3.0", "4.0"]);
    assert_eq!((rows[0]["said"].as_str(), rows[4]["both"].as_str()), ("x, \"quoted\"", "[1.0,2]"));
    assert_eq!(rows[3]["command"], "conserva run main.rhai --set word=x --set a=1 --set b=1");
    // The same command computes nothing again; a larger study computes its new points.
    let before = records(&folder.join("out/main-sweep"));
    run_to(&folder, &["sweep", "main.rhai", "--vary", "a=0.5,1,2", "--vary", "b=1..3:3", "--set", "word=x"], 0);
    let after = records(&folder.join("out/main-sweep"));
    assert_eq!((before.len(), after.len()), (6, 9));
    assert!(before.iter().all(|(point, record)| after[point] == *record));
    // Zipped lists, points from a file, samples.
    run_to(&folder, &["sweep", "main.rhai", "--vary", "a=1,2", "--vary", "word=x,y", "--zip", "--out", "zip"], 0);
    assert_eq!(column(&table(&folder.join("zip")), "said"), ["x, \"quoted\"", "y, \"quoted\""]);
    std::fs::write(folder.join("points.csv"), "b, word\n3,\"odd, one\"\n4, plain\n").unwrap();
    run_to(&folder, &["sweep", "main.rhai", "--values", "points.csv", "--vary", "a=0..1", "--sample", "sobol:16", "--out", "sobol"], 0);
    let rows = table(&folder.join("sobol"));
    assert_eq!((rows.len(), rows[0]["said"].as_str()), (32, "odd, one, \"quoted\""));
    for row in &rows {
        let [a, b, sum] = ["a", "b", "sum"].map(|name| row[name].parse::<f64>().unwrap());
        assert_eq!(a + b, sum);
    }
    std::fs::write(
        folder.join("kept.study.toml"),
        "script = \"main.rhai\"\nsample = \"random:3\"\nseed = 4\n[vary]\na = \"0..1\"\nb = [1, 2]\n[set]\nword = \"kept\"\n",
    )
    .unwrap();
    run_to(&folder, &["sweep", "kept.study.toml"], 0);
    let rows = table(&folder.join("out/kept-sweep"));
    assert_eq!((rows.len(), rows[5]["said"].as_str()), (6, "kept, \"quoted\""));
}

#[test]
fn what_cannot_be_planned_says_why_and_computes_nothing() {
    let folder = folder("refusals", SUM);
    for (arguments, said) in [
        (&["sweep"][..], "needs a script"),
        (&["sweep", "main.rhai"], "nothing varies"),
        (&["sweep", "none.rhai", "--vary", "a=1"], "cannot be read"),
        (&["sweep", "main.rhai", "--vary", "aa=1,2"], "did you mean `a`?"),
        (&["sweep", "main.rhai", "--vary", "a=1,1"], "a=1 stands twice"),
        (&["sweep", "main.rhai", "--vary", "a=1", "--set", "a=2"], "both varies and is set"),
        (&["sweep", "main.rhai", "--vary", "a=0..1"], "--sample sobol:64"),
        (&["sweep", "main.rhai", "--vary", "a=0..1:x"], "neither a number of values"),
        (&["sweep", "main.rhai", "--values", "none.csv"], "cannot be read"),
        (&["sweep", "point", "out", "--index", "0"], "holds no study"),
        (&["sweep", "collect", "nowhere"], "holds no study"),
    ] {
        let output = run_to(&folder, arguments, 2);
        assert!(stderr(&output).contains(said), "{arguments:?}: {}", stderr(&output));
    }
    assert!(!folder.join("out").exists());
    std::fs::write(folder.join("broken.rhai"), "let a = param(\"a\", 1;").unwrap();
    run_to(&folder, &["sweep", "broken.rhai", "--vary", "a=1,2"], 2);
    run_to(&folder, &["sweep", "main.rhai", "--vary", "a=1,2", "--out", "study"], 0);
    for (arguments, said) in [
        (&["sweep", "main.rhai", "--vary", "a=1,2", "--set", "b=3", "--out", "study"][..], "now b=3"),
        (&["sweep", "study", "--vary", "a=3"], "is planned already"),
        (&["sweep", "point", "study", "--index", "2"], "the numbers 0 to 1"),
        (&["sweep", "point", "study", "--index", "x"], "names no points"),
    ] {
        let output = run_to(&folder, arguments, 2);
        assert!(stderr(&output).contains(said), "{arguments:?}: {}", stderr(&output));
    }
    // A changed script has new points.
    std::fs::write(folder.join("main.rhai"), format!("{SUM}result(\"more\", 1);\n")).unwrap();
    assert!(stderr(&run_to(&folder, &["sweep", "study"], 2)).contains("has been changed since"));
    run_to(&folder, &["sweep", "study", "--retry", "all"], 0);
    assert_eq!(column(&table(&folder.join("study")), "more"), ["1", "1"]);
}

/// Kinds of failure of `block.rhai`, their outcomes, and the causes in the row.
const FAILURES: [(&str, &str, &str); 7] = [
    ("throw", "failed", "the user's own error"),
    ("check", "failed", "main.rhai:14:"),
    ("wrong", "failed", "must be a number"),
    ("endless", "failed", "operations"),
    ("late", "out of time", "not done after 2 s"),
    ("diverging", "failed", "main.rhai:"),
    ("odd", "failed", "there is no kind odd"),
];

#[test]
fn points_that_fail_are_rows_and_harm_no_others() {
    let folder = folder("failures", BLOCK);
    let mut rows = vec!["spin,kind".to_string()];
    for index in 0..200 {
        let kind = if index % 28 == 1 { FAILURES.get(index / 28).map_or("well", |(kind, ..)| kind) } else { "well" };
        rows.push(format!("{},{kind}", 1.0 + index as f64 / 64.0));
    }
    std::fs::write(folder.join("points.csv"), rows.join("\n") + "\n").unwrap();
    let arguments = ["sweep", "main.rhai", "--values", "points.csv", "--point-time", "2s", "--max-operations", "100000", "--out", "study"];
    let output = run_to(&folder, &arguments, 1);
    assert_eq!(stderr(&output).lines().filter(|line| line.starts_with("point ")).count(), 7, "{}", stderr(&output));
    let study = folder.join("study");
    let table_of_all = table(&study);
    assert_eq!(column(&table_of_all, "outcome").iter().filter(|outcome| **outcome == "completed").count(), 193);
    for (kind, outcome, said) in FAILURES {
        let row = table_of_all.iter().find(|row| row["kind"] == kind).unwrap();
        assert_eq!(row["outcome"], outcome, "{kind}");
        assert!(row["cause"].contains(said), "{kind}: {}", row["cause"]);
        assert!(row["command"].ends_with(&format!("--set kind={kind}")) && row["energy"].is_empty());
        assert!(!row["energy at first"].is_empty(), "what a point has yielded before it failed is kept");
    }
    // Rigid motion keeps the initial energy: m v^2 / 2 + J w^2 / 2 with m = 1 and J of a unit square.
    for row in table_of_all.iter().filter(|row| row["outcome"] == "completed") {
        let [spin, energy] = ["spin", "energy"].map(|name| row[name].parse::<f64>().unwrap());
        let expected = 0.5 + spin * spin / 12.0;
        assert!((energy / expected - 1.0).abs() < 1e-12, "{energy} {expected}");
    }
    // The command of a row repeats its point.
    let row = table_of_all.iter().find(|row| row["kind"] == "throw").unwrap();
    let words: Vec<&str> = row["command"].split(' ').skip(1).collect();
    assert!(stderr(&run_to(&folder, &words, 2)).contains("the user's own error"));
    // Again: nothing is missing; failed points are computed again on request.
    let before = records(&study);
    run_to(&folder, &["sweep", "study"], 1);
    assert_eq!(records(&study), before);
    run_to(&folder, &["sweep", "study", "--retry", "failed"], 1);
    let after = records(&study);
    assert_eq!(before.iter().filter(|(point, record)| after[*point] != **record).count(), 7);
    assert_eq!(table(&study), table_of_all);
}

#[test]
fn whoever_computes_the_points_the_table_is_the_same() {
    let folder = folder("engines", BLOCK);
    let vary = ["--vary", "dt=0.01,0.02", "--vary", "spin=1..3:6"];
    for arguments in [
        &["sweep", "main.rhai", "--out", "one", "--jobs", "1"][..],
        &["sweep", "main.rhai", "--out", "three", "--jobs", "3", "--threads", "2"],
        &["sweep", "plan", "main.rhai", "--out", "singly"],
    ] {
        run_to(&folder, &[arguments, &vary].concat(), 0);
    }
    for index in (0..12).rev().step_by(2) {
        run_to(&folder, &["sweep", "point", "singly", "--index", &index.to_string()], 0);
    }
    run_to(&folder, &["sweep", "point", "singly", "--index", "0-4"], 0);
    assert_eq!(run(&folder, &["sweep", "collect", "singly"]).status.code(), Some(1), "points are missing");
    assert_eq!(column(&table(&folder.join("singly")), "outcome").iter().filter(|outcome| **outcome == "missing").count(), 3);
    run_to(&folder, &["sweep", "point", "singly", "--index", "6", "--count", "100"], 0);
    assert!(stdout(&run_to(&folder, &["sweep", "collect", "singly"], 0)).contains("energy"));
    let one = table(&folder.join("one"));
    assert!(one == table(&folder.join("three")) && one == table(&folder.join("singly")));
    assert_eq!(one.len(), 12);
}

#[test]
fn a_point_that_somebody_computes_is_left_to_him() {
    let folder = folder("claims", BLOCK);
    run_to(&folder, &["sweep", "plan", "main.rhai", "--vary", "spin=1,2", "--out", "study"], 0);
    let point = folder.join("study/points/spin=1");
    std::fs::create_dir_all(&point).unwrap();
    let claim = std::fs::File::create(point.join(".claim")).unwrap();
    claim.lock().unwrap();
    assert!(stdout(&run_to(&folder, &["sweep", "point", "study", "--index", "0"], 0)).contains("under way elsewhere"));
    // A waiting study.
    let mut waiting = begun(&folder, &["sweep", "study"]);
    std::thread::sleep(Duration::from_millis(500));
    assert!(waiting.try_wait().unwrap().is_none() && !point.join("point.json").exists());
    drop(claim);
    assert_eq!(waiting.wait().unwrap().code(), Some(0));
    assert_eq!(table(&folder.join("study")).len(), 2);
}

fn begun(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = conserva(folder, arguments);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Child processes of a process.
fn children(parent: u32) -> Vec<u32> {
    let of = |entry: std::fs::DirEntry| {
        let stat = std::fs::read_to_string(entry.path().join("stat")).ok()?;
        let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
        (fields.get(1)?.parse() == Ok(parent)).then(|| entry.file_name().to_string_lossy().parse().ok())?
    };
    std::fs::read_dir("/proc").into_iter().flatten().flatten().filter_map(of).collect()
}

fn kill(process: u32) {
    let _ = Command::new("kill").args(["-9", &process.to_string()]).stderr(Stdio::null()).status();
}

#[cfg(target_os = "linux")]
#[test]
fn whoever_is_killed_the_table_is_the_same_and_nothing_is_computed_twice() {
    let folder = folder("kills", &BLOCK.replace("10.0 * dt", "60.0 * dt"));
    let vary = ["--vary", "dt=0.005,0.01", "--vary", "spin=1..3:12"];
    run_to(&folder, &[&["sweep", "main.rhai", "--out", "whole"][..], &vary].concat(), 0);
    let mut random = SplitMix(15);
    let arguments = [&["sweep", "main.rhai", "--out", "killed", "--jobs", "2"][..], &vary].concat();
    let study = folder.join("killed");
    for round in 0..20 {
        let mut controller = begun(&folder, &arguments);
        std::thread::sleep(Duration::from_millis(5 + random.below(60) as u64));
        let workers = children(controller.id());
        match round % 3 {
            0 => kill(controller.id()),
            1 => workers.iter().take(1).for_each(|&worker| kill(worker)),
            _ => [controller.id()].into_iter().chain(workers.iter().copied()).for_each(kill),
        }
        controller.wait().unwrap();
        // Orphaned processes end with their current point; finished points stay.
        let before = records(&study);
        let is_done = |record: &[u8]| !String::from_utf8_lossy(record).contains("\"killed\"");
        std::thread::sleep(Duration::from_millis(20));
        let after = records(&study);
        assert!(before.iter().filter(|(_, record)| is_done(record)).all(|(point, record)| after[point] == *record), "round {round}");
        // Most rounds start anew, so that the next kill interrupts work.
        if round % 5 == 4 {
            run_to(&folder, &arguments, 0);
            let last = records(&study);
            assert!(after.iter().filter(|(_, record)| is_done(record)).all(|(point, record)| last[point] == *record), "round {round}");
            assert_eq!(table(&study), table(&folder.join("whole")), "round {round}");
            std::fs::remove_dir_all(&study).unwrap();
        }
    }
}

#[test]
fn what_cannot_be_written_ends_the_study_and_the_next_one_goes_on() {
    let folder = folder("refused files", BLOCK);
    let arguments = ["sweep", "main.rhai", "--vary", "spin=1,2,3,4", "--out", "study", "--jobs", "1"];
    run_to(&folder, &["sweep", "plan", "main.rhai", "--vary", "spin=1,2,3,4", "--out", "study"], 0);
    // A folder in the place of the record of a point.
    std::fs::create_dir_all(folder.join("study/points/spin=3/point.json/x")).unwrap();
    std::fs::write(folder.join("study/points/spin=2"), "in the way").unwrap();
    let output = run_to(&folder, &arguments, 3);
    assert!(stderr(&output).contains("spin=2") && stderr(&output).contains("goes on with what is missing"), "{}", stderr(&output));
    let before = records(&folder.join("study"));
    assert_eq!(before.len(), 1);
    std::fs::remove_file(folder.join("study/points/spin=2")).unwrap();
    run_to(&folder, &arguments, 0);
    assert!(before.iter().all(|(point, record)| records(&folder.join("study"))[point] == *record));
}
