//! Expressions of units, such as `kg/m^3`, `N/mm` or `t*mm/s^2`.

use std::fmt;

use super::table::{named, names};
use super::unit::Unit;

/// An expression that is no unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnitError {
    /// Unknown unit name.
    Unknown(String),
    /// A text that is no product or quotient of unit names (operators `*`, `/`, `^`, parentheses).
    Malformed {
        /// Refused unit expression.
        text: String,
        /// Expected continuation in words.
        expected: &'static str,
    },
}

impl fmt::Display for UnitError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UnitError::Unknown(name) => write!(out, "there is no unit \"{name}\""),
            UnitError::Malformed { text, expected } => write!(out, "\"{text}\" is no unit: {expected}"),
        }
    }
}

impl Unit {
    /// Reads an expression.
    ///
    /// # Errors
    /// A name that no unit has, or a text that is no product or quotient of units.
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        let mut reader = Reader { text, rest: text.trim() };
        let unit = reader.product()?;
        if reader.rest.is_empty() { Ok(unit) } else { Err(reader.malformed("what follows the unit is neither `*` nor `/`")) }
    }

    /// Names of units, for suggestions.
    pub fn names() -> Vec<&'static str> {
        names()
    }
}

struct Reader<'a> {
    text: &'a str,
    rest: &'a str,
}

/// Digits of exponents as superscripts.
const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹";

impl Reader<'_> {
    fn malformed(&self, expected: &'static str) -> UnitError {
        UnitError::Malformed { text: self.text.into(), expected }
    }

    fn take(&mut self, letter: char) -> bool {
        let found = self.rest.strip_prefix(letter);
        self.rest = found.map_or(self.rest, str::trim_start);
        found.is_some()
    }

    fn product(&mut self) -> Result<Unit, UnitError> {
        let mut unit = self.power()?;
        loop {
            let sign = if self.take('*') || self.take('·') {
                1
            } else if self.take('/') {
                -1
            } else if self.rest.starts_with(|letter: char| letter.is_alphabetic()) {
                1
            } else {
                return Ok(unit);
            };
            unit = unit.times(self.power()?, sign);
        }
    }

    fn power(&mut self) -> Result<Unit, UnitError> {
        let unit = self.single()?;
        let mut exponent = 1;
        if self.take('^') {
            exponent = self.whole()?;
        } else if let Some((raised, negative)) = self.raised() {
            exponent = if negative { -raised } else { raised };
        }
        self.rest = self.rest.trim_start();
        Ok(Unit::ONE.times(unit, exponent))
    }

    fn single(&mut self) -> Result<Unit, UnitError> {
        if self.take('(') {
            let unit = self.product()?;
            return if self.take(')') { Ok(unit) } else { Err(self.malformed("a parenthesis is not closed")) };
        }
        if self.take('1') {
            return Ok(Unit::ONE);
        }
        let is_first = |letter: char| (letter.is_alphabetic() || "%°".contains(letter)) && !RAISED.contains(letter);
        let end = self.rest.find(|letter: char| !is_first(letter)).unwrap_or(self.rest.len());
        // A name may end with a zero: `g0`.
        let end = if end > 0 && self.rest[end..].starts_with('0') { end + 1 } else { end };
        let (name, rest) = self.rest.split_at(end);
        if name.is_empty() {
            return Err(self.malformed("write names with `*`, `/` and whole exponents, such as `kg/m^3`"));
        }
        self.rest = rest;
        named(name).ok_or_else(|| UnitError::Unknown(name.into()))
    }

    fn whole(&mut self) -> Result<i32, UnitError> {
        let end = self.rest.char_indices().find(|(at, letter)| !(letter.is_ascii_digit() || *at == 0 && *letter == '-'));
        let (digits, rest) = self.rest.split_at(end.map_or(self.rest.len(), |(at, _)| at));
        let exponent = digits.parse().ok().filter(|exponent: &i32| exponent.abs() <= 9);
        self.rest = rest;
        exponent.ok_or_else(|| self.malformed("an exponent is a whole number, such as `m^3`"))
    }

    fn raised(&mut self) -> Option<(i32, bool)> {
        let rest = self.rest.strip_prefix('⁻');
        let negative = rest.is_some();
        let rest = rest.unwrap_or(self.rest);
        let letter = rest.chars().next()?;
        let digit = RAISED.chars().position(|raised| raised == letter)?;
        self.rest = &rest[letter.len_utf8()..];
        Some((digit as i32, negative))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> ([i32; 3], f64) {
        let unit = Unit::parse(text).unwrap();
        (unit.dimension.0, unit.scale.number())
    }

    #[test]
    fn expressions_are_products_of_units_with_exponents() {
        assert_eq!(read("MPa"), ([1, -1, -2], 1e6));
        assert_eq!(read("kg/m^3"), ([1, -3, 0], 1.0));
        assert_eq!(read("kg/m³"), read("kg m⁻³"));
        assert_eq!(read("t*mm/s^2"), read("N"));
        assert_eq!(read("N/(mm*s)"), read("N/mm/s"));
        assert_eq!(read("N mm"), read("mJ"));
        assert_eq!(read("1/s"), ([0, 0, -1], 1.0));
        assert_eq!(read("g0"), ([0, 1, -2], 9.80665));
        assert_eq!(read("lbf/in^2"), read("psi"));
        assert_eq!(read("min").1, 60.0, "not a milli-inch");
        for bad in ["", "kg/", "m^", "m^1.5", "(m", "m)", "furlong", "5", "m-s"] {
            assert!(Unit::parse(bad).is_err(), "{bad}");
        }
        assert_eq!(Unit::parse("mPascal"), Err(UnitError::Unknown("mPascal".into())));
    }
}
