//! Numbers and text: angles, formatting, and the engine's mathematical functions for whole numbers.
//!
//! The engine does not turn `2` into `2.0` for its own functions, so `sqrt(2)` would fail; here they take both.

use rhai::{Dynamic, ImmutableString};

use super::arguments::{Arguments, as_number};
use super::registry::{Absent, Form, Function, Kind, Parameter, Topic, body, number_text};
use crate::math::catalogue::Interval;

/// A number with so many significant digits; with an exponent where that is shorter.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return number_text(value + 0.0); // without the sign of a zero
    }
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    let exponent: i32 = scientific.split('e').nth(1).and_then(|text| text.parse().ok()).unwrap_or(0);
    if (-4..7).contains(&exponent) { format!("{value:.*}", (digits as i32 - 1 - exponent).max(0) as usize) } else { scientific }
}

/// A number with at most six significant digits, as messages show it.
pub fn brief(value: f64) -> String {
    let text = significant(value, 6);
    let (digits, exponent) = text.split_once('e').map_or((text.as_str(), None), |(digits, exponent)| (digits, Some(exponent)));
    let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    let digits = if digits == "-0" { "0" } else { digits };
    exponent.map_or(digits.to_string(), |exponent| format!("{digits}e{exponent}"))
}

fn of_number(name: &'static str, summary: &'static str, compute: fn(f64) -> f64) -> Function {
    Function {
        name,
        form: Form::Function,
        topic: Topic::Numbers,
        summary,
        parameters: vec![Parameter::number("x", "any", Interval::Finite, "a number")],
        returns: "number",
        example: format!("print({name}(1));").into(),
        see_also: &[],
        body: body(move |call| Ok(Dynamic::from(compute(call.number("x")?)))),
    }
}

fn of_two(name: &'static str, summary: &'static str, names: [&'static str; 2], compute: fn(f64, f64) -> f64) -> Function {
    Function {
        name,
        form: Form::Function,
        topic: Topic::Numbers,
        summary,
        parameters: names.map(|name| Parameter::number(name, "any", Interval::Finite, "a number")).into(),
        returns: "number",
        example: format!("print({name}(1, 2));").into(),
        see_also: &[],
        body: body(move |call| Ok(Dynamic::from(compute(call.number(names[0])?, call.number(names[1])?)))),
    }
}

/// The functions of this topic.
pub fn functions() -> Vec<Function> {
    vec![
        of_number("deg", "an angle in degrees as radians", f64::to_radians),
        of_number("sqrt", "the square root", f64::sqrt),
        of_number("sin", "the sine of an angle in radians", f64::sin),
        of_number("cos", "the cosine of an angle in radians", f64::cos),
        of_number("tan", "the tangent of an angle in radians", f64::tan),
        of_number("asin", "the angle of a sine", f64::asin),
        of_number("acos", "the angle of a cosine", f64::acos),
        of_number("atan", "the angle of a tangent", f64::atan),
        of_number("sinh", "the hyperbolic sine", f64::sinh),
        of_number("cosh", "the hyperbolic cosine", f64::cosh),
        of_number("tanh", "the hyperbolic tangent", f64::tanh),
        of_number("exp", "the exponential function", f64::exp),
        of_number("ln", "the natural logarithm", f64::ln),
        of_number("log", "the logarithm to base 10", f64::log10),
        of_number("floor", "the greatest whole number below", f64::floor),
        of_number("ceiling", "the least whole number above", f64::ceil),
        of_number("round", "the nearest whole number", f64::round),
        of_two("hypot", "the length of the vector (x, y)", ["x", "y"], f64::hypot),
        of_two("atan", "the angle of the vector (x, y), with its quadrant: `atan(y, x)`", ["y", "x"], f64::atan2),
        Function {
            name: "fmt",
            form: Form::Function,
            topic: Topic::Numbers,
            summary: "a number as text with so many significant digits",
            parameters: vec![
                Parameter::number("x", "any", Interval::Finite, "the number"),
                Parameter::new("digits", Kind::Integer, "significant digits").within(Interval::Closed(1.0, 17.0)).or(Absent::Integer(6)),
            ],
            returns: "String",
            example: "print(fmt(2.0 / 3.0, 3)); // 0.667".into(),
            see_also: &[],
            body: body(|call| {
                let argument = call.argument("x");
                let x = as_number(&argument.value()).ok_or_else(|| argument.wrong_type())?;
                let digits = call.integer("digits")?;
                Ok(Dynamic::from(ImmutableString::from(significant(x, digits as usize))))
            }),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::{brief, significant};

    #[test]
    fn digits_are_significant_ones() {
        assert_eq!(significant(2.0 / 3.0, 3), "0.667");
        assert_eq!(significant(1234.5678, 6), "1234.57");
        assert_eq!(significant(123456.0, 3), "123456");
        assert_eq!(significant(1.23456e-9, 3), "1.23e-9");
        assert_eq!(significant(-0.00012345, 2), "-0.00012");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(-0.0, 3), "0");
        assert_eq!([2.0, -0.0, 0.25, 1e-9, 1.5e10, 100000.0].map(brief), ["2", "0", "0.25", "1e-9", "1.5e10", "100000"]);
    }
}
