//! Physical dimensions as scripts write them, such as `force * length` or `mass/volume`, and numbers in other units.

/// Physical dimension: exponents of mass, length and time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension(pub [i32; 3]);

/// Dimensions with a name of their own.
const NAMED: &[(&str, [i32; 3])] = &[
    ("1", [0, 0, 0]),
    ("rad", [0, 0, 0]),
    ("mass", [1, 0, 0]),
    ("length", [0, 1, 0]),
    ("time", [0, 0, 1]),
    ("area", [0, 2, 0]),
    ("volume", [0, 3, 0]),
    ("velocity", [0, 1, -1]),
    ("stress", [1, -1, -2]),
    ("force", [1, 1, -2]),
    ("energy", [1, 2, -2]),
];

impl Dimension {
    /// Reads a product or quotient of named dimensions with whole exponents; `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let mut exponents = [0; 3];
        let mut sign = 1;
        let mut rest = text.trim();
        while !rest.is_empty() {
            let end = rest.find(['*', '/']).unwrap_or(rest.len());
            let (name, power) = rest[..end].trim().split_once('^').unwrap_or((rest[..end].trim(), "1"));
            let power: i32 = power.parse().ok()?;
            let (_, of) = NAMED.iter().find(|(known, _)| *known == name)?;
            (0..3).for_each(|i| exponents[i] += sign * power * of[i]);
            sign = if rest[end..].starts_with('/') { -1 } else { 1 };
            rest = rest[end..].get(1..).unwrap_or("").trim();
        }
        (!text.trim().is_empty()).then_some(Dimension(exponents))
    }
}

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
    fn products_and_quotients_are_read() {
        let of = |text: &str| Dimension::parse(text).map(|dimension| dimension.0);
        assert_eq!(of("mass/volume"), Some([1, -3, 0]));
        assert_eq!(of("length/time^2"), Some([0, 1, -2]));
        assert_eq!(of("force * length"), Some([1, 2, -2]));
        assert_eq!(of("1/time"), Some([0, 0, -1]));
        assert_eq!(of("1"), Some([0, 0, 0]));
        assert_eq!([of(""), of("weight"), of("length^x")], [None, None, None]);
        let millimeters = Units { mass: 1e-3, length: 1e3, time: 1.0 };
        // a newton is a newton in tonnes, millimeters and seconds; a pascal is 1e-6 of a megapascal
        let factor = |text: &str| millimeters.factor(Dimension::parse(text).unwrap());
        assert!((factor("force") - 1.0).abs() < 1e-15);
        assert!((factor("stress") - 1e-6).abs() < 1e-21);
    }
}
