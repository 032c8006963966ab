//! Robustness of the contact iteration: seeded random collisions of two free rings, half of them one inside the other, with a secondary
//! mesh finer or coarser than the primary. Prints the fraction of halved nominal steps, Newton iterations, and the largest defects of the
//! ledger and of the momenta.
//!
//! The set is that of the project's experiments on the contact iteration: speeds 2 to 40, spins -30 to 30, steps 0.001, 0.002 and 0.005, 60
//! steps. Their recommended algorithm halved no step with 3.6 iterations; with three times the step size (a stress test with an approach of
//! up to one and a half facets a step) 3.8 iterations in 40 steps.
//!
//! `cargo example collisions -- [number of collisions] [factor of the step] [gap | persistency | velocity | penalty] [a
//! contact method, such as mortar] [augmented]`

use std::error::Error;

use conserva::contact::{ContactMethod, METHODS};
use conserva::dynamics::{Enforcement, GAP, Model, Options, Simulation, UPDATE_RULES};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::NeoHookean;
use conserva::mesh::{Mesh, ring};

/// Reproducible random numbers (Knuth's linear congruence, the upper bits).
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.between(0.0, values.len() as f64) as usize]
    }
}

/// A collision: two rings with a small clearance, moving towards each other.
fn collision(number: usize, rule: &str, method: &'static ContactMethod, augmented: bool) -> Result<(Model, f64), Box<dyn Error>> {
    let random = &mut Random(1000 + 7919 * number as u64);
    random.between(0.0, 1.0);
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material()?;
    let inside = number.is_multiple_of(2);
    let direction = random.between(0.0, std::f64::consts::TAU);
    let speed = random.between(2.0, 40.0);
    let spins = [random.between(-30.0, 30.0), random.between(-30.0, 30.0)];
    let cells = random.one_of(&[[24, 32], [28, 36], [32, 40], [20, 28]]);
    let cells = if random.between(0.0, 1.0) < 0.5 { cells } else { [cells[1], cells[0]] };
    let (angles, clearance) = ([random.between(0.0, 1.0), random.between(0.0, 1.0)], random.between(0.01, 0.05));
    let (first, second): (Mesh, Mesh) = if inside {
        let inner = ring(0.5, 1.0 - clearance, [3, cells[0]], [0.0; 2], angles[0])?;
        (inner, ring(1.0, 1.5, [3, cells[1]], [0.0; 2], angles[1])?)
    } else {
        let across = random.between(-0.8, 0.8);
        let distance = ((2.0 + clearance) * (2.0 + clearance) - across * across).sqrt();
        let (s, c) = direction.sin_cos();
        let center = [distance * c - across * s, distance * s + across * c];
        (ring(0.5, 1.0, [3, cells[0]], [0.0; 2], angles[0])?, ring(0.5, 1.0, [3, cells[1]], center, angles[1])?)
    };
    let mut model = Model::new("collision");
    let (first, second) = (model.add_body("first", first, &steel), model.add_body("second", second, &steel));
    let (update, enforcement) = match rule {
        "penalty" => (&GAP, Enforcement::Penalty { factor: 1.0 }),
        name => (*UPDATE_RULES.iter().find(|rule| rule.name == name).ok_or("no such rule")?, Enforcement::Multiplier),
    };
    let enforcement = if augmented { Enforcement::AugmentedLagrange { factor: 100.0 } } else { enforcement };
    let facing = model.boundary(second, if inside { "inner" } else { "outer" })?;
    let contact = model.add_contact("collision", model.boundary(first, "outer")?, facing);
    (contact.method, contact.update, contact.enforcement) = (method, Some(update), enforcement);
    let (s, c) = direction.sin_cos();
    for (body, share, spin) in [(first, 0.7 * speed, spins[0]), (second, -0.3 * speed, spins[1])] {
        model.set_initial_velocity(body, [share * c, share * s, 0.0], [0.0, 0.0, spin]);
    }
    Ok((model, random.one_of(&[0.001, 0.002, 0.005])))
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |index: usize, default: f64| arguments.get(index).map_or(Ok(default), |text| text.parse::<f64>());
    let (count, factor) = (number(0, 200.0)? as usize, number(1, 1.0)?);
    let rule = arguments.get(2).map_or("gap", String::as_str);
    let name = arguments.get(3).map_or("mortar", String::as_str);
    let method = *METHODS.iter().find(|method| method.name == name).ok_or("no such method")?;
    let augmented = arguments.get(4).is_some_and(|word| word == "augmented");
    let steps = if factor > 1.0 { 40 } else { 60 };

    let (mut nominal, mut halved, mut pieces, mut iterations, mut most, mut active, mut lost) = (0, 0, 0, 0, 0, 0, 0);
    let (mut ledger, mut momentum, mut angular, mut penetration) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for k in 0..count {
        let (model, dt) = collision(k, rule, method, augmented)?;
        let mut sim = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, factor * dt))?;
        let energy = sim.row().total();
        // Scale of momenta: the masses of the bodies at the speed of the energy, with an arm of one.
        let size = (2.0 * energy * 1e-3 * 5.0).sqrt();
        let (mut worst, mut touched, mut report) = (0.0f64, 0, String::new());
        for step in 0..steps {
            let mut halvings = 0;
            let outcome = sim.step(None, &mut |row| {
                halvings += row.halvings;
                pieces += 1;
                iterations += row.newton_iterations;
                most = most.max(row.newton_iterations);
                worst = worst.max(row.energy_defect.abs() / energy);
                momentum = momentum.max(row.momentum_defect / size);
                angular = angular.max(row.angular_momentum_defect / size);
                penetration = penetration.max(row.max_penetration);
                touched += usize::from(row.active > 0);
            });
            nominal += 1;
            if halvings > 0 {
                halved += 1;
                report = format!("{report}  step {step}: {halvings} halvings");
            }
            if let Err(error) = outcome {
                lost += 1;
                report = format!("{report}  LOST: {error}");
                break;
            }
        }
        active += touched;
        ledger = ledger.max(worst);
        if !report.is_empty() || worst > 1e-10 {
            println!("collision {k} (dt {}): touching in {touched} steps, worst ledger defect {worst:.1e}{report}", factor * dt);
        }
    }
    let enforced = if augmented { ", augmented Lagrange" } else { "" };
    println!("{count} collisions with `{rule}`, {name}{enforced}, {factor} times the step");
    println!("{nominal} nominal steps, {active} accepted ones in contact");
    println!("halved {halved} ({:.2} %), lost runs {lost}", 100.0 * halved as f64 / nominal as f64);
    println!("iterations {:.2} in the mean, {most} at most", iterations as f64 / pieces as f64);
    println!("worst defects of a step: energy {ledger:.1e}, momentum {momentum:.1e}, angular momentum {angular:.1e} (relative)");
    println!("largest penetration {penetration:.1e}");
    Ok(())
}
