//! Bolts: tightened to a preload, then locked at their length.

use std::sync::Arc;

use super::change::change;
use super::ends::{end_parameters, ends_of};
use super::handle::ModelHandle;
use crate::dynamics::{BoltDefinition, BoltElement};
use crate::script::api::examples::plate_example;
use crate::script::language::prelude::*;

/// `add_bolt`.
pub fn add_bolt() -> Function {
    let mut keys = end_parameters();
    keys.extend([
        Parameter::number("preload", "force", Interval::Positive, "the tension to which it is tightened (plane: per thickness)"),
        Parameter::number(
            "stiffness",
            "force / length",
            Interval::Positive,
            "its stiffness `E A / l` when it is locked (plane: per thickness)",
        ),
        Parameter::number(
            "locked_at",
            "time",
            Interval::NonNegative,
            "the time until which its tension rises from 0, and at which its length is locked; 0: the preload acts from the start, and \
             `settle` at the start finds the length",
        )
        .or(0.0),
    ]);
    method_of::<ModelHandle>(Topic::Model, "add_bolt")
        .summary(
            "clamps points of bodies or boundaries by a bolt with a preload: while it is tightened it pulls both ends together with the \
             preload, whatever their distance; then its length is locked, and it is a spring about the preload. The end on a boundary is \
             the mean of its nodes, so that it does not stiffen the boundary. The history has its `length`, `force` and `work`",
        )
        .parameters(vec![
            Parameter::text("name", "its name, unique among springs, dampers, chambers and masses"),
            Parameter::options("ends, preload and stiffness").keys(keys),
        ])
        .see_also(&["add_spring", "add_actuator", "add_coupling", "tie", "settle"])
        .example(plate_example(
            "let lid = press.add_body(\"lid\", rectangle(#{ size: [2.0, 0.5], cells: [8, 1], origin: [0.0, 1.0] }), steel);\n\
             press.add_bolt(\"bolt\", #{ from: plate.boundary(\"bottom\"), to: lid.boundary(\"top\"), preload: 10.0, stiffness: 200.0 });\n\
             print(press);",
        ))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let ends = ends_of(&options, &model)?;
            let [preload, stiffness, locked_at] = ["preload", "stiffness", "locked_at"].map(|name| options.number(name));
            let element = BoltElement { preload: preload?, stiffness: stiffness?, locked_at: locked_at? };
            change(call, &model, |data| data.model.parts.push(Arc::new(BoltDefinition { name, ends, element })))
        })
}
