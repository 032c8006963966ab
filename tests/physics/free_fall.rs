//! Free fall: the parabola, exactly.
//!
//! Closed form. The schemes whose positions move by the mean velocity integrate a constant acceleration exactly: `v_1 = v_0 + dt g`,
//! `q_1 = q_0 + dt (v_0 + v_1)/2`, at any step size, so positions differ from the parabola by round-off alone, and kinetic plus potential
//! energy stays.

use conserva::dynamics::LoadKind;
use conserva::integrators::{self, ENERGY_MOMENTUM, Scheme};
use conserva::materials::{NeoHookean, SaintVenantKirchhoff};
use conserva::mesh::{Mesh, block, rectangle};

use crate::common::{Builder, drift, run, worst};

fn fall(mesh: Mesh, integrator: &'static Scheme) {
    let (velocity, gravity) = ([3.0, 4.0, 0.0], [0.5, -9.81, 0.0]);
    let dimension = mesh.dimension();
    let mut builder = Builder::default();
    let body =
        builder.body("block", mesh, &NeoHookean { youngs_modulus: 1e4, poisson_ratio: 0.3, density: 2.0 }.material().expect("in range"));
    builder.set_initial_velocity(body, velocity, [0.0; 3]);
    builder.model.gravity = gravity;
    let mut sim = builder.simulate(integrator, 0.1);
    let start = sim.state().positions;
    let rows = run(&mut sim, 2.0);
    let state = sim.state();
    for (k, (q, x)) in state.positions.iter().zip(&start).enumerate() {
        let i = k % dimension;
        let expected = x + 2.0 * velocity[i] + 2.0 * gravity[i];
        // Positions of order 20, twenty steps, round-off of the solve.
        assert!((q - expected).abs() < 1e-11, "{}: {q} {expected}", integrator.name);
        assert!((state.velocities[k] - velocity[i] - 2.0 * gravity[i]).abs() < 1e-10);
    }
    let kinetic = worst(&rows, |row| row.kinetic);
    assert!(kinetic > 5.0 * rows[0].kinetic && worst(&rows, |row| row.strain) < 1e-14 * kinetic);
    assert!(worst(&rows, |row| row.total() - rows[0].total()) < 1e-12 * kinetic);
    assert!(worst(&rows, |row| row.momentum_defect) < 1e-11);
    assert!(worst(&rows, |row| row.angular_momentum_defect) < 1e-10);
    assert!(drift(&rows, |row| row.momentum) > 1.0, "its weight is an external force");
}

#[test]
fn falls_on_the_parabola_at_any_step() {
    for &integrator in integrators::CATALOGUE.iter().filter(|scheme| scheme.promises.order == 2) {
        fall(rectangle([2.0, 1.0], [3, 2], [0.0; 2]).expect("the mesh is sound"), integrator);
        fall(block([2.0, 1.0, 1.0], [2, 2, 1], [0.0; 3]).expect("the mesh is sound"), integrator);
    }
}

/// A force on a free body moves its mass center as a point mass: `m a = F` (dead force, so exactly).
#[test]
fn dead_force_accelerates_the_mass_center() {
    let mut builder = Builder::default();
    let mesh = rectangle([2.0, 1.0], [4, 2], [0.0; 2]).expect("the mesh is sound");
    let body = builder.body(
        "block",
        mesh,
        &SaintVenantKirchhoff { youngs_modulus: 1e3, poisson_ratio: 0.3, density: 2.0 }.material().expect("in range"),
    );
    builder.load(body, "right", LoadKind::Force([3.0, 1.0, 0.0]), conserva::dynamics::Constant(2.0));
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.05);
    let rows = run(&mut sim, 1.0);
    for row in &rows {
        assert!((row.momentum[0] - 6.0 * row.time).abs() < 1e-11 && (row.momentum[1] - 2.0 * row.time).abs() < 1e-11);
    }
    // The load's work is in the ledger; energies are of order ten.
    assert!(worst(&rows, |row| row.energy_defect) < 1e-11 && worst(&rows, |row| row.load_work) > 0.1);
}
