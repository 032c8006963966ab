//! Springs between bodies, boundaries and the ground.

use std::sync::Arc;

use super::arguments::{body_of, node_at_point};
use super::change::change;
use super::ends::{GROUND, constants_parameter, end_parameters, ends_of, one_of, text_of};
use super::handle::{BodyHandle, ModelHandle};
use crate::dynamics::{Elastic, Sides, SpringDefinition, SpringElement, SpringLaw, TorsionDefinition};
use crate::script::api::examples::{TOUCH, plate_example};
use crate::script::api::time_functions::points_of;
use crate::script::language::prelude::*;

/// Signs of the elongation for which a spring acts.
const SIDES: &[&str] = &["both", "tension", "compression"];

/// Function `add_spring` of scripts.
pub fn add_spring() -> Function {
    let mut keys = end_parameters();
    keys.extend(law_parameters("force / length", "force per elongation (plane: per thickness)"));
    keys.push(
        Parameter::number("rest_length", "length", Interval::NonNegative, "the length at which the elongation is 0")
            .otherwise("its length in the undeformed bodies"),
    );
    method_of::<ModelHandle>(Topic::Model, "add_spring")
        .summary(
            "joins points of bodies, centroids of boundaries or the ground by a spring, linear, by a table or by an energy as text in the \
             elongation `length - rest_length`: its energy is part of `potential`, the history has its `length`, `force` and `energy`",
        )
        .parameters(vec![
            Parameter::text("name", "its name, unique among springs, dampers, chambers and masses"),
            Parameter::options("ends and law").keys(keys),
        ])
        .see_also(&["add_damper", "add_chamber", "add_mass", "force", "fix", "tie"])
        .example(plate_example(&format!(
            "{TOUCH}press.add_spring(\"tie rod\", #{{ from: plate, from_point: [1.0, 1.0], to: table, to_point: [1.0, -1.0], stiffness: \
             50.0 }});\npress.add_spring(\"cable\", #{{ from: plate.boundary(\"top\"), to: \"ground\", to_point: [1.0, 3.0],\n    energy: \
             \"k/2*x^2 + k*x^4\", constants: #{{ k: 20.0 }}, sides: \"tension\" }});\nprint(press);"
        )))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let (ends, law) = (ends_of(&options, &model)?, law_of(&options)?);
            let rest_length = options.optional_number("rest_length")?;
            change(call, &model, |data| {
                data.model.parts.push(Arc::new(SpringDefinition { name, ends, element: SpringElement { law, rest_length } }));
            })
        })
}

/// Parameters of a spring's force law.
fn law_parameters(of_stiffness: &'static str, stiffness: &'static str) -> [Parameter; 5] {
    let optional = |name, kind, what| Parameter::new(name, kind, what).otherwise("one of `stiffness`, `table`, `energy` is given");
    [
        Parameter::number("stiffness", of_stiffness, Interval::Positive, stiffness)
            .otherwise("one of `stiffness`, `table`, `energy` is given"),
        optional("table", Kind::Array, "points `[elongation, force]` with increasing elongations, linear between them and beyond"),
        optional("energy", Kind::Text, "the energy as text in the elongation `x`, such as `\"k/2*x^2 + c/4*x^4\"`"),
        constants_parameter(),
        Parameter::new(
            "sides",
            Kind::Choice(SIDES),
            "the elongations at which it acts: a cable has `\"tension\"`, a stop `\"compression\"`",
        )
        .or("both"),
    ]
}

/// Function `add_torsion_spring` of scripts.
pub fn add_torsion_spring() -> Function {
    let points = |name| Parameter::array(name, "two points of it while it is undeformed, the nearest nodes: from one to the other");
    let mut keys = vec![
        Parameter::object::<BodyHandle>("from", "a body, whose direction counts backward, towards the ground forward"),
        points("from_points").of("length"),
        Parameter::new("to", Kind::Either("a Body or \"ground\""), "what it turns against"),
        points("to_points").of("length").otherwise("`to` is the ground"),
    ];
    keys.extend(law_parameters("force * length", "moment per radian (per thickness)"));
    method_of::<ModelHandle>(Topic::Model, "add_torsion_spring")
        .summary(
            "turns two plane bodies, or a body and the ground, against each other by a torsional spring: its elongation `x` is the angle \
             by which their directions have turned from the undeformed bodies, over whole turns; the history has its `angle`, `moment` and \
             `energy`",
        )
        .parameters(vec![
            Parameter::text("name", "its name, unique among springs, dampers, chambers and masses"),
            Parameter::options("directions and law").keys(keys),
        ])
        .see_also(&["add_spring", "add_damper", "torque"])
        .example(plate_example(&format!(
            "{TOUCH}press.add_torsion_spring(\"hinge\", #{{ from: table, from_points: [[0.0, -1.0], [2.0, -1.0]],\n    to: plate, \
             to_points: [[0.0, 0.0], [2.0, 0.0]], stiffness: 20.0 }});"
        )))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let (dimension, is_round) = (model.0.borrow().model.dimension(), model.0.borrow().model.is_axisymmetric());
            if dimension != 2 || is_round {
                let failure = call.refuse(causes::DIMENSION, "a torsional spring is for bodies that move in a plane");
                return Err(failure.hint("in space, and around an axis, join bodies by springs between points").into());
            }
            let mut directions = vec![direction_of(&options, &model, "from", "from_points")?];
            let to = options.argument("to");
            if to.value().read_lock::<rhai::ImmutableString>().is_some_and(|word| *word == GROUND) {
                // A spring to the ground has one direction, and its angle grows counter-clockwise.
                directions.truncate(1);
            } else {
                directions.push(direction_of(&options, &model, "to", "to_points")?);
            }
            let law = law_of(&options)?;
            change(call, &model, |data| data.model.parts.push(Arc::new(TorsionDefinition { name, directions, law })))
        })
}

/// Returns a body and two of its nodes.
fn direction_of(options: &Options, model: &ModelHandle, key: &str, points_key: &str) -> Result<(usize, [u32; 2]), Failure> {
    let (body, argument) = (body_of(&options.argument(key), model)?, options.argument(points_key));
    if !argument.is_given() {
        return Err(argument.missing());
    }
    match argument.points::<2>()?[..] {
        [[ax, ay], [bx, by]] => {
            let node = |x, y| node_at_point(&argument, &body, [x, y, 0.0]);
            Ok((body.index, [node(ax, ay)?, node(bx, by)?]))
        }
        _ => Err(argument
            .refuse(causes::OPTIONS_TOGETHER, format!("`{points_key}` must be two points"))
            .hint("write `[[0.0, 0.0], [1.0, 0.0]]`")),
    }
}

fn law_of(options: &Options) -> Result<SpringLaw, Failure> {
    let elastic = match one_of(options, &["stiffness", "table", "energy"])? {
        0 => Elastic::Linear(options.number("stiffness")?),
        1 => {
            let argument = options.argument("table");
            let points = points_of(&argument, ["elongation", "force"])?;
            if points.len() < 2 {
                let failure = argument.refuse(causes::COUNT, "the table of a spring needs two points at least");
                return Err(failure.hint("write `[[0.0, 0.0], [0.1, 5.0]]`"));
            }
            Elastic::Table(Arc::new(points))
        }
        _ => {
            let argument = options.argument("energy");
            Elastic::Energy(Arc::new(text_of(options, &argument, "x", "the energy")?), [1.0, 1.0])
        }
    };
    let sides = match options.text("sides")?.as_str() {
        "tension" => Sides::Tension,
        "compression" => Sides::Compression,
        _ => Sides::Both,
    };
    Ok(SpringLaw { elastic, sides })
}
