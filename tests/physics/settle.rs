//! Equilibria of `settle` balance body by body, and an equilibrium is found if there is one.
//!
//! Closed forms: a bar of Saint Venant-Kirchhoff material without Poisson's effect under a dead end load `p` has the stretch that solves
//! `lambda^3 - lambda = 2 p/E`; in a stack every interface carries the weight above it.

use conserva::contact::Obstacle;
use conserva::dynamics::{Constant, Interaction, LoadKind, SettleReport, Simulation};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::{NeoHookean, SaintVenantKirchhoff};
use conserva::mesh::{rectangle, ring};

use crate::common::Builder;

/// Required: the forces on every body balance to this fraction of their size.
const BALANCE: f64 = 1e-10;

fn settle(sim: &mut Simulation) -> SettleReport {
    sim.settle().unwrap_or_else(|error| panic!("{error}"))
}

/// Asserts that a settled state does not change by another `settle`: a step without improvement is not taken.
fn expect_settled(sim: &mut Simulation) {
    let before = sim.state().clone();
    settle(sim);
    assert_eq!(sim.state().positions, before.positions);
    assert_eq!(sim.row().strain, before.row.strain);
}

/// `lambda - 1` of the bar, by Newton's method on `d^3 + 3 d^2 + 2 d = 2 p/E`, which does not cancel for small loads.
fn elongation(load_over_modulus: f64) -> f64 {
    let mut d = load_over_modulus;
    for _ in 0..60 {
        d -= (d * d * d + 3.0 * d * d + 2.0 * d - 2.0 * load_over_modulus) / (3.0 * d * d + 6.0 * d + 2.0);
    }
    d
}

/// A soft block falls on a floor and is compressed, while a stiffer body lies elsewhere without contact.
#[test]
fn a_stiff_bystander_hides_no_imbalance() {
    const PRESSURE: f64 = 10.0;
    let soft = SaintVenantKirchhoff { youngs_modulus: 200.0, poisson_ratio: 0.0, density: 1.0 }.material().expect("in range");
    for bystander in [0.0, 2e4, 2e6, 2e9] {
        let mut builder = Builder::default();
        let block = builder.body("block", rectangle([10.0, 10.0], [20, 20], [0.0, 0.01]).expect("the mesh is sound"), &soft);
        let floor = builder.body("floor", rectangle([20.0, 1.0], [10, 1], [-5.0, -1.0]).expect("the mesh is sound"), &soft);
        builder.fix(floor, "bottom", [true; 3]);
        builder.fix(floor, "top", [true; 3]);
        builder.fix(block, "left", [true, false, false]);
        if bystander > 0.0 {
            let stiff = SaintVenantKirchhoff { youngs_modulus: bystander, poisson_ratio: 0.0, density: 1.0 }.material().expect("in range");
            let other = builder.body("bystander", rectangle([10.0, 1.0], [4, 1], [0.0, -10.0]).expect("the mesh is sound"), &stiff);
            builder.fix(other, "bottom", [true; 3]);
        }
        builder.load(block, "top", LoadKind::Traction([0.0, -PRESSURE, 0.0]), Constant(1.0));
        builder.contact((block, "bottom"), (floor, "top"));
        let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.1);
        settle(&mut sim);
        let reaction = sim.contact("contact").expect("there is one").force[1];
        assert!((reaction / (10.0 * PRESSURE) - 1.0).abs() < BALANCE, "{bystander:e}: {reaction}");
        let fields = &sim.fields()[0];
        let shortening = elongation(-PRESSURE / 200.0) * 10.0 - 0.01;
        for node in fields.mesh.boundary_nodes(fields.mesh.boundary("top").expect("a rectangle has it")) {
            // An imbalance of 1e-10 of the load changes the shortening by about 1e-10.
            assert!((fields.displacement[node as usize][1] / shortening - 1.0).abs() < 2.0 * BALANCE, "{bystander:e}");
        }
        expect_settled(&mut sim);
    }
}

/// Regression: the error of the first damped step remained, 3e-6 of the strain, whatever its size.
#[test]
fn small_strains_are_as_exact_as_positions_can_be() {
    for load in [1e-6, 1e-4, 1e-2, 1.0, 100.0] {
        let mut builder = Builder::default();
        let stuff = SaintVenantKirchhoff { youngs_modulus: 900.0, poisson_ratio: 0.0, density: 1.0 }.material().expect("in range");
        let strip = builder.body("strip", rectangle([10.0, 0.5], [20, 1], [0.0; 2]).expect("the mesh is sound"), &stuff);
        builder.fix(strip, "left", [true, false, false]);
        builder.fix(strip, "top", [false, true, false]);
        builder.fix(strip, "bottom", [false, true, false]);
        builder.load(strip, "right", LoadKind::Traction([load, 0.0, 0.0]), Constant(1.0));
        let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.05);
        settle(&mut sim);
        let fields = &sim.fields()[0];
        let tip = fields.mesh.points.iter().position(|point| point[0] == 10.0).expect("the strip ends there");
        let off = fields.displacement[tip][0] / (10.0 * elongation(load / 900.0)) - 1.0;
        // Coordinates of 10 are exact to 2e-15, strains of cells of 0.5 to 4e-15; the bar has 20 cells.
        assert!(off.abs() < BALANCE + 2e-14 / (load / 900.0), "{load:e}: {off:e}");
        expect_settled(&mut sim);
    }
}

/// A block at a height above a wider one with a fixed bottom.
fn drop_from(height: f64) -> (Simulation, SettleReport) {
    let rubber = NeoHookean { youngs_modulus: 1e4, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
    let mut builder = Builder::default();
    let base = builder.body("base", rectangle([3.0, 1.0], [15, 5], [-1.5, -1.0]).expect("the mesh is sound"), &rubber);
    let block = builder.body("block", rectangle([1.0, 1.0], [6, 6], [-0.5, height]).expect("the mesh is sound"), &rubber);
    builder.fix(base, "bottom", [true; 3]);
    builder.model.gravity = [0.0, -10.0, 0.0];
    builder.contact((block, "bottom"), (base, "top"));
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.005);
    let report = settle(&mut sim);
    (sim, report)
}

#[test]
fn a_body_comes_to_rest_from_any_height() {
    let (_, touching) = drop_from(0.0);
    for height in [0.0, 0.05, 2.0, 300.0] {
        let (mut sim, report) = drop_from(height);
        let force = sim.contact("contact").expect("there is one").force;
        assert!((force[1] / 10.0 - 1.0).abs() < BALANCE && force[0].abs() < 10.0 * BALANCE, "{height}: {force:?}");
        // The energy is quadratic in the remaining imbalance. For large heights coordinates have a round-off of 3e-14 of the height,
        // relative to strains of 1e-4.
        assert!((report.strain / touching.strain - 1.0).abs() < BALANCE + 1e-12 * height, "{height}: {:e}", report.strain);
        // Half a facet a step in the neighborhood of contact, half the distance before.
        assert!(report.steps <= 25, "{height}: {} steps", report.steps);
        expect_settled(&mut sim);
    }
}

/// Blocks of equal size over a rigid floor, with gaps of 0.01, each shifted sideways by a multiple of `offset`.
fn stack(count: usize, offset: f64, height: f64) -> Simulation {
    let rubber = NeoHookean { youngs_modulus: 1e4, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
    let mut builder = Builder::default();
    builder.model.gravity = [0.0, -10.0, 0.0];
    for k in 0..count {
        let corner = [-0.5 + offset * (k % 3) as f64, height + 0.5 * k as f64 + 0.01 * (k + 1) as f64];
        let mesh = rectangle([1.0, 0.5], [5 + k % 2, 3], corner).expect("the mesh is sound");
        let block = builder.body(&format!("block {k}"), mesh, &rubber);
        let bottom = builder.boundary(block, "bottom");
        if k == 0 {
            let plane = Obstacle::HalfPlane { point: [0.0; 2], normal: [0.0, 1.0] };
            builder.model.add_interaction(Interaction::obstacle("0", bottom, plane));
        } else {
            let top = builder.boundary(block - 1, "top");
            builder.model.add_interaction(Interaction::contact(&k.to_string(), bottom, top));
        }
    }
    builder.simulate(&ENERGY_MOMENTUM, 0.005)
}

#[test]
fn stacks_come_to_rest() {
    for (count, height) in [(10, 0.0), (20, 0.0), (3, 50.0)] {
        let mut sim = stack(count, 0.0, height);
        settle(&mut sim);
        for k in 0..count {
            let (force, weight) = (sim.contact(&k.to_string()).expect("there is one").force[1], 5.0 * (count - k) as f64);
            assert!((force / weight - 1.0).abs() < BALANCE, "{count}: {force} above, {weight} expected at {k}");
        }
        expect_settled(&mut sim);
        // At rest nothing moves in time: forces with an imbalance of 1e-10 move a block by 1e-14 in a step.
        let settled = sim.state().positions.clone();
        for _ in 0..5 {
            sim.step(None, &mut |_| ()).unwrap_or_else(|error| panic!("{error}"));
        }
        let moved = sim.state().positions.iter().zip(&settled).fold(0.0f64, |most, (new, old)| most.max((new - old).abs()));
        assert!(moved < 1e-11, "{count}: {moved:e}");
    }
}

/// Blocks without lateral support: the top of a block that is loaded off its center inclines.
#[test]
fn a_frictionless_stack_out_of_line_is_said_to_lack_guidance() {
    let mut sim = stack(10, 0.02, 0.0);
    let message = sim.settle().expect_err("there is no stable equilibrium");
    let (cause, hint) = (message.to_string(), message.hint());
    let report = sim.failure().expect("it is kept").explanation();
    assert!(report.contains("contact has no friction") && report.contains("body \"block"), "{report}");
    assert!(hint.contains("guide"), "{cause}: {hint}");
    // The state is that before.
    assert_eq!(sim.state().positions, stack(10, 0.02, 0.0).state().positions);
}

/// The shifted stack with lateral guidance.
#[test]
fn guidance_brings_a_stack_out_of_line_to_rest() {
    let rubber = NeoHookean { youngs_modulus: 1e4, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
    let mut builder = Builder::default();
    builder.model.gravity = [0.0, -10.0, 0.0];
    for k in 0..5 {
        let mesh = rectangle([1.0, 0.5], [5 + k % 2, 3], [0.02 * (k % 3) as f64, 0.51 * k as f64]).expect("the mesh is sound");
        let block = builder.body(&format!("block {k}"), mesh, &rubber);
        builder.fix(block, "left", [true, false, false]);
        if k == 0 {
            builder.fix(block, "bottom", [false, true, false]);
        } else {
            let (bottom, top) = (builder.boundary(block, "bottom"), builder.boundary(block - 1, "top"));
            builder.model.add_interaction(Interaction::contact(&k.to_string(), bottom, top));
        }
    }
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.005);
    settle(&mut sim);
    for k in 1..5 {
        let (force, weight) = (sim.contact(&k.to_string()).expect("there is one").force[1], 5.0 * (5 - k) as f64);
        assert!((force / weight - 1.0).abs() < BALANCE, "{force} above, {weight} expected at {k}");
    }
    expect_settled(&mut sim);
}

/// Steel in meters: round-off of the positions is 1e-7 of the weight at a node, but not in the sum of the forces on the block.
#[test]
fn round_off_at_nodes_does_not_hide_the_weight() {
    let steel = NeoHookean { youngs_modulus: 2.1e11, poisson_ratio: 0.3, density: 7800.0 }.material().expect("in range");
    let mut builder = Builder::default();
    let base = builder.body("base", rectangle([0.3, 0.1], [15, 5], [-0.15, -0.1]).expect("the mesh is sound"), &steel);
    let block = builder.body("block", rectangle([0.1, 0.1], [6, 6], [-0.05, 0.001]).expect("the mesh is sound"), &steel);
    builder.fix(base, "bottom", [true; 3]);
    builder.model.gravity = [0.0, -9.81, 0.0];
    builder.contact((block, "bottom"), (base, "top"));
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 1e-5);
    settle(&mut sim);
    let force = sim.contact("contact").expect("there is one").force[1];
    assert!((force / (0.01 * 7800.0 * 9.81) - 1.0).abs() < BALANCE, "{force}");
    expect_settled(&mut sim);
}

/// A press fit has contact forces and no load.
#[test]
fn a_press_fit_stays_settled() {
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material().expect("in range");
    let mut builder = Builder::default();
    let outer = builder.body("outer ring", ring(1.0, 1.5, [10, 48], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let inner = builder.body("inner ring", ring(0.5, 1.002, [10, 40], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    builder.fix(outer, "outer", [true; 3]);
    builder.contact((inner, "outer"), (outer, "inner"));
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.005);
    settle(&mut sim);
    let contact = sim.contact("contact").expect("there is one");
    // Only contact acts on the inner ring: its resultant over the sum of its forces.
    assert!(contact.force[0].hypot(contact.force[1]) < BALANCE * contact.normal_force, "{:?}", contact.force);
    expect_settled(&mut sim);
}
