//! A force element implemented outside of the crate: a dashpot, whose energy becomes heat with every time integrator. Prints the difference
//! of a block on a spring and a dashpot from the closed form, and the ledger defect including the heat.
//! `cargo example dashpot`

use std::error::Error;
use std::sync::Arc;

use conserva::dynamics::{
    Change, Iterate, Numbering, Options, Part, PartDefinition, PartStepResult, Pose, Refusal, Simulation, StepError, Sums,
};
use conserva::integrators::{CATALOGUE, Scheme};
use conserva::linear::{Block, Pattern};

#[allow(dead_code)]
#[path = "newmark.rs"]
pub mod newmark;
use newmark::{AMPLITUDE, STIFFNESS, oscillator};

/// Dashpot between two nodes of a plane model, with a force opposite to their relative velocity.
#[derive(Clone)]
pub struct Dashpot {
    /// Body and node of its mesh, for both ends.
    pub ends: [(usize, u32); 2],
    pub viscosity: f64,
    /// Nodes in the numbering of the model, and their blocks in the matrix.
    pub placed: ([u32; 2], [Block; 4]),
}

impl PartDefinition for Dashpot {
    fn name(&self) -> &str {
        "dashpot"
    }
    fn bodies(&self) -> Vec<usize> {
        self.ends.map(|(body, _)| body).to_vec()
    }
    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        let nodes = self.ends.map(|(body, node)| numbering.first[body] as u32 + node);
        Box::new(Dashpot { placed: (nodes, Default::default()), ..self.clone() })
    }
    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let [mass, length, time] = change.units;
        Arc::new(Dashpot { viscosity: self.viscosity * mass / (time * length), ..self.clone() })
    }
    fn describe(&self) -> String {
        format!("dashpot: viscosity {}", self.viscosity)
    }
}

impl Part for Dashpot {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&self.placed.0);
    }
    fn place(&mut self, pattern: &Pattern) {
        self.placed.1 = [0, 1, 2, 3].map(|k| pattern.block(self.placed.0[k / 2], self.placed.0[k % 2]));
    }
    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let ([a, b], weighted) = (self.placed.0.map(|node| 2 * node as usize), at.weight * self.viscosity);
        for i in 0..2 {
            let force = weighted * (at.velocity[b + i] - at.velocity[a + i]);
            sums.internal[a + i] -= force;
            sums.internal[b + i] += force;
        }
        let Some(values) = sums.tangent.as_deref_mut() else { return Ok(()) };
        for (block, sign) in self.placed.1.iter().zip([1.0, -1.0, -1.0, 1.0]) {
            (0..2).for_each(|i| values[block.at(i, i)] += sign * weighted * at.velocity_slope);
        }
        Ok(())
    }
    fn energy(&self, _at: Pose, _memory: &[f64]) -> f64 {
        0.0
    }
    fn after_step(&self, at: &Iterate, _memory: &[f64]) -> Result<PartStepResult, StepError> {
        let [a, b] = self.placed.0.map(|node| 2 * node as usize);
        let power = (0..2).map(|i| self.viscosity * (at.velocity[b + i] - at.velocity[a + i]).powi(2)).sum::<f64>();
        Ok(PartStepResult { dissipated: at.dt * power, ..PartStepResult::default() })
    }
}

/// Difference from the closed form over the initial motion, and the largest defect of the ledger over the initial energy.
pub fn run(scheme: &'static Scheme, steps: usize) -> Result<[f64; 2], Box<dyn Error>> {
    let (viscosity, speed, end) = (1.0, 0.3, 2.0);
    let mut model = oscillator()?;
    model.set_initial_velocity(1, [speed, 0.0, 0.0], [0.0; 3]);
    model.parts.push(Arc::new(Dashpot { ends: [(0, 1), (1, 0)], viscosity, placed: Default::default() }));
    let mut sim = Simulation::new(&model, Options::new(scheme, end / steps as f64))?;
    let (energy, mut defect) = (sim.row().total(), 0.0f64);
    (0..steps).try_for_each(|_| sim.step(None, &mut |row| defect = defect.max(row.energy_defect.abs())))?;
    // The mass is 1: x'' + 2 delta x' + (omega^2 + delta^2) x = 0.
    let (delta, omega) = (0.5 * viscosity, f64::sqrt(STIFFNESS - 0.25 * viscosity * viscosity));
    let sine = (speed + delta * AMPLITUDE) / omega;
    let expected = (-delta * end).exp() * (AMPLITUDE * (omega * end).cos() + sine * (omega * end).sin());
    Ok([(sim.state().positions[8] - 3.0 + AMPLITUDE - expected).abs() / AMPLITUDE, defect / energy])
}

fn main() -> Result<(), Box<dyn Error>> {
    for &scheme in CATALOGUE {
        let ([coarse, _], [fine, defect]) = (run(scheme, 200)?, run(scheme, 400)?);
        println!("{}: {fine:.2e} off, order {:.3}, defect of energy {defect:.1e}", scheme.name, (coarse / fine).log2());
    }
    Ok(())
}
