//! A free spinning block: energy, linear and angular momentum are constant for every step size.
//!
//! Exact laws. In space the block rotates about its middle axis, about which rigid rotation is unstable (Euler), so that it tumbles. A
//! benchmark of this kind: Simo and Tarnow, ZAMP 43 (1992), section 6.

use conserva::integrators::ENERGY_MOMENTUM;
use conserva::mesh::{Mesh, block, rectangle};

use crate::common::{Builder, drift, material, run, worst};

fn tumble(mesh: Mesh, law: &str, angular: [f64; 3], dt: f64, until: f64) {
    let mut builder = Builder::default();
    let body = builder.body("block", mesh, &material(law, [500.0, 0.3, 1.0]));
    builder.set_initial_velocity(body, [2.0, -1.0, 0.0], angular);
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, dt);
    let rows = run(&mut sim, until);
    let energy = rows[0].total();
    assert_eq!(rows.iter().map(|row| row.halvings).sum::<usize>(), 0);
    // Per step Newton leaves 1e-13 of the energy at most; over all steps these add up.
    assert!(worst(&rows, |row| row.energy_defect) < 1e-12 * energy, "{law}: {:.1e}", worst(&rows, |row| row.energy_defect) / energy);
    assert!(worst(&rows, |row| row.total() - energy) < 1e-11 * energy, "{law}");
    assert!(drift(&rows, |row| row.momentum) < 1e-11, "{law}: {:.1e}", drift(&rows, |row| row.momentum));
    let size = rows[0].angular_momentum.iter().fold(0.0f64, |size, x| size.max(x.abs()));
    assert!(drift(&rows, |row| row.angular_momentum) < 1e-11 * size, "{law}: {:.1e}", drift(&rows, |row| row.angular_momentum));
    assert!(worst(&rows, |row| row.strain) > 1e-3 * energy, "{law}: it deforms");
}

#[test]
fn plane_block_keeps_energy_and_momenta_through_many_turns() {
    for law in ["neo_hookean", "saint_venant_kirchhoff"] {
        // Eight turns, 0.3 radians a step.
        tumble(rectangle([3.0, 1.0], [6, 2], [0.0; 2]).expect("the mesh is sound"), law, [0.0, 0.0, 6.0], 0.05, 8.0);
    }
}

#[test]
fn block_in_space_keeps_energy_and_momenta_while_it_tumbles() {
    for law in ["neo_hookean", "saint_venant_kirchhoff"] {
        tumble(block([3.0, 2.0, 1.0], [3, 2, 1], [0.0; 3]).expect("the mesh is sound"), law, [0.1, 5.0, 0.1], 0.05, 4.0);
    }
}

/// Regression: errors of Newton's method had the same sign in every step and added up to 8e-11 of the energy.
#[test]
fn what_newton_leaves_in_each_step_does_not_add_up() {
    let mut builder = Builder::default();
    let mesh = rectangle([2.0, 2.0], [2, 2], [0.0; 2]).expect("the mesh is sound");
    let body = builder.body("block", mesh, &material("neo_hookean", [100.0, 0.3, 1.0]));
    builder.set_initial_velocity(body, [2.0, -1.0, 0.0], [0.0, 0.0, 6.0]);
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.1);
    let rows = run(&mut sim, 2000.0);
    let energy = rows[0].total();
    // A tenth of the bound is round-off.
    assert!(worst(&rows, |row| row.total() - energy) < 2.5e-11 * energy, "{:.1e}", worst(&rows, |row| row.total() - energy) / energy);
}
