//! An elastic bar and a rigid wall: the bar flies against it, or it pushes the bar.
//!
//! Closed form (one-dimensional wave): a bar of length L, density rho and wave speed c that meets a wall at the relative speed v is pressed
//! by rho c v from the first touch until the wave has returned from the free end, 2 L/c later; it leaves with the speed v reversed. A wall
//! that moves at v does the work 2 rho L v^2 on a bar at rest, which leaves it at 2 v.

use std::sync::Arc;

use conserva::contact::Obstacle;
use conserva::dynamics::{Amplitude, Enforcement, GAP, Interaction, LedgerRow, PERSISTENCY, Partner, Ramp, UpdateRule, VELOCITY};
use conserva::integrators::{self, ENERGY_MOMENTUM, Scheme};
use conserva::materials::SaintVenantKirchhoff;
use conserva::mesh::rectangle;

use crate::common::{Builder, run, worst};

const LENGTH: f64 = 1.0;
const HEIGHT: f64 = 0.05;
/// Speed over wave speed 1: strains of 1e-3, so that the waves are linear to 0.2 %.
const SPEED: f64 = 1e-3;

/// The bar from x = gap to gap + 1 in cells of 1/100, wave speed 1, density 1, and the wall x <= 0.
fn collide(
    integrator: &'static Scheme,
    moving_wall: bool,
    update: &'static UpdateRule,
    enforcement: Enforcement,
    until: f64,
) -> Vec<LedgerRow> {
    let (cells, dt) = (100, 0.005);
    // The first touch is in the middle of a step.
    let gap = SPEED * 10.5 * dt;
    let mut builder = Builder::default();
    let mesh = rectangle([LENGTH, HEIGHT], [cells, 1], [gap, 0.0]).expect("the mesh is sound");
    let bar = builder.body(
        "bar",
        mesh,
        &SaintVenantKirchhoff { youngs_modulus: 1.0, poisson_ratio: 0.0, density: 1.0 }.material().expect("in range"),
    );
    let left = builder.boundary(bar, "left");
    let mut motion: [Option<Amplitude>; 3] = [None, None, None];
    if moving_wall {
        motion[0] = Some(Arc::new(Ramp { start: 0.0, end: 10.0, value: 10.0 * SPEED }));
    } else {
        builder.set_initial_velocity(bar, [-SPEED, 0.0, 0.0], [0.0; 3]);
    }
    let partner = Partner::Obstacle { shape: Obstacle::HalfPlane { point: [0.0; 2], normal: [1.0, 0.0] }, motion, turn: None };
    builder.model.add_interaction(Interaction { update: Some(update), enforcement, ..Interaction::new("wall", left, partner) });
    run(&mut builder.simulate(integrator, dt), until)
}

const RULES: [(&UpdateRule, Enforcement); 4] = [
    (&GAP, Enforcement::Multiplier),
    (&PERSISTENCY, Enforcement::Multiplier),
    (&VELOCITY, Enforcement::Multiplier),
    // The stiffness of the penalty is the facet length (0.05) over the factor: a factor of 1 would delay the release by 0.1.
    (&GAP, Enforcement::Penalty { factor: 25.0 }),
];

#[test]
fn contact_lasts_until_the_wave_returns_and_presses_with_the_impedance() {
    for moving_wall in [false, true] {
        for (update, enforcement) in RULES {
            let rows = collide(&ENERGY_MOMENTUM, moving_wall, update, enforcement, 2.5);
            let (h, mass) = (LENGTH / 100.0, LENGTH * HEIGHT);
            // Kinetic energy of the impact, or the work of the wall, which is four times that.
            let energy = 0.5 * mass * SPEED * SPEED;
            let name = format!("{update:?} {enforcement:?} moving {moving_wall}");
            // Strains of 1e-3 are differences of positions about 1 over cells of 0.01: a relative round-off of 1e-11 in each.
            assert!(
                worst(&rows, |row| row.energy_defect) < 1e-10 * energy,
                "{name}: {:.1e}",
                worst(&rows, |row| row.energy_defect) / energy
            );
            assert!(worst(&rows, |row| row.momentum_defect) < 1e-10 * mass * SPEED, "{name}");

            // Force from the change of the momentum; the wave speed is 1.
            let force: Vec<f64> = rows.windows(2).map(|pair| (pair[1].momentum[0] - pair[0].momentum[0]) / pair[1].dt).collect();
            let pressed = |index: &usize| force[*index] > 0.01 * SPEED * HEIGHT;
            let first = (0..force.len()).find(pressed).expect("it touches");
            let last = (0..force.len()).rfind(pressed).expect("it touches");
            let (touch, release) = (rows[first].time, rows[last + 1].time);
            let impulse = rows[rows.len() - 1].momentum[0] - rows[0].momentum[0];
            // The first and last tenth, with numerical oscillations, are left out.
            let (from, to) = (first + (last - first) / 10, last - (last - first) / 10);
            let mean = force[from..to].iter().sum::<f64>() / (to - from) as f64 / HEIGHT;
            let work: f64 = rows[1..].iter().map(|row| row.load_work).sum();
            println!(
                "{name}: duration {:.4}, mean pressure over rho c v {:.5}, impulse over 2 m v {:.5}, work over 2 m v^2 {:.5}, lost {:.2e}",
                release - touch,
                mean / SPEED,
                impulse / (2.0 * mass * SPEED),
                work / (4.0 * energy),
                -rows[1..].iter().map(|row| row.contact_work).sum::<f64>() / energy,
            );
            assert!((release - touch - 2.0).abs() < 4.0 * h, "{name}: {touch} {release}");
            assert!((mean / SPEED - 1.0).abs() < 0.01, "{name}: {}", mean / SPEED);
            assert!((impulse / (2.0 * mass * SPEED) - 1.0).abs() < 0.01, "{name}: {}", impulse / (2.0 * mass * SPEED));
            if moving_wall {
                // The wall moves at constant speed: its work is impulse times speed.
                assert!((work - impulse * SPEED).abs() < 1e-9 * energy, "{name}: {work} {}", impulse * SPEED);
            } else {
                assert_eq!(work, 0.0);
            }
        }
    }
}

/// For every integrator, whatever its energy error: the impulse of the wall explains the change of the momentum, and its work is impulse
/// times speed.
#[test]
fn every_integrator_books_impulse_and_work_of_the_wall() {
    for &integrator in integrators::CATALOGUE.iter().filter(|scheme| !scheme.goes_back()) {
        let rows = collide(integrator, true, &GAP, Enforcement::Multiplier, 0.5);
        let mass = LENGTH * HEIGHT;
        let impulse = rows[rows.len() - 1].momentum[0];
        let work: f64 = rows[1..].iter().map(|row| row.load_work).sum();
        assert!(impulse > 0.1 * mass * SPEED, "{}: {impulse}", integrator.name);
        // For integrators with forces in several steps, the work of the moving wall uses the forces at the ends of steps.
        let closeness = if integrator.is_long() { 0.02 } else { 1e-9 };
        assert!((work / (impulse * SPEED) - 1.0).abs() < closeness, "{}: {work} {impulse}", integrator.name);
        // Relative round-off of 1e-11, as above.
        let defect = worst(&rows, |row| row.momentum_defect);
        assert!(defect < 1e-10 * mass * SPEED, "{}: {:.1e}", integrator.name, defect / (mass * SPEED));
    }
}
