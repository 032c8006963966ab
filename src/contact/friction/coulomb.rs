//! Coulomb's friction law with static friction, adhesion, maximum shear stress and a viscous film.

use std::sync::Arc;

use super::law::{FrictionLaw, Limit, SlipState};

/// Largest shear stress `L`, and film stress:
/// ```text
/// L = min(mu(v) p + min(adhesion(v), 10 p), most),    and a film of shear stress min(viscosity v, 10 p)
/// mu(v) = mu (1 + (static_ratio - 1) exp(-(v/transition_speed)^exponent)),    adhesion(v) = adhesion exp(-(v/transition_speed)^exponent)
/// ```
///
/// with the pressure `p`, the slip speed `v` and the kinetic coefficient `mu`. `mu` alone is Coulomb's law, `static_ratio` with `exponent`
/// 2 and a viscosity the Stribeck curve. `most` is the maximum shear stress of the material (Shaw, Orowan).
#[derive(Clone, Debug, PartialEq)]
pub struct Coulomb {
    /// Static over kinetic friction coefficient, at least 1.
    pub static_ratio: f64,
    /// Speed of the transition from static to kinetic friction `[length/time]`; infinite: static at every speed.
    pub transition_speed: f64,
    /// Exponent of the transition, 1 or 2.
    pub exponent: f64,
    /// Shear strength at zero pressure and zero speed, while in contact `[stress]`.
    pub adhesion: f64,
    /// Maximum shear stress of dry friction `[stress]`.
    pub most: f64,
    /// Film shear stress per slip speed `[stress time/length]`.
    pub viscosity: f64,
}

impl Default for Coulomb {
    fn default() -> Self {
        Coulomb { static_ratio: 1.0, transition_speed: f64::INFINITY, exponent: 1.0, adhesion: 0.0, most: f64::INFINITY, viscosity: 0.0 }
    }
}

impl FrictionLaw for Coulomb {
    fn depends_on_speed(&self) -> bool {
        self.transition_speed.is_finite()
    }

    fn limit(&self, SlipState { coefficient, pressure, speed }: SlipState) -> Limit {
        let (rest, by_speed) = if self.transition_speed.is_finite() {
            let ratio = speed / self.transition_speed;
            let rest = (-ratio.powf(self.exponent)).exp();
            (rest, -rest * self.exponent * ratio.powf(self.exponent - 1.0) / self.transition_speed)
        } else {
            (1.0, 0.0)
        };
        let over = self.static_ratio - 1.0;
        let mu = coefficient * (1.0 + over * rest);
        // With a shear stress that remains at zero pressure there would be no equilibrium at a node that opens.
        let (adhesion, bound) = (self.adhesion * rest, ROUGH * pressure);
        let is_bound = adhesion > bound;
        // At zero pressure a node comes into contact: its pressure will likely be beyond that of the bound.
        let of_bound = if is_bound && pressure > 0.0 { ROUGH } else { 0.0 };
        let dry = mu * pressure + adhesion.min(bound);
        if dry >= self.most {
            return Limit { shear: self.most, ..Limit::default() };
        }
        Limit {
            shear: dry,
            by_pressure: mu + of_bound,
            by_speed: (coefficient * over * pressure + if is_bound { 0.0 } else { self.adhesion }) * by_speed,
        }
    }

    fn impulse_ratio(&self, at: SlipState) -> f64 {
        Coulomb { adhesion: 0.0, ..self.clone() }.limit(at).shear / at.pressure
    }

    fn film(&self) -> f64 {
        self.viscosity
    }

    fn in_units(&self, stress: f64, speed: f64) -> Arc<dyn FrictionLaw> {
        Arc::new(Coulomb {
            transition_speed: speed * self.transition_speed,
            adhesion: stress * self.adhesion,
            most: stress * self.most,
            viscosity: stress / speed * self.viscosity,
            ..*self
        })
    }
}

/// Largest ratio of shear stress to pressure, also the coefficient of rough surfaces. Without this bound a finite shear stress would vanish
/// at once when a node opens, and the step would have no solution.
pub const ROUGH: f64 = 10.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_have_exact_derivatives_and_no_units() {
        let law = Coulomb { static_ratio: 1.5, transition_speed: 0.3, exponent: 2.0, adhesion: 0.4, most: 9.0, viscosity: 0.2 };
        let at = |pressure: f64, speed: f64| law.limit(SlipState { coefficient: 0.5, pressure, speed });
        for (pressure, speed) in [(2.0, 0.2), (0.01, 0.1), (50.0, 0.1)] {
            let (found, h) = (at(pressure, speed), 1e-6);
            let slope = |a: Limit, b: Limit| (a.shear - b.shear) / (2.0 * h);
            assert!((slope(at(pressure + h, speed), at(pressure - h, speed)) - found.by_pressure).abs() < 1e-8);
            assert!((slope(at(pressure, speed + h), at(pressure, speed - h)) - found.by_speed).abs() < 1e-8);
            let other = law.in_units(3.0, 7.0).limit(SlipState { coefficient: 0.5, pressure: 3.0 * pressure, speed: 7.0 * speed });
            assert!((other.shear - 3.0 * found.shear).abs() < 1e-13 * other.shear);
        }
        assert_eq!((at(50.0, 0.1).shear, law.film(), law.in_units(3.0, 7.0).film()), (9.0, 0.2, 3.0 / 7.0 * 0.2));
        let plain = Coulomb::default().limit(SlipState { coefficient: 0.3, pressure: 2.0, speed: 1e300 });
        assert_eq!(plain, Limit { shear: 0.6, by_pressure: 0.3, by_speed: 0.0 });
    }
}
