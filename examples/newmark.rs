//! A time integrator implemented outside of the crate: Newmark's method with any `beta` and `gamma`.
//!
//! A block on a spring vibrates after an initial displacement. The program prints the largest difference from the closed form, its order in
//! the step size, and the change of the energy. `cargo example newmark`

use std::error::Error;
use std::f64::consts::TAU;
use std::sync::Arc;

use conserva::dynamics::{End, Model, Options, Simulation, SpringDefinition, SpringElement, SpringLaw};
use conserva::integrators::{
    ConservedQuantities, Derivative, Dissipation, History, LagWeights, LeadingError, Parameters, Scheme, StepKind, UpdateCoefficients,
};
use conserva::materials::NeoHookean;
use conserva::mesh::rectangle;

/// `q_1 = q_0 + dt v_0 + dt^2 ((1/2 - beta) a_0 + beta a_1)`, `v_1 = v_0 + dt ((1 - gamma) a_0 + gamma a_1)`, solved for `v_1` and `a_1`.
pub const fn newmark(name: &'static str, beta: f64, gamma: f64) -> Scheme {
    Scheme {
        name,
        summary: "Newmark's method",
        derivative: Derivative::AT_END,
        remembers: &[History::Acceleration, History::Force],
        velocity: UpdateCoefficients { moved: gamma / beta, velocity: 1.0 - gamma / beta, acceleration: 1.0 - 0.5 * gamma / beta },
        acceleration: UpdateCoefficients { moved: 1.0 / beta, velocity: -1.0 / beta, acceleration: 1.0 - 0.5 / beta },
        // `M a = -f` at both ends, so that forces have the weights of the accelerations.
        weight: gamma,
        lag: LagWeights::once(gamma),
        step: StepKind::Whole,
        dissipation: Dissipation::NONE,
        averages_stress: false,
        parameters: Parameters::NONE,
        promises: ConservedQuantities { energy: false, momentum: true, angular_momentum: false, order: if gamma == 0.5 { 2 } else { 1 } },
        // Error of the average acceleration; for `gamma` > 1/2 the term of first order precedes it.
        error: LeadingError { first: 0.5 * (gamma - 0.5), second: 1.0 / 12.0 },
    }
}

/// Second order, without damping: equivalent to the trapezoidal rule.
pub static AVERAGE: Scheme = newmark("average acceleration", 0.25, 0.5);
/// First order; fast vibrations decay.
pub static DAMPED: Scheme = newmark("damped", 0.3025, 0.6);

/// Stiffness of the spring, and its initial elongation.
pub const STIFFNESS: f64 = 20.0;
pub const AMPLITUDE: f64 = 0.1;
const PERIODS: f64 = 3.0;

/// A block of mass 1 on an elongated spring.
pub fn oscillator() -> Result<Model, Box<dyn Error>> {
    // The block deforms by STIFFNESS / modulus of the motion.
    let steel = NeoHookean { youngs_modulus: 1e8, poisson_ratio: 0.3, density: 1.0 }.material()?;
    let mut model = Model::new("oscillator");
    for (name, x, components) in [("wall", 0.0, [true, true, false]), ("block", 3.0, [false, true, false])] {
        let mesh = rectangle([1.0, 1.0], [1, 1], [x, 0.0])?;
        let body = model.add_body(name, mesh, &steel);
        for side in ["left", "right"] {
            model.fix(model.boundary(body, side)?, components);
        }
    }
    // From the right end of the wall's lower edge to the left end of that of the block.
    let ends = [(0, 1), (1, 0)];
    let (ends, law) = (ends.map(End::from), SpringLaw::linear(STIFFNESS));
    model.parts.push(Arc::new(SpringDefinition {
        name: "spring".into(),
        ends,
        element: SpringElement { law, rest_length: Some(2.0 - AMPLITUDE) },
    }));
    Ok(model)
}

/// Largest difference from the closed form in amplitudes, and the smallest and largest energy over the initial one.
pub fn run(scheme: &'static Scheme, steps: usize) -> Result<(f64, [f64; 2]), Box<dyn Error>> {
    let omega = STIFFNESS.sqrt();
    let mut sim = Simulation::new(&oscillator()?, Options::new(scheme, PERIODS * TAU / omega / steps as f64))?;
    let energy = sim.row().total();
    let (mut error, mut range) = (0.0f64, [energy; 2]);
    for _ in 0..steps {
        sim.step(None, &mut |row| range = [range[0].min(row.total()), range[1].max(row.total())])?;
        let moved = (sim.state().positions[8] - 3.0) / AMPLITUDE;
        error = error.max((moved - (omega * sim.time()).cos() + 1.0).abs());
    }
    Ok((error, range.map(|value| value / energy)))
}

fn main() -> Result<(), Box<dyn Error>> {
    for scheme in [&AVERAGE, &DAMPED] {
        println!("{}, of order {}:", scheme.name, scheme.promises.order);
        let mut before = None;
        for steps in [100, 200, 400, 800] {
            let (error, [least, largest]) = run(scheme, steps)?;
            let rate = before.map_or(String::new(), |before: f64| format!(", order {:.3}", (before / error).log2()));
            println!("  {steps:>4} steps: {error:.2e} off{rate}, energy {least:.12} to {largest:.12} of that at the start");
            before = Some(error);
        }
    }
    Ok(())
}
