//! A force element with a mass, implemented outside of the crate: ballast at a corner of the block of `newmark.rs`, which vibrates on a
//! spring. Prints the largest difference from the closed form, and its order. `cargo example ballast`

use std::error::Error;
use std::f64::consts::TAU;
use std::sync::Arc;

use conserva::dynamics::{Change, Iterate, Numbering, Options, Part, PartDefinition, Pose, Refusal, Simulation, Sums};
use conserva::integrators::{CATALOGUE, Scheme};
use conserva::linear::Pattern;

#[allow(dead_code)]
#[path = "newmark.rs"]
pub mod newmark;
use newmark::{AMPLITUDE, STIFFNESS, oscillator};

/// A mass at a node of a body.
#[derive(Clone)]
pub struct Ballast {
    pub body: usize,
    /// Node of the body's mesh; after placing, in the numbering of the model.
    pub node: u32,
    pub mass: f64,
}

impl PartDefinition for Ballast {
    fn name(&self) -> &str {
        "ballast"
    }
    fn bodies(&self) -> Vec<usize> {
        vec![self.body]
    }
    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        Box::new(Ballast { node: numbering.first[self.body] as u32 + self.node, ..self.clone() })
    }
    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let [mass, length, _] = change.units;
        // In the plane the mass is per thickness.
        Arc::new(Ballast { mass: self.mass * mass / if change.is_plane { length } else { 1.0 }, ..self.clone() })
    }
    fn describe(&self) -> String {
        format!("ballast: mass {}", self.mass)
    }
}

impl Part for Ballast {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&[self.node]);
    }
    fn place(&mut self, _pattern: &Pattern) {}
    fn linearize(&self, _at: &Iterate, _memory: &[f64], _sums: &mut Sums) -> Result<(), Refusal> {
        Ok(())
    }
    fn energy(&self, _at: Pose, _memory: &[f64]) -> f64 {
        0.0
    }
    fn point_masses(&self) -> Vec<(u32, f64)> {
        vec![(self.node, self.mass)]
    }
}

/// Largest distance from the closed form over two periods, in amplitudes.
pub fn run(scheme: &'static Scheme, steps: usize) -> Result<f64, Box<dyn Error>> {
    let mass = 3.0;
    let mut model = oscillator()?;
    model.parts.push(Arc::new(Ballast { body: 1, node: 0, mass }));
    // The block has the mass 1.
    let omega = (STIFFNESS / (1.0 + mass)).sqrt();
    let mut sim = Simulation::new(&model, Options::new(scheme, 2.0 * TAU / omega / steps as f64))?;
    let mut error = 0.0f64;
    for _ in 0..steps {
        sim.step(None, &mut |_| ())?;
        let moved = (sim.state().positions[8] - 3.0) / AMPLITUDE;
        error = error.max((moved - (omega * sim.time()).cos() + 1.0).abs());
    }
    Ok(error)
}

fn main() -> Result<(), Box<dyn Error>> {
    for &scheme in CATALOGUE {
        let (coarse, fine) = (run(scheme, 200)?, run(scheme, 400)?);
        println!("{}: {fine:.2e} off, order {:.3} of {}", scheme.name, (coarse / fine).log2(), scheme.promises.order);
    }
    Ok(())
}
