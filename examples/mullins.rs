//! A law with history variables implemented outside of the crate: rubber that softens where it has been strained before (Mullins 1948), as
//! a damage of the whole energy (Simo, Computer Methods in Applied Mechanics and Engineering 60, 1987).
//!
//! Prints the difference of the pressure of a column from the closed form under loading, unloading and further loading, and the defect of
//! the balance of stored energy and heat of a column in motion. `cargo example mullins`

use conserva::dynamics::{LoadKind, Model, Options, Simulation, Table};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::{CATALOGUE, Components, Heat, HistoryLaw, Material, PointHistory, Response, StrainStep, StressOf};
use conserva::math::lanes::{Lanes, WIDTH};
use conserva::mesh::rectangle;
use std::array::from_fn;
use std::error::Error;

/// `psi = g(m) w(E)` with `w = lambda/2 (tr E)^2 + mu E:E`, its largest value `m` so far, and `g = rest + (1 - rest) exp(-m/scale)`.
#[derive(Clone)]
pub struct Mullins {
    pub lambda: f64,
    pub mu: f64,
    pub rest: f64,
    pub scale: f64,
}

impl Mullins {
    fn stress<const S: usize>(&self, strain: &[f64; S]) -> [f64; S] {
        let pressure = self.lambda * (strain[0] + strain[1] + strain[2]);
        from_fn(|k| 2.0 * self.mu * strain[k] + if k < 3 { pressure } else { 0.0 })
    }
    fn energy<const S: usize>(&self, strain: &[f64; S]) -> f64 {
        0.5 * self.stress(strain).iter().zip(strain).map(|(stress, strain)| stress * strain).sum::<f64>()
    }

    fn left(&self, m: f64) -> f64 {
        self.rest + (1.0 - self.rest) * (-m / self.scale).exp()
    }
    /// Integral of `g` between two values.
    fn work(&self, from: f64, to: f64) -> f64 {
        let share = -(-(to - from) / self.scale).exp_m1() * (-from / self.scale).exp();
        self.rest * (to - from) + (1.0 - self.rest) * self.scale * share
    }

    /// `-int g' m dm`, the heat up to a largest energy `m` `[energy/volume]`.
    fn heat(&self, m: f64) -> f64 {
        self.work(0.0, m) - self.left(m) * m
    }

    /// Stress of a step, or at its end, and its derivative with respect to the strain at the end.
    fn respond<const S: usize>(&self, [start, end]: [&[f64; S]; 2], m: f64, of_step: bool) -> ([f64; S], [[f64; S]; S]) {
        let (w_1, last) = (self.energy(end), self.stress(end));
        // For a quadratic energy the work of the mean stress equals the change of the energy.
        let (stress, share) = if of_step { (self.stress(&from_fn(|k| 0.5 * (start[k] + end[k]))), 0.5) } else { (last, 1.0) };
        // Mean of `g` over the change of `w`, and its derivative with respect to `w_1`.
        let [factor, slope] = if w_1 <= m {
            [self.left(m), 0.0]
        } else if of_step {
            let w_0 = self.energy(start);
            let mean = (self.left(m) * (m - w_0) + self.work(m, w_1)) / (w_1 - w_0);
            [mean, (self.left(w_1) - mean) / (w_1 - w_0)]
        } else {
            [self.left(w_1), (self.rest - 1.0) / self.scale * (-w_1 / self.scale).exp()]
        };
        let stiffness: [[f64; S]; S] = from_fn(|l| self.stress(&from_fn(|k| f64::from(u8::from(k == l)))));
        let tangent = from_fn(|k| from_fn(|l| factor * share * stiffness[l][k] + slope * stress[k] * last[l]));
        (stress.map(|component| factor * component), tangent)
    }
}

fn lane_of<const S: usize>(components: &Components<S>, lane: usize) -> [f64; S] {
    components.map(|component| component.0[lane])
}

impl<const S: usize> HistoryLaw<S> for Mullins {
    fn variables(&self) -> usize {
        1
    }

    fn responses_into(&self, step: &StrainStep<S>, responses: &mut [Response<S>]) {
        // Half of the derivative with respect to the strain in the middle.
        let (ends, weight) = if step.stress == StressOf::Middle { (step.middle, 0.5) } else { (step.end, 1.0) };
        for (point, response) in responses.iter_mut().enumerate() {
            for lane in 0..WIDTH {
                let strains = [&lane_of(&step.start[point], lane), &lane_of(&ends[point], lane)];
                let (stress, tangent) = self.respond(strains, step.history[point].0[lane], step.stress == StressOf::Step);
                (0..S).for_each(|k| response.stress[k].0[lane] = stress[k]);
                (0..S * S).for_each(|k| response.tangent[k / S][k % S].0[lane] = weight * tangent[k / S][k % S]);
            }
        }
    }

    fn advance_into(&self, step: &StrainStep<S>, after: &mut [Lanes<false>], heat: &mut [Heat]) {
        for (point, (after, heat)) in after.iter_mut().zip(heat).enumerate() {
            let m = step.history[point].0;
            after.0 = from_fn(|lane| m[lane].max(self.energy(&lane_of(&step.end[point], lane))));
            heat.plastic.0 = from_fn(|lane| self.heat(after.0[lane]) - self.heat(m[lane]));
        }
    }

    fn energies_into(&self, strain: &[Components<S>], history: &[Lanes<false>], energies: &mut [Lanes<false>]) {
        for (point, energy) in energies.iter_mut().enumerate() {
            energy.0 = from_fn(|lane| self.left(history[point].0[lane]) * self.energy(&lane_of(&strain[point], lane)));
        }
    }

    fn stresses_into(&self, strain: &[Components<S>], history: &[Lanes<false>], stresses: &mut [Components<S>]) {
        for (point, stress) in stresses.iter_mut().enumerate() {
            let own: [[f64; S]; WIDTH] = from_fn(|lane| self.stress(&lane_of(&strain[point], lane)));
            *stress = from_fn(|k| Lanes(from_fn(|lane| self.left(history[point].0[lane]) * own[lane][k])));
        }
    }

    fn shown(&self, history: &[Lanes<false>], lane: usize) -> Option<PointHistory> {
        Some(PointHistory { heat: self.heat(history[0].0[lane]), ..PointHistory::default() })
    }
}

/// Largest difference of the pressure from the closed form over the pressure; for the following motion the largest energy defect of a step
/// and the heat, over the initial energy.
pub fn run() -> Result<[f64; 3], Box<dyn Error>> {
    let law = Mullins { lambda: 1.0, mu: 0.5, rest: 0.3, scale: 0.02 };
    let row = CATALOGUE.iter().find(|row| row.name == "saint_venant_kirchhoff").ok_or("it is gone")?;
    let material = Material::of_history_law("mullins", Material::new(row, &[4.0 / 3.0, 1.0 / 3.0, 1.0])?, law.clone());
    let mut model = Model::new("column");
    let body = model.add_body("column", rectangle([1.0, 1.0], [2, 2], [0.0, 0.0])?, &material);
    for (side, held) in [("left", 0), ("right", 0), ("bottom", 1)] {
        model.fix(model.boundary(body, side)?, from_fn(|i| i == held));
    }
    let pressures = [(0.0, 0.0), (1.0, 0.06), (2.0, 0.03), (3.0, 0.08), (3.01, 0.1)];
    model.load(model.boundary(body, "top")?, LoadKind::Traction([0.0, -1.0, 0.0]), Table::new(pressures.to_vec()).ok_or("times grow")?);
    let mut sim = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, 0.02))?;
    let (mut off, mut m, mut defect) = (0.0f64, 0.0f64, 0.0f64);
    for &(time, pressure) in &pressures[1..4] {
        sim.settle_at(time)?;
        let stretch = sim.state().positions[2 * 8 + 1];
        let strain = [0.0, 0.5 * (stretch * stretch - 1.0), 0.0, 0.0];
        m = m.max(law.energy(&strain));
        off = off.max((law.left(m) * stretch * law.stress(&strain)[1] / -pressure - 1.0).abs());
    }
    let start = sim.row().clone();
    for _ in 0..200 {
        sim.step(None, &mut |row| defect = defect.max(row.energy_defect.abs() / start.total()))?;
    }
    Ok([off, defect, (sim.row().plastic_work[0] - start.plastic_work[0]) / start.total()])
}

fn main() -> Result<(), Box<dyn Error>> {
    let [off, defect, heat] = run()?;
    println!("pressure {off:.1e} off the closed form; energy of a step closes to {defect:.1e}, {:.1} % became heat", 100.0 * heat);
    Ok(())
}
