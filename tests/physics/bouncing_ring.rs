//! A spinning ring bounces on a rigid plane under gravity, and in a rigid ring without gravity.
//!
//! Exact laws. Plane: the contact force is normal, so the momentum along the plane is constant; the impulses of gravity and contact explain
//! the rest. Ring: contact forces have no moment about its center, so the angular momentum about it is constant. `gap` dissipates energy at
//! closings, booked as contact work; the other rules and the penalty keep it (Hesch and Betsch 2007; Laursen and Chawla, IJNME 40, 1997;
//! Laursen and Love, IJNME 53, 2002).

use conserva::contact::Obstacle;
use conserva::dynamics::{Enforcement, GAP, Interaction, LedgerRow, PERSISTENCY, UpdateRule, VELOCITY};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::NeoHookean;
use conserva::math::tolerances::CORNER_SLACK;
use conserva::mesh::ring;

use crate::common::{Builder, drift, run, worst};

const RULES: [(&UpdateRule, Enforcement); 4] = [
    (&GAP, Enforcement::Multiplier),
    (&PERSISTENCY, Enforcement::Multiplier),
    (&VELOCITY, Enforcement::Multiplier),
    (&GAP, Enforcement::Penalty { factor: 1.0 }),
];

/// Length of a facet of the ring, 2 sin(pi / 40), rounded up.
const FACET: f64 = 0.157;

/// A ring of radius 1 at the origin, thrown at 2 and 5, spinning at 3, with gravity.
fn bounce(obstacle: Obstacle, gravity: f64, rule: (&'static UpdateRule, Enforcement), until: f64) -> Vec<LedgerRow> {
    // Corners of an obstacle have constraints of their own with a slack of this fraction of a facet; nodes do not penetrate.
    let corners = if matches!(obstacle, Obstacle::Polyline { .. }) { CORNER_SLACK * FACET } else { 0.0 };
    let mut builder = Builder::default();
    let mesh = ring(0.7, 1.0, [2, 40], [0.0; 2], 0.0).expect("the mesh is sound");
    let body =
        builder.body("ring", mesh, &NeoHookean { youngs_modulus: 1e4, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range"));
    let outer = builder.boundary(body, "outer");
    let definition = Interaction::obstacle("ground", outer, obstacle);
    builder.model.add_interaction(Interaction { update: Some(rule.0), enforcement: rule.1, ..definition });
    builder.model.gravity = [0.0, -gravity, 0.0];
    builder.set_initial_velocity(body, [2.0, 5.0, 0.0], [0.0, 0.0, 3.0]);
    let rows = run(&mut builder.simulate(&ENERGY_MOMENTUM, 0.004), until);

    let closings = rows.windows(2).filter(|pair| pair[1].active > 0 && pair[0].active == 0).count();
    assert!(closings >= 2, "{rule:?}: it bounces {closings} times");
    // The defect is Newton's tolerance; energies are of order 30, momenta of order 8, and a step adds the round-off of some hundred nodes.
    let energy = rows[0].total();
    assert!(worst(&rows, |row| row.energy_defect) < 1e-11 * energy, "{rule:?}: {:.1e}", worst(&rows, |row| row.energy_defect));
    assert!(worst(&rows, |row| row.momentum_defect) < 1e-11, "{rule:?}: {:.1e}", worst(&rows, |row| row.momentum_defect));
    let turning = worst(&rows, |row| row.angular_momentum_defect);
    assert!(turning < 1e-11, "{rule:?}: {turning:.1e}");
    // An obstacle at rest does no work as a load.
    assert_eq!(worst(&rows, |row| row.load_work), 0.0);

    let booked: f64 = rows[1..].iter().map(|row| row.contact_work).sum();
    let change = rows[rows.len() - 1].total() - energy;
    assert!((change - booked).abs() < 1e-10 * energy, "{rule:?}: {change} {booked}");
    if rule == RULES[0] {
        // The loss of a closing is lambda Phi(q_0) > 0.
        assert!(booked < -1e-4 * energy && booked > -0.3 * energy, "{booked}");
        assert!(rows[1..].iter().all(|row| row.contact_work < 1e-11 * energy));
        assert!(worst(&rows, |row| row.max_penetration) < corners + 1e-10);
    } else {
        assert!(change.abs() < 1e-10 * energy, "{rule:?}: {change:.1e} of {energy}");
    }
    println!(
        "{rule:?}: {} steps, {closings} closings, {} iterations, {} halvings, \
         booked {booked:.3e} of {energy:.1}, defect {:.1e}, penetration {:.1e}",
        rows.len() - 1,
        rows[1..].iter().map(|row| row.newton_iterations).sum::<usize>(),
        rows[1..].iter().map(|row| row.halvings).sum::<usize>(),
        worst(&rows, |row| row.energy_defect),
        worst(&rows, |row| row.max_penetration),
    );
    rows
}

#[test]
fn on_a_plane_the_momentum_along_it_is_constant() {
    for rule in RULES {
        let rows = bounce(Obstacle::HalfPlane { point: [0.0, -1.5], normal: [0.0, 1.0] }, 10.0, rule, 4.0);
        let along = drift(&rows, |row| [row.momentum[0], 0.0, 0.0]);
        assert!(along < 1e-11, "{rule:?}: {along:.1e}");
    }
}

#[test]
fn in_a_rigid_ring_the_angular_momentum_about_its_center_is_constant() {
    for rule in RULES {
        let rows = bounce(Obstacle::Ring { center: [0.0; 2], radius: 1.6 }, 0.0, rule, 1.5);
        let turning = drift(&rows, |row| row.angular_momentum);
        assert!(turning < 1e-11, "{rule:?}: {turning:.1e}");
    }
}

/// The ring rolls over a polyline with flats, a step up and a roof; nodes slide over its corners.
#[test]
fn over_the_corners_of_a_polyline_the_energy_closes() {
    let points = vec![[20.0, -1.2], [6.0, -1.2], [4.0, -0.8], [2.0, -1.5], [1.0, -1.5], [0.8, -1.3], [-20.0, -1.3]];
    for rule in RULES {
        bounce(Obstacle::Polyline { points: points.clone() }, 10.0, rule, 3.0);
    }
}
