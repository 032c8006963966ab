//! Colliding rings, a known contact test (input `contact2D_initfield` of the code 4C): one ring flies at 20 into another at rest, glancing.
//!
//! Radii 8 to 10 around (-5, 0) and 10 to 12 around (15.8, -16), Saint Venant-Kirchhoff, E = 2250, nu = 0.125, density 0.1, step 0.01 to
//! t = 1; the outer boundary of the second is secondary. Exact laws: momenta, and the ledger with the loss of the rule `gap`. Meshes of 2
//! x 50 cells instead of 4 x 100.

use conserva::dynamics::GAP;
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::SaintVenantKirchhoff;
use conserva::mesh::ring;

use crate::common::{Builder, drift, run, worst};

#[test]
fn they_meet_and_part_and_the_ledger_closes() {
    let stuff = SaintVenantKirchhoff { youngs_modulus: 2250.0, poisson_ratio: 0.125, density: 0.1 }.material().expect("in range");
    let mut builder = Builder::default();
    let first = builder.body("first", ring(8.0, 10.0, [2, 50], [-5.0, 0.0], 0.0).expect("the mesh is sound"), &stuff);
    let second = builder.body("second", ring(10.0, 12.0, [2, 50], [15.8, -16.0], 0.0).expect("the mesh is sound"), &stuff);
    builder.contact((second, "outer"), (first, "outer"));
    builder.set_initial_velocity(first, [20.0, 0.0, 0.0], [0.0; 3]);
    builder.model.interactions[0].update = Some(&GAP);
    let rows = run(&mut builder.simulate(&ENERGY_MOMENTUM, 0.01), 1.0);
    let (start, end) = (&rows[0], &rows[rows.len() - 1]);
    let energy = start.total();

    assert!(start.active == 0 && end.active == 0 && worst(&rows, |row| row.active as f64) >= 2.0, "they meet and part");
    let touching: Vec<f64> = rows.iter().filter(|row| row.active > 0).map(|row| row.time).collect();
    // Rigid circles would touch when the centers are 22 apart: (20.8 - 20 t)^2 + 16^2 = 22^2; one step for the polygons.
    let meeting = (20.8 - (22.0f64 * 22.0 - 256.0).sqrt()) / 20.0;
    assert!((touching[0] - meeting).abs() < 0.02, "they meet at {} instead of {meeting}", touching[0]);

    // Required: momenta to 1e-11 of themselves.
    let momentum = start.momentum[0];
    assert!(drift(&rows, |row| row.momentum) < 1e-11 * momentum, "{:.1e}", drift(&rows, |row| row.momentum) / momentum);
    // About the origin the first ring has no angular momentum; the scale is momentum times the distance of the centers.
    assert!(drift(&rows, |row| row.angular_momentum) < 1e-11 * momentum * 20.0);
    assert!(worst(&rows, |row| row.energy_defect) < 1e-11 * energy, "{:.1e}", worst(&rows, |row| row.energy_defect) / energy);
    let lost = -rows[1..].iter().map(|row| row.contact_work).sum::<f64>();
    assert!((energy - end.total() - lost).abs() < 1e-10 * energy && lost > 0.0 && lost < 0.1 * energy, "lost {lost:.2e} of {energy:.2e}");
}
