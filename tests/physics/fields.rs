//! Fields and totals of bodies: closed forms of a homogeneous stretch and of a rigid motion, and sums over bodies against the ledger.

use conserva::dynamics::{InitialVelocity, Prescription, Ramp};
use conserva::integrators;
use conserva::materials::SaintVenantKirchhoff;
use conserva::mesh::rectangle;

use crate::common::Builder;

fn block(origin: [f64; 2], name: &str, builder: &mut Builder) -> usize {
    let material = SaintVenantKirchhoff { youngs_modulus: 1e3, poisson_ratio: 0.0, density: 3.0 }.material().expect("in range");
    builder.body(name, rectangle([2.0, 1.0], [4, 2], origin).expect("the mesh is sound"), &material)
}

/// Closed form: a bar with Poisson's ratio 0 at the stretch `l` has the strain `(l^2 - 1)/2`, the Cauchy stress `l E (l^2 - 1)/2` on its
/// undeformed height, and the energy `E/2 ((l^2 - 1)/2)^2` per volume.
#[test]
fn a_homogeneous_stretch_has_its_strain_stress_and_energy_everywhere() {
    let mut builder = Builder::default();
    let body = block([0.0; 2], "bar", &mut builder);
    builder.fix(body, "left", [true, false, false]);
    builder.fix(body, "bottom", [false, true, false]);
    let on = builder.boundary(body, "right");
    let displacement = std::sync::Arc::new(Ramp { start: 0.0, end: 1.0, value: 0.5 });
    builder.model.prescriptions.push(Prescription::along(on, 0, displacement));
    let mut sim = builder.simulate(&integrators::ENERGY_MOMENTUM, 0.01);
    sim.settle_at(1.0).expect("it is pulled");
    let stretch: f64 = 1.25;
    let strain = 0.5 * (stretch * stretch - 1.0);
    let fields = &sim.fields()[body];
    for node in 0..fields.strain.len() {
        for (component, expected) in [strain, 0.0, 0.0, 0.0, 0.0, 0.0].into_iter().enumerate() {
            assert!((fields.strain[node][component] - expected).abs() < 1e-10);
        }
        assert!((fields.stress[node][0] - stretch * 1e3 * strain).abs() < 1e-7, "{:?}", fields.stress[node]);
        assert!((fields.von_mises(node) - fields.stress[node][0]).abs() < 1e-7);
        assert!((fields.pressure(node) + fields.stress[node][0] / 3.0).abs() < 1e-7);
    }
    let totals = sim.body(body);
    assert!((totals.strain - 2.0 * 0.5 * 1e3 * strain * strain).abs() < 1e-7 && (totals.mass - 6.0).abs() < 1e-12);
    assert!((totals.center[0] - stretch).abs() < 1e-9 && (totals.center[1] - 0.5).abs() < 1e-9);
}

#[test]
fn bodies_add_up_to_the_ledger() {
    let mut builder = Builder::default();
    let bodies = [block([0.0; 2], "lower", &mut builder), block([0.3, 4.0], "upper", &mut builder)];
    builder.model.gravity = [0.5, -2.0, 0.0];
    for (k, &body) in bodies.iter().enumerate() {
        builder.model.initial_velocities.push(InitialVelocity { body, linear: [1.0 + k as f64, 0.5, 0.0], angular: [0.0, 0.0, 3.0] });
    }
    let mut sim = builder.simulate(&integrators::ENERGY_MOMENTUM, 0.01);
    // Closed form: mass 6, moment of inertia 6 (2^2 + 1^2)/12.
    let start = sim.body(0);
    assert!((start.kinetic - (3.0 * 1.25 + 0.5 * 2.5 * 9.0)).abs() < 1e-11 && (start.momentum[0] - 6.0).abs() < 1e-12);
    assert!((start.angular_momentum[2] - (6.0 * 0.5 - 0.5 * 6.0 + 2.5 * 3.0)).abs() < 1e-11);
    for _ in 0..20 {
        sim.step(None, &mut |_| ()).expect("the step converges");
        let (row, totals) = (sim.row(), bodies.map(|body| sim.body(body)));
        let near = |sum: f64, of: f64| assert!((sum - of).abs() < 1e-11 * (1.0 + of.abs()), "{sum} {of}");
        near(totals.iter().map(|body| body.kinetic).sum(), row.kinetic);
        near(totals.iter().map(|body| body.strain).sum(), row.strain);
        near(totals.iter().map(|body| body.potential).sum(), row.potential);
        for i in 0..3 {
            near(totals.iter().map(|body| body.momentum[i]).sum(), row.momentum[i]);
            near(totals.iter().map(|body| body.angular_momentum[i]).sum(), row.angular_momentum[i]);
        }
    }
}
