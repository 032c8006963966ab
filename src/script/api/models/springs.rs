//! Springs between points of bodies.

use std::sync::Arc;

use rhai::Dynamic;

use super::arguments::{body_of, node_at};
use super::change::change;
use super::handle::{BodyHandle, ModelHandle};
use crate::dynamics::SpringDefinition;
use crate::math::catalogue::Interval;
use crate::script::api::examples::{TOUCH, plate_example};
use crate::script::language::arguments::{Arguments, Options};
use crate::script::language::failure::Failure;
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::handle::Handle;
use crate::script::language::parameter::{Absent, Kind, Parameter};

/// `add_spring`.
pub fn add_spring() -> Function {
    let end = |name, which: &'static str| Parameter::new(name, Kind::Handle(BodyHandle::NAME), which);
    let point = |name| Parameter::new(name, Kind::Vector, "a point of it in the undeformed body: the nearest node").of("length");
    Function {
        name: "add_spring",
        form: Form::Method(ModelHandle::receiver()),
        topic: Topic::Model,
        summary: "joins points of two bodies by a linear spring: energy stiffness/2 (length - rest_length)^2, part of `potential`",
        parameters: vec![
            Parameter::new("name", Kind::Text, "its name, unique among springs"),
            Parameter::new(
                "options",
                Kind::Options(vec![
                    end("from", "the body at one end"),
                    point("from_point"),
                    end("to", "the body at the other end"),
                    point("to_point"),
                    Parameter::number("stiffness", "force / length", Interval::Positive, "force per elongation (plane: per thickness)"),
                    Parameter::number("rest_length", "length", Interval::NonNegative, "the length at which it does not pull")
                        .or(Absent::Means("its length in the undeformed bodies")),
                ]),
                "ends and stiffness",
            ),
        ],
        returns: "",
        example: plate_example(&format!(
            "{TOUCH}press.add_spring(\"tie rod\", #{{ from: plate, from_point: [1.0, 1.0], to: table, to_point: [1.0, -1.0], stiffness: \
             50.0 }});\nprint(press);"
        )),
        see_also: &["force", "fix", "tie"],
        body: body(|call| {
            let model = call.receiver::<ModelHandle>();
            let (name, options) = (call.name("name")?, call.options("options")?);
            let ends = [end_of(&options, &model, "from", "from_point")?, end_of(&options, &model, "to", "to_point")?];
            let (stiffness, rest_length) = (options.number("stiffness")?, options.optional_number("rest_length")?);
            change(call, &model, |data| {
                data.model.parts.push(Arc::new(SpringDefinition { name, ends, stiffness, rest_length }));
            })?;
            Ok(Dynamic::UNIT)
        }),
    }
}

/// Body and node of an end.
fn end_of(options: &Options, model: &ModelHandle, body: &str, point: &str) -> Result<(usize, u32), Failure> {
    let body = body_of(&options.argument(body), model)?;
    Ok((body.index, node_at(&options.argument(point), &body)?))
}
