//! Random scripts with friction in space (`tests/common/friction/`): rigid bodies, soft bodies, friction work of every integrator, first
//! steps. Prints a line for each run with a fault, then a table.
//!
//! `cargo example friction -- --kind rigid|soft|work|first_step [--runs N] [--seed FIRST]`; `--script SEED` prints one
//! script.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::error::Error;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::{Parser, ValueEnum};
use conserva::script::{Checkpoints, Diagnostic, Observer, Progress, Session, Settings};

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/friction/mod.rs"]
mod friction;

use friction::Case;

/// Kind of study.
#[derive(Clone, Copy, ValueEnum)]
#[value(rename_all = "snake_case")]
enum Kind {
    /// Rigid bodies that rest, slide and spin
    Rigid,
    /// Soft bodies, each scene with five step sizes
    Soft,
    /// Friction work: each scene with every integrator and four step sizes
    Work,
    /// First steps under loads of any size
    FirstStep,
}

/// Random scripts with friction in space.
#[derive(Parser)]
struct Arguments {
    /// Kind of scripts
    #[arg(long, value_enum, default_value = "rigid")]
    kind: Kind,
    /// Number of runs
    #[arg(long, default_value_t = 50)]
    runs: u64,
    /// First seed
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Seconds after which a run counts as endless
    #[arg(long, default_value_t = 20)]
    patience: u64,
    /// Prints the script of a seed
    #[arg(long)]
    script: Option<u64>,
}

/// Observer that collects printed lines, and stops a session that takes too long.
struct Listener {
    printed: RefCell<Vec<String>>,
    interrupt: Arc<AtomicBool>,
    end: Instant,
}

impl Observer for Listener {
    fn print(&self, line: &str) {
        self.printed.borrow_mut().push(line.into());
    }
    fn passed(&self, _: &str) {}
    fn warn(&self, _: &Diagnostic) {}
    fn advanced(&self, _: &Progress) {
        if Instant::now() > self.end {
            self.interrupt.store(true, Ordering::Relaxed);
        }
    }
    fn began(&self, _: &str) {}
    fn ended(&self) {}
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let worker = std::thread::Builder::new().stack_size(conserva::script::STACK);
    worker.spawn(move || work(&arguments).map_err(|error| error.to_string()))?.join().map_err(|_| "a defect")??;
    Ok(())
}

fn case(kind: Kind, seed: u64) -> Case {
    match kind {
        Kind::Rigid => friction::rigid::case(seed),
        Kind::Soft => friction::soft::case(seed),
        Kind::Work => friction::work::case(seed),
        Kind::FirstStep => friction::first_step::case(seed),
    }
}

/// Printed lines of a script, and its error.
fn run(script: &str, patience: Duration) -> Result<(Vec<String>, Option<Diagnostic>), Box<dyn Error>> {
    let interrupt: Arc<AtomicBool> = Arc::default();
    let listener = Rc::new(Listener { printed: RefCell::default(), interrupt: interrupt.clone(), end: Instant::now() + patience });
    let settings = Settings { output: None, threads: 1, workers: 1, interrupt, checkpoints: Checkpoints::Never, ..Settings::default() };
    let place = std::env::temp_dir().join(format!("friction-{}.rhai", std::process::id()));
    std::fs::write(&place, script)?;
    let mut session = Session::new(settings, &std::env::temp_dir(), listener.clone()).map_err(|error| format!("{error:?}"))?;
    let error = session.run_file(&place).error;
    std::fs::remove_file(&place)?;
    Ok((listener.printed.take(), error))
}

fn work(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    if let Some(seed) = arguments.script {
        print!("{}", case(arguments.kind, seed).script);
        return Ok(());
    }
    let mut table: BTreeMap<String, [usize; 3]> = BTreeMap::new();
    let mut worst: BTreeMap<String, (f64, u64)> = BTreeMap::new();
    let mut slowest = (Duration::ZERO, 0);
    for seed in arguments.seed..arguments.seed + arguments.runs {
        let case = case(arguments.kind, seed);
        let begun = Instant::now();
        let (printed, error) = run(&case.script, Duration::from_secs(arguments.patience))?;
        slowest = slowest.max((begun.elapsed(), seed));
        let [runs, failed, wrong] = table.entry(case.kind.clone()).or_default();
        *runs += 1;
        if let Some(error) = error {
            *failed += 1;
            println!("{seed} {}: {}: {} {} {}", case.kind, case.name, error.code, error.title, error.causes.join("; "));
            continue;
        }
        let ratios = case.judge(&printed);
        let faults: Vec<String> =
            ratios.iter().filter(|(_, ratio)| ratio.is_nan() || *ratio > 1.0).map(|(name, ratio)| format!("{name} {ratio:.2e}")).collect();
        if !faults.is_empty() {
            *wrong += 1;
            println!("{seed} {}: {}: {}", case.kind, case.name, faults.join(", "));
        }
        for (name, ratio) in ratios {
            let entry = worst.entry(name).or_insert((0.0, seed));
            if ratio.is_nan() || ratio > entry.0 {
                *entry = (ratio, seed);
            }
        }
    }
    for (kind, [runs, failed, wrong]) in &table {
        println!("{kind}: {runs} runs, {failed} failed, {wrong} wrong");
    }
    for (name, (ratio, seed)) in &worst {
        println!("largest {name}: {ratio:.2e} of what is allowed (seed {seed})");
    }
    println!("slowest: {:.2?} (seed {})", slowest.0, slowest.1);
    Ok(())
}
