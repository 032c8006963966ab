//! Sizes of units: a factor times a power of ten, so that decimal conversions are rounded once.

/// Largest power of ten that is a number without round-off.
const EXACT: i32 = 22;

/// Relative difference of equal sizes: round-off of a few products and roots.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// Size of a unit relative to that of the SI: `factor * 10^power`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    factor: f64,
    power: i32,
}

impl Scale {
    /// Size of a unit of the SI.
    pub const ONE: Scale = Scale::new(1.0, 0);

    /// Size `factor * 10^power`.
    pub const fn new(factor: f64, power: i32) -> Self {
        Scale { factor, power }
    }

    /// Product with a power of another size.
    pub fn times(self, other: Scale, power: i32) -> Self {
        let factor = if power >= 0 { self.factor * other.factor.powi(power) } else { self.factor / other.factor.powi(-power) };
        Scale { factor, power: self.power + power * other.power }
    }

    /// Root of a whole degree.
    pub fn root(self, degree: i32) -> Self {
        if degree == 1 {
            return self;
        }
        let (whole, rest) = (self.power.div_euclid(degree), self.power.rem_euclid(degree));
        let inside = self.factor * 10f64.powi(rest);
        Scale { factor: if degree == 2 { inside.sqrt() } else { inside.powf(1.0 / f64::from(degree)) }, power: whole }
    }

    /// A value multiplied by the size.
    pub fn of(self, value: f64) -> f64 {
        let mut value = value * self.factor;
        let mut left = self.power;
        while left != 0 {
            let part = left.clamp(-EXACT, EXACT);
            value = if part > 0 { value * 10f64.powi(part) } else { value / 10f64.powi(-part) };
            left -= part;
        }
        value
    }

    /// The size as a number.
    pub fn number(self) -> f64 {
        self.of(1.0)
    }

    /// True if both sizes are equal up to round-off.
    pub fn is(self, other: Scale) -> bool {
        (self.times(other, -1).number() - 1.0).abs() <= ROUND_OFF
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_conversions_are_rounded_once() {
        let millimeter = Scale::new(1.0, -3);
        let to_millimeters = Scale::ONE.times(millimeter, -1);
        assert_eq!([0.1, 0.3, 7.0].map(|x| to_millimeters.of(x)), [100.0, 300.0, 7000.0]);
        let tonne = Scale::new(1.0, 3);
        let density = Scale::ONE.times(tonne.times(millimeter, -3), -1);
        assert_eq!(density.of(7850.0), 7.85e-9);
        assert!(Scale::new(4.0, 3).root(2).is(Scale::new(4000f64.sqrt(), 0)));
        assert_eq!(Scale::new(1.0, 6).root(2), Scale::new(1.0, 3));
        assert!((Scale::new(1.0, -44).number() / 1e-44 - 1.0).abs() < 1e-15, "two roundings");
        assert!(!Scale::ONE.is(Scale::new(1.000001, 0)));
    }
}
