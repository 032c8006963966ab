//! Node-to-segment contact of two free rings, one in the other with clearance: nodes slide over facet borders, meet and part.
//!
//! Exact laws: both momenta are constant; `gap` books what closings lose, `persistency` and `velocity` lose nothing (Hesch and Betsch,
//! IUTAM Bookseries 3, 2007).

use conserva::dynamics::{ContactMethod, Enforcement, LedgerRow, UpdateRule};
use conserva::integrators::Integrator;
use conserva::mesh::ring;

use crate::common::{Builder, drift, material, run, worst};

fn hop(inner_is_secondary: bool, update: UpdateRule, enforcement: Enforcement) -> Vec<LedgerRow> {
    let steel = material("neo_hookean", [1e5, 0.1, 1e-3]);
    let mut builder = Builder::default();
    let outer = builder.body("outer ring", ring(1.0, 1.5, [3, 48], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let inner = builder.body("inner ring", ring(0.5, 0.95, [3, 40], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let (journal, race) = ((inner, "outer"), (outer, "inner"));
    if inner_is_secondary {
        builder.contact(journal, race)
    } else {
        builder.contact(race, journal)
    }
    let contact = &mut builder.model.contacts[0];
    (contact.method, contact.update, contact.enforcement) = (ContactMethod::NodeToSegment, update, enforcement);
    builder.throw(inner, [5.0, 0.0, 0.0], [0.0, 0.0, 20.0]);
    run(&mut builder.simulate(Integrator::EnergyMomentum, 0.001), 0.12)
}

#[test]
fn rings_with_clearance_keep_energy_and_momenta() {
    for inner_is_secondary in [true, false] {
        for (update, enforcement) in [
            (UpdateRule::Gap, Enforcement::Multiplier),
            (UpdateRule::Persistency, Enforcement::Multiplier),
            (UpdateRule::Velocity, Enforcement::Multiplier),
            (UpdateRule::Gap, Enforcement::Penalty { factor: 1.0 }),
        ] {
            let rows = hop(inner_is_secondary, update, enforcement);
            let name = format!("{update:?} {enforcement:?} inner {inner_is_secondary}");
            let energy = rows[0].total();
            let closings = rows.windows(2).filter(|pair| pair[1].active > 0 && pair[0].active == 0).count();
            let booked: f64 = rows[1..].iter().map(|row| row.contact_work).sum();
            println!(
                "{name}: {closings} closings, {} steps, {} iterations, {} halvings, booked {booked:.2e} of {energy:.2e}, defect {:.1e}, penetration {:.1e}",
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
            if (update, enforcement) == (UpdateRule::Gap, Enforcement::Multiplier) {
                assert!((change - booked).abs() < 1e-10 * energy && booked < 0.0 && booked > -0.5 * energy, "{name}: {booked}");
                assert!(worst(&rows, |row| row.max_penetration) < 1e-10, "{name}");
            } else {
                assert!(change.abs() < 1e-10 * energy, "{name}: {change:.1e}");
            }
        }
    }
}
