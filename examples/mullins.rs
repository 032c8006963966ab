//! A law with history variables that this crate does not have, written beside it: rubber that softens where it has been stretched before
//! (Mullins 1948), in the form of a damage of the whole energy (Simo, Computer Methods in Applied Mechanics and Engineering 60, 1987).
//!
//! A column is pressed, let go and pressed again: the program prints how far its force is from the closed form on the three ways, and then
//! how far the energy of a body in motion is from what is stored and what became heat. `cargo run --release --example mullins`

use std::error::Error;

use conserva::dynamics::{LedgerRow, LoadKind, Model, Options, Simulation, Table};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::{Components, Heat, HistoryLaw, Material, Response, SAINT_VENANT_KIRCHHOFF, StrainStep, StressOf};
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
        let way = w_1 - w_0;
        let mean = (self.left(m) * (m - w_0) + self.work(m, w_1)) / way;
        // Half of g' where the quotient is round-off.
        let limit = -0.5 * (1.0 - self.rest) / self.scale * (-w_1 / self.scale).exp();
        [mean, if way > 1e-8 * w_1 { (self.left(w_1) - mean) / way } else { limit }]
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
