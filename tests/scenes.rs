//! Random scenes with oracles that know nothing of the code: energies, momenta and depth from positions and velocities alone.
//!
//! A hundred scenes here, thousands by `cargo run --release --example scenes`. Methods and rules go around with the seeds. What fails is
//! named with its seed: `cargo run --release --example scenes -- --shrink SEED --method M --rule R` makes a small script of it.

mod common;
#[path = "common/scenes/mod.rs"]
mod scenes;

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use conserva::dynamics::{ContactMethod, UpdateRule};

use scenes::geometry::{Point, add, length, subtract, turned};
use scenes::run::{Fault, Outcome, run, simulate};
use scenes::{Kind, Scene};

/// Number of scenes.
const COUNT: u64 = 100;

/// The scene of a seed; methods and rules take turns, so that twelve seeds in a row have all pairs.
fn scene(seed: u64) -> Scene {
    let (methods, rules) = (ContactMethod::ALL, UpdateRule::ALL);
    Scene::random(seed).with(methods[(seed % 4) as usize], rules[(seed % 3) as usize])
}

/// All runs, made once for all tests of this file, on all threads.
fn runs() -> &'static [(Scene, Outcome)] {
    static RUNS: OnceLock<Vec<(Scene, Outcome)>> = OnceLock::new();
    RUNS.get_or_init(|| {
        let next = AtomicUsize::new(0);
        let work = || {
            let seeds = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed) as u64).take_while(|&seed| seed < COUNT);
            let outcomes = seeds.map(|seed| (scene(seed), run(&scene(seed), &mut |_| ())));
            outcomes.collect::<Vec<_>>()
        };
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let mut runs: Vec<(Scene, Outcome)> = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            workers.into_iter().flat_map(|worker| worker.join().expect("a run does not panic")).collect()
        });
        runs.sort_by_key(|(scene, _)| scene.seed);
        runs
    })
}

/// No run has any of these faults.
fn assert_free_of(faults: &[Fault]) {
    let describe = |(scene, outcome): &(Scene, Outcome)| {
        let findings: Vec<String> = outcome.findings.iter().filter(|finding| faults.contains(&finding.fault)).map(describe).collect();
        let (method, rule) = (scene.method.name(), scene.rule.name());
        (!findings.is_empty()).then(|| format!("seed {} ({:?}, {method}, {rule}): {}", scene.seed, scene.kind, findings.join("; ")))
    };
    fn describe(finding: &scenes::run::Finding) -> String {
        format!("{} {:.2e} at step {} {}", finding.fault.name(), finding.worst, finding.worst_step, finding.text)
    }
    let found: Vec<String> = runs().iter().filter_map(describe).collect();
    assert!(found.is_empty(), "{} of {COUNT} scenes:\n{}", found.len(), found.join("\n"));
}

#[test]
fn every_run_comes_to_its_end() {
    assert_free_of(&[Fault::Failed, Fault::Slow]);
}

#[test]
fn energy_never_grows() {
    assert_free_of(&[Fault::Gained]);
}

#[test]
fn ledger_and_momenta_close() {
    assert_free_of(&[Fault::Defect, Fault::Momentum]);
}

#[test]
fn the_ledger_has_the_energy_that_positions_and_velocities_have() {
    assert_free_of(&[Fault::Ledger]);
}

#[test]
fn nothing_is_deeper_than_a_tenth_of_a_facet() {
    assert_free_of(&[Fault::Deep]);
}

/// The scenes are worth something: bodies meet in nearly all of them, and every kind is there.
#[test]
fn bodies_meet_and_all_kinds_are_there() {
    let touching = runs().iter().filter(|(_, outcome)| outcome.touching > 0).count();
    assert!(touching * 10 >= runs().len() * 9, "{touching}");
    for kind in [Kind::Collision, Kind::Nested, Kind::Box, Kind::Drum, Kind::Fall, Kind::Stack, Kind::Extreme] {
        assert!(runs().iter().any(|(scene, _)| scene.kind == kind), "{kind:?}");
    }
    assert!((0..COUNT).all(|seed| scene(seed).is_free_of_overlap()));
}

/// What does not move and is not pulled stays where it is, to the last bit: without overlap nothing pushes.
#[test]
fn rest_stays_rest() {
    for seed in 0..COUNT {
        let mut sim = simulate(&scene(seed).at_rest()).expect("the scene is sound");
        let start = sim.shared_state();
        for step in 0..3 {
            sim.step(None, &mut |_| ()).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            let state = sim.shared_state();
            assert!(state.velocities.iter().all(|&v| v == 0.0), "seed {seed} step {step}");
            assert_eq!(state.positions, start.positions, "seed {seed} step {step}");
        }
    }
}

/// Positions of all nodes until some steps after the first touch.
fn journey(scene: &Scene, after: usize) -> Vec<Vec<Point>> {
    let mut sim = simulate(scene).expect("the scene is sound");
    let (mut places, mut left) = (Vec::new(), after);
    for _ in 0..scene.steps {
        if sim.step(None, &mut |_| ()).is_err() || left == 0 {
            break;
        }
        left -= usize::from(sim.row().active > 0);
        places.push(sim.shared_state().positions.chunks_exact(2).map(|x| [x[0], x[1]]).collect());
    }
    places
}

/// A scene and its image take the same way.
fn assert_same_way(image: impl Fn(&Scene) -> Scene, place: impl Fn(Point) -> Point) {
    let mut failures = Vec::new();
    for seed in 0..40 {
        let scene = scene(seed);
        let (ours, theirs) = (journey(&scene, 5), journey(&image(&scene), 5));
        let apart = |(a, b): (&Vec<Point>, &Vec<Point>)| a.iter().zip(b).map(|(a, b)| length(subtract(place(*a), *b))).fold(0.0, f64::max);
        let worst = ours.iter().zip(&theirs).map(apart).fold(0.0, f64::max);
        if worst > 1e-9 || ours.len() != theirs.len() {
            failures.push(format!("seed {seed} ({:?}): {worst:.1e}, {} and {} steps", scene.kind, ours.len(), theirs.len()));
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

#[test]
fn the_mirror_image_takes_the_mirrored_way() {
    assert_same_way(Scene::mirrored, |[x, y]| [-x, y]);
}

#[test]
fn the_turned_and_moved_scene_takes_the_turned_and_moved_way() {
    assert_same_way(|scene| scene.turned(0.7).moved([2.0, -1.0]), |x| add(turned(0.7, x), [2.0, -1.0]));
}
