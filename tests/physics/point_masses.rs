//! Masses at points of bodies: weight, inertia in every scheme, energy and momenta in flight and impact.

use std::sync::Arc;

use conserva::dynamics::{End, PERSISTENCY, PointMassDefinition, SpringDefinition, SpringElement, SpringLaw, VELOCITY};
use conserva::integrators::{CATALOGUE, ENERGY_MOMENTUM};
use conserva::mesh::rectangle;

use crate::common::{Builder, drift, material, run, worst};

/// Block 1 x 1 of density 1 at `x`, with a mass at its upper right corner.
fn loaded(builder: &mut Builder, name: &str, x: f64, modulus: f64, mass: f64) -> usize {
    let law = material("neo_hookean", [modulus, 0.3, 1.0]);
    let body = builder.body(name, rectangle([1.0, 1.0], [2, 2], [x, 0.0]).expect("the mesh is sound"), &law);
    let node = (body, 8);
    builder.model.parts.push(Arc::new(PointMassDefinition { name: format!("mass on {name}"), node, mass }));
    body
}

/// Closed form: a stiff block of mass 1 with a mass 3 at a corner falls like any other body, and its support carries the weight.
#[test]
fn a_mass_weighs_and_falls() {
    for &scheme in CATALOGUE {
        let mut builder = Builder::default();
        loaded(&mut builder, "block", 0.0, 1e3, 3.0);
        builder.model.gravity = [0.0, -2.0, 0.0];
        let mut sim = builder.simulate(scheme, 0.01);
        let rows = run(&mut sim, 0.1);
        let momentum = rows[rows.len() - 1].momentum;
        assert!((momentum[1] + 2.0 * 4.0 * 0.1).abs() < 1e-11, "{}: {momentum:?}", scheme.name);
    }
}

/// Two masses `m` at the ends of a spring `k`: `omega^2 = 2 k / m`, here with most of `m` in points at the nodes of the spring.
#[test]
fn masses_swing_with_their_period() {
    let (stiffness, dt) = (20.0, 0.01);
    let mut builder = Builder::default();
    let light = material("neo_hookean", [1e7, 0.3, 1e-3]);
    let bodies = [0.0, 3.0].map(|x| builder.body(&format!("at {x}"), rectangle([1.0, 1.0], [2, 2], [x, 0.0]).unwrap(), &light));
    let ends = [(bodies[0], 5), (bodies[1], 3)];
    for node in ends {
        builder.model.parts.push(Arc::new(PointMassDefinition { name: format!("mass {}", node.0), node, mass: 0.999 }));
    }
    let (ends, law) = (ends.map(End::from), SpringLaw::linear(stiffness));
    builder.model.parts.push(Arc::new(SpringDefinition {
        name: "spring".into(),
        ends,
        element: SpringElement { law, rest_length: Some(1.8) },
    }));
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, dt);
    let turn = 2.0 * (0.5 * (2.0 * stiffness).sqrt() * dt).atan();
    for row in &run(&mut sim, 2.0)[1..] {
        let stretch = (2.0 * row.potential / stiffness).sqrt();
        let expected = 0.2 * (turn * row.step as f64).cos().abs();
        assert!((stretch - expected).abs() < 1e-4, "step {}: {stretch} {expected}", row.step);
    }
}

#[test]
fn bodies_with_masses_keep_energy_and_momenta_in_flight_and_in_impact() {
    for rule in [&PERSISTENCY, &VELOCITY] {
        let mut builder = Builder::default();
        let left = loaded(&mut builder, "left", 0.0, 100.0, 0.7);
        let right = loaded(&mut builder, "right", 1.05, 100.0, 0.3);
        builder.model.set_initial_velocity(left, [1.0, 0.0, 0.0], [0.0, 0.0, 0.2]);
        let contact = builder.model.add_contact(
            "faces",
            builder.model.boundary(left, "right").unwrap(),
            builder.model.boundary(right, "left").unwrap(),
        );
        contact.update = Some(rule);
        let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.005);
        // The rotation is about the common center of the block and the mass.
        assert!((sim.row().momentum[0] - 1.7).abs() < 1e-12);
        let rows = run(&mut sim, 0.6);
        let energy = rows[0].total();
        assert!(rows.iter().any(|row| row.active > 0), "they meet");
        assert!(worst(&rows, |row| row.energy_defect) < 1e-11 * energy);
        assert!(worst(&rows, |row| row.total() - energy) < 1e-10 * energy, "{}", rule.name);
        assert!(drift(&rows, |row| row.momentum) < 1e-11 && drift(&rows, |row| row.angular_momentum) < 1e-10);
    }
}
