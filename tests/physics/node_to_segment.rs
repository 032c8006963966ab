//! Node-to-segment contact of two free rings, one in the other with clearance: nodes slide over facet borders, meet and separate.
//!
//! Exact laws: linear and angular momentum are constant; `gap` books the energy dissipated by closings, `persistency` and `velocity`
//! dissipate none (Hesch and Betsch, IUTAM Bookseries 3, 2007).

use conserva::contact::{ContactMethod, FacetShape, MORTAR, NODE_TO_SEGMENT};
use conserva::dynamics::{Enforcement, GAP, Hat, LedgerRow, LoadKind, PERSISTENCY, UpdateRule, VELOCITY};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::NeoHookean;
use conserva::mesh::ring;

use crate::common::{Builder, drift, run, worst};

fn hop(inner_is_secondary: bool, update: &'static UpdateRule, enforcement: Enforcement) -> Vec<LedgerRow> {
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material().expect("in range");
    let mut builder = Builder::default();
    let outer = builder.body("outer ring", ring(1.0, 1.5, [3, 48], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let inner = builder.body("inner ring", ring(0.5, 0.95, [3, 40], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let (journal, race) = ((inner, "outer"), (outer, "inner"));
    if inner_is_secondary {
        builder.contact(journal, race)
    } else {
        builder.contact(race, journal)
    }
    let contact = &mut builder.model.interactions[0];
    (contact.method, contact.update, contact.enforcement) = (&NODE_TO_SEGMENT, Some(update), enforcement);
    builder.set_initial_velocity(inner, [5.0, 0.0, 0.0], [0.0, 0.0, 20.0]);
    run(&mut builder.simulate(&ENERGY_MOMENTUM, 0.001), 0.12)
}

#[test]
fn rings_with_clearance_keep_energy_and_momenta() {
    for inner_is_secondary in [true, false] {
        for (update, enforcement) in [
            (&GAP, Enforcement::Multiplier),
            (&PERSISTENCY, Enforcement::Multiplier),
            (&VELOCITY, Enforcement::Multiplier),
            (&GAP, Enforcement::Penalty { factor: 1.0 }),
        ] {
            let rows = hop(inner_is_secondary, update, enforcement);
            let name = format!("{update:?} {enforcement:?} inner {inner_is_secondary}");
            let energy = rows[0].total();
            let closings = rows.windows(2).filter(|pair| pair[1].active > 0 && pair[0].active == 0).count();
            let booked: f64 = rows[1..].iter().map(|row| row.contact_work).sum();
            println!(
                "{name}: {closings} closings, {} steps, {} iterations, {} halvings, \
                 booked {booked:.2e} of {energy:.2e}, defect {:.1e}, penetration {:.1e}",
                rows.len() - 1,
                rows[1..].iter().map(|row| row.newton_iterations).sum::<usize>(),
                rows[1..].iter().map(|row| row.halvings).sum::<usize>(),
                worst(&rows, |row| row.energy_defect) / energy,
                worst(&rows, |row| row.max_penetration),
            );
            assert!(closings >= 2, "{name}: {closings}");
            // Newton's tolerance; momenta are of order 1e-2.
            let defect = worst(&rows, |row| row.energy_defect);
            assert!(defect < 1e-11 * energy, "{name}: {:.1e}", defect / energy);
            assert!(drift(&rows, |row| row.momentum) < 1e-13, "{name}: {:.1e}", drift(&rows, |row| row.momentum));
            assert!(drift(&rows, |row| row.angular_momentum) < 1e-13, "{name}: {:.1e}", drift(&rows, |row| row.angular_momentum));
            let change = rows[rows.len() - 1].total() - energy;
            if (update, enforcement) == (&GAP, Enforcement::Multiplier) {
                assert!((change - booked).abs() < 1e-10 * energy && booked < 0.0 && booked > -0.5 * energy, "{name}: {booked}");
                assert!(worst(&rows, |row| row.max_penetration) < 1e-10, "{name}");
            } else {
                assert!(change.abs() < 1e-10 * energy, "{name}: {change:.1e}");
            }
        }
    }
}

/// The bearing with clearance: a journal, pressed down by its weight, is spun up in a held race by an impulse of 0.01.
fn spun_up(method: &'static ContactMethod, radius: f64) -> LedgerRow {
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material().expect("in range");
    let mut builder = Builder::default();
    let outer = builder.body("outer ring", ring(1.0, 1.5, [3, 48], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let inner = builder.body("inner ring", ring(0.5, radius, [3, 40], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    builder.fix(outer, "outer", [true; 3]);
    builder.contact((inner, "outer"), (outer, "inner"));
    (builder.model.interactions[0].method, builder.model.interactions[0].update) = (method, Some(&GAP));
    // The test is about the corners of polygons.
    builder.model.interactions[0].facets = Some(FacetShape::Straight);
    builder.model.gravity = [0.0, -50.0, 0.0];
    builder.load(inner, "inner", LoadKind::Torque([0.0, 0.0, 1.0]), Hat { start: 0.0, end: 0.2, peak: 0.1 });
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.0025);
    // The corners of the larger journal overlap the race at the start.
    sim.settle().unwrap_or_else(|error| panic!("{error}"));
    let rows = run(&mut sim, 0.5);
    let last = &rows[rows.len() - 1];
    let scale = worst(&rows, |row| row.kinetic + row.strain);
    println!(
        "{method:?} radius {radius}: {} iterations, {} halvings in {} steps, {} in contact, angular momentum {:.3e}, defect {:.1e}",
        rows[1..].iter().map(|row| row.newton_iterations).sum::<usize>(),
        rows[1..].iter().map(|row| row.halvings).sum::<usize>(),
        rows.len() - 1,
        rows.iter().filter(|row| row.active > 0).count(),
        last.angular_momentum[2],
        worst(&rows, |row| row.energy_defect) / scale
    );
    // Newton's tolerance; the work of the hat is of order 0.1, forces are of order 1.
    assert!(worst(&rows, |row| row.energy_defect) < 1e-11 * scale.max(0.01), "{method:?} {radius}");
    assert!(worst(&rows, |row| row.momentum_defect) < 1e-12 && worst(&rows, |row| row.angular_momentum_defect) < 1e-12);
    assert!(rows.iter().any(|row| row.active > 0));
    last.clone()
}

/// Advantage of mortar contact. The corners of the journal lie on the radius, the middles of the race's facets at cos(pi/48) = 0.99786: a
/// journal of 0.995 rotates freely, the corners of one of 0.998 lock with those of the race, although a circle would have clearance.
#[test]
fn a_journal_turns_or_is_caught_by_its_corners() {
    for (method, radius, turns) in
        [(&NODE_TO_SEGMENT, 0.995, true), (&MORTAR, 0.995, true), (&NODE_TO_SEGMENT, 0.998, false), (&MORTAR, 0.998, true)]
    {
        let momentum = spun_up(method, radius).angular_momentum[2];
        // Free: most of the impulse of 0.01 remains (the weight rattles over the corners). Locked: the race takes it.
        assert!(if turns { momentum > 5e-3 } else { momentum.abs() < 1e-3 }, "{method:?} {radius}: {momentum}");
    }
}
