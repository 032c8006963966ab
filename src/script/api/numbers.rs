//! Numbers and text: angles, formatting, and the engine's mathematical functions for whole numbers.
//!
//! The engine does not convert `2` to `2.0` for its own functions, so that `sqrt(2)` would fail; the functions here accept both.

use rhai::ImmutableString;

use crate::script::language::digits::significant;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};

/// Largest depth of nested arrays.
const MAX_DEPTH: usize = 8;

fn of_number(name: &'static str, summary: &'static str, compute: fn(f64) -> f64) -> Function {
    function(Topic::Numbers, name)
        .summary(summary)
        .parameters(vec![Parameter::number("x", "any", Interval::Finite, "a number, or an array of numbers entry by entry")])
        .returns("number")
        .example(format!("print({name}(1));\nprint({name}([1, 0.5]));"))
        .body(move |call| {
            let argument = call.argument("x");
            Ok(entrywise(&argument, compute)?)
        })
}

/// Applies a function to a number, or to each entry of an array of numbers.
///
/// # Errors
/// The argument is neither.
pub(super) fn entrywise(argument: &Argument, compute: impl Fn(f64) -> f64) -> Result<Dynamic, Failure> {
    let value = argument.value();
    let entry = |value: &Dynamic| as_number(value).map(|x| Dynamic::from(compute(x)));
    if value.is_array() { each(argument, &value, &entry, 0) } else { Ok(compute(argument.number()?).into()) }
}

/// Applies a function of numbers to all entries of an array, including nested arrays.
fn each(argument: &Argument, value: &Dynamic, of: &dyn Fn(&Dynamic) -> Option<Dynamic>, depth: usize) -> Result<Dynamic, Failure> {
    let Some(entries) = value.read_lock::<Array>().filter(|_| depth < MAX_DEPTH) else {
        let failure = argument.wrong(causes::WRONG_TYPE, "must be a number or an array of numbers");
        let failure = failure.label(format!("this contains {}", describe(argument.call().engine(), value)));
        return Err(failure.hint("`values.map(|v| …)` makes numbers of the entries"));
    };
    entries
        .iter()
        .map(|entry| of(entry).map_or_else(|| each(argument, entry, of, depth + 1), Ok))
        .collect::<Result<Array, _>>()
        .map(Into::into)
}

/// Function `abs`: absolute value; whole numbers stay whole.
fn abs() -> Function {
    let size = |value: &Dynamic| match value.as_int().ok().and_then(i64::checked_abs) {
        Some(whole) => Some(whole.into()),
        None => as_number(value).map(|x| x.abs().into()),
    };
    function(Topic::Numbers, "abs")
        .summary("the size of a number without its sign")
        .parameters(vec![Parameter::number("x", "any", Interval::Finite, "a number, or an array of numbers entry by entry")])
        .returns("number")
        .see_also(&["max", "min"])
        .example("print(abs(-1.5));\nprint(abs([-1, 2.5]));")
        .body(move |call| {
            let argument = call.argument("x");
            let value = argument.value();
            if value.is_array() {
                return Ok(each(&argument, &value, &size, 0)?);
            }
            argument.number()?;
            Ok(size(&value).unwrap_or_default())
        })
}

fn of_two(name: &'static str, summary: &'static str, names: [&'static str; 2], compute: fn(f64, f64) -> f64) -> Function {
    function(Topic::Numbers, name)
        .summary(summary)
        .parameters(
            names.map(|name| Parameter::number(name, "any", Interval::Finite, "a number, or an array of numbers entry by entry")).into(),
        )
        .returns("number")
        .example(format!("print({name}(1, 2));\nprint({name}([1, 3], 2));"))
        .body(move |call| {
            let [a, b] = names.map(|name| call.argument(name));
            match [a.value(), b.value()].map(|value| value.into_array().ok()) {
                [None, None] => Ok(Dynamic::from(compute(a.number()?, b.number()?))),
                [Some(x), Some(y)] if x.len() != y.len() => {
                    let failure = b.refuse(causes::WRONG_TYPE, format!("{} works entry by entry", call.function.title()));
                    Err(failure
                        .cause(format!("the arrays have {} and {} entries", x.len(), y.len()))
                        .hint("give arrays of one length")
                        .into())
                }
                [Some(x), Some(y)] => {
                    let all = x.iter().zip(&y).map(|(x, y)| entry_of(&a, x).and_then(|x| Ok(compute(x, entry_of(&b, y)?).into())));
                    Ok(all.collect::<Result<Array, Failure>>()?.into())
                }
                [Some(x), None] => {
                    let y = b.number()?;
                    Ok(x.iter().map(|x| Ok(compute(entry_of(&a, x)?, y).into())).collect::<Result<Array, Failure>>()?.into())
                }
                [None, Some(y)] => {
                    let x = a.number()?;
                    Ok(y.iter().map(|y| Ok(compute(x, entry_of(&b, y)?).into())).collect::<Result<Array, Failure>>()?.into())
                }
            }
        })
}

/// Number in an array.
fn entry_of(argument: &Argument, value: &Dynamic) -> Result<f64, Failure> {
    as_number(value).ok_or_else(|| {
        let failure = argument.wrong(causes::WRONG_TYPE, "must be a number or an array of numbers");
        failure.label(format!("this contains {}", describe(argument.call().engine(), value)))
    })
}

/// Script functions of this topic.
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
        abs(),
        of_two("hypot", "the length of the vector (x, y)", ["x", "y"], f64::hypot),
        of_two("atan", "the angle of the vector (x, y), with its quadrant: `atan(y, x)`", ["y", "x"], f64::atan2),
        function(Topic::Numbers, "fmt")
            .summary("a number as text with a given number of significant digits")
            .parameters(vec![
                Parameter::number("x", "any", Interval::Finite, "the number"),
                Parameter::integer("digits", "significant digits").within(Interval::Closed(1.0, 17.0)).or(6),
            ])
            .returns("String")
            .example("print(fmt(2.0 / 3.0, 3)); // 0.667")
            .body(|call| {
                let argument = call.argument("x");
                let x = as_number(&argument.value()).ok_or_else(|| argument.wrong_type())?;
                let digits = call.integer("digits")?;
                Ok(Dynamic::from(ImmutableString::from(significant(x, digits as usize))))
            }),
    ]
}
