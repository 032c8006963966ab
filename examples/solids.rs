//! Hundreds of random scenes of bodies in space, judged by oracles that are independent of the kernels (`tests/common/solids.rs`): one line
//! for each run with a fault, then a table for each rule.
//!
//! `cargo example solids -- [count] [--first SEED] [--rule R] [--friction MU]`, or `--seed N` for one

use std::error::Error;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;
use conserva::dynamics::UPDATE_RULES;

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/solids.rs"]
mod solids;

use solids::{Outcome, Scene, run};

/// Random scenes of bodies in space.
#[derive(Parser)]
struct Arguments {
    /// Number of scenes
    #[arg(default_value_t = 40)]
    count: u64,
    /// First seed
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Update rule: gap, persistency, velocity or all
    #[arg(long, default_value = "all")]
    rule: String,
    /// Coefficient of friction
    #[arg(long, default_value_t = 0.0)]
    friction: f64,
    /// One scene, every step in numbers
    #[arg(long)]
    seed: Option<u64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let friction = arguments.friction;
    for rule in UPDATE_RULES.iter().copied().filter(|rule| arguments.rule == "all" || rule.name == arguments.rule) {
        if let Some(seed) = arguments.seed {
            let scene = Scene { seed, rule, friction };
            let (model, ..) = solids::model_of(scene);
            for body in &model.bodies {
                println!("{}: {}, {} nodes", body.name, body.mesh.counted_cells(), body.mesh.points.len());
            }
            let outcome = solids::watched(scene, &mut |row, depth| {
                println!(
                    "{:5} t {:.4} active {:2} depth {depth:.4} reported {:.4} kinetic {:.4} strain {:.4} iterations {} halvings {}",
                    row.step, row.time, row.active, row.max_penetration, row.kinetic, row.strain, row.newton_iterations, row.halvings
                );
            });
            println!("{} {seed}: {outcome:?}", rule.name);
            continue;
        }
        let (next, found) = (AtomicU64::new(arguments.first), Mutex::new(Vec::<(u64, Outcome)>::new()));
        std::thread::scope(|scope| {
            for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
                scope.spawn(|| {
                    loop {
                        let seed = next.fetch_add(1, Ordering::Relaxed);
                        if seed >= arguments.first + arguments.count {
                            return;
                        }
                        let outcome = run(Scene { seed, rule, friction });
                        found.lock().expect("no thread panics").push((seed, outcome));
                    }
                });
            }
        });
        let mut found = found.into_inner()?;
        found.sort_by_key(|(seed, _)| *seed);
        for (seed, outcome) in &found {
            let Outcome { failure, depth, gain, defect, momentum, friction: given, ratio, .. } = outcome;
            if failure.is_some()
                || *depth > 0.1
                || *gain > 1e-10
                || *defect > 1e-11
                || *momentum > 1e-10
                || *given > 1e-12
                || *ratio > friction + 1e-6
            {
                let failure = failure.as_deref().unwrap_or("");
                println!(
                    "{} {seed}: depth {depth:.3}, gain {gain:.1e}, defect {defect:.1e}, momentum {momentum:.1e}, friction {given:.1e}, \
                     ratio {ratio:.4} {failure}",
                    rule.name
                );
            }
        }
        let count = |is_one: fn(&Outcome) -> bool| found.iter().filter(|(_, outcome)| is_one(outcome)).count();
        let sum = |of: fn(&Outcome) -> usize| found.iter().map(|(_, outcome)| of(outcome)).sum::<usize>();
        let largest = |of: fn(&Outcome) -> f64| found.iter().map(|(_, outcome)| of(outcome)).fold(0.0, f64::max);
        let mut depths: Vec<f64> = found.iter().map(|(_, outcome)| outcome.depth).collect();
        depths.sort_by(f64::total_cmp);
        println!(
            "{:12} {} runs, {} touch, {} failed, {} deeper than 0.15; largest defect {:.1e}, gain {:.1e}, momentum {:.1e}, \
             friction {:.1e}; depth median {:.4}, 98 % {:.3}, largest {:.3} facets; {:.2} iterations a step, {} halvings",
            rule.name,
            found.len(),
            count(|outcome| outcome.touching > 0),
            count(|outcome| outcome.failure.is_some()),
            count(|outcome| outcome.depth > 0.15),
            largest(|outcome| outcome.defect),
            largest(|outcome| outcome.gain),
            largest(|outcome| outcome.momentum),
            largest(|outcome| outcome.friction),
            depths[depths.len() / 2],
            depths[(depths.len() * 98 / 100).min(depths.len() - 1)],
            depths[depths.len() - 1],
            sum(|outcome| outcome.iterations) as f64 / sum(|outcome| outcome.steps).max(1) as f64,
            sum(|outcome| outcome.halvings),
        );
    }
    Ok(())
}
