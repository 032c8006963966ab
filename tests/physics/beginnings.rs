//! Start of a model and its loads: initial displacements, gravity over time, single points that are fixed and loaded.

use conserva::dynamics::{InitialDisplacement, LoadKind, Ramp};
use conserva::integrators::{ENERGY_MOMENTUM, MIDPOINT, TRAPEZOIDAL};
use conserva::materials::SaintVenantKirchhoff;
use conserva::mesh::{Boundary, rectangle};

use crate::common::{Builder, drift, run, worst};

/// Bar 2 x 1 from the origin, of mass 6, with Young's modulus 1000 and Poisson's ratio 0.
fn bar() -> (Builder, usize) {
    let mut builder = Builder::default();
    let material = SaintVenantKirchhoff { youngs_modulus: 1e3, poisson_ratio: 0.0, density: 3.0 }.material().expect("in range");
    let body = builder.body("bar", rectangle([2.0, 1.0], [4, 2], [0.0; 2]).expect("the mesh is sound"), &material);
    (builder, body)
}

/// Closed form: the stretch `l` stores `E/2 ((l^2 - 1)/2)^2` per volume; after release the total energy is constant.
#[test]
fn a_body_that_starts_strained_has_that_energy_and_keeps_it() {
    let (mut builder, body) = bar();
    let points = builder.model.bodies[body].mesh.points.clone();
    let displacement = points.iter().map(|x| [0.25 * (x[0] - 1.0), 0.0, 0.0]).collect();
    builder.model.initial_displacements.push(InitialDisplacement { body, displacement });
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.002);
    let strain = 0.5 * (1.25f64.powi(2) - 1.0);
    let stored = 2.0 * 0.5 * 1e3 * strain * strain;
    assert!((sim.row().strain - stored).abs() < 1e-11 * stored, "{}", sim.row().strain);
    let rows = run(&mut sim, 0.4);
    assert!(worst(&rows, |row| row.total() - stored) < 1e-10 * stored && worst(&rows, |row| row.kinetic) > 0.5 * stored);
    assert!(drift(&rows, |row| row.momentum) < 1e-10 && drift(&rows, |row| row.angular_momentum) < 1e-10);
}

/// Closed form: gravity that grows linearly over a time `T` gives a free body the momentum `m g t^2/(2 T)`.
#[test]
fn gravity_that_grows_is_a_load() {
    // Other integrators apply a part of each load in later steps (`tests/scripts/integrators.rhai`).
    for integrator in [&ENERGY_MOMENTUM, &MIDPOINT, &TRAPEZOIDAL] {
        let (mut builder, _) = bar();
        builder.model.gravity = [1.0, -10.0, 0.0];
        builder.model.gravity_amplitude = Some(std::sync::Arc::new(Ramp { start: 0.0, end: 1.0, value: 1.0 }));
        let mut sim = builder.simulate(integrator, 0.01);
        for row in &run(&mut sim, 1.0) {
            let expected = 6.0 * -10.0 * 0.5 * row.time * row.time;
            assert!((row.momentum[1] - expected).abs() < 1e-10 && row.potential == 0.0, "{}", integrator.name);
            assert!(row.energy_defect.abs() < 1e-10 && (row.step == 0 || row.load_work > 0.0), "{}", integrator.name);
        }
    }
}

/// Exact law: a force on a point accelerates the center of mass; a fixed point has the reaction of its load.
#[test]
fn single_points_are_loaded_and_held() {
    let (mut builder, body) = bar();
    let points = builder.model.bodies[body].mesh.points.clone();
    let node = |at: [f64; 2]| Boundary::of_node(points.iter().position(|x| x[..2] == at).expect("there is a node") as u32);
    let on = |boundary| conserva::dynamics::BodyBoundary { body, boundary };
    let mut free = builder.model.clone();
    builder.model.load(on(node([2.0, 1.0])), LoadKind::Force([0.0, -3.0, 0.0]), conserva::dynamics::Constant(2.0));
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.005);
    for row in &run(&mut sim, 0.2) {
        assert!((row.momentum[1] + 6.0 * row.time).abs() < 1e-11 && row.energy_defect.abs() < 1e-11);
    }
    // Hinge and roller each carry half of the weight of 60.
    free.gravity = [0.0, -10.0, 0.0];
    free.fix(on(node([0.0, 0.0])), [true, true, false]);
    free.fix(on(node([2.0, 0.0])), [false, true, false]);
    let mut sim =
        conserva::dynamics::Simulation::new(&free, conserva::dynamics::Options::new(&ENERGY_MOMENTUM, 0.01)).expect("it is sound");
    sim.settle().expect("it rests on two points");
    let reactions = &sim.row().reactions;
    assert!(reactions.len() == 2 && reactions.iter().all(|reaction| (reaction.force[1] - 30.0).abs() < 1e-7), "{reactions:?}");
}

#[test]
fn points_have_no_area() {
    let (mut builder, body) = bar();
    let on = conserva::dynamics::BodyBoundary { body, boundary: Boundary::of_node(0) };
    builder.model.load(on, LoadKind::Traction([1.0, 0.0, 0.0]), conserva::dynamics::Constant(1.0));
    let error = builder.model.check().unwrap_err();
    assert_eq!(error.to_string(), "\"bar.node 0\" has single points, which have no area");
}
