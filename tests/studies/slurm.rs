//! The engine for Slurm, with a Slurm of two nodes on this machine. A message is printed if it cannot be started.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use super::program::{conserva, folder, stderr};
use super::{BLOCK, column, records, table};

/// A Slurm that is stopped at the end of the test.
struct Slurm {
    folder: PathBuf,
}

impl Slurm {
    /// Starts Slurm; `None` if the programs are missing or may not be started.
    fn start(folder: &Path) -> Option<Slurm> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/slurm/start.sh");
        let port = 20_000 + std::process::id() % 20_000;
        let output = Command::new("sh").arg(script).arg(folder).arg(port.to_string()).stdin(Stdio::null()).output().ok()?;
        let slurm = Slurm { folder: folder.into() };
        if output.status.success() {
            return Some(slurm);
        }
        eprintln!("SKIPPED: Slurm cannot be started here, so its engine is not tested: {}", stderr(&output).trim());
        None
    }

    fn command(&self, program: &str, arguments: &[&str]) -> Output {
        Command::new(program).args(arguments).env("SLURM_CONF", self.folder.join("slurm.conf")).output().unwrap()
    }

    fn conserva(&self, folder: &Path, arguments: &[&str]) -> Command {
        let mut command = conserva(folder, arguments);
        command.env("SLURM_CONF", self.folder.join("slurm.conf"));
        command
    }

    /// Waits until a condition is true.
    fn wait(&self, what: &str, mut holds: impl FnMut(&str) -> bool) {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(60) {
            let queue = self.command("squeue", &["--noheader", "--array", "--format=%F_%K %T %N"]);
            if holds(&String::from_utf8_lossy(&queue.stdout)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        panic!("{what} did not come");
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        let processes = std::fs::read_to_string(self.folder.join("pids")).unwrap_or_default();
        for process in processes.lines() {
            let _ = Command::new("kill").args(["-9", process]).status();
        }
    }
}

/// Folder name with characters that are special in a shell and in Slurm.
const ARRAY: &str = "array 50%A \"it's\" $(exit 1)";

#[test]
fn slurm_computes_the_same_table_and_lost_tasks_are_made_up_for() {
    let folder = folder("slurm", &BLOCK.replace("10.0 * dt", "param(\"steps\", 10.0) * dt"));
    let Some(slurm) = Slurm::start(&folder.join("slurm")) else { return };
    let vary = ["--vary", "dt=0.005,0.01", "--vary", "spin=1..3:15"];
    let run = |arguments: &[&str]| slurm.conserva(&folder, arguments).output().unwrap();
    // 30 points in more tasks than an array of this Slurm may have, hence two arrays.
    let output = run(&[&["sweep", "main.rhai", "--engine", "slurm", "--time", "5", "--out", ARRAY, "--per-task", "2"][..], &vary].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(std::fs::read_to_string(folder.join(ARRAY).join("slurm/jobs.txt")).unwrap().lines().count(), 2);
    let output = run(&[&["sweep", "main.rhai", "--out", "here"][..], &vary].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(table(&folder.join(ARRAY)), table(&folder.join("here")));
    let nodes: Vec<bool> = ["on one", "on two"].map(|node| claims(&folder.join(ARRAY)).iter().any(|claim| claim.contains(node))).to_vec();
    assert_eq!(nodes, [true, true], "both nodes compute");

    // Long points: one task is cancelled, one is requeued while it runs, and the attached program is ended.
    let long = ["sweep", "main.rhai", "--vary", "spin=1..4:4", "--set", "steps=120000", "--out", "long", "--engine", "slurm"];
    let mut follower = slurm.conserva(&folder, &long).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let claim = |spin: &str| std::fs::read_to_string(folder.join(format!("long/points/spin={spin}/.claim"))).unwrap_or_default();
    slurm.wait("two running points", |_| ["1", "2"].iter().all(|spin| claim(spin).contains("Slurm task")));
    let job = std::fs::read_to_string(folder.join("long/slurm/jobs.txt")).unwrap().trim().to_string();
    follower.kill().unwrap();
    follower.wait().unwrap();
    assert!(slurm.command("scontrol", &["requeue", &format!("{job}_0")]).status.success());
    assert!(slurm.command("scancel", &[&format!("{job}_1"), &format!("{job}_3")]).status.success());
    // A requeued task waits for two minutes; it may be released earlier, but not in the second of its end, in which Slurm revokes it.
    std::thread::sleep(Duration::from_secs(3));
    slurm.wait("the requeued task", |queue| {
        let _ = slurm.command("scontrol", &["update", &format!("JobId={job}_0"), "StartTime=now"]);
        queue.lines().all(|line| !line.contains("PENDING"))
    });
    // Until then the table has a row for the unfinished point.
    slurm.wait("the end of the cancelled task", |_| {
        assert_ne!(run(&["sweep", "collect", "long", "--quiet"]).status.code(), Some(3));
        let row = &table(&folder.join("long"))[1];
        row["outcome"] == "stopped" && row["cause"].contains(&format!("Slurm task {job}_1"))
    });
    let output = run(&["sweep", "long", "--engine", "slurm"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    // The same command submits the points left by the old tasks.
    let told = stderr(&output);
    assert!(told.contains("tasks of this study are with Slurm already") && told.contains("submitted to Slurm"), "{told}");
    let rows = table(&folder.join("long"));
    // The energy defect of this many steps exceeds the limit for a run.
    let outcomes = column(&rows, "outcome").into_iter().map(|outcome| outcome.replace("not conserving", "completed"));
    assert_eq!(outcomes.collect::<Vec<_>>(), ["completed"; 4]);
    assert_eq!(records(&folder.join("long")).len(), 4);
}

/// Processes that computed the points of a study.
fn claims(study: &Path) -> Vec<String> {
    let points = std::fs::read_dir(study.join("points")).unwrap().flatten();
    points.map(|point| std::fs::read_to_string(point.path().join(".claim")).unwrap()).collect()
}
