//! Forces per unit mass, given by a closure of position, velocity and time.

use std::sync::Arc;

use rhai::FnPtr;

use super::arguments::deformable_of;
use super::change::change;
use super::handle::{BodyHandle, ModelHandle};
use crate::dynamics::BodyForceDefinition;
use crate::script::api::examples::plate_example;
use crate::script::api::time_functions::body_field;
use crate::script::language::prelude::*;

/// Function `body_force` of scripts.
pub fn body_force() -> Function {
    method_of::<ModelHandle>(Topic::Model, "body_force")
        .summary("loads a body with a force per mass that a closure of position, velocity and time gives; its work is part of `load_work`")
        .parameters(vec![
            Parameter::text("name", "its name, unique among springs, dampers, chambers and masses"),
            Parameter::object::<BodyHandle>("body", "the body"),
            Parameter::new(
                "force",
                Kind::Closure("|x, v, t|"),
                "the force per mass as an array, of position and velocity as arrays, and time",
            )
            .of("length/time^2"),
        ])
        .see_also(&["gravity", "rotating_frame", "force", "add_damping"])
        .example(plate_example("press.body_force(\"to the center\", plate, |x, v, t| [-4.0 * x[0], -4.0 * x[1]]);"))
        .body(|call, model| {
            let (name, body) = (call.name("name")?, deformable_of(&call.argument("body"), &model)?);
            let argument = call.argument("force");
            let value = argument.value();
            let Some(function) = value.read_lock::<FnPtr>().map(|function| function.clone()) else {
                return Err(if argument.is_given() { argument.wrong_type() } else { argument.missing() }.into());
            };
            argument.check_parameters(&function, "|x, v, t|")?;
            let definition = body.definition();
            let field = body_field(call, function, definition.mesh.dimension());
            let part = BodyForceDefinition { name, body: body.index, definition, field };
            change(call, &model, |data| data.model.parts.push(Arc::new(part)))
        })
}
