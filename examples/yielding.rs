//! Hundreds of random impacts of elastic-plastic bodies, judged by the ledger (`tests/common/yielding.rs`): one line for each run that has
//! a fault or does not complete, then a line for each formulation.
//!
//! `cargo example yielding -- [count] [--first SEED]`, or `--seed N` for every step of one

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/yielding.rs"]
mod yielding;

use yielding::{Outcome, run, take};

/// Random impacts of bodies that yield.
#[derive(Parser)]
struct Arguments {
    /// Number of scenes
    #[arg(default_value_t = 40)]
    count: u64,
    /// First seed
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// One scene, every step in numbers
    #[arg(long)]
    seed: Option<u64>,
}

fn main() {
    let arguments = Arguments::parse();
    if let Some(seed) = arguments.seed {
        let mut outcome = Outcome::default();
        take(seed, &mut outcome, &mut |row| {
            println!(
                "{:5} t {:.4} dt {:.2e} active {:2} kinetic {:.4e} strain {:.4e} heat {:.4e} defect {:.1e} iterations {} halvings {}",
                row.step,
                row.time,
                row.dt,
                row.active,
                row.kinetic,
                row.strain,
                row.plastic_work.iter().sum::<f64>(),
                row.energy_defect,
                row.newton_iterations,
                row.halvings
            );
        });
        return println!("{outcome:?}");
    }
    // A panic is a finding with its seed.
    std::panic::set_hook(Box::new(|_| ()));
    let (next, found) = (AtomicU64::new(arguments.first), Mutex::new(Vec::<(u64, Outcome)>::new()));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= arguments.first + arguments.count {
                        return;
                    }
                    let outcome = run(seed);
                    found.lock().expect("no thread panics").push((seed, outcome));
                }
            });
        }
    });
    let mut found = found.into_inner().expect("no thread panics");
    found.sort_by_key(|(seed, _)| *seed);
    let is_wrong = |outcome: &Outcome| !outcome.faults().is_empty() || outcome.failure.is_some();
    for (seed, outcome) in found.iter().filter(|(_, outcome)| is_wrong(outcome)) {
        println!("{seed}: {} {} ({})", outcome.faults(), outcome.failure.as_deref().unwrap_or(""), outcome.title);
    }
    for group in 0..4 {
        let own: Vec<&Outcome> = found.iter().filter(|(seed, _)| seed % 4 == group).map(|(_, outcome)| outcome).collect();
        let Some(place) = own.first().and_then(|outcome| outcome.place) else { continue };
        let largest = |of: fn(&Outcome) -> f64| own.iter().map(|outcome| of(outcome)).fold(0.0, f64::max);
        let sum = |of: fn(&Outcome) -> usize| own.iter().map(|outcome| of(outcome)).sum::<usize>();
        println!(
            "{place:?}: {} runs, {} touch, {} yield, {} with a fault, {} not to their end; largest defect {:.1e}, momentum {:.1e}, \
             gain {:.1e}; heat {:.1} % in the mean; {:.2} iterations a step, {} halvings",
            own.len(),
            sum(|outcome| usize::from(outcome.touching > 0)),
            sum(|outcome| usize::from(outcome.heat > 0.0)),
            sum(|outcome| usize::from(!outcome.faults().is_empty())),
            sum(|outcome| usize::from(outcome.failure.is_some())),
            largest(|outcome| outcome.defect),
            largest(|outcome| outcome.momentum),
            largest(|outcome| outcome.gain),
            100.0 * own.iter().map(|outcome| outcome.heat).sum::<f64>() / own.len() as f64,
            sum(|outcome| outcome.iterations) as f64 / sum(|outcome| outcome.steps).max(1) as f64,
            sum(|outcome| outcome.halvings),
        );
    }
}
