//! `compare_integrators`: one model under several time integrators and step sizes, as a table, plots and a page.

use std::time::{Duration, Instant};

use rhai::EvalAltResult;

use super::record::{FAILURE, free_name, name_parameter};
use super::sweep::{closure_of, not_in_check};
use crate::dynamics::{LedgerRow, Options as KernelOptions, Simulation, StepError};
use crate::integrators::Scheme;
use crate::math::tolerances::NO_ENERGY;
use crate::output::{Curve, CurveStyle, Drawing, Plot, PlotAxis, RunFiles, rows_csv, study_page, svg};
use crate::script::api::files::failures::output_failure;
use crate::script::api::files::run_folder::RunFolder;
use crate::script::api::models::handle::ModelHandle;
use crate::script::api::nested_runs::begin_study;
use crate::script::api::simulations::integrators::{IntegratorHandle, title};
use crate::script::api::simulations::simulate::kernels;
use crate::script::api::simulations::step_control::{StepControlHandle, StepSize};
use crate::script::language::callback::Callback;
use crate::script::language::digits::brief;
use crate::script::language::failure::interrupted;
use crate::script::language::plain::Plain;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};

/// Ratio of the smallest step size to the step size of the reference run.
const FINER: f64 = 8.0;
/// Colors of the curves in a plot.
const COLORS: usize = 7;

/// Function `compare_integrators` of scripts.
pub fn compare_integrators() -> Function {
    function(Topic::Studies, "compare_integrators")
        .summary(
            "runs a model under several time integrators, and with several step sizes where `dt` is an array, and gives an array of rows: \
             `integrator`, `dt` (the mean of steps that choose their size), `time` (how far it came), `steps`, `energy_drift` (the largest \
             sum of what the integrator added to the energy or took, over the largest energy), `energy` (at the end), `momentum_defect` \
             and `angular_momentum_defect` (what neither loads nor supports explain), `iterations`, `factorizations`, `halvings`, \
             `seconds`, with several step sizes `error` (largest distance of a node at the end from the run of the first integrator with \
             an eighth of the smallest `dt`) and `order`, and `failure`, which is empty or says why it stopped. In the folder `studies` of \
             the run are the table, plots, and both as a page",
        )
        .parameters(vec![Parameter::options("what is run, and how")])
        .keys(vec![
            Parameter::new("model", Kind::Closure("||"), "gives the model; it is called for each run"),
            Parameter::array("integrators", "the time integrators"),
            Parameter::new("dt", Kind::Either("a number, `auto()`, or an array of them"), "the step size, or several").of("time"),
            Parameter::number("end", "time", Interval::Positive, "the time at which runs end"),
            Parameter::flag("settle", "whether runs begin with a static equilibrium").or(false),
            Parameter::integer("max_halvings", "how often a step that fails may be halved").within(Interval::Closed(0.0, 50.0)).or(7),
            name_parameter("integrators"),
        ])
        .returns("Array")
        .see_also(&["energy_momentum", "generalized_alpha", "sweep", "expect_order", "format_table"])
        .example(
            "fn flight() {\n    \
                  let rubber = neo_hookean(#{ youngs_modulus: 200.0, poisson_ratio: 0.3, density: 1.0 });\n    \
                  let sky = model(\"sky\");\n    \
                  let bar = sky.add_body(\"bar\", rectangle(#{ size: [3.0, 0.5], cells: [6, 1] }), rubber);\n    \
                  sky.initial_velocity(bar, #{ angular: 4.0 });\n    \
                  sky\n\
                  }\n\
                  let rows = compare_integrators(#{ model: || flight(), integrators: [energy_momentum(), hht()], dt: 0.02, end: 0.2 });\n\
                  print(format_table(rows, [\"integrator\", \"energy_drift\", \"iterations\", \"failure\"]));",
        )
        .body(run)
}

/// Parameters of a comparison.
struct Task<'a> {
    call: &'a Call<'a>,
    model: Callback,
    until: f64,
    settles: bool,
    max_halvings: usize,
}

/// Result of a run with one integrator and step size.
struct ComparedRun {
    integrator: Scheme,
    dt: f64,
    rows: Vec<LedgerRow>,
    /// Positions at the end of the run.
    positions: Vec<f64>,
    factorizations: usize,
    spent: Duration,
    failure: String,
    error: Option<f64>,
    order: Option<f64>,
}

fn run(call: &Call) -> Result<Dynamic, Box<EvalAltResult>> {
    let options = call.options("options")?;
    let integrators = integrators_of(&options)?;
    let sizes = sizes_of(&options)?;
    let task = Task {
        call,
        model: closure_of(call, &options, "model", "||")?,
        until: options.number("end")?,
        settles: options.flag("settle")?,
        max_halvings: options.integer("max_halvings")? as usize,
    };
    not_in_check(call, format!("would run {} integrators with {} step sizes", integrators.len(), sizes.len()))?;
    let name = free_name(call, &options)?;
    let mut courses = Vec::new();
    for integrator in &integrators {
        for size in &sizes {
            courses.push(task.run(*integrator, size)?);
        }
    }
    if sizes.len() > 1 {
        let finest = courses.iter().map(|course| course.dt).fold(f64::INFINITY, f64::min) / FINER;
        measure(&mut courses, &task.run(integrators[0], &StepSize::Fixed(finest))?);
    }
    let names = integrators.iter().map(|integrator| title(integrator).replace('_', " ")).collect::<Vec<_>>();
    if let Some(files) = RunFolder::of(call.host).files(call.host).map_err(|error| output_failure(&error))? {
        write(&files, &name, &courses, &names, &sizes).map_err(|error| output_failure(&error))?;
    }
    Ok(courses.iter().map(|course| Dynamic::from(course.map())).collect::<Array>().into())
}

/// Returns the integrators in the options.
fn integrators_of(options: &Options) -> Result<Vec<Scheme>, Failure> {
    let argument = options.argument("integrators");
    let entries = argument.array()?;
    if entries.is_empty() {
        return Err(argument
            .refuse(causes::EMPTY, "`integrators` of `compare_integrators` is empty")
            .hint("write `[energy_momentum(), hht()]`"));
    }
    let one = |(index, entry): (usize, &Dynamic)| {
        if entry.clone().try_cast::<IntegratorHandle>().is_some_and(|handle| handle.0.is_static()) {
            let failure = argument
                .refuse(causes::BODY_KIND, "`compare_integrators` compares motions, and `statics()` has none")
                .label(format!("entry {index}"));
            return Err(failure.hint("run it by itself: `simulate(model, #{ integrator: statics(), dt: 0.1 })`"));
        }
        entry.clone().try_cast::<IntegratorHandle>().map(|handle| handle.0).ok_or_else(|| {
            let failure = argument.refuse(causes::WRONG_TYPE, "`integrators` of `compare_integrators` must be an array of integrators");
            let given = describe(argument.call().engine(), entry);
            failure.label(format!("entry {index} is {given}")).hint("call each one: `[energy_momentum(), hht()]`")
        })
    };
    entries.iter().enumerate().map(one).collect()
}

/// Returns the step sizes, the largest first, then adaptive ones.
fn sizes_of(options: &Options) -> Result<Vec<StepSize>, Failure> {
    let argument = options.argument("dt");
    let value = argument.value();
    let one = |entry: &Dynamic| match entry.clone().try_cast::<StepControlHandle>() {
        Some(handle) => Some(StepSize::Chosen(handle)),
        None => as_number(entry).filter(|dt| *dt > 0.0 && dt.is_finite()).map(StepSize::Fixed),
    };
    let sizes = match value.read_lock::<Array>() {
        Some(array) => array.iter().map(one).collect::<Option<Vec<StepSize>>>(),
        None => one(&value).map(|size| vec![size]),
    };
    let Some(mut sizes) = sizes.filter(|sizes| !sizes.is_empty()) else {
        let failure =
            argument.refuse(causes::OUT_OF_RANGE, "`dt` of `compare_integrators` must be a positive number, `auto()`, or an array of them");
        let given = describe(argument.call().engine(), &value);
        return Err(failure.label(format!("this is {given}")).hint("write `0.01` or `[0.02, 0.01, 0.005]`"));
    };
    let key = |size: &StepSize| if let StepSize::Fixed(dt) = size { -dt } else { f64::INFINITY };
    sizes.sort_by(|a, b| key(a).total_cmp(&key(b)));
    sizes.dedup_by(|a, b| key(a) == key(b) && key(a).is_finite());
    Ok(sizes)
}

impl Task<'_> {
    /// Runs the model once; a failed run is a result, but a model that cannot be made is an error.
    fn run(&self, integrator: Scheme, size: &StepSize) -> Result<ComparedRun, Box<EvalAltResult>> {
        let call = self.call;
        let value = {
            let _aside = begin_study(call.host, None);
            self.model.call([])?
        };
        let Some(model) = value.clone().try_cast::<ModelHandle>() else {
            let failure =
                call.refuse(causes::WRONG_TYPE, format!("`model` of `compare_integrators` gives {}", describe(call.engine(), &value)));
            return Err(failure.hint(format!("let its last expression, without a semicolon, be a {}", ModelHandle::NAME)).into());
        };
        let mut kernel = KernelOptions::new(&integrator, 0.0);
        size.put_into(&mut kernel, 0.0);
        kernel.max_halvings = self.max_halvings;
        kernel.threads = call.host.settings.threads;
        kernel.interrupt = Some(call.host.settings.interrupt.clone());
        let model = model.0.borrow().clone();
        let mut simulation = kernels(call, &model.model, None, kernel)?;
        let (begun, mut rows) = (Instant::now(), vec![simulation.row().clone()]);
        call.host.observer.began(&format!("{} with dt = {size}", title(&integrator)));
        let outcome = self.steps(&mut simulation, &mut rows);
        call.host.observer.ended();
        let failure = match outcome {
            Ok(()) => String::new(),
            Err(StepError::Interrupted { .. }) => return Err(interrupted("interrupted in `compare_integrators`").into()),
            Err(error) => error.to_string(),
        };
        let dt = match size {
            StepSize::Fixed(dt) => *dt,
            StepSize::Chosen(_) => simulation.time() / (rows.len() - 1).max(1) as f64,
        };
        let (positions, factorizations) = (simulation.state().positions, simulation.statistics().factorizations);
        Ok(ComparedRun { integrator, dt, rows, positions, factorizations, spent: begun.elapsed(), failure, error: None, order: None })
    }

    fn steps(&self, simulation: &mut Simulation, rows: &mut Vec<LedgerRow>) -> Result<(), StepError> {
        if self.settles {
            simulation.settle()?;
            *rows = vec![simulation.row().clone()];
        } else {
            simulation.check_apart()?;
        }
        while simulation.time() < self.until {
            simulation.step(Some(self.until), &mut |row| rows.push(row.clone()))?;
        }
        Ok(())
    }
}

/// Computes errors of the completed runs, and orders between the step sizes of each integrator.
fn measure(courses: &mut [ComparedRun], reference: &ComparedRun) {
    for course in courses.iter_mut().filter(|course| course.failure.is_empty() && reference.failure.is_empty()) {
        let distance = course.positions.iter().zip(&reference.positions).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        course.error = Some(distance);
    }
    for index in 1..courses.len() {
        let [coarse, fine] = [&courses[index - 1], &courses[index]];
        if let (true, Some(a), Some(b)) = (coarse.integrator == fine.integrator, coarse.error, fine.error) {
            courses[index].order = Some((a / b).ln() / (coarse.dt / fine.dt).ln()).filter(|order| order.is_finite());
        }
    }
}

impl ComparedRun {
    fn is_measured(&self) -> bool {
        self.error.is_some()
    }

    fn scale(&self) -> f64 {
        self.rows.iter().map(|row| row.kinetic + row.strain.abs() + row.potential.abs()).fold(NO_ENERGY, f64::max)
    }

    /// Returns the accumulated energy defect up to each row, relative to the largest energy.
    fn drifts(&self) -> Vec<f64> {
        let scale = self.scale();
        let mut sum = 0.0;
        let add = |row: &LedgerRow| {
            sum += row.energy_defect;
            sum / scale
        };
        self.rows.iter().map(add).collect()
    }

    fn last(&self) -> &LedgerRow {
        &self.rows[self.rows.len() - 1]
    }

    fn worst(&self, of: fn(&LedgerRow) -> f64) -> f64 {
        self.rows.iter().map(of).fold(0.0, f64::max)
    }

    fn sum(&self, of: fn(&LedgerRow) -> usize) -> f64 {
        self.rows[1..].iter().map(of).sum::<usize>() as f64
    }

    /// Returns the columns of the run except wall-clock times; `error` and `order` only if known.
    fn columns(&self) -> Vec<(&'static str, f64)> {
        let mut columns = vec![
            ("dt", self.dt),
            ("time", self.last().time),
            ("steps", (self.rows.len() - 1) as f64),
            ("energy_drift", self.drifts().iter().fold(0.0, |worst, drift| f64::max(worst, drift.abs()))),
            ("energy", self.last().total()),
            ("momentum_defect", self.worst(|row| row.momentum_defect)),
            ("angular_momentum_defect", self.worst(|row| row.angular_momentum_defect)),
            ("iterations", self.sum(|row| row.newton_iterations)),
            ("factorizations", self.factorizations as f64),
            ("halvings", self.sum(|row| row.halvings)),
        ];
        columns.extend(self.error.map(|error| ("error", error)));
        columns.extend(self.order.map(|order| ("order", order)));
        columns
    }

    fn map(&self) -> Map {
        let counts = ["steps", "iterations", "factorizations", "halvings"];
        let value = |name: &str, value: f64| if counts.contains(&name) { Dynamic::from(value as i64) } else { value.into() };
        let mut map: Map = self.columns().into_iter().map(|(name, number)| (name.into(), value(name, number))).collect();
        map.insert("integrator".into(), title(&self.integrator).into());
        map.insert("seconds".into(), self.spent.as_secs_f64().into());
        map.insert(FAILURE.into(), self.failure.clone().into());
        map
    }

    /// Returns the fields of the run in the order of the columns `names`.
    fn fields(&self, names: &[&str], text: fn(f64) -> String) -> Vec<String> {
        let columns = self.columns();
        let field = |name: &&str| match *name {
            "integrator" => title(&self.integrator),
            FAILURE => self.failure.clone(),
            name => columns.iter().find(|(known, _)| *known == name).map_or(String::new(), |(_, value)| text(*value)),
        };
        names.iter().map(field).collect()
    }
}

/// Writes the table, the plots and the page.
fn write(
    files: &RunFiles,
    name: &str,
    courses: &[ComparedRun],
    labels: &[String],
    sizes: &[StepSize],
) -> Result<(), crate::output::OutputError> {
    let mut header = vec!["integrator"];
    let widest = courses.iter().map(ComparedRun::columns).max_by_key(Vec::len).unwrap_or_default();
    header.extend(widest.iter().map(|(name, _)| *name));
    header.push(FAILURE);
    let exact: Vec<Vec<String>> = courses.iter().map(|course| course.fields(&header, |value| Plain::Number(value).field())).collect();
    files.write(&format!("studies/{name}.csv"), rows_csv(&header.iter().map(|name| (*name).to_string()).collect::<Vec<_>>(), &exact))?;
    let plots = plots(courses, labels, sizes);
    for (what, drawing) in &plots {
        files.write(&format!("studies/{name}-{what}.svg"), svg(drawing))?;
    }
    let shown: Vec<Vec<String>> = courses.iter().map(|course| course.fields(&header, brief)).collect();
    let words: Vec<String> = header.iter().map(|name| name.replace('_', " ")).collect();
    let about = "What each integrator did to the energy and the momenta of the same model, and what that cost. Energy drift is what the \
                 integrator itself added or took, over the largest energy; work of loads, contact and friction is no drift.";
    let drawings: Vec<Drawing> = plots.into_iter().map(|(_, drawing)| drawing).collect();
    let page = study_page("Time integrators", about, &words.iter().map(String::as_str).collect::<Vec<_>>(), &shown, &drawings);
    files.write(&format!("studies/{name}.html"), page)?;
    Ok(())
}

/// Makes curves distinguishable: curves whose color repeats are dashed.
fn told_apart(curves: impl Iterator<Item = Curve>) -> Vec<Curve> {
    let styles = std::iter::repeat_n(CurveStyle::Line, COLORS).chain(std::iter::repeat(CurveStyle::Dashed));
    curves.zip(styles).map(|(curve, style)| Curve { style, ..curve }).collect()
}

/// Returns plots over time of the runs with the largest step size, and a work-precision diagram if there are several step sizes.
fn plots(courses: &[ComparedRun], labels: &[String], sizes: &[StepSize]) -> Vec<(&'static str, Drawing)> {
    let first: Vec<&ComparedRun> = courses.iter().step_by(sizes.len()).collect();
    let over_time = |title: &str, is_logarithmic: bool, of: &dyn Fn(&ComparedRun) -> Vec<f64>| {
        let curve = |(course, label): (&&ComparedRun, &String)| Curve {
            label: label.clone(),
            x: course.rows.iter().map(|row| row.time).collect(),
            y: of(course),
            ..Curve::default()
        };
        let axis = |label: &str, is_logarithmic| PlotAxis { label: label.into(), is_logarithmic, ..PlotAxis::default() };
        let curves = told_apart(first.iter().zip(labels).map(curve));
        let title = format!("{title}, dt = {}", sizes[0]);
        Plot { title, x: axis("time", false), y: axis("", is_logarithmic), curves, size: [760.0, 420.0] }.draw()
    };
    let each = |of: fn(&LedgerRow) -> f64| move |course: &ComparedRun| course.rows.iter().map(of).collect::<Vec<f64>>();
    let sums = |of: fn(&LedgerRow) -> f64| {
        move |course: &ComparedRun| {
            let mut sum = 0.0;
            let add = |row: &LedgerRow| {
                sum += of(row);
                sum
            };
            course.rows.iter().map(add).collect::<Vec<f64>>()
        }
    };
    let turn = |row: &LedgerRow| row.column("angular_momentum").unwrap_or(f64::NAN);
    let mut all = vec![
        ("energy", over_time("total energy", false, &each(LedgerRow::total))),
        (
            "drift",
            over_time("size of the energy drift, over the largest energy", true, &|course| {
                course.drifts().into_iter().map(f64::abs).collect()
            }),
        ),
        ("angular-momentum", over_time("angular momentum", false, &each(turn))),
        ("iterations", over_time("Newton iterations so far", false, &sums(|row| row.newton_iterations as f64))),
    ];
    if courses.iter().any(ComparedRun::is_measured) {
        let curve = |(courses, label): (&[ComparedRun], &String)| {
            let known: Vec<&ComparedRun> = courses.iter().filter(|course| course.is_measured()).collect();
            let x = known.iter().map(|course| course.factorizations as f64).collect();
            Curve { label: label.clone(), x, y: known.iter().filter_map(|course| course.error).collect(), ..Curve::default() }
        };
        let axis = |label: &str| PlotAxis { label: label.into(), is_logarithmic: true, ..PlotAxis::default() };
        let curves = told_apart(courses.chunks(sizes.len()).zip(labels).map(curve));
        let title = "work against precision".to_string();
        let plot = Plot { title, x: axis("factorizations"), y: axis("error"), curves, size: [760.0, 420.0] };
        all.push(("work", plot.draw()));
    }
    all
}
