//! Description of a catalogue row (materials, integrators, contact methods).
//!
//! One description feeds the script functions, `help`, the suggestions in errors, the reference page and the contract tests.

/// An interval of admissible values of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interval {
    /// Every finite number.
    Finite,
    /// Greater than zero.
    Positive,
    /// Zero or greater.
    NonNegative,
    /// Strictly between the two bounds.
    Open(f64, f64),
    /// Between the two bounds, both included.
    Closed(f64, f64),
}

impl Interval {
    /// True if `value` is finite and inside the interval.
    pub fn contains(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Interval::Finite => true,
                Interval::Positive => value > 0.0,
                Interval::NonNegative => value >= 0.0,
                Interval::Open(low, high) => low < value && value < high,
                Interval::Closed(low, high) => low <= value && value <= high,
            }
    }

    /// Returns the value if it is inside the interval.
    ///
    /// # Errors
    /// The value is outside the interval.
    pub fn check(self, value: f64) -> Result<f64, OutOfRange> {
        if self.contains(value) { Ok(value) } else { Err(OutOfRange { range: self, value }) }
    }
}

impl std::fmt::Display for Interval {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Interval::Finite => write!(out, "a finite number"),
            Interval::Positive => write!(out, "greater than 0"),
            Interval::NonNegative => write!(out, "0 or greater"),
            Interval::Open(low, high) => write!(out, "greater than {low} and less than {high}"),
            Interval::Closed(low, high) => write!(out, "from {low} to {high}"),
        }
    }
}

/// Value outside the interval of its parameter; displayed as `must be ..., but is ...`, after the name of the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfRange {
    /// Admissible values.
    pub range: Interval,
    /// Refused value of the parameter.
    pub value: f64,
}

impl std::fmt::Display for OutOfRange {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "must be {}, but is {:?}", self.range, self.value)
    }
}

impl std::error::Error for OutOfRange {}

impl OutOfRange {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        "C0532"
    }
}

/// One named number that a catalogue row is constructed from.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Name as written in a script.
    pub name: &'static str,
    /// Summary of the entry, one sentence.
    pub summary: &'static str,
    /// Physical dimension, such as `stress` or `mass/volume`; `1` for a pure number.
    pub dimension: &'static str,
    /// Admissible values.
    pub range: Interval,
    /// Default of the parameter; `None` for a required one.
    pub default: Option<f64>,
}
