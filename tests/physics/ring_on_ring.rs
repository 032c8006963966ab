//! A free spinning ring meets the inside of a free ring: impacts and releases, with every update rule and with the penalty.
//!
//! Exact laws: momenta are constant; `gap` dissipates energy at each closing, never creates any, and the ledger books the loss as contact
//! work, so that it closes; the other rules and the penalty keep the energy through impact and release (Hesch and Betsch 2007; Laursen and
//! Chawla, IJNME 40, 1997; Laursen and Love, IJNME 53, 2002). The case is that of the prototype: clearance 0.05, speed 5, spin 20.

use conserva::dynamics::{Enforcement, GAP, LedgerRow, PERSISTENCY, UpdateRule, VELOCITY};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::NeoHookean;
use conserva::mesh::ring;

use crate::common::{Builder, drift, run, worst};

fn hop(update: &'static UpdateRule, enforcement: Enforcement) -> Vec<LedgerRow> {
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material().expect("in range");
    let mut builder = Builder::default();
    let outer = builder.body("outer ring", ring(1.0, 1.5, [3, 48], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let inner = builder.body("inner ring", ring(0.5, 0.95, [3, 40], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    builder.contact((inner, "outer"), (outer, "inner"));
    builder.model.interactions[0].update = Some(update);
    builder.model.interactions[0].enforcement = enforcement;
    builder.set_initial_velocity(inner, [5.0, 0.0, 0.0], [0.0, 0.0, 20.0]);
    let rows = run(&mut builder.simulate(&ENERGY_MOMENTUM, 0.001), 0.12);

    let closings = rows.windows(2).filter(|pair| pair[1].active > 0 && pair[0].active == 0).count();
    let apart = rows.iter().filter(|row| row.active == 0).count();
    assert!(closings >= 2 && apart > 20, "it meets and parts: {closings} closings, {apart} steps apart");
    // Ledger: Newton's tolerance. Momenta are of order 1e-2 (density 1e-3, area 2, speed 5).
    let (energy, defect) = (rows[0].total(), worst(&rows, |row| row.energy_defect));
    assert!(defect < 1e-11 * energy, "{update:?}: defect {defect:.1e} of {energy}");
    assert!(drift(&rows, |row| row.momentum) < 1e-13, "{update:?}: {:.1e}", drift(&rows, |row| row.momentum));
    assert!(drift(&rows, |row| row.angular_momentum) < 1e-13, "{update:?}: {:.1e}", drift(&rows, |row| row.angular_momentum));
    rows
}

#[test]
fn gap_loses_energy_at_closings_only_and_books_it() {
    let rows = hop(&GAP, Enforcement::Multiplier);
    let energy = rows[0].total();
    for pair in rows.windows(2) {
        // The loss is lambda Phi(q_0) >= 0 up to the gap tolerance of a closed node, 1e-12 h^2.
        assert!(pair[1].total() <= pair[0].total() + 1e-11 * energy, "energy grows at t = {}", pair[1].time);
    }
    let lost = -rows[1..].iter().map(|row| row.contact_work).sum::<f64>();
    assert!(lost > 1e-3 * energy && lost < 0.5 * energy, "lost {lost:.2e} of {energy:.2e}");
    assert!((energy - rows[rows.len() - 1].total() - lost).abs() < 1e-10 * energy);
    // No penetration at the end of a step, except of inactive nodes with a small overlap (of at most 0.15 facets).
    assert!(worst(&rows, |row| row.max_penetration) < 0.01, "{}", worst(&rows, |row| row.max_penetration));
}

#[test]
fn the_other_rules_keep_the_energy_through_impact_and_release() {
    for (update, enforcement) in
        [(&PERSISTENCY, Enforcement::Multiplier), (&VELOCITY, Enforcement::Multiplier), (&GAP, Enforcement::Penalty { factor: 1.0 })]
    {
        let rows = hop(update, enforcement);
        let energy = rows[0].total();
        let change = worst(&rows, |row| row.total() - energy);
        // Newton's tolerance in each of 120 steps.
        assert!(change < 1e-10 * energy, "{update:?} {enforcement:?}: the energy changes by {change:.1e} of {energy}");
        // Approach of one step at speed 5, and the effect of rotation.
        assert!(worst(&rows, |row| row.max_penetration) < 0.02, "{update:?}: {}", worst(&rows, |row| row.max_penetration));
    }
}
