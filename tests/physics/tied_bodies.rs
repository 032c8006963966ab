//! Two bodies with nonmatching meshes, tied: a patch test in tension, and two rings of half the thickness in free rotation.
//!
//! Exact laws: linear displacements are in both finite element spaces and satisfy the tie exactly, so the patch test is solved exactly;
//! energy, linear and angular momentum of the free body are constant, also if the tied polygons do not coincide.

use conserva::dynamics::{Constant, Interaction, LoadKind, Partner};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::{NeoHookean, SaintVenantKirchhoff};
use conserva::mesh::{rectangle, ring};

use crate::common::{Builder, drift, run, worst};

#[test]
fn a_tied_patch_in_tension_is_exact() {
    let mut builder = Builder::default();
    let rubber = SaintVenantKirchhoff { youngs_modulus: 1000.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
    let left = builder.body("left", rectangle([1.0, 1.0], [2, 3], [0.0; 2]).expect("the mesh is sound"), &rubber);
    let right = builder.body("right", rectangle([1.0, 1.0], [2, 4], [1.0, 0.0]).expect("the mesh is sound"), &rubber);
    let tie = Interaction::tie("seam", builder.boundary(right, "left"), builder.boundary(left, "right"));
    builder.model.add_interaction(tie);
    builder.fix(left, "left", [true, false, false]);
    builder.fix(left, "bottom", [false, true, false]);
    builder.load(right, "right", LoadKind::Traction([1.0, 0.0, 0.0]), Constant(100.0));
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.01);
    sim.settle().unwrap_or_else(|error| panic!("{error}"));
    let fields = sim.fields();
    let stretch = fields[1].position(2)[0] / 2.0;
    for body in &fields {
        for (node, x) in body.mesh.points.iter().enumerate() {
            // Damped steps reach displacements to about 1e-10.
            assert!((body.position(node)[0] - stretch * x[0]).abs() < 1e-9, "{} {x:?} {:?}", body.name, body.position(node));
            assert!((body.stress[node][0] / fields[0].stress[0][0] - 1.0).abs() < 1e-8 && body.stress[node][3].abs() < 1e-6);
        }
    }
    // The tie carries the traction over its length of 1.
    let seam = sim.contact("seam").expect("it is there");
    assert!((seam.force[0] + 100.0).abs() < 1e-6 && seam.force[1].abs() < 1e-6, "{:?}", seam.force);
    assert!(seam.pressure.iter().all(|pressure| (pressure - 100.0).abs() < 1e-6), "{:?}", seam.pressure);
}

#[test]
fn tied_rings_tumble_as_one_body() {
    for reach in [None, Some(0.1)] {
        let mut builder = Builder::default();
        let steel = NeoHookean { youngs_modulus: 1e4, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
        let outer = builder.body("outer", ring(1.0, 1.3, [2, 30], [0.0; 2], 0.1).expect("the mesh is sound"), &steel);
        let inner = builder.body("inner", ring(0.6, 1.0, [2, 36], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
        let partner = Partner::Tied { to: builder.boundary(outer, "inner"), reach };
        let tie = Interaction::new("fit", builder.boundary(inner, "outer"), partner);
        builder.model.add_interaction(tie);
        for body in [outer, inner] {
            builder.set_initial_velocity(body, [2.0, 1.0, 0.0], [0.0, 0.0, 8.0]);
        }
        let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.01);
        let rows = run(&mut sim, 1.0);
        let energy = rows[0].total();
        // Newton's tolerance; momenta are of order 10.
        assert!(worst(&rows, |row| row.energy_defect) < 1e-11 * energy, "{:.1e}", worst(&rows, |row| row.energy_defect) / energy);
        assert!(drift(&rows, |row| row.momentum) < 1e-10, "{:.1e}", drift(&rows, |row| row.momentum));
        assert!(drift(&rows, |row| row.angular_momentum) < 1e-10, "{:.1e}", drift(&rows, |row| row.angular_momentum));
        assert!(rows.iter().all(|row| row.active == 0 && row.contact_work.abs() < 1e-11 * energy));
        println!(
            "tied rings: {} iterations in {} steps, energy defect {:.1e}, angular drift {:.1e}",
            rows[1..].iter().map(|row| row.newton_iterations).sum::<usize>(),
            rows.len() - 1,
            worst(&rows, |row| row.energy_defect) / energy,
            drift(&rows, |row| row.angular_momentum)
        );
        // They have rotated by 8 rad, and the tie still holds.
        let fit = sim.contact("fit").expect("it is there");
        assert!(fit.gap.iter().all(|gap| gap.abs() < 1e-9) && fit.active.iter().all(|active| *active));
    }
}
