//! Force laws of one variable: springs by elongation, dampers by speed.
//!
//! Over a step a spring exerts the mean force `F = (V(x_1) - V(x_0)) / (x_1 - x_0)`, whose work equals the change of the potential. For a
//! linear law and a table it is an integral without cancellation. For a text it is the quotient, or Gauss quadrature of the slope, without
//! cancellation, where both agree within the quotient's round-off.

use std::sync::Arc;

use crate::materials::{Jet, ScalarText};

/// Four Gauss points on `[0, 1]` with their weights (Abramowitz and Stegun 1964, table 25.4).
const GAUSS: [[f64; 2]; 4] = [
    [0.069_431_844_202_973_71, 0.173_927_422_568_726_93],
    [0.330_009_478_207_571_87, 0.326_072_577_431_273_07],
    [0.669_990_521_792_428_1, 0.326_072_577_431_273_07],
    [0.930_568_155_797_026_3, 0.173_927_422_568_726_93],
];

/// Elastic force as a function of the elongation.
#[derive(Clone, Debug, PartialEq)]
pub enum Elastic {
    /// `F = k x`, with the stiffness `k` `[force/length]`.
    Linear(f64),
    /// Table of increasing elongations and forces, at least two points: linear between the points, extrapolated beyond them.
    Table(Arc<Vec<(f64, f64)>>),
    /// Stored energy as text, and the factors that convert its variable and its value to the units of the model.
    Energy(Arc<ScalarText>, [f64; 2]),
}

/// Elongations at which a spring acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Force at all elongations.
    Both,
    /// Force at positive elongations only: a cable, a belt.
    Tension,
    /// Force at negative elongations only: a stop.
    Compression,
}

/// Force law of a spring.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringLaw {
    /// Elastic force as a function of the elongation.
    pub elastic: Elastic,
    /// Elongations at which the spring acts.
    pub sides: Sides,
}

impl SpringLaw {
    /// Linear spring in tension and compression with the stiffness `stiffness` `[force/length]`.
    pub fn linear(stiffness: f64) -> Self {
        SpringLaw { elastic: Elastic::Linear(stiffness), sides: Sides::Both }
    }

    /// Stiffness of a linear spring in tension and compression; `None` for other laws.
    pub(crate) fn constant_stiffness(&self) -> Option<f64> {
        match (&self.elastic, self.sides) {
            (Elastic::Linear(stiffness), Sides::Both) => Some(*stiffness),
            _ => None,
        }
    }

    /// Law in other units, with the conversion factors of length, force and stiffness.
    pub fn changed(&self, [length, force, stiffness]: [f64; 3]) -> Self {
        let elastic = match &self.elastic {
            Elastic::Linear(k) => Elastic::Linear(k * stiffness),
            Elastic::Table(points) => Elastic::Table(Arc::new(points.iter().map(|(x, f)| (x * length, f * force)).collect())),
            Elastic::Energy(text, [x, energy]) => Elastic::Energy(text.clone(), [x * length, energy * length * force]),
        };
        SpringLaw { elastic, sides: self.sides }
    }

    /// Effective elongation of a spring, 0 on an inactive side (tension or compression), and its derivative.
    fn effective(&self, x: f64) -> (f64, f64) {
        let is_active = match self.sides {
            Sides::Both => true,
            Sides::Tension => x > 0.0,
            Sides::Compression => x < 0.0,
        };
        if is_active { (x, 1.0) } else { (0.0, 0.0) }
    }

    /// Stored energy at an elongation `[energy]`; 0 at zero elongation.
    pub fn energy(&self, x: f64) -> f64 {
        let x = self.effective(x).0;
        match &self.elastic {
            Elastic::Linear(k) => 0.5 * k * x.powi(2),
            Elastic::Table(points) => integral(points, 0.0, x),
            Elastic::Energy(text, units) => jet(text, units, x).value - jet(text, units, 0.0).value,
        }
    }

    /// Force at an elongation `[force]`, and its slope `[force/length]`.
    pub fn force(&self, x: f64) -> (f64, f64) {
        let (x, is_active) = self.effective(x);
        if is_active == 0.0 {
            return (0.0, 0.0);
        }
        match &self.elastic {
            Elastic::Linear(k) => (k * x, *k),
            Elastic::Table(points) => on(points, x),
            Elastic::Energy(text, units) => {
                let Jet { slope, curvature, .. } = jet(text, units, x);
                (slope, curvature)
            }
        }
    }

    /// Mean force between two elongations, and its derivative with respect to the second one.
    pub fn mean(&self, x_0: f64, x_1: f64) -> (f64, f64) {
        let ((c_0, in_0), (c_1, in_1)) = (self.effective(x_0), self.effective(x_1));
        if in_0 == 0.0 && in_1 == 0.0 {
            return (0.0, 0.0);
        }
        let (force, slope) = self.mean_of_active(c_0, c_1);
        if in_0 == in_1 {
            return (force, slope);
        }
        // The spring acts at one of both elongations only; the force vanishes at the other end of the path.
        let change = x_1 - x_0;
        let mean = force * (c_1 - c_0) / change;
        (mean, (self.force(x_1).0 - mean) / change)
    }

    fn mean_of_active(&self, x_0: f64, x_1: f64) -> (f64, f64) {
        let change = x_1 - x_0;
        match &self.elastic {
            Elastic::Linear(k) => (0.5 * k * (x_0 + x_1), 0.5 * k),
            Elastic::Table(points) => {
                let (force, slope) = on(points, x_1);
                if change == 0.0 || segment(points, x_0) == segment(points, x_1) {
                    return (0.5 * (on(points, x_0).0 + force), 0.5 * slope);
                }
                let mean = integral(points, x_0, x_1) / change;
                (mean, (force - mean) / change)
            }
            Elastic::Energy(text, units) => {
                let (mut mean, mut slope) = (0.0, 0.0);
                for [s, weight] in GAUSS {
                    let at = jet(text, units, x_0 + s * change);
                    mean += weight * at.slope;
                    slope += weight * s * at.curvature;
                }
                let [start, end] = [x_0, x_1].map(|x| jet(text, units, x));
                let quotient = (end.value - start.value) / change;
                let noise = 4.0 * f64::EPSILON * (end.value.abs() + start.value.abs()) / change.abs();
                if change == 0.0 || (quotient - mean).abs() <= noise {
                    return (mean, slope);
                }
                (quotient, (end.slope - quotient) / change)
            }
        }
    }

    /// Text of the law, such as `stiffness 3`.
    pub fn describe(&self) -> String {
        let law = match &self.elastic {
            Elastic::Linear(k) => format!("stiffness {k}"),
            Elastic::Table(points) => format!("a table of {} forces", points.len()),
            Elastic::Energy(text, _) => format!("energy `{}`", text.text()),
        };
        match self.sides {
            Sides::Both => law,
            Sides::Tension => format!("{law} in tension"),
            Sides::Compression => format!("{law} in compression"),
        }
    }
}

/// Value and derivatives of a text with factors of its variable and its value.
fn jet(text: &ScalarText, [of_x, of_value]: &[f64; 2], x: f64) -> Jet {
    let Jet { value, slope, curvature } = text.at(x / of_x);
    let slope_factor = of_value / of_x;
    Jet { value: of_value * value, slope: slope_factor * slope, curvature: slope_factor / of_x * curvature }
}

/// Index of the table segment that contains `x`; the first and the last one are unbounded.
fn segment(points: &[(f64, f64)], x: f64) -> usize {
    points[1..points.len() - 1].partition_point(|point| point.0 <= x)
}

/// Value and slope of a table.
fn on(points: &[(f64, f64)], x: f64) -> (f64, f64) {
    let k = segment(points, x);
    let ((x_0, f_0), (x_1, f_1)) = (points[k], points[k + 1]);
    let slope = (f_1 - f_0) / (x_1 - x_0);
    (f_0 + slope * (x - x_0), slope)
}

/// Integral of a table from `a` to `b`.
fn integral(points: &[(f64, f64)], a: f64, b: f64) -> f64 {
    if b < a {
        return -integral(points, b, a);
    }
    let (mut sum, mut x) = (0.0, a);
    for k in segment(points, a)..=segment(points, b) {
        let end = if k == segment(points, b) { b } else { points[k + 1].0 };
        let ((x_0, f_0), (x_1, f_1)) = (points[k], points[k + 1]);
        let at_middle = f_0 + (f_1 - f_0) / (x_1 - x_0) * (0.5 * (x + end) - x_0);
        sum += at_middle * (end - x);
        x = end;
    }
    sum
}

/// Damping force as a function of the speed.
#[derive(Clone, Debug, PartialEq)]
pub enum Viscous {
    /// `F = c v`, with `c` `[force time/length]`.
    Linear(f64),
    /// `F = c v (v^2 + s^2)^((p - 1)/2)`, which is `c |v|^p` for speeds above `s`.
    Power {
        /// Coefficient `c` `[force (time/length)^p]`.
        coefficient: f64,
        /// Exponent `p`.
        exponent: f64,
        /// Smoothing speed `s` `[length/time]`.
        smoothing: f64,
    },
    /// Force as text, and the factors that convert its speed and its value to the units of the model.
    Force(Arc<ScalarText>, [f64; 2]),
}

/// Decades of speed at which a text is sampled.
const DECADES: std::ops::RangeInclusive<i32> = -6..=6;

impl Viscous {
    /// Law in other units, with the conversion factors of speed and force.
    pub fn changed(&self, [speed, force]: [f64; 2]) -> Self {
        match self {
            Viscous::Linear(c) => Viscous::Linear(c * force / speed),
            Viscous::Power { coefficient, exponent, smoothing } => Viscous::Power {
                coefficient: coefficient * force / speed.powf(*exponent),
                exponent: *exponent,
                smoothing: smoothing * speed,
            },
            Viscous::Force(text, [v, f]) => Viscous::Force(text.clone(), [v * speed, f * force]),
        }
    }

    /// Force against a speed `[force]`, and its slope.
    pub fn force(&self, v: f64) -> (f64, f64) {
        match self {
            Viscous::Linear(c) => (c * v, *c),
            Viscous::Power { coefficient, exponent, smoothing } => {
                let square = v * v + smoothing * smoothing;
                if square == 0.0 {
                    return (0.0, if *exponent > 1.0 { 0.0 } else { *coefficient });
                }
                let size = coefficient * square.powf(0.5 * (exponent - 1.0));
                (size * v, size * (1.0 + (exponent - 1.0) * v * v / square))
            }
            Viscous::Force(text, units) => {
                let Jet { value, slope, .. } = jet(text, units, v);
                (value, slope)
            }
        }
    }

    /// Speed at which the law is undefined or drives instead of damping, among samples over many decades in both directions.
    pub fn drives_at(&self) -> Option<f64> {
        let speeds = DECADES.flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(decade)));
        let is_wrong = |v: &f64| {
            let against = self.force(*v).0 * v.signum();
            against.is_nan() || against < 0.0
        };
        if self.force(0.0).0 != 0.0 {
            return Some(0.0);
        }
        speeds.flat_map(|v| [v, -v]).find(is_wrong)
    }

    /// Text of the law, such as `coefficient 3`.
    pub fn describe(&self) -> String {
        match self {
            Viscous::Linear(c) => format!("coefficient {c}"),
            Viscous::Power { coefficient, exponent, .. } => format!("coefficient {coefficient}, exponent {exponent}"),
            Viscous::Force(text, _) => format!("force `{}`", text.text()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laws() -> Vec<SpringLaw> {
        let text = ScalarText::new("2*x^2 + x^4 + 0.3*sin(x)", "x", &[], "the energy").unwrap();
        let table = vec![(-1.0, -2.0), (-0.2, -0.5), (0.3, 0.6), (1.0, 4.0)];
        let elastic = [Elastic::Linear(3.0), Elastic::Table(Arc::new(table)), Elastic::Energy(Arc::new(text), [1.0, 1.0])];
        let sides = [Sides::Both, Sides::Tension, Sides::Compression];
        elastic.iter().flat_map(|elastic| sides.map(|sides| SpringLaw { elastic: elastic.clone(), sides })).collect()
    }

    #[test]
    fn the_mean_force_does_the_work_of_the_potential_and_its_slope_is_its_derivative() {
        for law in laws() {
            for (x_0, x_1) in [(0.4, 0.9), (-0.8, 1.7), (1.3, -2.0), (0.1, 0.1 + 1e-9), (-0.5, -0.5), (-0.6, -0.61)] {
                let (mean, slope) = law.mean(x_0, x_1);
                let work = law.energy(x_1) - law.energy(x_0);
                assert!((mean * (x_1 - x_0) - work).abs() < 4e-15, "{law:?} {x_0} {x_1}: {}", mean * (x_1 - x_0) - work);
                let h = 1e-6;
                let difference = (law.mean(x_0, x_1 + h).0 - law.mean(x_0, x_1 - h).0) / (2.0 * h);
                // Near equal elongations the difference quotient is round-off.
                assert!((difference - slope).abs() < 1e-5, "{law:?} {x_0} {x_1}: {difference} {slope}");
            }
            let moved = law.changed([10.0, 5.0, 0.5]);
            assert!((moved.energy(7.0) - 50.0 * law.energy(0.7)).abs() < 1e-13);
        }
    }

    #[test]
    fn dampers_never_drive_or_say_where() {
        let of = |text: &str| Viscous::Force(Arc::new(ScalarText::new(text, "v", &[], "the force").unwrap()), [1.0, 1.0]);
        assert_eq!(of("3*v + v^3").drives_at(), None);
        assert_eq!(of("3*v + 1").drives_at(), Some(0.0));
        assert!(of("v - v^3").drives_at().is_some_and(|v| v.abs() >= 1.0));
        let law = Viscous::Power { coefficient: 2.0, exponent: 0.3, smoothing: 1e-3 };
        assert!((law.force(4.0).0 - 2.0 * 4f64.powf(0.3)).abs() < 1e-6 && law.drives_at().is_none());
        let (h, v) = (1e-7, 0.002);
        assert!(((law.force(v + h).0 - law.force(v - h).0) / (2.0 * h) - law.force(v).1).abs() < 1e-4);
    }
}
