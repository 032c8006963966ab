//! Bushings between rigid bodies.

use std::sync::Arc;

use super::change::change;
use super::handle::{BodyHandle, ModelHandle};
use super::motors::bodies_of;
use crate::dynamics::{BushingDefinition, across};
use crate::script::api::examples::plate_example;
use crate::script::language::prelude::*;

/// Function `add_bushing` of scripts.
pub fn add_bushing() -> Function {
    let keys = vec![
        Parameter::object::<BodyHandle>("from", "a rigid body"),
        Parameter::new("to", Kind::Either("a Body or \"ground\""), "what it holds it to: another rigid body, with which its axes turn"),
        Parameter::vector("point", "where it is at rest, on both").of("length"),
        Parameter::vector("axis", "its first axis at rest").of("1").otherwise("the axis x"),
        Parameter::array(
            "stiffness",
            "of each motion of `from` against `to`, along the axes and then about them, 3 numbers in the plane and 6 in space (forces per \
             length, moments per radian; plane: per thickness), or rows of a symmetric matrix",
        ),
        Parameter::array("damping", "the same by the rates of these motions").otherwise("none"),
    ];
    method_of::<ModelHandle>(Topic::Model, "add_bushing")
        .summary(
            "holds a rigid body to another one, or to the ground, by stiffness and damping against all relative motions, as a rubber mount \
             does: its energy is part of `potential`; the history has its `displacement`, `angle`, `force`, `moment` and `energy`",
        )
        .parameters(vec![
            Parameter::text("name", "its name, unique among springs, dampers, chambers and masses"),
            Parameter::options("bodies, place, stiffness and damping").keys(keys),
        ])
        .see_also(&["add_joint", "add_spring", "add_damper"])
        .example(plate_example(
            "let engine = press.add_rigid_body(\"engine\", rectangle(#{ size: [1.0, 0.5], cells: [2, 1], origin: [5.0, 0.0] }), #{ \
             density: 1.0 });\n\
             press.add_bushing(\"mount\", #{ from: engine, to: \"ground\", point: [5.5, 0.0], stiffness: [50.0, 80.0, 5.0], damping: [0.5, \
             0.8, 0.05] });",
        ))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let bodies = bodies_of(&options, &model, "a bushing holds")?;
            let dimension = model.0.borrow().model.dimension();
            let point = options.argument("point").vector(dimension)?;
            let axis = options.argument("axis");
            let axis_vector = if axis.is_given() { axis.vector(dimension)? } else { [1.0, 0.0, 0.0] };
            if axis_vector == [0.0; 3] {
                return Err(axis.wrong(causes::NO_DIRECTION, "has no direction").hint("such as `[1.0, 0.0]`").into());
            }
            let axes = across(axis_vector);
            let count = if dimension == 2 { 3 } else { 6 };
            let stiffness = matrix_of(&options.argument("stiffness"), count)?;
            let damping = options.argument("damping");
            let damping = if damping.is_given() { matrix_of(&damping, count)? } else { vec![0.0; count * count] };
            let bushing = BushingDefinition { name, bodies, point, axes, stiffness, damping };
            change(call, &model, |data| data.model.parts.push(Arc::new(bushing)))
        })
}

/// Returns a square matrix, given by its diagonal or its rows, row by row.
fn matrix_of(argument: &Argument, count: usize) -> Result<Vec<f64>, Failure> {
    let rows = argument.value().try_cast::<Array>().unwrap_or_default();
    let number = |value: &Dynamic| value.as_float().ok().or_else(|| value.as_int().ok().map(|whole| whole as f64));
    let numbers = |array: &Array| array.iter().map(number).collect::<Option<Vec<f64>>>().filter(|found| found.len() == count);
    if let Some(diagonal) = numbers(&rows) {
        return Ok((0..count * count).map(|k| if k % (count + 1) == 0 { diagonal[k / count] } else { 0.0 }).collect());
    }
    let found: Option<Vec<Vec<f64>>> = rows.iter().map(|row| numbers(&row.clone().try_cast::<Array>()?)).collect();
    match found {
        Some(found) if found.len() == count => Ok(found.concat()),
        _ => {
            let failure = argument.wrong(causes::WRONG_TYPE, format!("must be {count} numbers, or {count} rows of {count} numbers"));
            Err(failure.hint("along the axes, then about them: in the plane `[kx, ky, k_angle]`, in space `[kx, ky, kz, kxx, kyy, kzz]`"))
        }
    }
}
