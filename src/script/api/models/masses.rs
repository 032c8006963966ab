//! Masses at points of bodies.

use std::sync::Arc;

use super::arguments::{body_of, node_at};
use super::change::change;
use super::handle::{BodyHandle, ModelHandle};
use crate::dynamics::PointMassDefinition;
use crate::script::api::examples::{TOUCH, plate_example};
use crate::script::language::prelude::*;

/// Function `add_mass` of scripts.
pub fn add_mass() -> Function {
    method_of::<ModelHandle>(Topic::Model, "add_mass")
        .summary("adds a mass at a point of a body: it moves with the point, weighs, and is part of the body's mass and momenta")
        .parameters(vec![
            Parameter::text("name", "its name, unique among masses and springs"),
            Parameter::options("where it is, and how large"),
        ])
        .keys(vec![
            Parameter::object::<BodyHandle>("body", "the body"),
            Parameter::vector("point", "a point of it in the undeformed body: the nearest node").of("length"),
            Parameter::number(
                "mass",
                "mass",
                Interval::NonNegative,
                "the mass (plane: per thickness; axisymmetric: of the whole circumference)",
            ),
        ])
        .see_also(&["add_spring", "add_body", "force"])
        .example(plate_example(&format!(
            "{TOUCH}press.add_mass(\"ballast\", #{{ body: plate, point: [1.0, 1.0], mass: 0.01 }});\nprint(press);"
        )))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let body = body_of(&options.argument("body"), &model)?;
            let node = (body.index, node_at(&options.argument("point"), &body)?);
            let mass = options.number("mass")?;
            change(call, &model, |data| data.model.parts.push(Arc::new(PointMassDefinition { name, node, mass })))
        })
}
