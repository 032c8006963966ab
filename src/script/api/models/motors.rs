//! Prescribed forces and torques over time: actuators between points, motors between rigid bodies.

use std::sync::Arc;

use rhai::ImmutableString;

use super::arguments::body_of;
use super::change::change;
use super::ends::{GROUND, end_parameters, ends_of};
use super::handle::{BodyHandle, ModelHandle};
use crate::bodies::BarycentricMap;
use crate::dynamics::{ActuatorDefinition, ActuatorElement, AxisRotation, MotorDefinition};
use crate::script::api::examples::{TOUCH, plate_example};
use crate::script::api::time_functions::amplitude_of;
use crate::script::language::prelude::*;

const NAME: &str = "its name, unique among springs, dampers, chambers and masses";

/// Function `add_actuator` of scripts.
pub fn add_actuator() -> Function {
    let mut keys = end_parameters();
    let force = Parameter::amplitude("force", "the force that pushes the ends apart over time (plane: per thickness)");
    keys.push(force.of("force"));
    method_of::<ModelHandle>(Topic::Model, "add_actuator")
        .summary(
            "pushes points of bodies, centroids of boundaries or the ground apart along their line with a force over time, as a cylinder \
             does: on both ends alike, its work is part of `load_work`; the history has its `length`, `force` and `work`",
        )
        .parameters(vec![Parameter::text("name", NAME), Parameter::options("ends and force").keys(keys)])
        .see_also(&["add_motor", "add_joint", "add_spring", "force"])
        .example(plate_example(&format!(
            "{TOUCH}press.add_actuator(\"cylinder\", #{{ from: plate.boundary(\"top\"), to: \"ground\", to_point: [1.0, 3.0], force: \
             ramp(0.0, 0.1, 2.0) }});"
        )))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let (ends, force) = (ends_of(&options, &model)?, amplitude_of(&options.argument("force"))?);
            change(call, &model, |data| data.model.parts.push(Arc::new(ActuatorDefinition { name, ends, element: ActuatorElement(force) })))
        })
}

/// Function `add_motor` of scripts.
pub fn add_motor() -> Function {
    let keys = vec![
        Parameter::object::<BodyHandle>("from", "the rigid body that it turns"),
        Parameter::new("to", Kind::Either("a Body or \"ground\""), "what it turns it against: the rigid body that has the torque back"),
        Parameter::vector("axis", "the axis at rest, in space: it turns with `to`").of("1").otherwise("the model is plane"),
        Parameter::amplitude("torque", "the torque over time, counter-clockwise or about `axis` (plane: per thickness)")
            .of("force * length"),
    ];
    method_of::<ModelHandle>(Topic::Model, "add_motor")
        .summary(
            "turns a rigid body against another one, or against the ground, with a torque over time: on both alike, its work is part of \
             `load_work`; the history has its `torque` and `work`. A motor that prescribes the angle is the `drive` of a joint",
        )
        .parameters(vec![Parameter::text("name", NAME), Parameter::options("bodies and torque").keys(keys)])
        .see_also(&["add_actuator", "add_joint", "torque", "add_torsion_spring"])
        .example(plate_example(
            "let rotor = press.add_rigid_body(\"rotor\", ring(#{ inner_radius: 0.1, outer_radius: 0.4, cells: [1, 12], center: [5.0, 0.0] \
             }), #{ density: 1.0 });\n\
             press.add_joint(\"bearing\", #{ kind: \"point\", from: rotor, point: [5.0, 0.0] });\n\
             press.add_motor(\"motor\", #{ from: rotor, to: \"ground\", torque: hat(0.0, 0.5, 0.1) });",
        ))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let bodies = bodies_of(&options, &model, "a motor turns")?;
            let axis = axis_of(&options, model.0.borrow().model.dimension())?;
            let torque = amplitude_of(&options.argument("torque"))?;
            change(call, &model, |data| data.model.parts.push(Arc::new(MotorDefinition { name, bodies, axis, torque })))
        })
}

/// Index of a rigid body, with its masters.
pub type BodyWithMasters = (usize, Vec<u32>);

/// Returns two rigid bodies with their masters, or one and the ground; `what` describes the element for messages.
pub fn bodies_of(options: &Options, model: &ModelHandle, what: &str) -> Result<[Option<BodyWithMasters>; 2], Failure> {
    let (from, to) = (options.argument("from"), options.argument("to"));
    let is_ground = to.value().read_lock::<ImmutableString>().is_some_and(|word| *word == GROUND);
    let first = masters_of(&from, model, what)?;
    let second = if is_ground { None } else { Some(masters_of(&to, model, what)?) };
    if second.as_ref().is_some_and(|(body, _)| *body == first.0) {
        return Err(to.fail(format!("{what} a body against another one")).hint("name two bodies, or the ground"));
    }
    Ok([Some(first), second])
}

/// Returns a rigid body with its masters.
fn masters_of(argument: &Argument, model: &ModelHandle, what: &str) -> Result<BodyWithMasters, Failure> {
    if !argument.is_given() {
        return Err(argument.missing());
    }
    let index = body_of(argument, model)?.index;
    let data = model.0.borrow();
    let body = &data.model.bodies[index];
    match BarycentricMap::new(&body.mesh).filter(|_| body.rigid.is_some()) {
        Some(frame) => Ok((index, frame.masters)),
        None => {
            let failure = argument.refuse(causes::BODY_KIND, format!("body \"{}\" deforms, and {what} rigid bodies", body.name));
            Err(failure.hint("add it with `add_rigid_body`, or load a boundary of it: `model.torque(boundary, amplitude)`"))
        }
    }
}

/// The axis of a motor.
fn axis_of(options: &Options, dimension: usize) -> Result<[f64; 3], Failure> {
    let argument = options.argument("axis");
    match (dimension, argument.is_given()) {
        (2, false) => Ok(AxisRotation::UPRIGHT),
        (2, true) => {
            Err(argument.refuse(causes::DIMENSION, "the model is plane: a motor turns about the third axis").hint("remove the option"))
        }
        (_, false) => Err(argument.missing()),
        (_, true) => {
            let axis = argument.vector(3)?;
            if axis == [0.0; 3] {
                return Err(argument.wrong(causes::NO_DIRECTION, "has no direction").hint("such as `[0.0, 0.0, 1.0]`"));
            }
            Ok(axis)
        }
    }
}
