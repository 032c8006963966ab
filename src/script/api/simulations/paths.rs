//! `sim.follow_load`: equilibria along a load as an object with the columns of a history, states, and points where stability is lost.

use std::rc::Rc;

use super::handle::SimulationHandle;
use super::history::unknown_column;
use super::settling::push_equilibrium;
use super::states::StateHandle;
use crate::dynamics::{CriticalKind, LedgerRow, Path, PathEnd, PathError, PathOptions};
use crate::output::History;
use crate::script::api::examples::plate_example;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::{brief, number_text};
use crate::script::language::prelude::*;

/// Default number of load increments up to the end of a path.
const INCREMENTS: f64 = 20.0;

/// Largest number of points of a path.
const MOST: f64 = 100_000.0;

/// Equilibria of a simulation along a load.
#[derive(Clone)]
pub struct PathHandle {
    path: Rc<Path>,
    /// Rows of the path, with times in the units of the script.
    rows: Rc<Vec<LedgerRow>>,
    /// History before the path.
    before: History,
    simulation: SimulationHandle,
}

impl Handle for PathHandle {
    const NAME: &'static str = "Path";
    const MAKER: &'static str = "make one with `sim.follow_load(#{ load: 1.0 })`";

    fn describe(&self) -> String {
        let (first, last) = (&self.rows[0], &self.rows[self.rows.len() - 1]);
        let mut lines = vec![format!(
            "path of {} equilibria of \"{}\" from t = {} to {}, {}",
            self.rows.len(),
            self.simulation.0.name,
            brief(first.time),
            brief(last.time),
            end_of(&self.path.end)
        )];
        for point in &self.path.critical {
            lines.push(format!("  {} at t = {} after point {}", kind_of(point.kind), brief(self.script_time(point.load)), point.after));
        }
        lines.join("\n")
    }
}

impl PathHandle {
    fn script_time(&self, time: f64) -> f64 {
        self.simulation.0.script_time(time)
    }
}

fn kind_of(kind: CriticalKind) -> &'static str {
    match kind {
        CriticalKind::Limit => "limit point",
        CriticalKind::Bifurcation => "bifurcation",
    }
}

fn end_of(end: &PathEnd) -> &'static str {
    match end {
        PathEnd::Reached => "reached",
        PathEnd::Points => "points used up",
        PathEnd::Lost(_) => "lost",
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![follow_load(), column(), critical(), unstable(), end(), state()]
}

fn path_example(line: &str) -> std::borrow::Cow<'static, str> {
    plate_example(&format!(
        "press.fix(plate.boundary(\"left\"));\npress.force(plate.boundary(\"right\"), [0.0, -1e3], |t| t);\n\
         let sim = simulate(press, #{{ integrator: energy_momentum(), dt: 0.001 }});\n\
         let path = sim.follow_load(#{{ load: 1.0, increment: 0.25 }});\n{line}"
    ))
}

fn follow_load() -> Function {
    let options = vec![
        Parameter::number("load", "time", Interval::Finite, "the load at which the path ends, as a time of the time functions"),
        Parameter::number("increment", "time", Interval::Positive, "the first increment; then they choose themselves")
            .otherwise("a twentieth of the way"),
        Parameter::integer("points", "equilibria at most").within(Interval::Closed(2.0, MOST)).or(1000),
        Parameter::flag(
            "arc_length",
            "whether a step has a given length in displacements, so that the load may fall and the path go back (snap-through, snap-back); \
             without it a step has a given load",
        )
        .or(true),
    ];
    method_of::<SimulationHandle>(Topic::Simulation, "follow_load")
        .summary(
            "follows equilibria along the load from the present state, without inertia: loads and prescribed motions are functions of \
             time, and time is the load; finds limit points and bifurcations; the simulation stays where it is, and `restore` goes to a \
             state of the path",
        )
        .parameters(vec![Parameter::options("how far, and how").keys(options)])
        .see_also(&["settle", "modes", "restore", "plot_curves"])
        .example(path_example("print(path);\nprint(path.time);\nsim.restore(path.state(-1));"))
        .body_with_options(|call, handle, options| {
            handle.refuse_nested(call)?;
            handle.refuse_in_check(call)?;
            handle.looked()?;
            let options = path_options(&handle, &options)?;
            let found = handle.found(call, "equilibria", |simulation| simulation.path(&options, &mut |_| ()))?;
            let path = found.map_err(|error| refused(call, &handle, error))?;
            if let PathEnd::Lost(cause) = &path.end {
                let load = path.points.last().map_or(0.0, |point| handle.0.script_time(point.state.row.time));
                let warning = Diagnostic::warning(format!("the path is lost at t = {}", brief(load)), call.place(&Target::Call));
                let hint = if options.by_arc {
                    "take a smaller `increment`"
                } else {
                    "beyond a limit point there may be no equilibrium nearby: follow the path with `arc_length: true`"
                };
                call.host.warn(warning.code("C0733").cause(format!("no further equilibrium was found: {cause}")).hint(hint));
            }
            let rows = path.points.iter().map(|point| handle.0.script_row(point.state.row.clone())).collect();
            let before = handle.0.history.borrow().clone();
            let path = PathHandle { path: Rc::new(path), rows: Rc::new(rows), before, simulation: handle };
            Ok(path)
        })
}

/// Options of a path from the arguments of a call; times are those of the solver, whose unit may differ from that of the script.
fn path_options(handle: &SimulationHandle, options: &Options) -> Result<PathOptions, Failure> {
    let (until, given) = (options.number("load")?, options.argument("increment"));
    let now = handle.0.simulation.try_borrow().map(|simulation| handle.0.script_time(simulation.time())).unwrap_or_default();
    if until == now {
        let argument = options.argument("load");
        let failure = argument.refuse(causes::TIME, format!("the simulation is at t = {} already", number_text(now)));
        return Err(failure.hint("give another time for the end of the path; `settle` finds the equilibrium of this one"));
    }
    let increment = if given.is_given() { given.number()? } else { (until - now).abs() / INCREMENTS };
    let points = options.argument("points").integer()? as usize;
    let [until, increment] = [until, increment].map(|time| handle.0.kernel_time(time));
    Ok(PathOptions { until, increment, points, by_arc: options.flag("arc_length")? })
}

/// Error message of a refused `follow_load`.
fn refused(call: &Call, handle: &SimulationHandle, error: PathError) -> Failure {
    let (title, code) = (error.to_string(), error.code());
    match error {
        PathError::Step(error) => handle.step_failure(call, error),
        PathError::Contact { .. } => {
            call.fail(title).code(code).hint("go along the load with `sim.settle(time)` in a loop, which follows contact")
        }
    }
}

fn column() -> Function {
    column_of::<PathHandle>(Topic::Results, "column")
        .summary("a column of the history of the path as an array: `path.time` is the load, `path[\"tip.uy\"]` what a probe sees")
        .parameters(vec![Parameter::text("name", "the name of the column")])
        .returns("Array")
        .see_also(&["follow_load", "history"])
        .example(path_example("print(path.strain);"))
        .body(|call, path| {
            let name = call.text("name")?;
            match path.simulation.column_of(&*path.rows, 0, &name) {
                Some(values) => Ok(array_of(values)),
                None => Err(unknown_column(call, &path.simulation, &name).into()),
            }
        })
}

fn property(name: &'static str, returns: &'static str, summary: &'static str, read: impl Fn(&PathHandle) -> Dynamic + 'static) -> Function {
    property_of::<PathHandle>(Topic::Results, name)
        .summary(summary)
        .returns(returns)
        .see_also(&["follow_load"])
        .example(path_example(&format!("print(path.{name});")))
        .body(move |_, path| Ok(read(&path)))
}

fn critical() -> Function {
    let summary = "where the stiffness is singular, an array of maps with `kind` (\"limit point\" where the load has an extremum, \
                   \"bifurcation\" where another path branches off), `load` (also as `time`, the name of the path's column) and `after`, \
                   the point before it";
    property("critical", "Array", summary, |path| {
        let of = |point: &crate::dynamics::CriticalPoint| {
            let load = path.script_time(point.load);
            map_of([
                ("kind", kind_of(point.kind).into()),
                ("load", load.into()),
                ("time", load.into()),
                ("after", (point.after as i64).into()),
            ])
        };
        array_of(path.path.critical.iter().map(of))
    })
}

fn unstable() -> Function {
    let summary = "in how many directions each equilibrium is unstable: 0 of stable ones, -1 where that could not be counted";
    property("unstable", "Array", summary, |path| {
        array_of(path.path.points.iter().map(|point| point.unstable.map_or(-1, |count| count as i64)))
    })
}

fn end() -> Function {
    let summary = "how the path ended: \"reached\", \"points used up\" or \"lost\"";
    property("end", "String", summary, |path| end_of(&path.path.end).into())
}

fn state() -> Function {
    method_of::<PathHandle>(Topic::Results, "state")
        .summary("the state of a point of the path, for `restore`: pictures, modes and motion go on from there, the path is their history")
        .parameters(vec![Parameter::integer("point", "number of the point, from 0; negative ones count from the end")])
        .see_also(&["follow_load", "restore", "modes"])
        .example(path_example("sim.restore(path.state(2));\nprint(sim.time);"))
        .body(|call, path| {
            let number = call.integer("point")?;
            let count = path.rows.len();
            let place = if number < 0 { number + count as i64 } else { number };
            let Some(index) = usize::try_from(place).ok().filter(|&index| index < count) else {
                let failure = call
                    .argument("point")
                    .refuse(causes::NO_SUCH, format!("there is no point {number}: they are numbered from 0 to {}", count - 1));
                return Err(failure.hint("`path.time.len()` is their number").into());
            };
            let mut history = path.before.clone();
            // The path begins at the equilibrium of the present time, which the history before need not have.
            push_equilibrium(&mut history, path.rows[0].clone());
            path.rows[1..=index].iter().for_each(|row| history.push(row.clone()));
            let state = path.path.points[index].state.clone();
            Ok(StateHandle::of(path.simulation, state, history))
        })
}
