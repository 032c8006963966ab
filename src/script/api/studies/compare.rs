//! `compare`: the distance between two curves.
//!
//! A curve is measured, computed by a simulation, or made by the script, and is linear between its points (`math/curves.rs`).

use rhai::EvalAltResult;

use crate::math::curves::{Distance, distance, overlap};
use crate::output::is_count;
use crate::script::api::simulations::handle::SimulationHandle;
use crate::script::api::simulations::history::unknown_column;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};
use crate::script::language::wording::listed;

/// Forms of a curve, for messages.
const CURVE: &str = "an array of pairs `[x, y]`, a map of arrays `#{ x, y }`, or a column `#{ of: sim, y: \"total\" }`";

/// Keys of a curve.
const KEYS: [&str; 3] = ["of", "x", "y"];

/// Function `compare` of scripts.
pub fn compare() -> Function {
    let end = |name, summary| Parameter::number(name, "any", Interval::Finite, summary).otherwise("where both are known");
    function(Topic::Studies, "compare")
        .summary(
            "the distance of two curves in their common range, linear between their points: a map with the largest difference `max` (its \
             size, in the unit of y) and where it is, `at` (in that of x); `mean`, `mean_square` and `rms` of the difference over the \
             range; `relative`, which is `rms` over that of the first curve; the range, `from` and `to`. Of two simulations all columns of \
             their histories are compared over time: a map of such maps by their names",
        )
        .parameters(vec![
            Parameter::new("first", Kind::Either(CURVE), "the first curve, or a simulation; what is measured or exact"),
            Parameter::new("second", Kind::Either(CURVE), "the second curve, or a simulation"),
            Parameter::options("what is compared").otherwise("everything that both have"),
        ])
        .keys(vec![
            end("from", "where the comparison begins"),
            end("to", "where it ends"),
            Parameter::array("columns", "names of the columns of two simulations").otherwise("all that both have, but for counts"),
        ])
        .returns("Map")
        .see_also(&["minimize", "read_csv", "plot_curves", "history"])
        .example(
            "let measured = [[0.0, 0.0], [0.5, 0.26], [1.0, 1.0]];\n\
                  let t = linspace(0.0, 1.0, 101);\n\
                  let found = compare(measured, #{ x: t, y: t.map(|t| t * t) });\n\
                  print(`${found.rms} rms, ${found.max} at ${found.at}`);",
        )
        .body(run_compare)
}

fn run_compare(call: &Call) -> Result<Dynamic, Box<EvalAltResult>> {
    let options = call.options("options")?;
    let (first, second) = (call.argument("first"), call.argument("second"));
    let simulation = |argument: &Argument| argument.value().try_cast::<SimulationHandle>();
    let chosen = options.argument("columns");
    match (simulation(&first), simulation(&second)) {
        (Some(a), Some(b)) => {
            let mut found = Map::new();
            for name in columns(call, &chosen, &a, &b)? {
                let curve = |argument: &Argument, handle: &SimulationHandle| column(argument, handle, "time", &name);
                let distance = between(&options, &curve(&first, &a)?, &curve(&second, &b)?)?;
                found.insert(name.as_str().into(), described(distance).into());
            }
            Ok(found.into())
        }
        _ if chosen.is_given() => {
            let failure = chosen.refuse(causes::OTHER_OWNER, "`columns` of `compare` are those of two simulations");
            Err(failure.hint("write `#{ of: sim, y: \"total\" }` for one column").into())
        }
        (a, b) => {
            if let Some(argument) = [(a, first), (b, second)].into_iter().find_map(|(handle, argument)| handle.map(|_| argument)) {
                let failure = argument.refuse(causes::OTHER_OWNER, "a simulation is compared with another one").label("only this is one");
                return Err(failure.hint("write `#{ of: sim, y: \"total\" }` for one of its columns").into());
            }
            let (first, second) = (call.argument("first"), call.argument("second"));
            Ok(described(between(&options, &curve(&first)?, &curve(&second)?)?).into())
        }
    }
}

fn described(found: Distance) -> Map {
    let rms = found.mean_square.sqrt();
    let relative = if rms == 0.0 { 0.0 } else { rms / found.scale.sqrt() };
    let entries = [
        ("max", found.largest.abs()),
        ("at", found.at),
        ("mean", found.mean),
        ("mean_square", found.mean_square),
        ("rms", rms),
        ("relative", relative),
        ("from", found.range[0]),
        ("to", found.range[1]),
    ];
    entries.into_iter().map(|(name, value)| (name.into(), value.into())).collect()
}

/// Distance of two curves in their common range, limited by the options.
fn between(options: &Options, a: &[[f64; 2]], b: &[[f64; 2]]) -> Result<Distance, Failure> {
    let range = |curve: &[[f64; 2]]| format!("from {} to {}", brief(curve[0][0]), brief(curve[curve.len() - 1][0]));
    let call = options.argument("from").call().refuse(causes::EMPTY, "the curves have no range in common");
    let apart = || call.clone().cause(format!("the first one goes {}", range(a))).cause(format!("the second one goes {}", range(b)));
    let Some([mut first, mut last]) = overlap(a, b) else { return Err(apart().hint("check that both have the same unit")) };
    if let Some(from) = options.optional_number("from")? {
        first = first.max(from);
    }
    if let Some(to) = options.optional_number("to")? {
        last = last.min(to);
    }
    if first > last {
        return Err(apart()
            .cause(format!("with `from` and `to`, {} to {} is left", brief(first), brief(last)))
            .hint("choose a wider range"));
    }
    Ok(distance(a, b, [first, last]))
}

/// Columns by which two simulations are compared.
fn columns(call: &Call, chosen: &Argument, a: &SimulationHandle, b: &SimulationHandle) -> Result<Vec<String>, Failure> {
    if !chosen.is_given() {
        let both = a.columns().into_iter().filter(|name| name != "time" && !is_count(name) && b.columns().contains(name));
        return Ok(both.collect());
    }
    let name = |entry: &Dynamic| {
        let name = entry.clone().into_string().map_err(|_| chosen.wrong_type())?;
        match [a, b].into_iter().find(|handle| !handle.columns().contains(&name)) {
            Some(handle) => Err(unknown_column(call, handle, &name).at(chosen.target())),
            None => Ok(name),
        }
    };
    chosen.array()?.iter().map(name).collect()
}

/// Returns a column of a history over another one.
fn column(argument: &Argument, handle: &SimulationHandle, x: &str, y: &str) -> Result<Vec<[f64; 2]>, Failure> {
    let call = argument.call();
    handle.refuse_in_check(call)?;
    let values = |name: &str| handle.column(name).ok_or_else(|| unknown_column(call, handle, name).at(argument.target()));
    rising(argument, values(x)?.into_iter().zip(values(y)?).map(|(x, y)| [x, y]).collect())
}

/// Curve in an argument.
fn curve(argument: &Argument) -> Result<Vec<[f64; 2]>, Failure> {
    let value = argument.value();
    if let Some(map) = value.read_lock::<Map>() {
        if let Some(unknown) = map.keys().find(|key| !KEYS.contains(&key.as_str())) {
            let failure =
                argument.refuse(causes::NO_SUCH, format!("a curve has no `{unknown}`")).cause(format!("it has {}", listed(&KEYS, "and")));
            return Err(failure.hint("choose the columns: `#{ x: table.time, y: table.force }`"));
        }
        let text = |name: &str| map.get(name).and_then(|value| value.clone().into_string().ok());
        if let Some(handle) = map.get("of").and_then(|value| value.clone().try_cast::<SimulationHandle>()) {
            let y = text("y").ok_or_else(|| {
                argument.refuse(causes::WRONG_TYPE, "a curve of a simulation needs the name of a column").hint("write `y: \"total\"`")
            })?;
            return column(argument, &handle, &text("x").unwrap_or_else(|| "time".into()), &y);
        }
        let numbers = |name: &str| map.get(name)?.read_lock::<Array>()?.iter().map(as_number).collect::<Option<Vec<f64>>>();
        let (Some(x), Some(y)) = (numbers("x"), numbers("y")) else {
            let failure = argument.refuse(causes::WRONG_TYPE, "a curve that is a map has arrays of numbers `x` and `y`");
            return Err(failure.hint("write `#{ x: [0.0, 1.0], y: [2.0, 3.0] }`"));
        };
        if x.len() != y.len() {
            let failure = argument.refuse(causes::COUNT, "`x` and `y` of a curve must have the same length");
            return Err(failure.cause(format!("`x` has {} numbers, `y` has {}", x.len(), y.len())).hint("give one `y` for each `x`"));
        }
        return rising(argument, x.into_iter().zip(y).map(|(x, y)| [x, y]).collect());
    }
    let pair = |entry: &Dynamic| -> Option<[f64; 2]> {
        entry.read_lock::<Array>()?.iter().map(as_number).collect::<Option<Vec<f64>>>()?.try_into().ok()
    };
    match value.read_lock::<Array>().and_then(|array| array.iter().map(pair).collect::<Option<Vec<_>>>()) {
        Some(points) => rising(argument, points),
        None => {
            let failure = argument.wrong(causes::WRONG_TYPE, format!("must be {CURVE}"));
            let given = describe(argument.call().engine(), &value);
            Err(failure.label(format!("this is {given}")).hint("write `[[0.0, 1.0], [0.5, 1.2]]`"))
        }
    }
}

/// Returns points without gaps; the last of several points at one position.
fn rising(argument: &Argument, points: Vec<[f64; 2]>) -> Result<Vec<[f64; 2]>, Failure> {
    let mut curve: Vec<[f64; 2]> = Vec::new();
    for [x, y] in points {
        if !x.is_finite() || y.is_nan() {
            continue;
        }
        match curve.last_mut() {
            Some(last) if last[0] == x => last[1] = y,
            Some(last) if last[0] > x => {
                let failure = argument.refuse(causes::ORDER, "the places `x` of a curve must increase");
                let failure = failure.cause(format!("after {} comes {}", brief(last[0]), brief(x)));
                return Err(failure.hint("sort the points: `points.sort(|a, b| if a[0] < b[0] { -1 } else { 1 })`"));
            }
            _ => curve.push([x, y]),
        }
    }
    if curve.is_empty() {
        return Err(argument.refuse(causes::EMPTY, "a curve without points cannot be compared").hint("give pairs `[x, y]` of numbers"));
    }
    Ok(curve)
}
