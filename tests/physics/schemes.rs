//! Time integrators, force elements and laws implemented outside of the crate, in `examples/`: history vectors at the start, in steps of
//! any size, after `settle` and in a state of another scheme; a dashpot and a mass in every scheme, a law at rest and in motion.
//!
//! Closed forms: the scalar recursion of Newmark's method (Hughes, The Finite Element Method, 1987, section 9.1), the damped oscillator.

use std::sync::Arc;

use conserva::dynamics::{
    Constant, Interaction, LoadKind, ModelError, Options, PartDefinition, Prescription, Simulation, TimeFunction, TimeFunctionError,
};
use conserva::integrators::{CATALOGUE, ConservedQuantities, Dissipation, ENERGY_MOMENTUM, NEWMARK, Scheme, TRAPEZOIDAL};
use conserva::materials::{Material, NeoHookean, Viscosity};
use conserva::mesh::rectangle;

use crate::common::{Builder, difference, run, worst};

// The example includes the oscillator of `newmark.rs`, as the dashpot does.
#[allow(dead_code, clippy::duplicate_mod)]
#[path = "../../examples/ballast.rs"]
mod ballast;
#[allow(dead_code)]
#[path = "../../examples/dashpot.rs"]
mod dashpot;
#[allow(dead_code)]
#[path = "../../examples/law.rs"]
mod law;
#[allow(dead_code)]
#[path = "../../examples/mullins.rs"]
mod mullins;

use dashpot::newmark::{self, AMPLITUDE, AVERAGE, DAMPED, STIFFNESS, oscillator};

/// Newmark's method with linear acceleration, a scheme of second order that uses the acceleration at the start; stable up to `omega dt` =
/// 3.46.
static LINEAR: Scheme = newmark::newmark("linear acceleration", 1.0 / 6.0, 0.5);

/// Oscillator of mass 1 by Newmark's method: displacement from the rest length, velocity, acceleration.
#[derive(Clone, Copy)]
struct Point {
    x: f64,
    v: f64,
    a: f64,
}

impl Point {
    fn at(x: f64, v: f64) -> Self {
        Point { x, v, a: -STIFFNESS * x }
    }

    fn step(&mut self, [beta, gamma]: [f64; 2], dt: f64) {
        let guess = self.x + dt * self.v + dt * dt * (0.5 - beta) * self.a;
        let a = -STIFFNESS * guess / (1.0 + beta * dt * dt * STIFFNESS);
        let v = self.v + dt * ((1.0 - gamma) * self.a + gamma * a);
        *self = Point { x: guess + beta * dt * dt * a, v, a };
    }
}

/// Oscillator of the example with an initial velocity, and its displacement.
fn thrown(scheme: &'static Scheme, speed: f64, dt: f64) -> Simulation {
    let mut model = oscillator().expect("the model is sound");
    model.set_initial_velocity(1, [speed, 0.0, 0.0], [0.0; 3]);
    Simulation::new(&model, Options::new(scheme, dt)).expect("the scheme is sound")
}

fn displacement(sim: &Simulation) -> f64 {
    sim.state().positions[8] - 3.0 + AMPLITUDE
}

/// The block deforms by `STIFFNESS / 1e8` of the motion, and vibrates at the node of the spring by a small multiple of that. A step with
/// another initial acceleration differs by 1e-3.
const SAME: f64 = 1e-4 * AMPLITUDE;

#[test]
fn newmark_follows_its_recursion_in_steps_of_any_size() {
    for (scheme, factors) in [(&AVERAGE, [0.25, 0.5]), (&DAMPED, [0.3025, 0.6]), (&NEWMARK, [0.3025, 0.6])] {
        let (mut sim, mut point) = (thrown(scheme, 0.3, 0.02), Point::at(AMPLITUDE, 0.3));
        for step in 0..60 {
            let dt = [0.02, 0.011, 0.035][step / 7 % 3];
            sim.set_steps(dt, sim.options().tolerance, 0);
            sim.step(None, &mut |_| ()).expect("the step converges");
            point.step(factors, sim.row().dt);
            assert!((sim.row().dt - dt).abs() < 1e-12 && (displacement(&sim) - point.x).abs() < SAME, "{} {step}", scheme.name);
        }
    }
}

/// In a linear problem average acceleration keeps the energy; numerical damping per period decreases with the step size.
#[test]
fn newmark_is_of_its_order_and_average_acceleration_keeps_the_energy_of_linear_problems() {
    for (scheme, steps) in [(&AVERAGE, 200), (&DAMPED, 800)] {
        let of = |steps| newmark::run(scheme, steps).unwrap_or_else(|error| panic!("{error}"));
        let ((coarse, _), (fine, [least, largest])) = (of(steps), of(2 * steps));
        let rate = (coarse / fine).log2();
        assert!((rate - scheme.promises.order as f64).abs() < 0.1, "{}: {coarse} {fine}", scheme.name);
        // The energy of the spring is quadratic in its elongation; that of the block is 1e-7 of it.
        assert_eq!(largest - least < 1e-10, scheme.promises.order == 2, "{}: {least} {largest}", scheme.name);
    }
}

#[test]
fn average_acceleration_is_the_trapezoidal_rule() {
    let [mut sim, mut other] = [&AVERAGE, &TRAPEZOIDAL].map(|scheme| thrown(scheme, 0.3, 0.02));
    run(&mut sim, 1.0);
    run(&mut other, 1.0);
    // The same numbers in another order.
    assert!(difference(&sim.state().positions, &other.state().positions) < 1e-12);
}

#[test]
fn states_go_on_and_those_of_others_are_taken_over() {
    let factors = [0.3025, 0.6];
    let (mut sim, mut point) = (thrown(&DAMPED, 0.3, 0.02), Point::at(AMPLITUDE, 0.3));
    let advance = |sim: &mut Simulation, point: &mut Point| {
        for _ in 0..10 {
            sim.step(None, &mut |_| ()).expect("the step converges");
            point.step(factors, 0.02);
            assert!((displacement(sim) - point.x).abs() < SAME, "{} {}", displacement(sim), point.x);
        }
    };
    advance(&mut sim, &mut point);
    let (kept, at) = (sim.state(), point);
    advance(&mut sim, &mut point);
    let (bytes, end) = (postcard::to_stdvec(&kept).expect("a state can be written"), sim.state());
    let mut other = thrown(&DAMPED, 0.3, 0.02);
    other.restore(&postcard::from_bytes(&bytes).expect("and read"));
    advance(&mut other, &mut { at });
    assert!(other.state() == end, "a state goes on to the same bytes");
    // A state of another scheme.
    let mut before = thrown(&ENERGY_MOMENTUM, 0.3, 0.02);
    run(&mut before, 0.1);
    let (x, v) = (displacement(&before), before.state().velocities[8]);
    sim.restore(&before.state());
    advance(&mut sim, &mut Point::at(x, v));
}

/// Prescribed displacement with an initial acceleration.
struct Sway;

impl TimeFunction for Sway {
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError> {
        Ok(0.05 * (1.0 - (9.0 * time).cos()))
    }
    fn rate(&self, time: f64) -> Result<f64, TimeFunctionError> {
        Ok(0.45 * (9.0 * time).sin())
    }
    fn describe(&self) -> String {
        "sway".into()
    }
}

/// A soft bar with a moving left end, gravity, and a load: accelerations are nonzero everywhere at the start.
fn shaken(is_tied: bool) -> Builder {
    let mut builder = Builder::default();
    let rubber = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
    let left = builder.body("left", rectangle([1.0, 0.5], [4, 2], [0.0; 2]).expect("the mesh is sound"), &rubber);
    let mut end = left;
    if is_tied {
        end = builder.body("right", rectangle([1.0, 0.5], [4, 3], [1.0, 0.0]).expect("the mesh is sound"), &rubber);
        let tie = Interaction::tie("seam", builder.boundary(end, "left"), builder.boundary(left, "right"));
        builder.model.add_interaction(tie);
    }
    builder.fix(left, "left", [false, true, false]);
    let on = builder.boundary(left, "left");
    builder.model.prescriptions.push(Prescription::along(on, 0, Arc::new(Sway)));
    builder.load(end, "right", LoadKind::Traction([0.0, 1.0, 0.0]), Constant(1.0));
    builder.model.gravity = [0.0, -2.0, 0.0];
    builder
}

#[test]
fn supports_that_move_ties_and_settle_keep_order_and_ledger() {
    for (is_tied, settles) in [(false, false), (true, false), (false, true)] {
        let end = |scheme: &'static Scheme, steps: usize| {
            let mut sim = shaken(is_tied).simulate(scheme, 0.1 / steps as f64);
            if settles {
                // With the same velocities but other history vectors forces differ, and with wrong ones the scheme would be of first order.
                run(&mut sim, 0.05);
                sim.settle().expect("there is an equilibrium");
            }
            let rows = run(&mut sim, 0.1);
            assert!(worst(&rows, |row| row.momentum_defect) < 1e-11, "{}: {:e}", scheme.name, worst(&rows, |row| row.momentum_defect));
            sim.state().positions
        };
        let reference = end(&ENERGY_MOMENTUM, 1280);
        // Constraints are infinitely stiff: linear acceleration is unstable with them.
        let all = [(&LINEAR, 80), (&AVERAGE, 80), (&TRAPEZOIDAL, 80), (&NEWMARK, 320)];
        for &(scheme, steps) in &all[usize::from(is_tied)..] {
            let errors = [1, 2].map(|finer| difference(&end(scheme, steps * finer), &reference));
            let rate = (errors[0] / errors[1]).log2();
            println!("tied {is_tied} settles {settles} {}: errors {errors:?}, order {rate:.3}", scheme.name);
            assert!((rate - scheme.promises.order as f64).abs() < 0.15, "tied {is_tied} settles {settles} {}: order {rate}", scheme.name);
        }
    }
}

/// Order of a scheme in a model dominated by springs and dampers, where numerical damping of body vibrations is negligible.
fn order_beside_bodies(scheme: &Scheme) -> f64 {
    if scheme.dissipation.is_none() { scheme.promises.order as f64 } else { 2.0 }
}

#[test]
fn a_dashpot_is_right_in_every_scheme() {
    for &scheme in CATALOGUE.iter().chain(&[&AVERAGE]).filter(|scheme| !scheme.goes_back()) {
        let of = |steps: usize| dashpot::run(scheme, steps).unwrap_or_else(|error| panic!("{error}"));
        let ([coarse, _], [fine, defect]) = (of(400), of(800));
        let rate = (coarse / fine).log2();
        assert!((rate - order_beside_bodies(scheme)).abs() < 0.1, "{}: {coarse} {fine}", scheme.name);
        assert_eq!(defect < 1e-11, scheme.promises.energy || scheme.name == "midpoint", "{}: {defect:e}", scheme.name);
    }
}

#[test]
fn a_mass_at_a_node_is_right_in_every_scheme() {
    for &scheme in CATALOGUE.iter().chain(&[&AVERAGE]) {
        let of = |steps: usize| ballast::run(scheme, steps).unwrap_or_else(|error| panic!("{error}"));
        // Steps whose errors are well above round-off.
        let steps = if scheme.promises.order > 2 { 50 } else { 400 };
        let rate = (of(steps) / of(2 * steps)).log2();
        assert!((rate - order_beside_bodies(scheme)).abs() < 0.1, "{}: {rate}", scheme.name);
    }
}

#[test]
fn a_law_is_right_at_rest_and_keeps_the_energy_in_motion() {
    for pressure in [0.01, 0.1, 1.0] {
        let [off, drift] = law::run(pressure).unwrap_or_else(|error| panic!("{error}"));
        assert!(off < 1e-9 && drift < 1e-11, "pressure {pressure}: {off:e} off, drift {drift:e}");
    }
    let material = Material::of_law("stiffening", law::Stiffening { lambda: 1.0, mu: 0.5, k: 40.0 }, 2.0).expect("it is stiff");
    assert!((material.youngs_modulus() - 4.0 / 3.0).abs() < 1e-12, "mu (3 lambda + 2 mu)/(lambda + mu)");
    assert_eq!(material.constants(), [("density", 2.0)]);
    assert!(material.rescaled(|_| Some(2.0)).is_err());
    assert!(Material::of_law("nothing", law::Stiffening { lambda: 0.0, mu: 0.0, k: 1.0 }, 1.0).is_err());
}

#[test]
fn a_law_with_history_is_right_at_rest_and_its_heat_is_booked() {
    let [off, defect, heat] = mullins::run().unwrap_or_else(|error| panic!("{error}"));
    assert!(off < 1e-9 && defect < 1e-12 && heat > 0.05, "{off:e} off, defect {defect:e}, heat {heat}");
}

/// Viscous stresses use the mean rate of the step: they lag by half a step in schemes that combine the forces at both ends.
#[test]
fn viscous_bodies_fade_in_every_scheme() {
    for &scheme in CATALOGUE.iter().filter(|scheme| !scheme.goes_back()) {
        let end = |scheme: &'static Scheme, steps: usize| {
            let mut builder = Builder::default();
            let viscosity = Viscosity { shear: 0.5, bulk: 0.2, branches: Vec::new() };
            let rubber = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
            let body =
                builder.body("bar", rectangle([1.0, 0.5], [4, 2], [0.0; 2]).expect("the mesh is sound"), &rubber.with_viscosity(viscosity));
            builder.fix(body, "left", [true, true, false]);
            builder.load(body, "right", LoadKind::Traction([1.0, 0.0, 0.0]), Constant(5.0));
            let mut sim = builder.simulate(scheme, 0.2 / steps as f64);
            run(&mut sim, 0.2);
            sim.state().positions
        };
        let reference = end(&ENERGY_MOMENTUM, 1280);
        let errors = [160, 320].map(|steps| difference(&end(scheme, steps), &reference));
        let rate = (errors[0] / errors[1]).log2();
        println!("viscous {}: errors {errors:?}, order {rate:.3}", scheme.name);
        // If the lag is hardly larger than the error of second order, with the opposite sign, the first rates are below 1.
        let least = if errors[0] < 2.5e-5 { 0.7 } else { 0.9 };
        assert!(rate > least, "{}: {rate}", scheme.name);
    }
}

#[test]
fn rows_that_are_no_scheme_are_refused() {
    let refused = |scheme: Scheme| {
        let options = Options::new(&scheme, 0.01);
        match Simulation::new(&oscillator().expect("the model is sound"), options) {
            Err(error @ ModelError::UnsoundIntegrator { .. }) => error.to_string(),
            _ => panic!("it is taken"),
        }
    };
    let mut slow = AVERAGE;
    slow.velocity.velocity = 0.0;
    assert!(refused(slow).contains("a steady motion changes its velocity"));
    let mut forgetful = AVERAGE;
    forgetful.remembers = &[];
    assert!(refused(forgetful).contains("forces are remembered exactly where"));
    let mut wrong = DAMPED;
    wrong.acceleration.acceleration = 0.0;
    assert!(refused(wrong).contains("constant acceleration"));
    let mut greedy = ENERGY_MOMENTUM;
    greedy.dissipation.velocity = 1.5;
    assert!(refused(greedy).contains("shares that dissipate"));
    let remembering = Scheme { dissipation: Dissipation::to_radius(0.5), ..AVERAGE };
    assert!(refused(remembering).contains("remember nothing"));
    assert_eq!(AVERAGE.promises, ConservedQuantities { energy: false, momentum: true, angular_momentum: false, order: 2 });
    for scheme in CATALOGUE {
        assert_eq!(scheme.check(), Ok(()), "{}", scheme.name);
    }
    let part: &dyn PartDefinition = &dashpot::Dashpot { ends: [(0, 1), (1, 0)], viscosity: 1.0, placed: Default::default() };
    assert_eq!(part.describe(), "dashpot: viscosity 1");
}
