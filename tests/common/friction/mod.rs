//! Random scripts with friction in space, judged by closed forms, conservation of energy and momenta, and the sign of friction work.

pub mod first_step;
pub mod rigid;
pub mod soft;
pub mod work;

use conserva::integrators::{self, ConservedQuantities};

use super::common::Random;

/// Largest defect of the ledger and of the momenta over their scales.
const DEFECT: f64 = 1e-11;

/// Largest positive friction work of a step over the energy scale.
const GAIN: f64 = 1e-12;

/// A figure that a script prints, with the closed form.
pub struct Expected {
    /// Name of the figure.
    pub name: &'static str,
    /// Value by the closed form.
    pub value: f64,
    /// Largest distance from the closed form.
    pub tolerance: f64,
}

/// A random script.
pub struct Case {
    /// Kind of scene, by which failures are counted.
    pub kind: String,
    /// Parameters of the scene in one line.
    pub name: String,
    /// The script, which ends with the figures of [`figures`].
    pub script: String,
    /// Closed forms.
    pub expected: Vec<Expected>,
}

impl Case {
    /// Deviations of the printed lines `figure NAME VALUE` from closed forms and laws of conservation: name, and amount over what is
    /// allowed.
    pub fn judge(&self, printed: &[String]) -> Vec<(String, f64)> {
        let figures: Vec<(&str, f64)> = printed
            .iter()
            .filter_map(|line| {
                let mut words = line.strip_prefix("figure ")?.split(' ');
                Some((words.next()?, words.next()?.parse().unwrap_or(f64::NAN)))
            })
            .collect();
        let mut ratios = Vec::new();
        for (name, value) in &figures {
            let allowed = match *name {
                "energy" | "momentum" | "angular_momentum" => DEFECT,
                "friction" => GAIN,
                _ => continue,
            };
            ratios.push((name.to_string(), value / allowed));
        }
        for Expected { name, value, tolerance } in &self.expected {
            let found = figures.iter().find(|(other, _)| other == name).map_or(f64::NAN, |(_, value)| *value);
            ratios.push((name.to_string(), (found - value).abs() / tolerance));
        }
        ratios
    }
}

/// Lines of a script that print the largest defects and the largest friction work of a simulation `sim` over their scales; `mass` is that
/// of all moving bodies.
pub fn figures(mass: f64) -> String {
    promised_figures(mass, &integrators::ENERGY_MOMENTUM.promises)
}

/// Lines of [`figures`] for the quantities that an integrator conserves: the defects of others are those of the integrator.
pub fn promised_figures(mass: f64, promises: &ConservedQuantities) -> String {
    let mut lines = String::from(
        "let h = sim.history;\n\
         let scale = 1e-300;\n\
         for k in 0..h.total.len() { scale = max([scale, h.kinetic[k] + h.strain[k] + abs(h.potential[k])]); }\n\
         print(`figure friction ${max(h.friction_work) / scale}`);\n",
    );
    if promises.energy {
        lines += "print(`figure energy ${max([max(h.energy_defect), -min(h.energy_defect)]) / scale}`);\n";
    }
    for (name, is_kept) in [("momentum", promises.momentum), ("angular_momentum", promises.angular_momentum)] {
        if is_kept {
            lines += &format!("print(`figure {name} ${{max(h.{name}_defect) / sqrt(2.0 * {mass} * scale)}}`);\n");
        }
    }
    lines
}

/// One of some values.
pub fn pick<T: Clone>(random: &mut Random, from: &[T]) -> T {
    from[(random.between(0.0, from.len() as f64) as usize).min(from.len() - 1)].clone()
}

/// A whole number from `low` to `high`.
pub fn whole(random: &mut Random, low: usize, high: usize) -> usize {
    (random.between(low as f64, high as f64 + 1.0) as usize).clamp(low, high)
}

/// A value between two, evenly in its logarithm.
pub fn scaled(random: &mut Random, low: f64, high: f64) -> f64 {
    random.between(low.ln(), high.ln()).exp()
}

/// Random numbers of a seed.
pub fn random_of(seed: u64) -> Random {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0xf71c);
    for _ in 0..4 {
        random.next();
    }
    random
}

/// Step size of a script, and the time that about a hundred steps take.
pub struct Pace {
    /// Text of `dt`.
    pub text: String,
    /// Time of the run.
    pub time: f64,
    /// Step size, 0 for steps that choose it.
    pub dt: f64,
}

/// Step size from 1e-4 to 1e-2, or steps that choose theirs.
pub fn pace(random: &mut Random, longest: f64) -> Pace {
    if random.next() > 0.5 {
        return Pace { text: "auto(#{ first: 1e-3 })".into(), time: longest, dt: 0.0 };
    }
    let dt = scaled(random, 1e-4, 1e-2);
    Pace { text: format!("{dt:.4e}"), time: longest.min(60.0 * dt), dt }
}
