//! A material law implemented outside of the crate: its resistance to a change of volume grows with the change.
//!
//! A laterally constrained column is compressed; the program prints the difference of its height from the closed form, and after unloading
//! the change of the energy. `cargo example law`

use std::error::Error;

use conserva::dynamics::{LoadKind, Model, Options, Simulation, Table};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::{Law, Material};
use conserva::math::lanes::Real;
use conserva::math::tensor::Tensor;
use conserva::mesh::rectangle;

/// `W = lambda/2 (tr E)^2 + k/4 (tr E)^4 + mu E:E`.
#[derive(Clone)]
pub struct Stiffening {
    pub lambda: f64,
    pub mu: f64,
    pub k: f64,
}

impl Law for Stiffening {
    fn energy<T: Tensor>(&self, strain: &T) -> T::Scalar {
        let square = strain.trace() * strain.trace();
        square * (0.5 * self.lambda) + square * square * (0.25 * self.k) + strain.dot(strain) * self.mu
    }

    fn stress<T: Tensor>(&self, strain: &T) -> T {
        let trace = strain.trace();
        T::identity() * (trace * self.lambda + trace * trace * trace * self.k) + *strain * (2.0 * self.mu)
    }

    fn stress_tangent<T: Tensor>(&self, strain: &T) -> (T, T::Tangent) {
        let square = strain.trace() * strain.trace();
        let (bulk, shear) = (square * (3.0 * self.k) + self.lambda, T::Scalar::splat(2.0 * self.mu));
        (self.stress(strain), T::isotropic_tangent(bulk, shear, &T::identity()))
    }
}

/// Difference from the closed form under a pressure, and the energy drift after unloading over the energy at unloading.
pub fn run(pressure: f64) -> Result<[f64; 2], Box<dyn Error>> {
    let law = Stiffening { lambda: 1.0, mu: 0.5, k: 40.0 };
    let mut model = Model::new("column");
    let body = model.add_body("column", rectangle([1.0, 2.0], [2, 4], [0.0, 0.0])?, &Material::of_law("stiffening", law.clone(), 1.0)?);
    for side in ["left", "right"] {
        model.fix(model.boundary(body, side)?, [true, false, false]);
    }
    model.fix(model.boundary(body, "bottom")?, [false, true, false]);
    // The load vanishes at the middle of the first step.
    let let_go = Table::new(vec![(0.0, 1.0), (0.005, 0.0)]).ok_or("times grow")?;
    model.load(model.boundary(body, "top")?, LoadKind::Traction([0.0, -pressure, 0.0]), let_go);
    let mut sim = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, 0.02))?;
    sim.settle()?;
    // The force per undeformed area is the stretch times the second Piola-Kirchhoff stress, with E = (stretch^2 - 1)/2.
    let stretch = sim.state().positions[2 * 14 + 1] / 2.0;
    let strain = 0.5 * (stretch * stretch - 1.0);
    let force = stretch * ((law.lambda + 2.0 * law.mu) * strain + law.k * strain.powi(3));
    let (mut start, mut drift) = (None, 0.0f64);
    for _ in 0..200 {
        sim.step(None, &mut |row| {
            let energy = *start.get_or_insert(row.total());
            drift = drift.max((row.total() / energy - 1.0).abs());
        })?;
    }
    Ok([(force / -pressure - 1.0).abs(), drift])
}

fn main() -> Result<(), Box<dyn Error>> {
    for pressure in [0.01, 0.1, 1.0] {
        let [off, drift] = run(pressure)?;
        println!("pressure {pressure}: {off:.1e} off the closed form, energy drift of the free motion {drift:.1e}");
    }
    Ok(())
}
