//! Conversion of all numbers of a model to other units.

use crate::output::Dimension;

/// Conversion of units: numerical values of one kilogram, one meter, one second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Factor of masses.
    pub mass: f64,
    /// Factor of lengths.
    pub length: f64,
    /// Factor of times.
    pub time: f64,
}

impl Units {
    /// Identity conversion.
    pub const SAME: Units = Units { mass: 1.0, length: 1.0, time: 1.0 };

    /// The factor of a quantity.
    pub fn factor(&self, Dimension([mass, length, time]): Dimension) -> f64 {
        self.mass.powi(mass) * self.length.powi(length) * self.time.powi(time)
    }

    /// The factor of a stress.
    pub fn stress(&self) -> f64 {
        self.factor(Dimension([1, -1, -2]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_those_of_the_dimension() {
        let millimeters = Units { mass: 1e-3, length: 1e3, time: 1.0 };
        // a newton is a newton in tonnes, millimeters and seconds; a pascal is 1e-6 of a megapascal
        let factor = |text: &str| millimeters.factor(Dimension::parse(text).unwrap());
        assert!((factor("force") - 1.0).abs() < 1e-15);
        assert!((factor("stress") - 1e-6).abs() < 1e-21);
    }
}
