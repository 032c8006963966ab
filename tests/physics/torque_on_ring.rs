//! A torque on a free ring: its angular momentum is the integral of the torque, exactly, and the energy is the work of the torque.
//!
//! Exact laws. The kinks of the hat are at ends of steps, so that the mid-step and the end-point sum of the torque both equal its integral.
//! For comparison, the midpoint and the trapezoidal rule have an energy error in the ledger with the same steps.

use conserva::dynamics::{Hat, LedgerRow, LoadKind};
use conserva::integrators::{ENERGY_MOMENTUM, MIDPOINT, Scheme, TRAPEZOIDAL};
use conserva::materials::NeoHookean;
use conserva::mesh::ring;

use crate::common::{Builder, run, worst};

fn spun(integrator: &'static Scheme) -> Vec<LedgerRow> {
    let mut builder = Builder::default();
    let mesh = ring(0.5, 1.0, [3, 24], [2.0, 1.0], 0.0).expect("the mesh is sound");
    let body =
        builder.body("ring", mesh, &NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range"));
    builder.load(body, "inner", LoadKind::Torque([0.0, 0.0, 1.0]), Hat { start: 0.0, end: 1.0, peak: 6.0 });
    run(&mut builder.simulate(integrator, 0.05), 2.0)
}

/// Integral of the hat to a time.
fn impulse(time: f64) -> f64 {
    match time {
        t if t < 0.5 => 6.0 * t * t,
        t if t < 1.0 => 3.0 - 6.0 * (1.0 - t) * (1.0 - t),
        _ => 3.0,
    }
}

#[test]
fn angular_momentum_is_the_integral_of_the_torque() {
    for integrator in [&ENERGY_MOMENTUM, &MIDPOINT] {
        let rows = spun(integrator);
        for row in &rows {
            // Newton's method has errors of up to 1e-12 a step (1e-13 of the energy) in forty steps. The ring is away from the origin: the
            // torque has no resultant.
            assert!((row.angular_momentum[2] - impulse(row.time)).abs() < 1e-11, "{}: {row:?}", integrator.name);
            assert!(row.momentum[0].abs().max(row.momentum[1].abs()) < 1e-12, "{}: {:?}", integrator.name, row.momentum);
        }
        assert!(worst(&rows, |row| row.angular_momentum_defect) < 5e-12, "{}", integrator.name);
    }
}

#[test]
fn only_the_conserving_scheme_closes_the_energy() {
    let errors = [&ENERGY_MOMENTUM, &MIDPOINT, &TRAPEZOIDAL].map(|integrator| {
        let rows = spun(integrator);
        let total = rows[rows.len() - 1].total();
        println!("{}: worst energy defect of a step {:.1e} of {total:.3}", integrator.name, worst(&rows, |row| row.energy_defect));
        worst(&rows, |row| row.energy_defect) / total
    });
    // Newton's tolerance against the truncation error of order dt^3 in a ring with strains of a tenth.
    assert!(errors[0] < 1e-12 && errors[1] > 1e-5 && errors[2] > 1e-5, "{errors:?}");
}
