//! Common helpers of the kernel tests: short model building, runs with their ledger, reproducible random numbers.

// Each test program uses a part of this file.
#![allow(dead_code)]

use conserva::dynamics::{BodyBoundary, LedgerRow, LoadKind, Model, Options, Simulation, TimeFunction};
use conserva::integrators::Scheme;
use conserva::materials::{CATALOGUE, Material};
use conserva::mesh::Mesh;

/// A material of the catalogue by the name of its law: Young's modulus, Poisson's ratio, density.
pub fn material(name: &str, values: [f64; 3]) -> Material {
    let row = CATALOGUE.iter().find(|row| row.name == name).expect("the catalogue has it");
    Material::new(row, &values).expect("the constants are in their ranges")
}

/// Builder of a model whose bodies and boundaries exist: methods of [`Model`] that panic on errors.
#[derive(Default)]
pub struct Builder {
    /// The model so far.
    pub model: Model,
}

impl Builder {
    /// Adds a body; returns its number.
    pub fn body(&mut self, name: &str, mesh: Mesh, material: &Material) -> usize {
        self.model.add_body(name, mesh, material)
    }

    /// A boundary of a body.
    pub fn boundary(&self, body: usize, name: &str) -> BodyBoundary {
        self.model.boundary(body, name).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Fixes components of a boundary.
    pub fn fix(&mut self, body: usize, name: &str, components: [bool; 3]) {
        let on = self.boundary(body, name);
        self.model.fix(on, components);
    }

    /// Adds a load on a boundary.
    pub fn load(&mut self, body: usize, name: &str, kind: LoadKind, amplitude: impl TimeFunction + 'static) {
        let on = self.boundary(body, name);
        self.model.load(on, kind, amplitude);
    }

    /// Adds mortar contact with the default update rule.
    pub fn contact(&mut self, secondary: (usize, &str), primary: (usize, &str)) {
        let (secondary, primary) = (self.boundary(secondary.0, secondary.1), self.boundary(primary.0, primary.1));
        self.model.add_contact("contact", secondary, primary);
    }

    /// Sets the initial velocity of a body.
    pub fn set_initial_velocity(&mut self, body: usize, linear: [f64; 3], angular: [f64; 3]) {
        self.model.set_initial_velocity(body, linear, angular);
    }

    /// The simulation of the model.
    pub fn simulate(&self, integrator: &'static Scheme, dt: f64) -> Simulation {
        Simulation::new(&self.model, Options::new(integrator, dt)).expect("the model is sound")
    }
}

/// Runs to a time; returns the ledger of the initial state and of every accepted step.
pub fn run(sim: &mut Simulation, until: f64) -> Vec<LedgerRow> {
    let mut rows = vec![sim.row().clone()];
    while sim.time() < until - 1e-9 * sim.options().dt {
        sim.step(Some(until), &mut |row| rows.push(row.clone())).unwrap_or_else(|error| panic!("{error}"));
    }
    rows
}

/// Largest value that a quantity takes in the steps of a run (the first row, the initial state, left out).
pub fn worst(rows: &[LedgerRow], quantity: impl Fn(&LedgerRow) -> f64) -> f64 {
    rows[1..].iter().map(|row| quantity(row).abs()).fold(0.0, |largest, x| if x.is_nan() { x } else { largest.max(x) })
}

/// Largest difference of a vector's components from those of the initial state.
pub fn drift(rows: &[LedgerRow], vector: impl Fn(&LedgerRow) -> [f64; 3]) -> f64 {
    let first = vector(&rows[0]);
    rows.iter().map(|row| difference(&vector(row), &first)).fold(0.0, f64::max)
}

/// Largest difference of two vectors' components.
pub fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, |largest, x| if x.is_nan() { x } else { largest.max(x) })
}

/// Reproducible random numbers (Knuth's linear congruential generator, upper bits).
pub struct Random(pub u64);

impl Random {
    /// Random number between -1 and 1.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Random number between two bounds.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * 0.5 * (self.next() + 1.0)
    }
}
