//! Rotating frames of reference.

use std::sync::Arc;

use super::change::change;
use super::handle::ModelHandle;
use crate::dynamics::{AxisRotation, RotatingFrameDefinition, Spin};
use crate::script::api::examples::plate_example;
use crate::script::api::time_functions::amplitude_of;
use crate::script::language::prelude::*;
use crate::script::language::values::as_number;

/// Function `rotating_frame` of scripts.
pub fn rotating_frame() -> Function {
    let keys = vec![
        Parameter::amplitude("velocity", "the angular velocity, a number or a function of time").of("1/time"),
        Parameter::vector("axis", "the axis, in space: the frame turns about it counter-clockwise")
            .of("1")
            .otherwise("the third axis of plane models, that of symmetry of bodies of revolution"),
        Parameter::vector("center", "a point of the axis").of("length").otherwise("the origin"),
    ];
    method_of::<ModelHandle>(Topic::Model, "rotating_frame")
        .summary(
            "makes all positions and velocities relative to a rotating frame: on every mass act the centrifugal force, with a potential if \
             the velocity is constant, the Coriolis force, which does no work, and Euler's force if the velocity varies, whose work is \
             that of a load; in equilibria only the centrifugal force acts",
        )
        .parameters(vec![Parameter::options("how it turns").keys(keys)])
        .see_also(&["gravity", "body_force"])
        .example(plate_example("press.rotating_frame(#{ velocity: 0.5, center: [1.0, 0.0] });\nprint(press);"))
        .body_with_options(|call, model, options| {
            let definition = frame_of(&options, &model)?;
            if model.0.borrow().model.parts.iter().any(|part| part.is_gyroscopic()) {
                return Err(call
                    .refuse(causes::NAME_TAKEN, "the model has a rotating frame already")
                    .hint("give one velocity, about one axis")
                    .into());
            }
            change(call, &model, |data| data.model.parts.push(Arc::new(definition)))
        })
}

/// Returns the rotating frame in the options; the direction of its axis follows from the bodies.
fn frame_of(options: &Options, model: &ModelHandle) -> Result<RotatingFrameDefinition, Failure> {
    let (dimension, is_round) = {
        let data = model.0.borrow();
        (data.model.dimension(), data.model.is_axisymmetric())
    };
    let [velocity, axis, center] = ["velocity", "axis", "center"].map(|name| options.argument(name));
    let speed = amplitude_of(&velocity)?;
    let velocity = as_number(&velocity.value()).map_or(Spin::Varying(speed), Spin::Constant);
    let is_given = axis.is_given();
    let axis = match (dimension, is_given) {
        (2, false) => {
            if is_round {
                [0.0, 1.0, 0.0]
            } else {
                AxisRotation::UPRIGHT
            }
        }
        (2, true) => {
            let which = if is_round { "that of symmetry" } else { "the third one" };
            return Err(axis
                .refuse(causes::DIMENSION, format!("the model has two dimensions: its frame turns about one axis, {which}"))
                .hint("remove the option"));
        }
        (_, false) => return Err(axis.missing()),
        (_, true) => axis.vector(3)?,
    };
    let place = if center.is_given() { center.vector(dimension)? } else { [0.0; 3] };
    if is_round && place[0] != 0.0 {
        let failure = center.refuse(causes::DIMENSION, "the frame of bodies of revolution turns about their axis");
        return Err(failure.hint("remove the option, or give a point with the radius 0"));
    }
    Ok(RotatingFrameDefinition { axis, center: place, velocity })
}
