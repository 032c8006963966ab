//! Arrays of numbers: their largest and least entry, sum and mean, and numbers at equal distances.
//!
//! Arithmetic entry by entry is not here: its operators belong to the language (`language/elementwise.rs`).

use rhai::EvalAltResult;

use crate::script::language::limits::MAX_ARRAY;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};

/// Script functions of this topic.
pub fn functions() -> Vec<Function> {
    vec![
        of_numbers(
            "max",
            "the largest entry of an array of numbers, also `values.max()`, NaN left out; `max(a, b)` is the larger of two",
            |values| furthest(values, |entry, best| entry > best),
        ),
        of_numbers(
            "min",
            "the least entry of an array of numbers, also `values.min()`, NaN left out; `min(a, b)` is the smaller of two",
            |values| furthest(values, |entry, best| entry < best),
        ),
        of_numbers("sum", "the sum of an array of numbers, also `values.sum()`, NaN left out", |values| Some(sum(values))),
        of_numbers("mean", "the mean of an array of numbers, also `values.mean()`, NaN left out", |values| {
            (!values.is_empty()).then(|| mean(values).into())
        }),
        linspace(),
    ]
}

pub(super) fn numbers(values: &Array) -> impl Iterator<Item = f64> + '_ {
    values.iter().filter_map(as_number)
}

/// Mean of the numeric entries; NaN without any.
fn mean(values: &Array) -> f64 {
    let known: Vec<f64> = numbers(values).filter(|entry| !entry.is_nan()).collect();
    known.iter().sum::<f64>() / known.len() as f64
}

/// Largest or smallest entry, by `is_beyond`; NaN only without any number.
fn furthest(values: &Array, is_beyond: fn(f64, f64) -> bool) -> Option<Dynamic> {
    let beyond = |best: (usize, f64), entry: (usize, f64)| {
        let is_next = !entry.1.is_nan() && (best.1.is_nan() || is_beyond(entry.1, best.1));
        if is_next { entry } else { best }
    };
    numbers(values).enumerate().reduce(beyond).map(|(place, _)| values[place].clone())
}

/// Sum of the entries: a whole number if all entries are whole and the sum fits; NaN only without any number.
fn sum(values: &Array) -> Dynamic {
    let whole = values.iter().try_fold(0_i64, |sum, value| sum.checked_add(value.as_int().ok()?));
    let known = || numbers(values).filter(|entry| !entry.is_nan());
    let fraction = || if known().next().is_some() { known().sum() } else { f64::NAN };
    whole.map_or_else(|| fraction().into(), Dynamic::from)
}

fn of_numbers(name: &'static str, summary: &'static str, compute: fn(&Array) -> Option<Dynamic>) -> Function {
    function(Topic::Arrays, name)
        .summary(summary)
        .parameters(vec![Parameter::array("values", "the numbers")])
        .returns("number")
        .see_also(&["max", "min", "sum", "mean", "linspace"])
        .example(format!("print({name}([3, 1.5, 2]));"))
        .body(move |call| {
            let values = numbers_of(call, "values")?;
            compute(&values).ok_or_else(|| {
                let failure = call.argument("values").refuse(causes::NO_SUCH, format!("an empty array has no `{name}`"));
                failure.hint("check `values.is_empty()` first").into()
            })
        })
}

/// Returns the numbers of an argument; infinities and NaN are allowed, since results can have these.
pub(super) fn numbers_of(call: &Call, name: &str) -> Result<Array, Box<EvalAltResult>> {
    let argument = call.argument(name);
    let values = argument.array()?;
    match values.iter().find(|value| as_number(value).is_none()) {
        None => Ok(values),
        Some(other) => {
            let given = describe(call.engine(), other);
            let failure = argument.wrong(causes::WRONG_TYPE, "must be an array of numbers");
            Err(failure.label(format!("this contains {given}")).hint("`values.map(|v| …)` makes numbers of the entries").into())
        }
    }
}

fn linspace() -> Function {
    function(Topic::Arrays, "linspace")
        .summary("numbers at equal distances between a first and a last one")
        .parameters(vec![
            Parameter::number("first", "any", Interval::Finite, "the first number"),
            Parameter::number("last", "any", Interval::Finite, "the last number"),
            Parameter::integer("count", "how many, both ends among them").within(Interval::Closed(2.0, MAX_ARRAY as f64)),
        ])
        .see_also(&["sum", "mean"])
        .example("for t in linspace(0.0, 1.0, 5) { print(t); }")
        .body(|call| {
            let (first, last, count) = (call.number("first")?, call.number("last")?, call.integer("count")?);
            let number = |place: i64| {
                let share = place as f64 / (count - 1) as f64;
                // Exact at both ends.
                Dynamic::from(first * (1.0 - share) + last * share)
            };
            Ok((0..count).map(number).collect::<Array>())
        })
}
