//! The points of a study: all combinations of given values, or a list of points.

use std::ops::{Range, RangeInclusive};

use rhai::ImmutableString;

use crate::script::language::causes;
use crate::script::language::digits::brief;
use crate::script::language::plain::Plain;
use crate::script::language::prelude::*;
use crate::script::language::values::describe;
use crate::script::language::wording::{did_you_mean, listed};

/// Largest number of points of a study.
const MOST: usize = 1_000_000;

/// A point: values by their names, in the order of the names.
pub type Point = Vec<(String, Plain)>;

/// Returns the points in an argument.
///
/// # Errors
/// The argument has no points.
pub fn points(argument: &Argument) -> Result<Vec<Point>, Failure> {
    let value = argument.value();
    if let Some(map) = value.read_lock::<Map>() {
        return grid(argument, &map);
    }
    let Some(array) = value.read_lock::<Array>() else { return Err(argument.wrong_type()) };
    let points: Vec<Point> = array.iter().enumerate().map(|(index, entry)| point(argument, index, entry)).collect::<Result<_, _>>()?;
    let Some(first) = points.first() else {
        return Err(argument.wrong(causes::EMPTY, "has no points").hint("write `[#{ dt: 0.01 }, #{ dt: 0.005 }]`"));
    };
    for (index, point) in points.iter().enumerate() {
        let names = |point: &Point| point.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        if names(point) != names(first) {
            let failure = argument.refuse(causes::COUNT, format!("the points of {} do not have the same names", argument.title()));
            let failure = failure.cause(format!("point 0 has {}", listed(&names(first), "and")));
            return Err(failure
                .cause(format!("point {index} has {}", listed(&names(point), "and")))
                .hint("give every name in every point"));
        }
    }
    Ok(points)
}

/// Describes a point, such as `dt = 0.01, rule = "gap"`.
pub fn described(point: &Point) -> String {
    let value = |value: &Plain| match value {
        Plain::Number(number) => brief(*number),
        Plain::Text(text) => format!("{text:?}"),
        other => other.field(),
    };
    point.iter().map(|(name, plain)| format!("{name} = {}", value(plain))).collect::<Vec<_>>().join(", ")
}

/// Returns a point as a map.
pub fn map(point: &Point) -> Plain {
    Plain::Map(point.clone())
}

fn point(argument: &Argument, index: usize, entry: &Dynamic) -> Result<Point, Failure> {
    match entry.read_lock::<Map>() {
        Some(map) if map.is_empty() => Err(argument.refuse(causes::EMPTY, format!("point {index} of {} has no values", argument.title()))),
        Some(map) => map.iter().map(|(name, value)| plain(argument, name, value).map(|value| (name.to_string(), value))).collect(),
        None => {
            let given = describe(argument.call().engine(), entry);
            let failure = argument
                .refuse(causes::WRONG_TYPE, format!("the points of {} must be maps", argument.title()))
                .label(format!("entry {index} is {given}"));
            Err(failure.hint("write `[#{ dt: 0.01 }, #{ dt: 0.005 }]`, or `#{ dt: [0.01, 0.005] }`"))
        }
    }
}

/// All combinations: the last name runs fastest.
fn grid(argument: &Argument, map: &Map) -> Result<Vec<Point>, Failure> {
    if map.is_empty() {
        return Err(argument.wrong(causes::EMPTY, "names nothing").hint("write `vary: #{ dt: [0.01, 0.005] }`"));
    }
    let mut points: Vec<Point> = vec![Vec::new()];
    for (name, value) in map {
        let values = values(argument, name, value)?;
        if values.is_empty() {
            let failure = argument.refuse(causes::EMPTY, format!("`{name}` of {} has no values", argument.title()));
            return Err(failure.hint(format!("write `{name}: [1.0, 2.0]`")));
        }
        if points.len().saturating_mul(values.len()) > MOST {
            let failure = argument.wrong(causes::COUNT, format!("means more than {MOST} points"));
            return Err(failure.hint("give fewer values, or an array of points of your own choice"));
        }
        let longer = |point: &Point| {
            let point = point.clone();
            values
                .iter()
                .map(move |value| point.iter().cloned().chain([(name.to_string(), value.clone())]).collect())
                .collect::<Vec<Point>>()
        };
        points = points.iter().flat_map(longer).collect();
    }
    Ok(points)
}

/// Returns the values for a name: an array, a range, or a single value.
fn values(argument: &Argument, name: &str, value: &Dynamic) -> Result<Vec<Plain>, Failure> {
    let count = |range: Range<i64>| range.take(MOST + 1).map(Plain::Whole).collect();
    if let Some(range) = value.clone().try_cast::<Range<i64>>() {
        return Ok(count(range));
    }
    if let Some(range) = value.clone().try_cast::<RangeInclusive<i64>>() {
        return Ok(count(*range.start()..range.end().saturating_add(1)));
    }
    let is_number = |part: &str| part.trim().parse::<f64>().is_ok();
    if let Some((low, high)) = value.read_lock::<ImmutableString>().as_deref().and_then(|text| text.split_once(".."))
        && let (high, count) = high.split_once(':').unwrap_or((high, "5"))
        && is_number(low)
        && is_number(high)
    {
        let failure = argument.refuse(causes::EMPTY, format!("`{name}` of {} is one text, not values", argument.title()));
        let (low, high, count) = (fraction(low), fraction(high), count.split(':').next().unwrap_or("5"));
        return Err(failure.label("a range as the command line has it").hint(format!("write `{name}: linspace({low}, {high}, {count})`")));
    }
    match value.read_lock::<Array>() {
        Some(array) => array.iter().map(|entry| plain(argument, name, entry)).collect(),
        None => Ok(vec![plain(argument, name, value)?]),
    }
}

/// Returns the text of a number with a decimal point.
fn fraction(text: &str) -> String {
    text.trim().parse::<f64>().map_or_else(|_| text.into(), |number| format!("{number:?}"))
}

fn plain(argument: &Argument, name: &str, value: &Dynamic) -> Result<Plain, Failure> {
    Plain::of(value).ok_or_else(|| {
        let given = describe(argument.call().engine(), value);
        let failure =
            argument.refuse(causes::WRONG_TYPE, format!("`{name}` of {} must be numbers, strings or other data", argument.title()));
        failure
            .label(format!("this has {given}"))
            .hint(format!("vary a name, and choose by it: `if p.{name} == \"…\" {{ … }} else {{ … }}`"))
    })
}

/// Returns the failure of a name that is not permitted.
pub fn unknown(argument: &Argument, name: &str, known: &[String]) -> Failure {
    let failure = argument.wrong(causes::NO_SUCH, format!("has `{name}`, which is not searched for"));
    let failure = failure.cause(format!("what is searched for is {}", listed(known, "and")));
    failure.hint(did_you_mean(name, known.iter().map(String::as_str)).unwrap_or_else(|| "remove it".into()))
}
