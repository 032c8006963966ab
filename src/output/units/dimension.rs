//! Physical dimensions of functions and columns, such as `force * length` or `mass/volume`.

/// Physical dimension: exponents of mass, length and time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
    /// Factors of a product or quotient of named dimensions with their exponents; `None` for anything else.
    pub fn factors(text: &str) -> Option<Vec<(&'static str, i32)>> {
        let mut factors = Vec::new();
        let mut sign = 1;
        let mut rest = text.trim();
        while !rest.is_empty() {
            let end = rest.find(['*', '/']).unwrap_or(rest.len());
            let (name, power) = rest[..end].trim().split_once('^').unwrap_or((rest[..end].trim(), "1"));
            let power: i32 = power.parse().ok()?;
            let (known, _) = NAMED.iter().find(|(known, _)| *known == name)?;
            factors.push((*known, sign * power));
            sign = if rest[end..].starts_with('/') { -1 } else { 1 };
            rest = rest[end..].get(1..).unwrap_or("").trim();
        }
        (!factors.is_empty()).then_some(factors)
    }

    /// Reads a product or quotient of named dimensions with whole exponents; `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let mut exponents = [0; 3];
        for (name, power) in Self::factors(text)? {
            let (_, of) = NAMED.iter().find(|(known, _)| *known == name)?;
            (0..3).for_each(|i| exponents[i] += power * of[i]);
        }
        Some(Dimension(exponents))
    }

    /// Product with a power of another dimension.
    pub fn times(self, other: Dimension, power: i32) -> Self {
        Dimension(std::array::from_fn(|i| self.0[i] + power * other.0[i]))
    }

    /// Name of the dimension in words, such as `stress` or `mass/length^3`.
    pub fn words(self) -> String {
        if let Some((name, _)) = NAMED.iter().find(|(name, of)| *of == self.0 && *name != "1" && *name != "rad") {
            return (*name).into();
        }
        let factors = ["mass", "length", "time"].into_iter().zip(self.0).collect::<Vec<_>>();
        product(&factors)
    }
}

/// Text of a product of names with exponents, such as `kg*m^2/s`; `1` without any.
pub(super) fn product<S: AsRef<str>>(factors: &[(S, i32)]) -> String {
    let power = |(name, power): &(S, i32)| match power.abs() {
        1 => name.as_ref().to_string(),
        more => format!("{}^{more}", name.as_ref()),
    };
    let of = |sign: i32| factors.iter().filter(|factor| factor.1 * sign > 0).map(power).collect::<Vec<_>>();
    let (above, below) = (of(1), of(-1));
    let above = if above.is_empty() { "1".to_string() } else { above.join("*") };
    match below.len() {
        0 => above,
        1 => format!("{above}/{}", below[0]),
        _ => format!("{above}/({})", below.join("*")),
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
        assert_eq!(Dimension([1, -1, -2]).words(), "stress");
        assert_eq!(Dimension([1, -3, 0]).words(), "mass/length^3");
        assert_eq!(Dimension([0, 0, -1]).words(), "1/time");
    }
}
