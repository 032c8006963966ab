//! `sweep`: a closure evaluated at many points, in parallel, with results as rows.

use rhai::{Engine, EvalAltResult, FnPtr};

use super::record::{FAILURE, Record, name_parameter};
use super::vary::{Point, described, map, points};
use super::worker_pool::{Results, WorkerPool};
use crate::script::language::callback::Callback;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::failure::Class;
use crate::script::language::message::Message;
use crate::script::language::plain::Plain;
use crate::script::language::prelude::*;
use crate::script::language::settings::worthwhile;
use crate::script::language::values::describe;
use crate::script::language::wording::listed;
use crate::script::language::worker_pool::{Computed, Outcome};

/// Largest number of threads of a study.
const MOST_THREADS: f64 = 1024.0;

/// Function `sweep` of scripts.
pub fn sweep() -> Function {
    function(Topic::Studies, "sweep")
        .summary(
            "calls a closure for many points, several at a time, and gives an array of rows in the order of the points: each is a map with \
             the point's values, what the closure gave (`value`, or the keys of the map that it gave), and `failure`, which is empty or \
             says why the point failed. Simulations in it write no files; the rows are in `studies/sweep.csv` as they come",
        )
        .parameters(vec![Parameter::options("the points and what is done")])
        .keys(vec![
            Parameter::new(
                "vary",
                Kind::Either("a map of arrays `#{ dt: [0.01, 0.005] }` or an array of maps"),
                "what differs: of a map of arrays (or ranges, or single values) all combinations, names in the order of the alphabet, \
                     the last one runs fastest; an array of maps is the points as they are",
            ),
            Parameter::new(
                "run",
                Kind::Closure("|p|"),
                "computes a point, whose values are `p.dt`, …; gives a number, a string, an array or a map of such",
            ),
            Parameter::new("failures", Kind::Choice(&["keep", "stop"]), "whether a point that fails is a row, or ends the script")
                .or("keep"),
            threads_parameter(),
            name_parameter("sweep"),
        ])
        .returns("Array")
        .see_also(&["minimize", "format_table", "write_table", "compare", "plot_curves"])
        .example(
            "let rows = sweep(#{ vary: #{ n: [10, 100], rule: [\"left\", \"middle\"] }, run: |p| {\n    \
                  let offset = if p.rule == \"left\" { 0.0 } else { 0.5 };\n    \
                  let sum = 0.0;\n    \
                  for k in 0..p.n { sum += ((k + offset) / p.n) ** 2.0 / p.n; }\n    \
                  abs(sum - 1.0 / 3.0)\n\
                  } });\n\
                  print(format_table(rows));\n\
                  write_table(\"errors.csv\", rows);",
        )
        .body(run_sweep)
}

/// Description of the option `threads`.
pub fn threads_parameter() -> Parameter {
    Parameter::integer("threads", "points that are computed at a time; results do not depend on it")
        .within(Interval::Closed(1.0, MOST_THREADS))
        .otherwise("one for each processor; `conserva test` shares them among the tests")
}

/// Returns the number of threads from the options.
pub fn threads(call: &Call, options: &Options) -> Result<usize, Failure> {
    let argument = options.argument("threads");
    if argument.is_given() { Ok(worthwhile(argument.integer()? as usize)) } else { Ok(call.host.settings.workers) }
}

/// Returns the closure of one point in the options.
pub fn closure(call: &Call, options: &Options, name: &str) -> Result<Callback, Failure> {
    closure_of(call, options, name, "|p|")
}

/// Returns the closure in the options with the given parameters.
pub fn closure_of(call: &Call, options: &Options, name: &str, parameters: &str) -> Result<Callback, Failure> {
    let argument = options.argument(name);
    let function = argument.value().read_lock::<FnPtr>().map(|function| function.clone());
    let function = function.ok_or_else(|| argument.wrong_type())?;
    argument.check_parameters(&function, parameters)?;
    Ok(Callback::new(call, function))
}

/// In `conserva check`, lists the computation instead of running it; the script ends there.
pub fn not_in_check(call: &Call, line: String) -> Result<(), Failure> {
    if !call.host.is_check() {
        return Ok(());
    }
    call.host.findings.borrow_mut().push(line);
    let used = Failure::new(Class::ResultUsed, format!("the script uses what {} gives", call.function.title()));
    Err(used.placed(call.place(&Target::Call)))
}

fn run_sweep(call: &Call) -> Result<Dynamic, Box<EvalAltResult>> {
    let options = call.options("options")?;
    let points = points(&options.argument("vary"))?;
    let callback = closure(call, &options, "run")?;
    let threads = threads(call, &options)?;
    let stops = options.text("failures")? == "stop";
    let names: Vec<&str> = points[0].iter().map(|(name, _)| name.as_str()).collect();
    if let Some(name) = names.iter().find(|name| **name == FAILURE) {
        let failure = options
            .argument("vary")
            .refuse(causes::NAME_TAKEN, format!("`{name}` cannot be varied: this column has the cause of a failure"));
        return Err(failure.hint("choose another name").into());
    }
    not_in_check(call, format!("would compute {} points of {}", points.len(), listed(&names, "and")))?;
    let record = Record::begin(call, &options)?;
    let mut worker_pool = WorkerPool::new(call, callback, read, threads.min(points.len()));
    let is_apart = worker_pool.is_apart();
    let mut rows = Rows { call, options: &options, points: &points, record, is_apart, stops, rows: Vec::new(), failed: Vec::new() };
    let arguments: Vec<Vec<Plain>> = points.iter().map(|point| vec![map(point)]).collect();
    worker_pool.compute("sweep", &arguments, &mut rows)?;
    drop(worker_pool);
    rows.warn_of_failures();
    Ok(rows.value())
}

/// Converts the value of a closure, which must be data.
fn read(engine: &Engine, value: &Dynamic) -> Result<Plain, Failure> {
    let plain = Plain::of(value).filter(|plain| *plain != Plain::Nothing);
    plain.ok_or_else(|| {
        let given = describe(engine, value);
        let failure = Failure::script("the closure must give a number, a string, an array or a map of such")
            .code(causes::CLOSURE)
            .label(format!("it gives {given}"));
        failure.hint(if value.is_unit() {
            "let the last expression of the closure, without a semicolon, be the result"
        } else {
            "give numbers of it, such as `sim.energy.total`, in a map: `#{ energy: sim.energy.total, time: sim.time }`"
        })
    })
}

/// The rows of a sweep so far.
struct Rows<'a> {
    call: &'a Call<'a>,
    options: &'a Options<'a>,
    points: &'a [Point],
    record: Record,
    is_apart: bool,
    stops: bool,
    /// Results of each point, and the cause of its failure; the cause is empty without a failure.
    rows: Vec<(Point, String)>,
    /// Points that failed, with the messages.
    failed: Vec<(usize, Message)>,
}

impl Results for Rows<'_> {
    fn known(&self, point: &[Plain]) -> Option<Computed> {
        self.record.known(point)
    }

    fn computed(&mut self, point: &[Plain], computed: &Computed) -> Result<(), Failure> {
        if self.is_apart { self.record.keep(self.call.host, point, computed) } else { Ok(()) }
    }

    fn take(&mut self, index: usize, outcome: Outcome) -> Result<(), Failure> {
        let host = self.call.host;
        let (results, failure) = match outcome {
            Outcome::Done(Plain::Map(results)) => (results, String::new()),
            Outcome::Done(value) => (vec![("value".to_string(), value)], String::new()),
            Outcome::Refused(message) => return Err(message.failure_of(|title| self.options.argument("run").fail(title))),
            Outcome::Failed(message) => {
                let line = message.line(&host.sources);
                self.failed.push((index, message));
                (Vec::new(), line)
            }
        };
        let point = &self.points[index];
        let is_taken = |name: &str| name == FAILURE || point.iter().any(|(known, _)| known == name);
        if let Some((name, _)) = results.iter().find(|(name, _)| is_taken(name)) {
            let failure =
                self.options.argument("run").refuse(causes::CLOSURE, format!("the closure gives `{name}`, which rows have already"));
            let failure = failure.cause(format!("rows have the point's values and `{FAILURE}`, the cause of a failure"));
            return Err(failure.hint("choose another name"));
        }
        self.record.add(point.iter().chain(&results), &failure)?;
        self.rows.push((results, failure));
        match self.failed.last() {
            Some((_, message)) if self.stops => {
                Err(message.failure(&host.sources).cause(format!("at the point {} of `sweep`", described(point))))
            }
            _ => Ok(()),
        }
    }
}

impl Rows<'_> {
    fn warn_of_failures(&self) {
        let Some((index, message)) = self.failed.first() else { return };
        let title = match (self.failed.len(), self.points.len()) {
            (count, all) if count == all => format!("all {all} points of `sweep` failed"),
            (count, all) => format!("{count} of {all} points of `sweep` failed"),
        };
        let first = format!("{}: {}", described(&self.points[*index]), message.line(&self.call.host.sources));
        let warning = Diagnostic::warning(title, self.call.place(&Target::Call)).code("C1061").cause(first);
        self.call.host.warn(warning.hint("the column `failure` has the causes; `failures: \"stop\"` ends the script at the first failure"));
    }

    /// Returns the rows for the script, all with equal keys; `()` for missing values.
    fn value(&self) -> Dynamic {
        let mut names: Vec<&String> = Vec::new();
        for (name, _) in self.rows.iter().flat_map(|(results, _)| results) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let row = |(point, (results, failure)): (&Point, &(Point, String))| {
            let mut row: Map = names.iter().map(|name| (name.as_str().into(), Dynamic::UNIT)).collect();
            row.extend(point.iter().chain(results).map(|(name, value)| (name.as_str().into(), value.value())));
            row.insert(FAILURE.into(), failure.into());
            Dynamic::from(row)
        };
        self.points.iter().zip(&self.rows).map(row).collect::<Array>().into()
    }
}
