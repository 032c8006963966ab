//! Springs between nodes of two bodies: the period of two masses, and energy and momenta in free rotation.

use std::sync::Arc;

use conserva::dynamics::{End, SpringDefinition, SpringElement, SpringLaw};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::mesh::{Mesh, block, rectangle};

use crate::common::{Builder, drift, material, run, worst};

const STIFFNESS: f64 = 20.0;

/// Two blocks 1 x 1 (x 1) at a distance of 2, with a spring between the middles of the facing sides.
fn joined(meshes: [Mesh; 2], modulus: f64, rest_length: Option<f64>) -> Builder {
    let mut builder = Builder::default();
    let steel = material("neo_hookean", [modulus, 0.3, 1.0]);
    let ends = [("left", meshes[0].clone(), 1.0), ("right", meshes[1].clone(), 3.0)].map(|(name, mesh, x)| {
        let is_end = |point: &[f64; 3]| (point[0] - x).abs() < 1e-12 && (point[1] - 0.5).abs() < 1e-12 && point[2].abs() < 1e-12;
        let node = mesh.points.iter().position(is_end).expect("a node is there");
        (builder.body(name, mesh, &steel), node as u32)
    });
    builder.model.parts.push(Arc::new(SpringDefinition {
        name: "spring".into(),
        ends: ends.map(End::from),
        element: SpringElement { law: SpringLaw::linear(STIFFNESS), rest_length },
    }));
    builder
}

fn plane() -> [Mesh; 2] {
    [0.0, 3.0].map(|x| rectangle([1.0, 1.0], [2, 2], [x, 0.0]).expect("the mesh is sound"))
}

/// Closed form: masses `m` and `m` on a spring `k` swing with `omega^2 = 2 k / m`; a step turns the phase by `2 atan(omega dt / 2)`.
#[test]
fn two_masses_swing_with_their_period() {
    let builder = joined(plane(), 1e7, Some(1.8));
    let dt = 0.01;
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, dt);
    let (omega, amplitude) = ((2.0 * STIFFNESS).sqrt(), 0.2);
    let turn = 2.0 * (0.5 * omega * dt).atan();
    for row in &run(&mut sim, 2.0)[1..] {
        // The potential gives the absolute value of the elongation.
        let stretch = (2.0 * row.potential / STIFFNESS).sqrt();
        let expected = amplitude * (turn * row.step as f64).cos().abs();
        // The blocks deform by k/E = 2e-6 of the elongation, with some hundred periods of their own in one of the spring.
        assert!((stretch - expected).abs() < 2e-5 * amplitude, "step {}: {stretch} {expected}", row.step);
    }
}

#[test]
fn spinning_bodies_on_a_spring_keep_energy_and_momenta() {
    let space = [0.0, 3.0].map(|x| block([1.0, 1.0, 1.0], [2, 2, 1], [x, 0.0, 0.0]).expect("the mesh is sound"));
    for (meshes, angular) in [(plane(), [0.0, 0.0, 1.0]), (space, [0.4, -0.3, 1.0])] {
        let mut builder = joined(meshes, 200.0, None);
        builder.set_initial_velocity(0, [0.3, -2.0, 0.0], angular);
        builder.set_initial_velocity(1, [-0.1, 2.5, 0.0], [0.0, 0.0, -0.5]);
        let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.02);
        let rows = run(&mut sim, 4.0);
        let energy = rows[0].total();
        assert!(worst(&rows, |row| row.potential) > 0.05 * energy, "the spring works");
        assert!(worst(&rows, |row| row.energy_defect) < 1e-11 * energy);
        assert!(worst(&rows, |row| row.total() - energy) < 1e-10 * energy);
        assert!(drift(&rows, |row| row.momentum) < 1e-11 && drift(&rows, |row| row.angular_momentum) < 1e-10);
    }
}
