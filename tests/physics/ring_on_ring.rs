//! A free spinning ring meets the inside of a free ring: impacts and releases with the rule `gap`.
//!
//! Exact laws: momenta are constant; the rule loses energy at each closing, never gains, and the ledger books the loss as contact work, so that the
//! rest closes (Hesch and Betsch 2007; Laursen and Love, IJNME 53, 2002). The case is the prototype's own: clearance 0.05, speed 5, spin 20.

use conserva::integrators::Integrator;
use conserva::mesh::ring;

use crate::common::{Builder, drift, material, run, worst};

#[test]
fn energy_is_lost_at_closings_only_and_booked() {
    let steel = material("neo_hookean", [1e5, 0.1, 1e-3]);
    let mut builder = Builder::default();
    let outer = builder.body("outer ring", ring(1.0, 1.5, [4, 48], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let inner = builder.body("inner ring", ring(0.5, 0.95, [4, 40], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    builder.contact((inner, "outer"), (outer, "inner"));
    builder.throw(inner, [5.0, 0.0, 0.0], [0.0, 0.0, 20.0]);
    let rows = run(&mut builder.simulate(Integrator::EnergyMomentum, 0.001), 0.15);
    let energy = rows[0].total();

    let touching = rows.iter().filter(|row| row.active > 0).count();
    let closings = rows.windows(2).filter(|pair| pair[1].active > 0 && pair[0].active == 0).count();
    assert!(touching >= 5 && closings >= 1 && touching < rows.len() - 5, "it meets and parts: {touching} steps, {closings} closings");

    // Ledger: Newton's tolerance. Momenta are of order 1e-2 (mass 1e-3 per area, speed 5).
    let defect = worst(&rows, |row| row.energy_defect);
    assert!(defect < 1e-11 * energy, "defect {defect:.1e} of {energy}");
    for pair in rows.windows(2) {
        // Loss is lambda Phi(q_0) >= 0 up to the gap tolerance of a closed node, 1e-12 h^2.
        assert!(pair[1].total() <= pair[0].total() + 1e-11 * energy, "energy grows at t = {}", pair[1].time);
    }
    let lost = -rows[1..].iter().map(|row| row.contact_work).sum::<f64>();
    assert!(lost > 1e-3 * energy && lost < 0.5 * energy, "lost {lost:.2e} of {energy:.2e}");
    assert!((energy - rows[rows.len() - 1].total() - lost).abs() < 1e-10 * energy);
    assert!(drift(&rows, |row| row.momentum) < 1e-13, "{:.1e}", drift(&rows, |row| row.momentum));
    assert!(drift(&rows, |row| row.angular_momentum) < 1e-13, "{:.1e}", drift(&rows, |row| row.angular_momentum));
    // Nothing penetrates at the end of a step but nodes that sit one out with a sliver of overlap, by a small part of a facet (0.15).
    assert!(worst(&rows, |row| row.max_penetration) < 0.01, "{}", worst(&rows, |row| row.max_penetration));
}
