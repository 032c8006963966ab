//! Reactions of supports: weight, momentum, and the force of a prescribed motion.

use conserva::dynamics::{Model, Prescription, Ramp};
use conserva::integrators;
use conserva::materials::SaintVenantKirchhoff;
use conserva::mesh::rectangle;

use crate::common::Builder;

const GRAVITY: f64 = 10.0;

/// A block 2 x 1 from the origin, of density 3.
fn block(modulus: f64) -> (Builder, usize) {
    let mut builder = Builder::default();
    let material = SaintVenantKirchhoff { youngs_modulus: modulus, poisson_ratio: 0.0, density: 3.0 }.material().expect("in range");
    let body = builder.body("block", rectangle([2.0, 1.0], [4, 2], [0.0; 2]).expect("the mesh is sound"), &material);
    (builder, body)
}

#[test]
fn supports_carry_the_weight_and_its_moment() {
    let (mut builder, body) = block(1e4);
    builder.fix(body, "left", [true, true, false]);
    builder.model.gravity = [0.0, -GRAVITY, 0.0];
    assert_eq!(builder.model.support_names(), ["block.left"]);
    let mut sim = builder.simulate(&integrators::ENERGY_MOMENTUM, 0.01);
    assert!(sim.row().reactions.is_empty(), "nothing is known before the first step");
    sim.settle().expect("it hangs from its side");
    let reaction = sim.row().reactions[0];
    let weight = 3.0 * 2.0 * GRAVITY;
    assert!((reaction.force[1] - weight).abs() < 1e-9 * weight && reaction.force[0].abs() < 1e-9 * weight, "{reaction:?}");
    // The center of mass, at the distance 1 from the fixed side when undeformed, moves with the deformed block.
    let fields = sim.fields();
    let positions = sim.state().positions;
    let mass = |node: usize| {
        let [x, y, _] = fields[0].mesh.points[node];
        let on_edge = [x == 0.0 || x == 2.0, y == 0.0 || y == 1.0];
        3.0 * 0.25 / on_edge.into_iter().map(|edge| if edge { 2.0 } else { 1.0 }).product::<f64>()
    };
    let turning: f64 = (0..positions.len() / 2).map(|node| mass(node) * positions[2 * node]).sum::<f64>() * GRAVITY;
    assert!((reaction.moment[2] - turning).abs() < 1e-8 * turning, "{reaction:?} {turning}");
}

/// Exact law: the impulse of supports and gravity in a step is the change of the momentum, for every integrator.
#[test]
fn reactions_and_weight_change_the_momentum() {
    for &integrator in integrators::CATALOGUE {
        let (mut builder, body) = block(1e3);
        builder.fix(body, "left", [true, true, false]);
        builder.fix(body, "bottom", [false, true, false]);
        builder.model.gravity = [3.0, -GRAVITY, 0.0];
        let mut sim = builder.simulate(integrator, 0.01);
        let mut before = sim.row().momentum;
        for _ in 0..40 {
            sim.step(None, &mut |_| ()).expect("the step converges");
            let row = sim.row();
            for i in 0..2 {
                let force = row.reactions.iter().map(|reaction| reaction.force[i]).sum::<f64>() + 6.0 * [3.0, -GRAVITY][i];
                assert!((row.momentum[i] - before[i] - row.dt * force).abs() < 1e-11, "{} {}", integrator.name, row.step);
            }
            before = row.momentum;
        }
    }
}

/// Closed form: a bar with Poisson's ratio 0 at the stretch `l` has the force `E/2 (l^2 - 1) l` over its height.
#[test]
fn a_prescribed_motion_takes_the_force_of_its_stretch() {
    let (mut builder, body) = block(1e3);
    builder.fix(body, "left", [true, false, false]);
    builder.fix(body, "bottom", [false, true, false]);
    let pull = Prescription::along(builder.boundary(body, "right"), 0, std::sync::Arc::new(Ramp { start: 0.0, end: 1.0, value: 0.5 }));
    let model: &mut Model = &mut builder.model;
    model.prescriptions.push(pull);
    assert_eq!(model.support_names(), ["block.left", "block.bottom", "block.right"]);
    let mut sim = builder.simulate(&integrators::ENERGY_MOMENTUM, 0.01);
    sim.settle_at(1.0).expect("there is an equilibrium");
    let (stretch, reactions) = (1.25f64, &sim.row().reactions);
    let force = 0.5 * 1e3 * (stretch * stretch - 1.0) * stretch;
    assert!((reactions[2].force[0] - force).abs() < 1e-9 * force, "{reactions:?} {force}");
    assert!((reactions[0].force[0] + force).abs() < 1e-9 * force && reactions[1].force[1].abs() < 1e-9 * force);
}
