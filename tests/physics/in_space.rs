//! Random scenes of bodies in space; `cargo run --release --example solids` runs them by the hundred.

#[path = "../common/solids.rs"]
mod solids;

use conserva::dynamics::UPDATE_RULES;

/// Energy is never gained, the ledger closes, momenta stay, and nothing gets deep: `persistency` leaves what a step approaches.
#[test]
fn random_solids_conserve_and_stay_out_of_each_other() {
    let mut touching = 0;
    for seed in 100..112 {
        let rule = UPDATE_RULES[(seed % 3) as usize];
        let outcome = solids::run(seed, rule);
        assert!(outcome.failure.is_none(), "{} {seed}: {outcome:?}", rule.name);
        assert!(outcome.defect < 1e-11 && outcome.gain < 1e-10 && outcome.momentum < 1e-10, "{} {seed}: {outcome:?}", rule.name);
        assert!(outcome.depth < 0.15, "{} {seed}: {outcome:?}", rule.name);
        touching += usize::from(outcome.touching > 0);
    }
    assert!(touching >= 9, "{touching} of 12 touch");
}
