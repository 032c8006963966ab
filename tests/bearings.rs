//! The bearing over a grid of step sizes, torques, methods and rules: a few here, some hundred by `cargo example bearings`.

#[path = "common/bearings.rs"]
mod bearings;

use std::sync::atomic::{AtomicU32, Ordering};

use bearings::{Bearing, ITERATIONS};
use conserva::contact::MORTAR;
use conserva::dynamics::{GAP, PERSISTENCY};

/// Runs bearings on all threads; returns the violations of each and its iterations per step.
fn judged(bearings: &[Bearing], until: f64) -> Vec<(Vec<String>, f64)> {
    let next = AtomicU32::new(0);
    let work = || {
        let numbers = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed) as usize);
        let bearings = numbers.map_while(|number| bearings.get(number));
        let judge = |bearing: &Bearing| {
            let outcome = bearing.run(until);
            let faults = outcome.faults(bearing.rule).iter().map(|fault| format!("{bearing:?}: {fault}")).collect();
            (faults, outcome.iterations)
        };
        bearings.map(judge).collect::<Vec<_>>()
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("a run does not panic")).collect()
    })
}

fn expect_no_faults(judged: &[(Vec<String>, f64)]) {
    let faults: Vec<&String> = judged.iter().flat_map(|(faults, _)| faults).collect();
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Every method with every rule, with the larger steps of the grid: the other tests of this file have small ones.
#[test]
fn bearings_of_a_grid_keep_what_their_rules_promise() {
    let bearings: Vec<Bearing> = (0..12).map(|number| Bearing { dt: Bearing::of(number).dt.max(0.01), ..Bearing::of(number) }).collect();
    expect_no_faults(&judged(&bearings, 0.65));
}

/// Torques and time step sizes at which earlier versions created 1e-8 of the energy in contact under `gap`, or accepted a step with a
/// defect of 5e-10.
#[test]
fn bearings_that_once_gained_energy_no_longer_do() {
    let bearing = |(dt, torque)| Bearing { dt, torque, held: true, refine: 1, method: &MORTAR, rule: &GAP };
    let judged = judged(&[(0.005, 0.11), (0.005, 0.13), (0.01, 0.075), (0.01, 0.125)].map(bearing), 0.6);
    expect_no_faults(&judged);
}

#[test]
fn a_bearing_that_names_no_rule_conserves() {
    let bearing = |torque| Bearing { dt: 0.005, torque, held: true, refine: 1, method: &MORTAR, rule: &PERSISTENCY };
    let judged = judged(&[0.1, 0.13].map(bearing), 1.0);
    expect_no_faults(&judged);
    assert!(judged.iter().all(|(_, iterations)| *iterations < ITERATIONS), "{judged:?}");
}
