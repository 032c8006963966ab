//! `expect_invariant`: repeats a scenario moved, rotated or in other units, and requires the equivalent motion.

use rhai::EvalAltResult;

use crate::dynamics::BodyFields;
use crate::math::tolerances::{INVARIANT, STILL_AT};
use crate::script::api::checks::verdicts::{failed, only_listed, passed};
use crate::script::api::motion::Motion;
use crate::script::api::nested_runs::begin_study;
use crate::script::api::simulations::handle::SimulationHandle;
use crate::script::api::units::Units;
use crate::script::language::digits::{brief, number_text, significant};
use crate::script::language::prelude::*;
use crate::script::language::values::describe;

/// The function `expect_invariant`.
pub fn expect_invariant() -> Function {
    let factor = |name: &'static str, summary: &'static str| Parameter::number(name, "1", Interval::Positive, summary).or(1.0);
    function(Topic::Checks, "expect_invariant")
        .summary(
            "runs a scenario as it is and again turned, moved or in other units, each by itself, and ends the script with an error when it \
             moves otherwise",
        )
        .parameters(vec![
            Parameter::new(
                "action",
                Kind::Closure("||"),
                "builds a model, runs it and gives the simulation; while it is run again, `simulate` moves the whole model, and the script \
                 keeps its own clock",
            ),
            Parameter::options("what is changed"),
        ])
        .keys(vec![
            Parameter::number("rotate", "rad", Interval::Finite, "the angle by which the model is turned about the third axis")
                .otherwise("not turned"),
            Parameter::vector("translate", "the vector by which it is moved").of("length").otherwise("not moved"),
            Parameter::map("units", "the new units").otherwise("the same units").keys(vec![
                factor("mass", "how many new units of mass the old one is"),
                factor("length", "how many new units of length the old one is"),
                factor("time", "how many new units of time the old one is"),
            ]),
            Parameter::number("tolerance", "1", Interval::NonNegative, "the largest difference, relative to each quantity's size")
                .or(INVARIANT),
        ])
        .see_also(&["expect_order", "expect_conserved"])
        .example(
            "fn flight() {\n    let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });\n    let sky = \
                  model(\"sky\");\n    let plate = sky.add_body(\"plate\", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), rubber);\n    \
                  sky.initial_velocity(plate, #{ linear: [1.0, 0.0], angular: 2.0 });\n    let sim = simulate(sky, #{ integrator: \
                  energy_momentum(), dt: 0.01 });\n    sim.run_to(0.1);\n    sim\n}\nexpect_invariant(|| flight(), #{ rotate: deg(30), \
                  translate: [1.0, 2.0], units: #{ length: 1000.0, time: 1000.0 } });",
        )
        .body(run_invariance)
}

fn run_invariance(call: &Call) -> Result<(), Box<EvalAltResult>> {
    let options = call.options("options")?;
    let tolerance = options.number("tolerance")?;
    let motions = motions_of(&options)?;
    if motions.is_empty() {
        let failure = call.argument("options").fail("`expect_invariant` changes nothing").label("names no change");
        return Err(failure.hint("give `rotate`, `translate` or `units`").into());
    }
    let changes: Vec<String> = motions.iter().map(Motion::describe).collect();
    if only_listed(call, &format!("the scenario moves the same {}", changes.join(" and "))) {
        return Ok(());
    }
    let original = scenario(call, None)?;
    if original.0.model.model.is_axisymmetric()
        && let Some(motion) = motions.iter().find(|motion| !motion.keeps_axis_of_revolution())
    {
        let title = format!("a model of revolution cannot be {}", motion.describe());
        let failure = call.argument("options").refuse(causes::DIMENSION, title).label("moves the section relative to the axis");
        return Err(failure.hint("give `translate: [0, z]`, along the axis, or `units`").into());
    }
    let mut worst = Vec::new();
    for motion in motions {
        let moved = scenario(call, Some(motion))?;
        let (size, difference) = compare(call, &original, &moved, &motion)?;
        // The comparison is written such that NaN does not pass.
        if size <= tolerance {
            worst.push(significant(size, 2));
            continue;
        }
        let title = format!("the scenario is not the same when it is {}", motion.describe()).replace("is in other", "is written in other");
        let failure = failed(call, title).at(Target::Argument(0)).label(format!("tolerance {}", number_text(tolerance)));
        return Err(failure
            .cause(difference)
            .hint("a motion that depends on where it happens has a direction or a size in it that is not that of the model")
            .hint("where contact is chaotic, differences grow with time: compare a shorter run, or allow a larger `tolerance`")
            .into());
    }
    passed(call, &format!("ok  the same {} (largest relative difference {})", changes.join(" and "), worst.join(", ")))
}

/// Motions named by the options, each to be applied separately.
fn motions_of(options: &Options) -> Result<Vec<Motion>, Failure> {
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
    Ok(motions)
}

/// Runs the scenario, moved or not.
fn scenario(call: &Call, motion: Option<Motion>) -> Result<SimulationHandle, Box<EvalAltResult>> {
    let action = call.callback("action")?;
    let value = {
        let _aside = begin_study(call.host, motion);
        action.call([])?
    };
    match value.clone().try_cast::<SimulationHandle>() {
        Some(handle) => Ok(handle),
        None => {
            let failure = call.argument("action").refuse(causes::CLOSURE, "the closure must give a simulation");
            let failure = failure.label(format!("this gives {}", describe(call.engine(), &value)));
            Err(failure.hint("let the last expression of the closure, without a semicolon, be the simulation").into())
        }
    }
}

/// Returns the largest relative difference of two runs, and its description.
fn compare(call: &Call, original: &SimulationHandle, moved: &SimulationHandle, motion: &Motion) -> Result<(f64, String), Failure> {
    let read =
        |handle: &SimulationHandle| handle.with(call, |simulation| (simulation.row().clone(), simulation.fields(), simulation.dimension()));
    let ((row, fields, dimension), (moved_row, moved_fields, _)) = (read(original)?, read(moved)?);
    let units = motion.units;
    let same_shape =
        fields.len() == moved_fields.len() && fields.iter().zip(&moved_fields).all(|(a, b)| a.displacement.len() == b.displacement.len());
    if !same_shape {
        let failure = call.argument("action").refuse(causes::CLOSURE, "the closure gives another model when it is called again");
        return Err(failure.label("not the same bodies").hint("build the same model on every call"));
    }
    // Smaller differences of positions, and of velocities by as much in a step, are round-off.
    let model = &original.0.model.model;
    let farthest = model.bodies.iter().flat_map(|body| &body.mesh.points).fold(0.0f64, |farthest, point| farthest.max(length(*point)));
    let round_off = STILL_AT * motion.reach(farthest);
    let of_a_step = if row.dt > 0.0 { round_off / (units.time * row.dt) } else { 0.0 };
    let beyond = |difference: f64, round_off: f64| if difference <= round_off { 0.0 } else { difference };
    let mut worst = (0.0, String::new());
    let mut note = |difference: f64, scale: f64, what: String| {
        let size = if difference == 0.0 { 0.0 } else { difference / scale };
        if size.is_nan() || size > worst.0 {
            worst = (size, format!("{what} differs by {} relative to {}", significant(size, 3), brief(scale)));
        }
    };
    note((row.time - moved_row.time / units.time).abs(), row.time.abs(), "the time reached".into());
    // Energies of bodies of revolution are those of the whole circumference.
    let energy = motion.energy(if model.is_axisymmetric() { 3 } else { dimension });
    let total = row.kinetic.abs() + row.strain.abs();
    let scale_of = |pick: fn(&BodyFields) -> &Vec<[f64; 3]>| {
        fields.iter().flat_map(|body| pick(body).iter()).fold(0.0_f64, |scale, vector| scale.max(length(*vector)))
    };
    let (far, fast) = (scale_of(|body| &body.displacement), scale_of(|body| &body.velocity));
    if far * units.length > round_off || fast * units.length / units.time > of_a_step {
        note((row.kinetic - moved_row.kinetic / energy).abs(), total, "the kinetic energy".into());
        note((row.strain - moved_row.strain / energy).abs(), total, "the strain energy".into());
    }
    for (body, other) in fields.iter().zip(&moved_fields) {
        for node in 0..body.displacement.len() {
            let u = motion.vector(body.displacement[node], units.length);
            let off = beyond(gap(u, other.displacement[node]), round_off);
            note(off, far * units.length, format!("the displacement of node {node} of \"{}\"", body.name));
            let v = motion.vector(body.velocity[node], units.length / units.time);
            let scale = fast * units.length / units.time;
            note(beyond(gap(v, other.velocity[node]), of_a_step), scale, format!("the velocity of node {node} of \"{}\"", body.name));
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
