//! The bearing over a grid of step sizes, torques, supports, refinements, methods and update rules, with bounds for each run.

// Test and example each use a part of this file.
#![allow(dead_code)]

use conserva::contact::{ContactMethod, METHODS};
use conserva::dynamics::{Hat, LedgerRow, LoadKind, Model, Options, Simulation, UPDATE_RULES, UpdateRule};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::NeoHookean;
use conserva::mesh::ring;

/// End of the torque.
pub const SPUN: f64 = 0.5;

/// Largest energy defect of a step and largest contact work of a step, over the energy.
pub const DEFECT: f64 = 1e-11;
pub const GIVEN: f64 = 1e-12;

/// Largest change of the energy after the torque, over the energy, under energy-conserving rules.
pub const DRIFT: f64 = 1e-9;

/// Largest penetration in facets: overlap of rotating polygons and of the press fit, and the bound of the rule.
pub const DEPTH: f64 = 0.1;

/// Largest mean number of Newton iterations per step.
pub const ITERATIONS: f64 = 4.5;

/// A bearing of the grid.
#[derive(Clone, Copy, Debug)]
pub struct Bearing {
    pub dt: f64,
    pub torque: f64,
    /// True if the outer ring is fixed, false if it is free.
    pub held: bool,
    /// Refinement: factor of all numbers of cells.
    pub refine: usize,
    pub method: &'static ContactMethod,
    pub rule: &'static UpdateRule,
}

/// Results of a run; energies over the largest total of the run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Error that ended the run.
    pub failed: Option<String>,
    pub steps: usize,
    pub iterations: f64,
    pub factorizations: f64,
    pub defect: f64,
    pub given: f64,
    pub taken: f64,
    /// Change of the energy since the first step that began without torque.
    pub drift: f64,
    pub depth: f64,
}

impl Bearing {
    /// Bearing with a number: step sizes of 0.002 to 0.02 and torques of 0.02 to 0.3 by a Sobol sequence, all other parameters cyclically.
    pub fn of(number: u32) -> Bearing {
        let between = |low: f64, high: f64, axis: u32| low + (high - low) * f64::from(sobol_burley::sample(number, axis, 0));
        let (method, rule) = (METHODS[number as usize % METHODS.len()], UPDATE_RULES[number as usize % UPDATE_RULES.len()]);
        Bearing { dt: between(0.002, 0.02, 0), torque: between(0.02, 0.3, 1), held: number.is_multiple_of(2), refine: 1, method, rule }
    }

    fn model(&self) -> Result<Model, Box<dyn std::error::Error>> {
        let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material()?;
        let mut model = Model::new("bearing");
        let mesh = |inner, outer, around: usize| ring(inner, outer, [10 * self.refine, around * self.refine], [0.0; 2], 0.0);
        let outer = model.add_body("outer ring", mesh(1.0, 1.5, 48)?, &steel);
        let inner = model.add_body("inner ring", mesh(0.5, 1.002, 40)?, &steel);
        if self.held {
            model.fix(model.boundary(outer, "outer")?, [true; 3]);
        }
        let contact = model.add_contact("race", model.boundary(inner, "outer")?, model.boundary(outer, "inner")?);
        (contact.method, contact.update) = (self.method, Some(self.rule));
        model.load(model.boundary(inner, "inner")?, LoadKind::Torque([0.0, 0.0, 1.0]), Hat { start: 0.0, end: SPUN, peak: self.torque });
        Ok(model)
    }

    /// Settles the bearing and runs it until a time.
    pub fn run(&self, until: f64) -> Outcome {
        let mut outcome = Outcome::default();
        if let Err(error) = self.take(until, &mut outcome) {
            outcome.failed = Some(error.to_string());
        }
        outcome
    }

    fn take(&self, until: f64, outcome: &mut Outcome) -> Result<(), Box<dyn std::error::Error>> {
        let mut sim = Simulation::new(&self.model()?, Options::new(&ENERGY_MOMENTUM, self.dt))?;
        sim.settle()?;
        let mut rows = vec![sim.row().clone()];
        let mut taken = Ok(());
        while taken.is_ok() && sim.time() < until - 1e-9 * self.dt {
            taken = sim.step(Some(until), &mut |row| rows.push(row.clone()));
        }
        outcome.judge(&rows, sim.contact("race").map_or(1.0, |_| std::f64::consts::TAU * 1.002 / (40 * self.refine) as f64));
        Ok(taken?)
    }
}

impl Outcome {
    fn judge(&mut self, rows: &[LedgerRow], facet: f64) {
        let scale = rows.iter().map(LedgerRow::total).fold(f64::MIN_POSITIVE, f64::max);
        let largest = |value: &dyn Fn(&LedgerRow) -> f64| rows[1..].iter().map(value).fold(0.0, f64::max);
        self.steps = rows.len() - 1;
        let mean = |count: &dyn Fn(&LedgerRow) -> usize| rows[1..].iter().map(count).sum::<usize>() as f64 / self.steps.max(1) as f64;
        self.iterations = mean(&|row| row.newton_iterations);
        self.factorizations = mean(&|row| row.factorizations);
        self.defect = largest(&|row| row.energy_defect.abs()) / scale;
        self.given = largest(&|row| row.contact_work) / scale;
        self.taken = -rows[1..].iter().map(|row| row.contact_work.min(0.0)).sum::<f64>() / scale;
        self.depth = largest(&|row| row.max_penetration) / facet;
        // A step that contains the end of the torque has torque.
        let free: Vec<f64> = rows.iter().filter(|row| row.time >= SPUN).map(LedgerRow::total).collect();
        self.drift = free.iter().map(|total| (total / free[0] - 1.0).abs()).fold(0.0, f64::max);
    }

    /// Violations of the bounds under a rule.
    pub fn faults(&self, rule: &UpdateRule) -> Vec<String> {
        let mut faults: Vec<String> = self.failed.iter().map(|error| format!("FAILED {error}")).collect();
        let mut judge = |name: &str, value: f64, limit: f64| {
            if value.is_nan() || value > limit {
                faults.push(format!("{name} {value:.1e}"));
            }
        };
        judge("DEFECT", self.defect, DEFECT);
        judge("GIVEN", self.given, GIVEN);
        judge("DEPTH", self.depth, DEPTH);
        if rule.keeps_energy {
            judge("DRIFT", self.drift, DRIFT);
        }
        faults
    }
}
