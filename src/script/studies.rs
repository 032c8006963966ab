//! Checks that run a scenario several times: `expect_order` with smaller and smaller steps, `expect_invariant` moved, turned or in other
//! units.
//!
//! The simulations of a study are aside of the run: they write no files and stand in no summary.

use rhai::{Array, Dynamic, EvalAltResult};

use super::arguments::{Arguments, Call, as_number, describe};
use super::checks::{failed, listed, passed};
use super::failure::Failure;
use super::motion::Motion;
use super::numbers::{brief, significant};
use super::registry::{Absent, Form, Function, Kind, Parameter, Topic, body, number_text};
use super::scan::Target;
use super::simulations::SimulationHandle;
use super::units::Units;
use crate::math::catalogue::Interval;

/// The functions of this topic.
pub fn functions() -> Vec<Function> {
    vec![expect_order(), expect_invariant()]
}

/// Differences relative to the values below this are round-off; no order can be read from them.
const ROUND_OFF: f64 = 1e-13;

fn expect_order() -> Function {
    Function {
        name: "expect_order",
        form: Form::Function,
        topic: Topic::Checks,
        summary: "runs a closure with smaller and smaller steps and ends the script with an error unless its result converges \
                  with an order",
        parameters: vec![
            Parameter::new(
                "action",
                Kind::Closure("|dt|"),
                "computes with a step size; gives a number, an array of numbers, or a simulation, whose final positions are compared",
            ),
            Parameter::number("order", "1", Interval::Positive, "the order: halving the step divides the error by 2^order"),
            Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::number("dt", "any", Interval::Positive, "the largest step size"),
                    Parameter::new("runs", Kind::Integer, "the number of step sizes, each half of the one before")
                        .within(Interval::Closed(2.0, 12.0))
                        .or(Absent::Integer(4)),
                    Parameter::new("exact", Kind::Any, "the exact result, a number or an array of numbers")
                        .or(Absent::Means("results of successive step sizes are compared")),
                    Parameter::number(
                        "tolerance",
                        "1",
                        Interval::Positive,
                        "the largest deviation of the last order from the expected one",
                    )
                    .or(Absent::Number(0.2)),
                ]),
                "the step sizes",
            ),
        ],
        returns: "",
        example: "// the midpoint rule for y' = y, from 0 to 1\n\
                  fn exponential(dt) {\n    \
                      let y = 1.0;\n    \
                      for step in 0..round(1.0 / dt).to_int() { y *= (1.0 + dt / 2.0) / (1.0 - dt / 2.0); }\n    \
                      y\n\
                  }\n\
                  expect_order(|dt| exponential(dt), 2.0, #{ dt: 0.1, exact: exp(1.0) });"
            .into(),
        see_also: &["expect_close", "expect_invariant"],
        body: body(|call| {
            let (order, options) = (call.number("order")?, call.options("options")?);
            let (largest, runs, tolerance) = (options.number("dt")?, options.integer("runs")?, options.number("tolerance")?);
            let exact = options.argument("exact");
            let exact = if exact.is_given() {
                let numbers = numbers_in(&exact.value());
                Some(numbers.ok_or_else(|| exact.fail("`exact` of `expect_order` must be a number or an array of numbers"))?)
            } else {
                None
            };
            if exact.is_none() && runs < 3 {
                let failure = options.argument("runs").fail("an order needs three runs, or the exact result and two");
                return Err(failure.hint("give `runs: 4`, or `exact: …`").into());
            }
            if listed(call, &format!("the closure converges with order {}", number_text(order))) {
                return Ok(Dynamic::UNIT);
            }
            let sizes: Vec<f64> = (0..runs).map(|run| largest / f64::powi(2.0, run as i32)).collect();
            let mut results = Vec::new();
            for &dt in &sizes {
                results.push(result_of(call, dt, exact.as_deref().or(results.first().map(Vec::as_slice)))?);
            }
            let errors: Vec<f64> = match &exact {
                Some(exact) => results.iter().map(|result| distance(result, exact)).collect(),
                None => results.windows(2).map(|pair| distance(&pair[0], &pair[1])).collect(),
            };
            let rates: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
            let last = rates.last().copied().unwrap_or(f64::NAN);
            let shown: Vec<String> = rates.iter().map(|rate| format!("{rate:.2}")).collect();
            let scale = results.iter().flatten().fold(0.0_f64, |scale, value| scale.max(value.abs()));
            if (last - order).abs() <= tolerance {
                let errors: Vec<String> = errors.iter().map(|error| significant(*error, 2)).collect();
                return passed(call, &format!("ok  converges with order {} (errors {})", shown.join(", "), errors.join(", ")));
            }
            let title = format!("the closure converges with order {}, not {}", significant(last, 3), number_text(order));
            let mut failure = failed(call, title).at(Target::Argument(0)).label(format!("tolerance {}", number_text(tolerance)));
            let word = if exact.is_some() { "error" } else { "difference to the next" };
            for (index, error) in errors.iter().enumerate() {
                let rate = index.checked_sub(1).map(|before| format!(", order {}", shown[before])).unwrap_or_default();
                failure = failure.cause(format!("dt = {}: {word} {}{rate}", brief(sizes[index]), significant(*error, 3)));
            }
            let hint = if errors.iter().any(|error| *error <= ROUND_OFF * scale) {
                "the results agree to round-off, where no order can be read: begin with a larger `dt`, or compare something else"
            } else if last < order {
                "begin with a smaller `dt` if the orders still rise; loads with kinks and contact that opens or closes lower the order"
            } else {
                "begin with a smaller `dt` if the orders still fall; the result may be better than the method"
            };
            Err(failure.hint(hint).into())
        }),
    }
}

fn numbers_in(value: &Dynamic) -> Option<Vec<f64>> {
    match as_number(value) {
        Some(number) => Some(vec![number]),
        None => value.read_lock::<Array>().and_then(|array| array.iter().map(as_number).collect()),
    }
}

/// The largest difference of two results.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0_f64, |largest, (a, b)| largest.max((a - b).abs()))
}

/// What the closure gives for a step size, as long as another result.
fn result_of(call: &Call, dt: f64, like: Option<&[f64]>) -> Result<Vec<f64>, Box<EvalAltResult>> {
    let action = call.callback("action")?;
    let value = {
        let _aside = call.host.study(None);
        action.call([Dynamic::from(dt)])?
    };
    let numbers = match value.clone().try_cast::<SimulationHandle>() {
        Some(handle) => Some(handle.with(call, |simulation| simulation.state().positions)?),
        None => numbers_in(&value),
    };
    let wrong = |title: &str, label: String| -> Box<EvalAltResult> {
        let failure = call.argument("action").fail(title).label(label);
        failure.hint("let the last expression of the closure, without a semicolon, be the result").into()
    };
    let Some(numbers) = numbers else {
        let given = describe(call.engine(), &value);
        return Err(wrong("the closure must give a number, an array of numbers, or a simulation", format!("this gives {given}")));
    };
    if numbers.iter().any(|number| !number.is_finite()) {
        return Err(wrong("the closure gives a number that is not finite", format!("at dt = {}", number_text(dt))));
    }
    if like.is_some_and(|like| like.len() != numbers.len()) {
        let (count, other) = (numbers.len(), like.map_or(0, <[f64]>::len));
        return Err(wrong("the results have different lengths", format!("{count} numbers at dt = {}, not {other}", number_text(dt))));
    }
    Ok(numbers)
}

fn expect_invariant() -> Function {
    let factor =
        |name: &'static str, summary: &'static str| Parameter::number(name, "1", Interval::Positive, summary).or(Absent::Number(1.0));
    Function {
        name: "expect_invariant",
        form: Form::Function,
        topic: Topic::Checks,
        summary: "runs a scenario as it is and again turned, moved or in other units, each by itself, and ends the script with an \
                  error when it moves otherwise",
        parameters: vec![
            Parameter::new(
                "action",
                Kind::Closure("||"),
                "builds a model, runs it and gives the simulation; while it is run again, `simulate` moves the whole model, and the script \
                 keeps its own clock",
            ),
            Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::number("rotate", "rad", Interval::Finite, "the angle by which the model is turned about the third axis")
                        .or(Absent::Means("not turned")),
                    Parameter::new("translate", Kind::Vector, "the vector by which it is moved")
                        .of("length")
                        .or(Absent::Means("not moved")),
                    Parameter::new(
                        "units",
                        Kind::Options(vec![
                            factor("mass", "how many new units of mass the old one is"),
                            factor("length", "how many new units of length the old one is"),
                            factor("time", "how many new units of time the old one is"),
                        ]),
                        "the new units",
                    )
                    .or(Absent::Means("the same units")),
                    Parameter::number("tolerance", "1", Interval::NonNegative, "the largest difference, relative to each quantity's size")
                        .or(Absent::Number(INVARIANT)),
                ]),
                "what is changed",
            ),
        ],
        returns: "",
        example:
            "fn flight() {\n    let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });\n    let sky = \
                  model(\"sky\");\n    let plate = sky.add_body(\"plate\", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), rubber);\n    \
                  sky.initial_velocity(plate, #{ linear: [1.0, 0.0], angular: 2.0 });\n    let sim = simulate(sky, #{ integrator: \
                  energy_momentum(), dt: 0.01 });\n    sim.run_to(0.1);\n    sim\n}\nexpect_invariant(|| flight(), #{ rotate: deg(30), \
                  translate: [1.0, 2.0], units: #{ length: 1000.0, time: 1000.0 } });"
                .into(),
        see_also: &["expect_order", "expect_conserved"],
        body: body(|call| {
            let options = call.options("options")?;
            let tolerance = options.number("tolerance")?;
            let mut motions = Vec::new();
            if let Some(angle) = options.optional_number("rotate")? {
                motions.push(Motion::rotation(angle));
            }
            let offset = options.argument("translate");
            if offset.is_given() {
                let length = offset.array()?.len();
                motions.push(Motion::translation(offset.vector(if length == 3 { 3 } else { 2 })?));
            }
            if options.argument("units").is_given() {
                let units = options.nested("units")?;
                let units = Units { mass: units.number("mass")?, length: units.number("length")?, time: units.number("time")? };
                motions.push(Motion::in_units(units));
            }
            if motions.is_empty() {
                let failure = call.argument("options").fail("`expect_invariant` changes nothing").label("names no change");
                return Err(failure.hint("give `rotate`, `translate` or `units`").into());
            }
            let changes: Vec<String> = motions.iter().map(Motion::describe).collect();
            if listed(call, &format!("the scenario moves the same {}", changes.join(" and "))) {
                return Ok(Dynamic::UNIT);
            }
            let original = scenario(call, None)?;
            let mut worst = Vec::new();
            for motion in motions {
                let moved = scenario(call, Some(motion))?;
                let (size, difference) = compare(call, &original, &moved, &motion)?;
                // in this order a difference that is no number does not pass
                if size <= tolerance {
                    worst.push(significant(size, 2));
                    continue;
                }
                let what = motion.describe();
                let failure =
                    failed(call, format!("the scenario is not the same when it is {what}").replace("is in other", "is written in other"));
                let failure = failure.at(Target::Argument(0)).label(format!("tolerance {}", number_text(tolerance)));
                return Err(failure
                    .cause(difference)
                    .hint("a motion that depends on where it happens has a direction or a size in it that is not that of the model")
                    .hint("where contact is chaotic, differences grow with time: compare a shorter run, or allow a larger `tolerance`")
                    .into());
            }
            passed(call, &format!("ok  the same {} (largest relative difference {})", changes.join(" and "), worst.join(", ")))
        }),
    }
}

/// Largest relative difference by default: Newton stops at a residual that can move 1e-9 of the motion, and rotations round.
const INVARIANT: f64 = 1e-7;

/// Runs the scenario, moved or not.
fn scenario(call: &Call, motion: Option<Motion>) -> Result<SimulationHandle, Box<EvalAltResult>> {
    let action = call.callback("action")?;
    let value = {
        let _aside = call.host.study(motion);
        action.call([])?
    };
    match value.clone().try_cast::<SimulationHandle>() {
        Some(handle) => Ok(handle),
        None => {
            let failure = call.argument("action").fail("the closure must give a simulation");
            let failure = failure.label(format!("this gives {}", describe(call.engine(), &value)));
            Err(failure.hint("let the last expression of the closure, without a semicolon, be the simulation").into())
        }
    }
}

/// The largest relative difference of two runs, and it in words.
fn compare(call: &Call, original: &SimulationHandle, moved: &SimulationHandle, motion: &Motion) -> Result<(f64, String), Failure> {
    let read =
        |handle: &SimulationHandle| handle.with(call, |simulation| (simulation.row().clone(), simulation.fields(), simulation.dimension()));
    let ((row, fields, dimension), (moved_row, moved_fields, _)) = (read(original)?, read(moved)?);
    let units = motion.units;
    let same_shape =
        fields.len() == moved_fields.len() && fields.iter().zip(&moved_fields).all(|(a, b)| a.displacement.len() == b.displacement.len());
    if !same_shape {
        let failure = call.argument("action").fail("the closure gives another model when it is called again");
        return Err(failure.label("not the same bodies").hint("build the same model on every call"));
    }
    let mut worst = (0.0, String::new());
    let mut note = |difference: f64, scale: f64, what: String| {
        let size = if difference == 0.0 { 0.0 } else { difference / scale };
        if size.is_nan() || size > worst.0 {
            worst = (size, format!("{what} differs by {} relative to {}", significant(size, 3), brief(scale)));
        }
    };
    note((row.time - moved_row.time / units.time).abs(), row.time.abs(), "the time reached".into());
    let energy = motion.energy(dimension);
    let total = row.kinetic.abs() + row.strain.abs();
    note((row.kinetic - moved_row.kinetic / energy).abs(), total, "the kinetic energy".into());
    note((row.strain - moved_row.strain / energy).abs(), total, "the strain energy".into());
    let scale_of = |pick: fn(&crate::dynamics::BodyFields) -> &Vec<[f64; 3]>| {
        fields.iter().flat_map(|body| pick(body).iter()).fold(0.0_f64, |scale, vector| scale.max(length(*vector)))
    };
    let (far, fast) = (scale_of(|body| &body.displacement), scale_of(|body| &body.velocity));
    for (body, other) in fields.iter().zip(&moved_fields) {
        for node in 0..body.displacement.len() {
            let u = motion.vector(body.displacement[node], units.length);
            note(gap(u, other.displacement[node]), far * units.length, format!("the displacement of node {node} of \"{}\"", body.name));
            let v = motion.vector(body.velocity[node], units.length / units.time);
            let scale = fast * units.length / units.time;
            note(gap(v, other.velocity[node]), scale, format!("the velocity of node {node} of \"{}\"", body.name));
        }
    }
    Ok(worst)
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

fn gap(a: [f64; 3], b: [f64; 3]) -> f64 {
    length([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
}
