//! The bearing over step sizes, torques, supports, refinements, contact methods and update rules, with checks of the ledger in every step,
//! of the sign of contact work, and of the energy drift after the torque.
//!
//! One line for each run, a summary for each rule.
//!
//! `cargo example bearings -- [count] [--rule R] [--method M] [--refine N] [--until T] [--threads N]`

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use clap::Parser;
use conserva::contact::METHODS;
use conserva::dynamics::UPDATE_RULES;

#[path = "../tests/common/bearings.rs"]
mod bearings;

use bearings::{Bearing, ITERATIONS, Outcome};

/// A grid of bearings.
#[derive(Parser)]
struct Arguments {
    /// Number of bearings of each rule
    #[arg(default_value_t = 48)]
    count: u32,
    /// Update rule: gap, persistency, velocity or all
    #[arg(long, default_value = "all")]
    rule: String,
    /// Contact method: mortar, dual_mortar, averaged_mortar, node_to_segment, or turns for one after the other
    #[arg(long, default_value = "mortar")]
    method: String,
    /// Multiplies all numbers of cells
    #[arg(long, default_value_t = 1)]
    refine: usize,
    /// End of the runs; the torque ends at 0.5
    #[arg(long, default_value_t = 2.0)]
    until: f64,
    /// Threads, one bearing on each
    #[arg(long)]
    threads: Option<usize>,
}

fn main() {
    let arguments = Arguments::parse();
    let rules: Vec<_> = UPDATE_RULES.iter().filter(|rule| [rule.name, "all"].contains(&arguments.rule.as_str())).collect();
    let method = METHODS.iter().find(|method| method.name == arguments.method);
    let bearing = |number: u32, rule| {
        let bearing = Bearing::of(number);
        Bearing { rule, refine: arguments.refine, method: method.copied().unwrap_or(bearing.method), ..bearing }
    };
    let jobs: Vec<Bearing> = (0..arguments.count).flat_map(|number| rules.iter().map(move |rule| bearing(number, rule))).collect();
    let (next, outcomes) = (AtomicU32::new(0), Mutex::new(BTreeMap::<&str, Vec<Outcome>>::new()));
    println!("dt      torque held  method, rule                 steps iterations factorizations   defect    given    taken    drift depth");
    let work = || {
        while let Some(bearing) = jobs.get(next.fetch_add(1, Ordering::Relaxed) as usize) {
            let outcome = bearing.run(arguments.until);
            let (Bearing { dt, torque, held, method, rule, .. }, Outcome { steps, iterations, factorizations, .. }) = (bearing, &outcome);
            let Outcome { defect, given, taken, drift, depth, .. } = outcome;
            println!(
                "{dt:.5} {torque:.4} {held:5} {:28} {steps:5} {iterations:10.2} {factorizations:14.2} {defect:8.1e} {given:8.1e} \
                 {taken:8.1e} {drift:8.1e} {depth:5.3} {}",
                format!("{}, {}", method.name, rule.name),
                outcome.faults(rule).join(", ")
            );
            outcomes.lock().expect("nobody panics").entry(rule.name).or_default().push(outcome);
        }
    };
    let threads = arguments.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    for (rule, outcomes) in outcomes.into_inner().expect("nobody panics") {
        let largest = |value: fn(&Outcome) -> f64| outcomes.iter().map(value).fold(0.0, f64::max);
        let rule_of = UPDATE_RULES.iter().find(|other| other.name == rule).expect("it was asked for");
        println!(
            "{rule}: {} runs, {} with faults, {} with more than {ITERATIONS} iterations a step; at most defect {:.1e}, given {:.1e}, taken \
             {:.1e}, drift {:.1e}, depth {:.3}, iterations {:.2}",
            outcomes.len(),
            outcomes.iter().filter(|outcome| !outcome.faults(rule_of).is_empty()).count(),
            outcomes.iter().filter(|outcome| outcome.iterations > ITERATIONS).count(),
            largest(|outcome| outcome.defect),
            largest(|outcome| outcome.given),
            largest(|outcome| outcome.taken),
            largest(|outcome| outcome.drift),
            largest(|outcome| outcome.depth),
            largest(|outcome| outcome.iterations)
        );
    }
}
