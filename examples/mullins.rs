//! A law with history variables that this crate does not have, written beside it: rubber that softens where it has been stretched before
//! (Mullins 1948), in the form of a damage of the whole energy (Simo, Computer Methods in Applied Mechanics and Engineering 60, 1987).
//!
//! A column is pressed, let go and pressed again: the program prints how far its pressure is from the closed form, and how far the energy
//! of a column in motion is from what is stored and what became heat. `cargo run --release --example mullins`

use std::error::Error;

use conserva::dynamics::{LoadKind, Model, Options, Simulation, Table};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::{Components, Heat, HistoryLaw, Material, Response, SaintVenantKirchhoff, StrainStep, StressOf};
use conserva::math::lanes::{Lanes, WIDTH};
use conserva::mesh::rectangle;

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
        std::array::from_fn(|k| 2.0 * self.mu * strain[k] + if k < 3 { pressure } else { 0.0 })
    }

    fn energy<const S: usize>(&self, strain: &[f64; S]) -> f64 {
        0.5 * self.stress(strain).iter().zip(strain).map(|(stress, strain)| stress * strain).sum::<f64>()
    }

    pub fn left(&self, m: f64) -> f64 {
        self.rest + (1.0 - self.rest) * (-m / self.scale).exp()
    }

    /// Integral of `g` between two values.
    fn work(&self, from: f64, to: f64) -> f64 {
        let share = -(-(to - from) / self.scale).exp_m1() * (-from / self.scale).exp();
        self.rest * (to - from) + (1.0 - self.rest) * self.scale * share
    }

    /// `-int g' m dm`, the heat on the way to a largest energy `m` [energy/volume].
    pub fn heat(&self, m: f64) -> f64 {
        self.work(0.0, m) - self.left(m) * m
    }

    /// Mean of `g` over a step in which `w` goes from `w_0` to `w_1`, and its derivative with respect to `w_1`.
    fn mean(&self, w_0: f64, w_1: f64, m: f64) -> [f64; 2] {
        if w_1 <= m {
            return [self.left(m), 0.0];
        }
        let mean = (self.left(m) * (m - w_0) + self.work(m, w_1)) / (w_1 - w_0);
        [mean, (self.left(w_1) - mean) / (w_1 - w_0)]
    }

    /// Stress of a step and its derivative with respect to the strain at which it is wanted.
    fn respond<const S: usize>(&self, [start, end]: [&[f64; S]; 2], m: f64, of_step: bool) -> ([f64; S], [[f64; S]; S]) {
        let (mean, last) = (std::array::from_fn(|k| 0.5 * (start[k] + end[k])), self.stress(end));
        let (w_0, w_1) = (self.energy(start), self.energy(end));
        let steep = if w_1 > m { -(1.0 - self.rest) / self.scale * (-w_1 / self.scale).exp() } else { 0.0 };
        // The work of the mean stress of the quadratic energy is its change.
        let (stress, share, [factor, slope]) =
            if of_step { (self.stress(&mean), 0.5, self.mean(w_0, w_1, m)) } else { (last, 1.0, [self.left(w_1.max(m)), steep]) };
        let bulk = |k: usize, l: usize| if k < 3 && l < 3 { self.lambda } else { 0.0 };
        let entry = |k: usize, l: usize| {
            factor * share * (bulk(k, l) + if k == l { 2.0 * self.mu } else { 0.0 }) + slope * stress[k] * last[l]
        };
        (stress.map(|component| factor * component), std::array::from_fn(|k| std::array::from_fn(|l| entry(k, l))))
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
        let of_middle = step.stress == StressOf::Middle;
        for (point, response) in responses.iter_mut().enumerate() {
            let end = if of_middle { &step.middle[point] } else { &step.end[point] };
            for lane in 0..WIDTH {
                let ends = [&lane_of(&step.start[point], lane), &lane_of(end, lane)];
                let (stress, tangent) = self.respond(ends, step.history_of(point, 1)[0].0[lane], step.stress == StressOf::Step);
                for k in 0..S {
                    response.stress[k].0[lane] = stress[k];
                    (0..S).for_each(|l| response.tangent[k][l].0[lane] = if of_middle { 0.5 } else { 1.0 } * tangent[k][l]);
                }
            }
        }
    }

    fn advance_into(&self, step: &StrainStep<S>, after: &mut [Lanes<false>], heat: &mut [Heat]) {
        for point in 0..after.len() {
            for lane in 0..WIDTH {
                let m = step.history[point].0[lane];
                after[point].0[lane] = m.max(self.energy(&lane_of(&step.end[point], lane)));
                heat[point].plastic.0[lane] = self.heat(after[point].0[lane]) - self.heat(m);
            }
        }
    }

    fn energies_into(&self, strain: &[Components<S>], history: &[Lanes<false>], energies: &mut [Lanes<false>]) {
        for (point, energy) in energies.iter_mut().enumerate() {
            energy.0 = std::array::from_fn(|lane| self.left(history[point].0[lane]) * self.energy(&lane_of(&strain[point], lane)));
        }
    }

    fn stresses_into(&self, strain: &[Components<S>], history: &[Lanes<false>], stresses: &mut [Components<S>]) {
        for (point, stress) in stresses.iter_mut().enumerate() {
            for lane in 0..WIDTH {
                let own = self.stress(&lane_of(&strain[point], lane));
                (0..S).for_each(|k| stress[k].0[lane] = self.left(history[point].0[lane]) * own[k]);
            }
        }
    }
}

fn column(law: &Mullins) -> Result<(Model, usize), Box<dyn Error>> {
    let elastic = Material::of_law("elastic", SaintVenantKirchhoff { lambda: law.lambda, mu: law.mu }, 1.0)?;
    let mut model = Model::new("column");
    let mesh = rectangle([1.0, 1.0], [2, 2], [0.0, 0.0])?;
    let body = model.add_body("column", mesh, &Material::of_history_law("mullins", elastic, law.clone()));
    for (side, held) in [("left", 0), ("right", 0), ("bottom", 1)] {
        model.fix(model.boundary(body, side)?, std::array::from_fn(|i| i == held));
    }
    Ok((model, body))
}

/// Largest distance of the pressure from the closed form on the ways down, up and farther down, over the pressure; then of a column that is
/// thrown the largest defect of the energy in a step, and the heat, over its energy.
pub fn run() -> Result<[f64; 3], Box<dyn Error>> {
    let law = Mullins { lambda: 1.0, mu: 0.5, rest: 0.3, scale: 0.02 };
    let (mut model, body) = column(&law)?;
    let pressures = [0.06, 0.03, 0.06, 0.08];
    let times = pressures.iter().enumerate().map(|(k, pressure)| (k as f64 + 1.0, *pressure));
    let load = Table::new(std::iter::once((0.0, 0.0)).chain(times).collect()).ok_or("times grow")?;
    model.load(model.boundary(body, "top")?, LoadKind::Traction([0.0, -1.0, 0.0]), load);
    let mut sim = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, 0.02))?;
    let (mut off, mut m) = (0.0f64, 0.0f64);
    for (k, pressure) in pressures.into_iter().enumerate() {
        sim.settle_at(k as f64 + 1.0)?;
        let stretch = sim.state().positions[2 * 8 + 1];
        let strain = [0.0, 0.5 * (stretch * stretch - 1.0), 0.0, 0.0];
        m = m.max(law.energy(&strain));
        off = off.max((law.left(m) * stretch * law.stress(&strain)[1] / -pressure - 1.0).abs());
    }
    let (mut thrown, body) = column(&law)?;
    thrown.set_initial_velocity(body, [0.0, -0.2, 0.0], [0.0; 3]);
    let mut sim = Simulation::new(&thrown, Options::new(&ENERGY_MOMENTUM, 0.02))?;
    let (energy, mut defect) = (sim.row().total(), 0.0f64);
    for _ in 0..200 {
        sim.step(None, &mut |row| defect = defect.max(row.energy_defect.abs() / energy))?;
    }
    Ok([off, defect, sim.row().plastic_work[0] / energy])
}

fn main() -> Result<(), Box<dyn Error>> {
    let [off, defect, heat] = run()?;
    println!("pressure {off:.1e} off the closed form; energy of a step closes to {defect:.1e}, {:.1} % became heat", 100.0 * heat);
    Ok(())
}
