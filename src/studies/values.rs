//! Values of a parameter as written on the command line: `dt=0.01,0.005`, `torque=0.05..0.2:7`, `stiffness=1e3..1e6:4:log`, `gap=0..0.1`.

use std::str::FromStr;

use crate::script::{Class, Diagnostic};

/// Spacing of values in an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences.
    Linear,
    /// Equal ratios.
    Logarithmic,
}

/// Values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Listed values, each as for `--set`.
    Listed(Vec<String>),
    /// Samples from an interval.
    Interval {
        /// Lower end of the interval.
        low: f64,
        /// Upper end of the interval.
        high: f64,
        /// Spacing of the samples.
        scale: Scale,
    },
}

/// A varied parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Varied {
    /// Name of the parameter.
    pub name: String,
    /// Values of the parameter.
    pub values: Values,
}

/// Syntax of values, for messages.
const FORMS: &str = "write values (dt=0.01,0.005), a number of them between two ends (torque=0.05..0.2:7, or :7:log for equal factors), or \
                     an interval to sample (gap=0..0.1 with --sample)";
/// Largest number of values between two ends.
const MOST: usize = 1_000_000;
/// Number of digits of a computed value, without the round-off of summed differences.
const DIGITS: usize = 12;

impl FromStr for Varied {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').map(|(name, values)| (name.trim(), values.trim()));
        match parts.filter(|(name, _)| !name.is_empty()) {
            Some((name, values)) => Ok(Varied { name: name.into(), values: values.parse()? }),
            None => Err(FORMS.into()),
        }
    }
}

impl FromStr for Values {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((low, rest)) = text.split_once("..") {
            return between(low, rest);
        }
        let listed: Vec<String> = text.split(',').map(|value| value.trim().to_string()).collect();
        if listed.iter().any(String::is_empty) { Err(format!("a value is missing: {FORMS}")) } else { Ok(Values::Listed(listed)) }
    }
}

/// Parses the part of an interval behind `low`.
fn between(low: &str, rest: &str) -> Result<Values, String> {
    let mut parts = rest.split(':').map(str::trim);
    let high = parts.next().unwrap_or_default();
    let (mut count, mut scale) = (None, Scale::Linear);
    for part in parts {
        match part.parse::<usize>() {
            _ if part == "log" => scale = Scale::Logarithmic,
            Ok(number) if (2..=MOST).contains(&number) && count.is_none() => count = Some(number),
            Ok(_) => return Err(format!("`{part}` values between two ends: give a number from 2 to {MOST}")),
            Err(_) => return Err(format!("`{part}` is neither a number of values nor `log`: {FORMS}")),
        }
    }
    let end = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let (Some(low), Some(high)) = (end(low), end(high)) else { return Err(format!("the ends must be numbers: {FORMS}")) };
    if low == high || scale == Scale::Logarithmic && (low <= 0.0 || high <= 0.0) {
        return Err(if low == high { "both ends are the same".into() } else { "equal factors need ends above zero".to_string() });
    }
    let interval = Values::Interval { low, high, scale };
    Ok(match count {
        None => interval,
        Some(count) => Values::Listed((0..count).map(|index| interval.at(index as f64 / (count - 1) as f64)).collect()),
    })
}

impl Values {
    /// Returns the value at a fraction of the interval from the lower to the upper end, as a text for `--set`.
    pub fn at(&self, share: f64) -> String {
        match self {
            Values::Listed(values) => values[((share * values.len() as f64) as usize).min(values.len() - 1)].clone(),
            Values::Interval { low, high, .. } if share == 0.0 || share == 1.0 => number(if share == 0.0 { *low } else { *high }),
            Values::Interval { low, high, scale: Scale::Linear } => number(low + share * (high - low)),
            Values::Interval { low, high, scale: Scale::Logarithmic } => number((low.ln() + share * (high.ln() - low.ln())).exp()),
        }
    }
}

/// Formats a number with at most [`DIGITS`] digits, whole numbers without a fraction.
fn number(value: f64) -> String {
    let value: f64 = format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value);
    let plain = value == 0.0 || (0.000_01..1e15).contains(&value.abs());
    if plain { format!("{}", value + 0.0) } else { format!("{value:e}") }
}

/// Returns the message of a refused request.
pub(super) fn refusal(title: impl Into<String>) -> Diagnostic {
    Diagnostic::error(Class::Script, title)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(text: &str) -> Vec<String> {
        match text.parse::<Varied>() {
            Ok(Varied { values: Values::Listed(values), .. }) => values,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn lists_and_ranges() {
        assert_eq!(listed("dt = 0.01, 5e-3,1"), ["0.01", "5e-3", "1"]);
        assert_eq!(listed("torque=0.05..0.2:7"), ["0.05", "0.075", "0.1", "0.125", "0.15", "0.175", "0.2"]);
        assert_eq!(listed("n=1..4:4"), ["1", "2", "3", "4"]);
        assert_eq!(listed("e=1e-9..1e6:4:log"), ["1e-9", "0.0001", "10", "1000000"]);
        assert_eq!(listed("x=1..-1:3"), ["1", "0", "-1"]);
        let interval = Values::Interval { low: 1.0, high: 100.0, scale: Scale::Logarithmic };
        assert_eq!("e=1..100:log".parse::<Varied>().unwrap().values, interval);
        assert_eq!([0.0, 0.5, 1.0].map(|share| interval.at(share)), ["1", "10", "100"]);
    }

    #[test]
    fn what_is_no_list_is_refused_with_how_to_write_it() {
        for (text, said) in [
            ("dt", "write values"),
            ("=1", "write values"),
            ("dt=1,,2", "a value is missing"),
            ("dt=", "a value is missing"),
            ("dt=a..b:3", "must be numbers"),
            ("dt=1..2:x", "neither a number"),
            ("dt=1..2:1", "from 2"),
            ("dt=1..2:3:4", "from 2"),
            ("dt=0..2:3:log", "above zero"),
            ("dt=1..1", "the same"),
            ("dt=1..inf", "must be numbers"),
        ] {
            let error = text.parse::<Varied>().unwrap_err();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
