//! `sim.harmonic_response`: steady vibrations under a force or a base excitation, as an object with columns over the frequency.

use std::f64::consts::TAU;
use std::rc::Rc;

use super::handle::SimulationHandle;
use super::modes::{self, warn_of_damping, warn_of_turning};
use crate::dynamics::{BodyBoundary, Excitation, HarmonicError, HarmonicOptions, HarmonicResponse};
use crate::script::api::examples::plate_example;
use crate::script::api::models::arguments::node_at;
use crate::script::api::models::handle::{BodyHandle, BoundaryHandle};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;
use crate::script::language::values::as_number;

/// Steady vibrations of a simulation about a state.
#[derive(Clone)]
pub struct ResponseHandle {
    response: Rc<HarmonicResponse>,
    simulation: SimulationHandle,
    /// Ratio of the script's unit of time to that of the solver.
    unit: f64,
}

impl Handle for ResponseHandle {
    const NAME: &'static str = "HarmonicResponse";
    const MAKER: &'static str = "make one with `sim.harmonic_response(#{ frequencies: […], … })`";

    fn describe(&self) -> String {
        let frequencies = self.frequencies();
        let range = [frequencies.first(), frequencies.last()].map(|frequency| brief(frequency.copied().unwrap_or_default()));
        format!(
            "harmonic response of \"{}\" at t = {}, {} frequencies from {} to {}",
            self.simulation.0.name,
            brief(self.response.time / self.unit),
            frequencies.len(),
            range[0],
            range[1]
        )
    }
}

impl ResponseHandle {
    /// Frequencies in oscillations per unit of time of the script.
    fn frequencies(&self) -> Vec<f64> {
        self.response.frequencies.iter().map(|frequency| frequency * self.unit / TAU).collect()
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![harmonic_response(), frequencies(), at()]
}

fn response_example(line: &str) -> std::borrow::Cow<'static, str> {
    plate_example(&format!(
        "press.fix(plate.boundary(\"left\"));\nlet sim = simulate(press, #{{ integrator: energy_momentum(), dt: 0.001 }});\n\
         let response = sim.harmonic_response(#{{\n    frequencies: [100.0, 200.0, 300.0], boundary: plate.boundary(\"right\"), \
         force: [0.0, 1.0], loss_factor: 0.02,\n}});\n{line}"
    ))
}

fn option_parameters() -> Vec<Parameter> {
    let damping = |name: &'static str, dimension: &'static str, summary: &'static str| {
        Parameter::number(name, dimension, Interval::NonNegative, summary).or(0.0)
    };
    vec![
        Parameter::array("frequencies", "oscillations per time, positive").of("1/time"),
        Parameter::object::<BoundaryHandle>("boundary", "where the force acts").otherwise("nowhere; then give `base`"),
        Parameter::vector("force", "amplitude of the whole force, spread evenly").of("force").otherwise("none"),
        Parameter::vector("base", "amplitude of the motion of all supports and of the ground, in place of a force")
            .of("length")
            .otherwise("none"),
        damping("mass_damping", "1/time", "alpha of the damping alpha M of velocities; on a base, of those against the world at rest"),
        damping("stiffness_damping", "time", "beta of the damping beta K"),
        damping("loss_factor", "1", "eta of the stiffness K (1 + i eta); near a resonance twice the damping ratio"),
    ]
}

fn harmonic_response() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "harmonic_response")
        .summary(
            "steady vibrations about the present state, undeformed or settled under load, under a force or on a base that swings: for each \
             frequency one complex amplitude for every node; ties and closed contacts hold as in `modes`, and what dampers and viscous \
             materials do is left out: damping is what the options give; the state stays as it is",
        )
        .parameters(vec![Parameter::options("what swings, and what damps it").keys(option_parameters())])
        .see_also(&["modes", "settle", "plot_curves"])
        .example(response_example("print(response);\nprint(response.at(plate, [2.0, 1.0]).amplitude);"))
        .body_with_options(|call, handle, options| {
            handle.refuse_in_check(call)?;
            handle.looked()?;
            let unit = handle.0.kernel_time(1.0);
            let options = asked_for(&handle, call, &options, unit)?;
            let found = handle.found(call, "harmonic response", |simulation| simulation.harmonic_response(&options))?;
            let response = found.map_err(|error| refused(call, &handle, error, unit))?;
            if response.asymmetry > 0.0 {
                let title = "loads that turn with the surface make the stiffness unsymmetric: the response is that of its symmetric part";
                call.host.warn(Diagnostic::warning(title.to_string(), call.place(&Target::Call)).code("C0715"));
            }
            warn_of_turning(call, &handle);
            let cause = "what damps the response are the options `loss_factor`, `mass_damping` and `stiffness_damping`";
            warn_of_damping(call, &handle, cause, "give what the damping amounts to as one of them; a run has it all");
            Ok(ResponseHandle { response: Rc::new(response), simulation: handle, unit })
        })
}

/// Options of a harmonic response from the arguments of a call, converted to the units of the solver.
fn asked_for(handle: &SimulationHandle, call: &Call, options: &Options, unit: f64) -> Result<HarmonicOptions, Failure> {
    let dimension = handle.0.model.model.dimension();
    let argument = options.argument("frequencies");
    let given = argument.array()?;
    let frequencies: Vec<f64> = given.iter().filter_map(as_number).filter(|one| *one > 0.0 && one.is_finite()).collect();
    if frequencies.is_empty() || frequencies.len() != given.len() {
        let failure = argument.refuse(causes::OUT_OF_RANGE, "`frequencies` of `harmonic_response` must be an array of positive numbers");
        return Err(failure.hint("write `[10.0, 20.0, 30.0]`, or fill an array in a loop"));
    }
    let [boundary, force, base] = ["boundary", "force", "base"].map(|name| options.argument(name));
    let excitation = match (boundary.is_given() && force.is_given(), base.is_given()) {
        (true, false) => Excitation::Force { on: boundary_of(handle, &boundary)?, vector: force.vector(dimension)? },
        (false, true) if !boundary.is_given() && !force.is_given() => Excitation::Base(base.vector(dimension)?),
        _ => {
            let failure = call.refuse(causes::COUNT, "`harmonic_response` needs one excitation");
            return Err(failure.hint("give `boundary` and `force`, or `base`"));
        }
    };
    Ok(HarmonicOptions {
        frequencies: frequencies.iter().map(|frequency| frequency * TAU / unit).collect(),
        excitation,
        mass_damping: options.number("mass_damping")? / unit,
        stiffness_damping: options.number("stiffness_damping")? * unit,
        loss_factor: options.number("loss_factor")?,
    })
}

/// A boundary of a body of the simulation.
fn boundary_of(handle: &SimulationHandle, argument: &Argument) -> Result<BodyBoundary, Failure> {
    let BoundaryHandle { body, boundary, .. } = argument.handle()?;
    let bodies = &handle.0.model.model.bodies;
    let index = body.and_then(|body| bodies.iter().position(|known| known.name == body.definition().name));
    match index {
        Some(body) => Ok(BodyBoundary { body, boundary }),
        None => Err(argument
            .refuse(causes::OTHER_OWNER, "`boundary` must be one of a body of the simulation")
            .hint("take it from the body that `add_body` gave")),
    }
}

/// Error message of a refused `harmonic_response`.
fn refused(call: &Call, handle: &SimulationHandle, error: HarmonicError, unit: f64) -> Failure {
    let in_script = |frequency: f64| brief(frequency * unit / TAU);
    let code = error.code();
    let failure = match error {
        HarmonicError::Matrix(error) => modes::refused(call, handle, error),
        HarmonicError::Resonance { frequency } => call
            .fail(format!("the response at the frequency {} grows without bound: it is not damped", in_script(frequency)))
            .hint("give a damping, such as `loss_factor: 0.02`, or another frequency"),
        HarmonicError::NotFound { frequency, vectors } => call
            .fail(format!("the response at the frequency {} was not found with {vectors} vectors", in_script(frequency)))
            .hint("request lower frequencies: the mesh does not resolve such high ones"),
        HarmonicError::Nothing => call.fail(error.to_string()).hint("give a force on a boundary that may move"),
    };
    failure.code(code)
}

fn frequencies() -> Function {
    property_of::<ResponseHandle>(Topic::Results, "frequencies")
        .summary("the frequencies of the response, oscillations per time")
        .returns("Array")
        .see_also(&["harmonic_response", "at"])
        .example(response_example("print(response.frequencies);"))
        .body(|_, response| Ok(array_of(response.frequencies())))
}

fn at() -> Function {
    method_of::<ResponseHandle>(Topic::Results, "at")
        .summary(
            "the motion of the node of a body nearest to a point at rest, over the frequencies, as a map of arrays: `frequency`, \
             `amplitude` (the length of the vector of amplitudes), and for each axis `x`, `y`, `z` the amplitude `amplitude_x`, the phase \
             ahead of the excitation `phase_x` in radians, and the parts `real_x`, `imaginary_x`",
        )
        .parameters(vec![
            Parameter::object::<BodyHandle>("body", "the body"),
            Parameter::vector("point", "a point of the undeformed body").of("length"),
        ])
        .returns("Map")
        .see_also(&["harmonic_response", "plot_curves"])
        .example(response_example(
            "let tip = response.at(plate, [2.0, 1.0]);\n\
             plot_curves(\"tip.svg\", [#{ x: tip.frequency, y: tip.amplitude_y }], #{ x_label: \"frequency\" });",
        ))
        .body(|call, handle| {
            let (index, given) = (handle.simulation.body_index(call)?, call.handle::<BodyHandle>("body")?);
            let node = node_at(&call.argument("point"), &given)? as usize;
            let bodies = &handle.simulation.0.model.model.bodies;
            let before: usize = bodies[..index].iter().map(|body| body.mesh.points.len()).sum();
            let values = handle.response.at(before + node);
            let size = |vector: &[[f64; 2]; 3]| vector.iter().flatten().fold(0.0, |size: f64, part| size.hypot(*part));
            let mut map = Map::new();
            map.insert("frequency".into(), array_of(handle.frequencies()));
            map.insert("amplitude".into(), array_of(values.iter().map(size)));
            for (i, axis) in ["x", "y", "z"].into_iter().enumerate().take(handle.simulation.0.model.model.dimension()) {
                map.insert(format!("amplitude_{axis}").into(), array_of(values.iter().map(|vector| vector[i][0].hypot(vector[i][1]))));
                map.insert(format!("phase_{axis}").into(), array_of(values.iter().map(|vector| vector[i][1].atan2(vector[i][0]))));
                map.insert(format!("real_{axis}").into(), array_of(values.iter().map(|vector| vector[i][0])));
                map.insert(format!("imaginary_{axis}").into(), array_of(values.iter().map(|vector| vector[i][1])));
            }
            Ok(Dynamic::from(map))
        })
}
