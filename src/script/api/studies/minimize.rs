//! `minimize`: the point at which a closure has its minimum, between bounds.
//!
//! The search method is in `math/minimize.rs`. Its first points do not depend on values, and are computed in parallel; all others one after
//! another. A failed point counts as worse than all others.

use rhai::{Engine, EvalAltResult};

use super::record::{FAILURE, Record, name_parameter};
use super::sweep::{not_in_check, threads, threads_parameter};
use super::vary::{Point, described, map, unknown};
use super::worker_pool::{Results, WorkerPool};
use crate::math::minimize::{End, Search, beginnings};
use crate::math::tolerances::MINIMIZED;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::{brief, number_text};
use crate::script::language::failure::Class;
use crate::script::language::plain::Plain;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};
use crate::script::language::wording::listed;
use crate::script::language::worker_pool::{Computed, Outcome};

/// Default of the largest number of evaluations per variable.
const EVALUATIONS: usize = 100;

/// Function `minimize` of scripts.
pub fn minimize() -> Function {
    function(Topic::Studies, "minimize")
        .summary(
            "the point between bounds at which a closure gives the least number, by BOBYQA (Powell 2009): quadratic models through values, \
             no derivatives, no chance; it finds the minimum of the valley it begins in. A map with the point `best`, its `value`, whether \
             it `converged` and the `reason` of the end, `evaluations`, `failures`, the names whose best value is `at_bounds`, and the \
             `course`: a row for each evaluation, also in `studies/minimize.csv` as they come",
        )
        .parameters(vec![
            Parameter::new("run", Kind::Closure("|p|"), "computes the number for a point, whose values are `p.E`, …"),
            Parameter::options("where it searches").keys(options()),
        ])
        .returns("Map")
        .see_also(&["sweep", "compare", "read_csv", "fit"])
        .example(
            "let found = minimize(|p| (1.0 - p.x) ** 2.0 + 100.0 * (p.y - p.x ** 2.0) ** 2.0, #{\n    \
                  start: #{ x: -1.2, y: 1.0 },\n    \
                  bounds: #{ x: [-2.0, 2.0], y: [-2.0, 2.0] },\n\
                  });\n\
                  print(`${found.best} after ${found.evaluations} evaluations: ${found.reason}`);\n\
                  expect_close(found.best.x, 1.0, #{ absolute: 1e-4 });",
        )
        .body(run_minimize)
}

fn options() -> Vec<Parameter> {
    vec![
        Parameter::new("bounds", Kind::Either("a map of pairs `#{ E: [0.1, 10.0] }`"), "the least and the largest value of each variable"),
        Parameter::new("start", Kind::Either("a map of numbers `#{ E: 1.0 }`"), "values to begin with")
            .otherwise("the middle of the bounds"),
        Parameter::number("step", "1", Interval::Open(0.0, 0.5), "the first distance between points, as a share of each range").or(0.1),
        Parameter::number("tolerance", "1", Interval::Open(0.0, 0.5), "the last distance between points, as a share of each range")
            .or(MINIMIZED),
        Parameter::number("target", "any", Interval::Finite, "a value that is good enough").otherwise("none"),
        Parameter::integer("evaluations", "how often the closure is called at most")
            .within(Interval::Closed(4.0, 1e6))
            .otherwise("100 for each variable"),
        threads_parameter(),
        name_parameter("minimize"),
    ]
}

fn run_minimize(call: &Call) -> Result<Dynamic, Box<EvalAltResult>> {
    let options = call.options("options")?;
    let (names, search) = search(&options)?;
    let begun = search.clone();
    let first = call.host.watched(move || begun.first_points())?;
    let callback = call.callback("run")?;
    let threads = threads(call, &options)?.min(first.len());
    not_in_check(call, format!("would search for the least value over {}", listed(&names, "and")))?;
    let record = Record::begin(call, &options)?;
    let mut worker_pool = WorkerPool::new(call, callback, read, threads);
    let is_apart = worker_pool.is_apart();
    let mut evaluations = Evaluations { call, names: &names, record, is_apart, rows: Vec::new(), pending: Vec::new() };
    let mut failed = None;
    evaluations.compute(&mut worker_pool, &first)?;
    if evaluations.best().is_none() {
        return Err(evaluations.failure().into());
    }
    let observer = call.host.observer.clone();
    let searched = search.clone();
    // With hundreds of variables the search method takes seconds from one point to the next.
    let method = move |ask: &dyn Fn(Vec<f64>) -> Option<Option<f64>>| searched.minimize(|point| ask(point.to_vec()).flatten());
    let end = call.host.consulted(method, |point| {
        if evaluations.value(&point).is_none() {
            let least = evaluations.best().map_or(f64::NAN, |row| row.value);
            observer.began(&format!("minimize: evaluation {}, least value {}", evaluations.rows.len() + 1, brief(least)));
            failed = evaluations.compute(&mut worker_pool, std::slice::from_ref(&point)).err();
        }
        if failed.is_some() { None } else { evaluations.value(&point) }
    });
    observer.ended();
    if let Some(failure) = failed {
        return Err(failure.into());
    }
    drop(worker_pool);
    let end = end?.ok_or_else(|| call.fail("these numbers define no search").hint("choose a `tolerance` below `step`"))?;
    evaluations.warn(end, &search);
    Ok(evaluations.found(end, &search).into())
}

/// Names of the variables, and the search.
fn search(options: &Options) -> Result<(Vec<String>, Search), Failure> {
    let argument = options.argument("bounds");
    let wrong =
        || argument.wrong(causes::WRONG_TYPE, "must be a map of pairs of numbers").hint("write `#{ E: [0.1, 10.0], nu: [0.0, 0.49] }`");
    let value = argument.value();
    let bounds = value.read_lock::<Map>().map(|map| map.clone()).filter(|map| !map.is_empty()).ok_or_else(wrong)?;
    let (mut names, mut lower, mut upper) = (Vec::new(), Vec::new(), Vec::new());
    for (name, pair) in &bounds {
        let numbers = pair.read_lock::<Array>().map(|pair| pair.iter().map(as_number).collect::<Option<Vec<f64>>>());
        let Some([low, high]) = numbers.flatten().and_then(|pair| <[f64; 2]>::try_from(pair).ok()) else {
            return Err(wrong().label(format!("`{name}` is {}", describe(argument.call().engine(), pair))));
        };
        if !(low < high && (high - low).is_finite()) {
            let failure = argument.refuse(causes::ORDER, format!("the bounds of `{name}` must be finite, the lower one first"));
            return Err(failure.label(format!("these are {} and {}", number_text(low), number_text(high))).hint("write `[0.1, 10.0]`"));
        }
        if name == FAILURE || name == "value" || name == "evaluation" {
            return Err(argument
                .refuse(
                    causes::NAME_TAKEN,
                    format!("`{name}` is not available as a variable: the rows of the search have a column of this name"),
                )
                .hint("choose another name"));
        }
        names.push(name.to_string());
        lower.push(low);
        upper.push(high);
    }
    let start = start(&options.argument("start"), &names, &lower, &upper)?;
    let (step, tolerance) = (options.number("step")?, options.number("tolerance")?);
    if tolerance >= step {
        let failure = options.argument("tolerance").refuse(causes::ORDER, "`tolerance` of `minimize` must be less than `step`");
        return Err(failure.cause(format!("`step` is {}", number_text(step))).hint("give a smaller `tolerance`"));
    }
    let most = options.argument("evaluations");
    let least = beginnings(names.len()) + 1;
    let count = if most.is_given() { most.integer()? as usize } else { EVALUATIONS * names.len() };
    if count < least {
        let failure =
            most.refuse(causes::COUNT, format!("`evaluations` of `minimize` must be at least {least} for {} variables", names.len()));
        return Err(failure.cause(format!("the search begins with {} points", least - 1)).hint(format!("give {} or more", 2 * least)));
    }
    let target = options.optional_number("target")?;
    Ok((names, Search { start, lower, upper, step, tolerance, most: count, target }))
}

fn start(argument: &Argument, names: &[String], lower: &[f64], upper: &[f64]) -> Result<Vec<f64>, Failure> {
    if !argument.is_given() {
        return Ok(lower.iter().zip(upper).map(|(low, high)| 0.5 * low + 0.5 * high).collect());
    }
    let value = argument.value();
    let Some(map) = value.read_lock::<Map>() else {
        return Err(argument.wrong(causes::WRONG_TYPE, "must be a map of numbers").hint("write `#{ E: 1.0, nu: 0.3 }`"));
    };
    if let Some(name) = map.keys().find(|name| !names.iter().any(|known| known == name.as_str())) {
        return Err(unknown(argument, name, names));
    }
    let number = |(index, name): (usize, &String)| {
        let Some(number) = map.get(name.as_str()).and_then(as_number) else {
            return Err(argument.wrong(causes::NO_SUCH, format!("has no number `{name}`")).hint(format!("write `{name}: 1.0`")));
        };
        let (low, high) = (lower[index], upper[index]);
        if (low..=high).contains(&number) {
            return Ok(number);
        }
        let failure = argument.refuse(causes::ORDER, format!("`{name}` of {} lies beyond its bounds", argument.title()));
        let failure = failure.label(format!("this is {}", number_text(number)));
        Err(failure.cause(format!("its bounds are {} and {}", number_text(low), number_text(high))).hint("begin between them"))
    };
    names.iter().enumerate().map(number).collect()
}

/// Converts the value of a closure, which must be a number.
fn read(engine: &Engine, value: &Dynamic) -> Result<Plain, Failure> {
    as_number(value).map(Plain::Number).ok_or_else(|| {
        let failure =
            Failure::script("the closure must give a number").code(causes::CLOSURE).label(format!("it gives {}", describe(engine, value)));
        failure.hint(if value.is_unit() {
            "let the last expression of the closure, without a semicolon, be the result"
        } else {
            "give what is to become small, such as `compare(measured, computed).mean_square`"
        })
    })
}

/// Evaluation of the closure at a point.
struct Row {
    point: Vec<f64>,
    /// Value of the closure; NaN if it failed.
    value: f64,
    failure: String,
    class: Class,
}

/// The evaluations so far.
struct Evaluations<'a> {
    call: &'a Call<'a>,
    names: &'a [String],
    record: Record,
    is_apart: bool,
    rows: Vec<Row>,
    /// Points being computed.
    pending: Vec<Vec<f64>>,
}

impl Results for Evaluations<'_> {
    fn known(&self, point: &[Plain]) -> Option<Computed> {
        self.record.known(point)
    }

    fn computed(&mut self, point: &[Plain], computed: &Computed) -> Result<(), Failure> {
        if self.is_apart { self.record.keep(self.call.host, point, computed) } else { Ok(()) }
    }

    fn take(&mut self, index: usize, outcome: Outcome) -> Result<(), Failure> {
        let (value, failure, class) = match outcome {
            Outcome::Done(value) => (value.number().unwrap_or(f64::NAN), String::new(), Class::Numerics),
            Outcome::Failed(message) => (f64::NAN, message.line(&self.call.host.sources), message.class),
            Outcome::Refused(message) => return Err(message.failure_of(|title| self.call.argument("run").fail(title))),
        };
        let is_lost = failure.is_empty() && !value.is_finite();
        let failure = if is_lost { format!("the closure gives {}", number_text(value)) } else { failure };
        let row = Row { point: self.pending[index].clone(), value: if is_lost { f64::NAN } else { value }, failure, class };
        self.record.add(&self.fields(self.rows.len(), &row), &row.failure)?;
        self.rows.push(row);
        Ok(())
    }
}

impl Evaluations<'_> {
    fn compute(&mut self, worker_pool: &mut WorkerPool, points: &[Vec<f64>]) -> Result<(), Failure> {
        self.pending = points.to_vec();
        let arguments: Vec<Vec<Plain>> = points.iter().map(|point| vec![map(&self.named(point))]).collect();
        worker_pool.compute("minimize", &arguments, self)
    }

    fn named(&self, point: &[f64]) -> Point {
        self.names.iter().cloned().zip(point.iter().copied().map(Plain::Number)).collect()
    }

    fn fields(&self, index: usize, row: &Row) -> Point {
        let number = [("evaluation".to_string(), Plain::Whole(index as i64 + 1))].into_iter();
        let value = if row.value.is_nan() { Plain::Nothing } else { Plain::Number(row.value) };
        number.chain(self.named(&row.point)).chain([("value".to_string(), value)]).collect()
    }

    /// Returns the row with the least value, the first of several.
    fn best(&self) -> Option<&Row> {
        self.rows.iter().filter(|row| !row.value.is_nan()).reduce(|best, row| if row.value < best.value { row } else { best })
    }

    /// Returns the value of a computed point for the search; for a failed point, a value worse than all others.
    fn value(&self, point: &[f64]) -> Option<f64> {
        let row = self.rows.iter().find(|row| row.point == point)?;
        if !row.value.is_nan() {
            return Some(row.value);
        }
        let sound = || self.rows.iter().map(|row| row.value).filter(|value| !value.is_nan());
        let (least, largest) = (sound().fold(f64::INFINITY, f64::min), sound().fold(f64::NEG_INFINITY, f64::max));
        Some(if largest > least { largest + (largest - least) } else { largest + largest.abs().max(1.0) })
    }

    /// Returns the failure of a search whose first points all fail.
    fn failure(&self) -> Failure {
        let failure = self.call.argument("run").fail(format!("all {} points with which `minimize` begins fail", self.rows.len()));
        let failure = match self.rows.first() {
            Some(row) => failure.cause(format!("the first one, {}: {}", described(&self.named(&row.point)), row.failure)),
            None => failure,
        };
        let class = self.rows.first().map_or(Class::Script, |row| row.class);
        let failure = failure.hint("begin where the closure can be computed, with `start` and a smaller `step`");
        if class == Class::Script { failure } else { failure.of_class(class) }
    }

    fn warn(&self, end: End, search: &Search) {
        let host = self.call.host;
        let place = self.call.place(&Target::Call);
        let failed: Vec<&Row> = self.rows.iter().filter(|row| row.value.is_nan()).collect();
        if let Some(first) = failed.first() {
            let title = format!("{} of {} evaluations of `minimize` failed", failed.len(), self.rows.len());
            let warning = Diagnostic::warning(title, place.clone());
            let warning = warning.code("C1062").cause(format!("{}: {}", described(&self.named(&first.point)), first.failure));
            host.warn(warning.hint("they count as worse than all others; narrower bounds keep the search away from there"));
        }
        let mut values = self.rows.iter().map(|row| row.value).filter(|value| !value.is_nan());
        let first = values.next();
        if first.is_some_and(|first| values.clone().count() > 0 && values.all(|value| value == first)) {
            let title = format!("all {} evaluations of `minimize` give {}", self.rows.len(), brief(first.unwrap_or_default()));
            let warning = Diagnostic::warning(title, place.clone())
                .code("C1063")
                .cause("no value is better than another one, so `best` is only where the search was");
            host.warn(warning.hint(format!("let the closure depend on {}", listed(self.names, "and"))));
        }
        if end == End::Evaluations {
            let title = format!("`minimize` has not converged within {} evaluations", search.most);
            host.warn(Diagnostic::warning(title, place).code("C1064").hint("allow more `evaluations`, or accept a larger `tolerance`"));
        }
    }

    /// Returns the result as a map for the script.
    fn found(&self, end: End, search: &Search) -> Map {
        let Some(best) = self.best() else { return Map::new() };
        let reason = match end {
            End::Converged => "converged",
            End::Target => "target",
            End::Evaluations => "evaluations",
            End::RoundOff | End::Stopped => "round-off",
        };
        let is_at_bound = |index: &usize| [search.lower[*index], search.upper[*index]].contains(&best.point[*index]);
        let at_bounds: Array = (0..self.names.len()).filter(is_at_bound).map(|index| self.names[index].as_str().into()).collect();
        let row = |(index, row): (usize, &Row)| {
            let mut fields: Map = self.fields(index, row).iter().map(|(name, value)| (name.as_str().into(), value.value())).collect();
            fields.insert(FAILURE.into(), row.failure.as_str().into());
            Dynamic::from(fields)
        };
        let course: Array = self.rows.iter().enumerate().map(row).collect();
        let failures = self.rows.iter().filter(|row| row.value.is_nan()).count();
        Map::from([
            ("best".into(), map(&self.named(&best.point)).value()),
            ("value".into(), best.value.into()),
            ("converged".into(), matches!(end, End::Converged | End::Target).into()),
            ("reason".into(), reason.into()),
            ("evaluations".into(), (self.rows.len() as i64).into()),
            ("failures".into(), (failures as i64).into()),
            ("at_bounds".into(), at_bounds.into()),
            ("course".into(), course.into()),
        ])
    }
}
