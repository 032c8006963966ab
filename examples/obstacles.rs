//! Random bodies against random rigid obstacles, judged from positions alone: disks, planes and polylines of a twentieth of a facet to five
//! facets, at rest or moving by up to five facets a step.
//!
//! One line for each case with a fault, then sums. `cargo example obstacles -- [count] [--first SEED] [--seed SEED]`.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/scenes/mod.rs"]
mod scenes;

use scenes::obstacles::{Case, Verdict};
use scenes::run::{DEFECT, DEPTH};

/// Random bodies against random rigid obstacles.
#[derive(Parser)]
struct Arguments {
    /// Number of cases
    #[arg(default_value_t = 200)]
    count: u64,
    /// First seed
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// One case, told whole
    #[arg(long)]
    seed: Option<u64>,
    /// Threads, one case on each
    #[arg(long)]
    threads: Option<usize>,
}

fn main() {
    let arguments = Arguments::parse();
    std::panic::set_hook(Box::new(|_| ()));
    if let Some(seed) = arguments.seed {
        let case = Case::random(seed);
        println!("{case:#?}\n{:#?}", case.run());
        return;
    }
    let (next, verdicts) = (AtomicU64::new(arguments.first), Mutex::new(Vec::new()));
    let work = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= arguments.first + arguments.count {
                return;
            }
            let case = Case::random(seed);
            let verdict = case.run();
            tell(&case, &verdict);
            if let Ok(mut verdicts) = verdicts.lock() {
                verdicts.push(verdict);
            }
        }
    };
    let threads = arguments.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    let verdicts = verdicts.into_inner().unwrap_or_default();
    let count = |is: &dyn Fn(&Verdict) -> bool| verdicts.iter().filter(|verdict| is(verdict)).count();
    let largest = |of: &dyn Fn(&Verdict) -> f64| verdicts.iter().map(of).fold(0.0, f64::max);
    println!(
        "{} cases, {} touched: {} failed, {} deeper than {DEPTH}, {} missed; depth {:.3}, defect {:.1e}; {:.2} iterations in {} pieces",
        verdicts.len(),
        count(&|verdict| verdict.touched),
        count(&|verdict| verdict.error.is_some()),
        count(&|verdict| verdict.depth > DEPTH),
        count(&|verdict| verdict.missed.is_some()),
        largest(&|verdict| verdict.depth),
        largest(&|verdict| verdict.defect),
        verdicts.iter().map(|verdict| verdict.iterations).sum::<usize>() as f64 / count(&|_| true).max(1) as f64,
        verdicts.iter().map(|verdict| verdict.pieces).sum::<usize>(),
    );
}

/// Prints the faults of a case, one line each.
fn tell(case: &Case, verdict: &Verdict) {
    let title = format!("seed {} {} {:?}", case.seed, case.rule.name, case.form);
    if let Some(error) = &verdict.error {
        println!("{title}: FAILED {error}");
    }
    if verdict.depth > DEPTH {
        println!("{title}: DEEP {:.3} {}", verdict.depth, verdict.place);
    }
    if let Some(step) = verdict.missed {
        println!("{title}: MISSED in step {step}");
    }
    if verdict.defect > DEFECT {
        println!("{title}: DEFECT {:.1e}", verdict.defect);
    }
}
