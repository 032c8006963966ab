//! Numbers and text: angles, formatting, and the engine's mathematical functions for whole numbers.
//!
//! The engine does not convert `2` to `2.0` for its own functions, so that `sqrt(2)` would fail; the functions here accept both.

use rhai::{Dynamic, ImmutableString};

use crate::math::catalogue::Interval;
use crate::script::language::arguments::Arguments;
use crate::script::language::digits::significant;
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::parameter::{Absent, Kind, Parameter};
use crate::script::language::values::as_number;

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
