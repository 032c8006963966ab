//! Random scenes of bodies in space; `cargo example solids` runs them by the hundred.

#[path = "../common/solids.rs"]
mod solids;

use solids::Scene;

use conserva::dynamics::{Options, Simulation, UPDATE_RULES};
use conserva::integrators::ENERGY_MOMENTUM;

/// Energy never grows, the ledger closes, momenta are constant, and penetrations stay small: `persistency` permits the approach of one
/// step.
#[test]
fn random_solids_conserve_and_stay_out_of_each_other() {
    let mut touching = 0;
    for seed in 100..112 {
        let rule = UPDATE_RULES[(seed % 3) as usize];
        let outcome = solids::run(Scene { seed, rule, friction: 0.0 });
        assert!(outcome.failure.is_none(), "{} {seed}: {outcome:?}", rule.name);
        assert!(outcome.defect < 1e-11 && outcome.gain < 1e-10 && outcome.momentum < 1e-10, "{} {seed}: {outcome:?}", rule.name);
        assert!(outcome.depth < 0.15, "{} {seed}: {outcome:?}", rule.name);
        touching += usize::from(outcome.touching > 0);
    }
    assert!(touching >= 9, "{touching} of 12 touch");
}

/// Random scenes in space with friction: its work is never positive, and its stress is within the friction cone.
#[test]
fn random_solids_rub_each_other() {
    let mut rubbing = 0;
    for seed in 200..212 {
        let (rule, friction) = (UPDATE_RULES[(seed % 3) as usize], 0.4);
        let outcome = solids::run(Scene { seed, rule, friction });
        assert!(outcome.failure.is_none(), "{} {seed}: {outcome:?}", rule.name);
        assert!(outcome.defect < 1e-11 && outcome.gain < 1e-10 && outcome.momentum < 1e-10, "{} {seed}: {outcome:?}", rule.name);
        assert!(outcome.friction < 1e-12 && outcome.ratio < friction + 1e-6, "{} {seed}: {outcome:?}", rule.name);
        rubbing += usize::from(outcome.ratio > 0.0);
    }
    assert!(rubbing >= 6, "{rubbing} of 12 rub");
}

/// A new simulation continues from a state with the same bytes, with and without friction.
#[test]
fn a_state_is_taken_up_by_a_new_simulation() {
    for friction in [0.0, 0.5] {
        goes_on(friction);
    }
}

fn goes_on(friction: f64) {
    let (model, dt, _) = solids::model_of(Scene { seed: 100, rule: UPDATE_RULES[0], friction });
    let new = || Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, dt)).expect("the model is sound");
    let step = |sim: &mut Simulation| sim.step(None, &mut |_| ()).unwrap_or_else(|error| panic!("{error}"));
    let mut sim = new();
    while sim.row().active == 0 {
        step(&mut sim);
    }
    let state = sim.shared_state();
    let mut other = new();
    assert!(other.fits(&state));
    other.restore(&state);
    for _ in 0..10 {
        step(&mut sim);
        step(&mut other);
    }
    assert_eq!(sim.shared_state().positions, other.shared_state().positions);
}
