//! Every contact method with every enforcement and update rule: a ring is thrown against the inside of another one, so that nodes close,
//! slide over facet borders and separate.
//!
//! Exact laws: linear and angular momentum are constant; the ledger closes in every step; `gap` only dissipates energy, which is booked;
//! all other rules keep the energy over the whole run (Hesch and Betsch 2007; Laursen and Chawla, IJNME 40, 1997; Laursen and Love, IJNME
//! 53, 2002).

use conserva::contact::{ContactMethod, METHODS, MORTAR, NODE_TO_SEGMENT};
use conserva::dynamics::{Enforcement, GAP, LedgerRow, PERSISTENCY, UPDATE_RULES, UpdateRule};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::NeoHookean;
use conserva::mesh::{rectangle, ring};

use crate::common::{Builder, drift, run, worst};

const ENFORCEMENTS: [Enforcement; 3] =
    [Enforcement::Multiplier, Enforcement::AugmentedLagrange { factor: 100.0 }, Enforcement::Penalty { factor: 1.0 }];

fn collide(method: &'static ContactMethod, update: &'static UpdateRule, enforcement: Enforcement) -> Vec<LedgerRow> {
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material().expect("in range");
    let mut builder = Builder::default();
    let outer = builder.body("outer ring", ring(1.0, 1.5, [2, 36], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let inner = builder.body("inner ring", ring(0.5, 0.95, [2, 28], [0.0; 2], 0.1).expect("the mesh is sound"), &steel);
    builder.contact((inner, "outer"), (outer, "inner"));
    let contact = &mut builder.model.interactions[0];
    (contact.method, contact.update, contact.enforcement) = (method, Some(update), enforcement);
    builder.set_initial_velocity(inner, [8.0, 0.0, 0.0], [0.0, 0.0, 20.0]);
    run(&mut builder.simulate(&ENERGY_MOMENTUM, 0.001), 0.05)
}

#[test]
fn every_method_with_every_enforcement_and_rule_keeps_what_it_promises() {
    for &method in METHODS {
        for enforcement in ENFORCEMENTS {
            for &update in UPDATE_RULES {
                let penalty = matches!(enforcement, Enforcement::Penalty { .. });
                if penalty && update != &GAP {
                    continue; // The update rule is not used.
                }
                let case = format!("{} {enforcement:?} {}", method.name, update.name);
                let rows = collide(method, update, enforcement);
                let energy = rows[0].total();
                let touching = rows.iter().filter(|row| row.active > 0).count();
                let parts = rows.iter().skip_while(|row| row.active == 0).any(|row| row.active == 0);
                assert!(touching >= 2 && parts, "{case}: it meets and parts, {touching} steps in contact");
                // Newton's tolerance.
                let defect = worst(&rows, |row| row.energy_defect);
                assert!(defect < 1e-11 * energy, "{case}: defect {defect:.1e} of {energy:.1e}");
                // 1e-11 of the momenta, which are of order 2e-2: density 1e-3, area 2, speed 8.
                let (linear, angular) = (drift(&rows, |row| row.momentum), drift(&rows, |row| row.angular_momentum));
                assert!(linear < 2e-13 && angular < 2e-13, "{case}: momenta drift by {linear:.1e}, {angular:.1e}");
                if !update.keeps_energy && !penalty {
                    for pair in rows.windows(2) {
                        assert!(pair[1].total() <= pair[0].total() + 1e-11 * energy, "{case}: energy grows at {}", pair[1].time);
                    }
                } else {
                    let change = worst(&rows, |row| row.total() - energy);
                    assert!(change < 1e-10 * energy, "{case}: the energy changes by {change:.1e} of {energy:.1e}");
                }
            }
        }
    }
}

/// Regression: augmented Lagrange and Lagrange multipliers give the same motion.
#[test]
fn augmented_lagrange_moves_as_multipliers_do() {
    for update in [&GAP, &PERSISTENCY] {
        let last = |enforcement| collide(&MORTAR, update, enforcement).pop().expect("there are steps");
        let (solved, augmented) = (last(Enforcement::Multiplier), last(Enforcement::AugmentedLagrange { factor: 100.0 }));
        // Both end within Newton's tolerances; collisions of slender bodies multiply differences.
        let difference = (solved.strain - augmented.strain).abs();
        assert!(difference < 1e-6 * solved.total(), "{update:?}: strain energies differ by {difference:.1e} of {:.1e}", solved.total());
    }
}

/// Two passes of node-to-segment contact, each side secondary once: more constraints than independent motions, which augmented Lagrange and
/// the penalty cope with.
#[test]
fn two_passes_of_node_to_segment_contact_conserve() {
    for enforcement in [Enforcement::AugmentedLagrange { factor: 100.0 }, Enforcement::Penalty { factor: 1.0 }] {
        let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material().expect("in range");
        let mut builder = Builder::default();
        let outer = builder.body("outer ring", ring(1.0, 1.5, [2, 36], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
        let inner = builder.body("inner ring", ring(0.5, 0.95, [2, 28], [0.0; 2], 0.1).expect("the mesh is sound"), &steel);
        builder.contact((inner, "outer"), (outer, "inner"));
        builder.contact((outer, "inner"), (inner, "outer"));
        for (contact, name) in builder.model.interactions.iter_mut().zip(["there", "and back"]) {
            (contact.name, contact.method) = (name.into(), &NODE_TO_SEGMENT);
            (contact.update, contact.enforcement) = (Some(&PERSISTENCY), enforcement);
        }
        builder.set_initial_velocity(inner, [8.0, 0.0, 0.0], [0.0, 0.0, 20.0]);
        let rows = run(&mut builder.simulate(&ENERGY_MOMENTUM, 0.001), 0.03);
        let energy = rows[0].total();
        assert!(rows.iter().filter(|row| row.active > 0).count() >= 2, "{enforcement:?}: it meets");
        assert!(worst(&rows, |row| row.total() - energy) < 1e-10 * energy, "{enforcement:?}");
        assert!(drift(&rows, |row| row.momentum) < 1e-13 && drift(&rows, |row| row.angular_momentum) < 1e-13, "{enforcement:?}");
    }
}

/// Two equal blocks meet face to face, corner on corner: nodes of both sides stay aligned while the gap closes.
///
/// The corners sit on a kink of the weighted gap, which pulls them back from both sides. By symmetry nothing moves sideways; momentum is
/// exchanged as in the collision of two equal bars.
#[test]
fn equal_blocks_collide_face_to_face() {
    for &update in UPDATE_RULES {
        let rubber = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.0, density: 1.0 }.material().expect("in range");
        let mut builder = Builder::default();
        let block = |x: f64| rectangle([1.0, 0.1], [20, 2], [x, 0.0]).expect("the mesh is sound");
        let (left, right) = (builder.body("left", block(0.0), &rubber), builder.body("right", block(1.013), &rubber));
        builder.contact((left, "right"), (right, "left"));
        builder.model.interactions[0].update = Some(update);
        builder.set_initial_velocity(left, [1.0, 0.0, 0.0], [0.0; 3]);
        let rows = run(&mut builder.simulate(&ENERGY_MOMENTUM, 0.002), 0.4);
        let energy = rows[0].total();
        assert!(rows.iter().any(|row| row.active > 0) && rows[rows.len() - 1].active == 0, "{update:?}: they meet and part");
        assert!(worst(&rows, |row| row.energy_defect) < 1e-11 * energy, "{update:?}");
        // Momentum 0.1, and round-off of it in each of 200 steps.
        assert!(drift(&rows, |row| row.momentum) < 1e-13 && drift(&rows, |row| row.angular_momentum) < 1e-13, "{update:?}");
    }
}
