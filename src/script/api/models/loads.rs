//! Loads on boundaries: tractions, forces, pressures, torques, each as a function of time.

use std::sync::Arc;

use rhai::EvalAltResult;

use super::arguments::{boundary_of, boundary_parameter};
use super::change::change;
use super::data::LoadNote;
use super::handle::ModelHandle;
use crate::dynamics::{Amplitude, Load, LoadKind};
use crate::math::norms::length;
use crate::script::api::examples::plate_example;
use crate::script::api::time_functions::{RecordedTimeFunction, amplitude_of};
use crate::script::language::digits::{number_text, vector_text};
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        directed(
            "traction",
            "loads a boundary with a force per undeformed area that keeps its direction",
            "stress",
            "the force per area at amplitude 1",
            LoadKind::Traction,
        ),
        directed(
            "force",
            "loads a boundary with a force that keeps its direction, spread evenly",
            "force",
            "the whole force at amplitude 1",
            LoadKind::Force,
        ),
        pressure(),
        torque(),
    ]
}

/// Script function for a load given by a vector.
fn directed(
    name: &'static str,
    summary: &'static str,
    dimension: &'static str,
    what: &'static str,
    kind: fn([f64; 3]) -> LoadKind,
) -> Function {
    method_of::<ModelHandle>(Topic::Model, name)
        .summary(summary)
        .parameters(vec![boundary_parameter(), Parameter::vector("vector", what).of(dimension), amplitude_parameter()])
        .see_also(&["torque", "gravity", "hat", "ramp", "sine", "table"])
        .example(plate_example(&format!("press.{name}(plate.boundary(\"right\"), [0.0, -5.0], ramp(0.0, 0.1, 1.0));")))
        .body(move |call, model| {
            let dimension = model.0.borrow().model.dimension();
            let vector = call.argument("vector").vector(dimension)?;
            let word = format!("{name} {}", vector_text(&vector[..dimension]));
            add_load(call, kind(vector), &word)
        })
}

fn pressure() -> Function {
    method_of::<ModelHandle>(Topic::Model, "pressure")
        .summary("loads a boundary with a pressure against its deformed surface")
        .parameters(vec![
            boundary_parameter(),
            Parameter::number("pressure", "stress", Interval::Finite, "the pressure at amplitude 1; positive pushes into the body"),
            amplitude_parameter(),
        ])
        .see_also(&["traction", "force"])
        .example(plate_example("press.pressure(plate.boundary(\"top\"), 50.0, ramp(0.0, 0.1, 1.0));"))
        .body(|call, _| {
            let pressure = call.number("pressure")?;
            add_load(call, LoadKind::Pressure(pressure), &format!("pressure {}", number_text(pressure)))
        })
}

fn torque() -> Function {
    method_of::<ModelHandle>(Topic::Model, "torque")
        .summary("loads a boundary with a torque about the third axis, in space about any, as nodal forces without resultant")
        .parameters(vec![
            boundary_parameter(),
            Parameter::amplitude("amplitude", "the torque over time, counter-clockwise").of("force * length"),
            Parameter::vector("axis", "the direction of the axis, in space; it stays as the body turns").of("1").otherwise("[0, 0, 1]"),
        ])
        .see_also(&["force", "traction", "hat"])
        .example(plate_example("press.torque(plate.boundary(\"left\"), |t| if t < 0.1 { 5.0 } else { 0.0 });"))
        .body(|call, model| {
            let (dimension, argument) = (model.0.borrow().model.dimension(), call.argument("axis"));
            if !argument.is_given() {
                return add_load(call, LoadKind::Torque([0.0, 0.0, 1.0]), "torque");
            }
            if dimension == 2 {
                let failure = argument.refuse(causes::DIMENSION, "the model is plane: a torque turns about the third axis");
                return Err(failure.hint("leave the axis out").into());
            }
            let axis = argument.vector(3)?;
            let size = length(axis);
            if size == 0.0 {
                return Err(argument.wrong(causes::NO_DIRECTION, "has no direction").hint("such as `[1.0, 0.0, 0.0]`").into());
            }
            add_load(call, LoadKind::Torque(axis.map(|x| x / size)), &format!("torque about {}", vector_text(&axis)))
        })
}

fn add_load(call: &Call, kind: LoadKind, word: &str) -> Result<(), Box<EvalAltResult>> {
    let model = call.receiver::<ModelHandle>();
    let on = boundary_of(&call.argument("boundary"), &model)?;
    let function = amplitude_of(&call.argument("amplitude"))?;
    let title = format!("{word} on \"{}\" with amplitude {}", model.0.borrow().model.boundary_name(&on), function.describe());
    let amplitude = Arc::new(RecordedTimeFunction::new(function));
    let dimension = match kind {
        LoadKind::Traction(_) | LoadKind::Pressure(_) => "stress",
        LoadKind::Force(_) => "force",
        LoadKind::Torque(_) => "force * length",
    };
    let note = LoadNote { title, dimension, place: call.place(&Default::default()), amplitude: amplitude.clone() };
    change(call, &model, |data| {
        let amplitude: Amplitude = amplitude;
        data.model.loads.push(Load { kind, on, amplitude });
        data.loads.push(note);
    })
}

fn amplitude_parameter() -> Parameter {
    Parameter::amplitude("amplitude", "its size over time, as a factor").or(1.0)
}
