//! Gears: coordinates of two joints that change in a fixed ratio.

use rhai::ImmutableString;

use super::change::change;
use super::handle::ModelHandle;
use crate::dynamics::{Gear, JointDefinition, JointKind, Model};
use crate::script::api::examples::plate_example;
use crate::script::language::prelude::*;

/// Function `add_gear` of scripts.
pub fn add_gear() -> Function {
    let keys = vec![
        Parameter::array(
            "joints",
            "names of two joints, each with an angle (a `hinge`, in the plane a `point`) or a travel (a `slider`, a `slot`)",
        ),
        Parameter::new(
            "ratio",
            Kind::Number,
            "factor of the second coordinate: of gears teeth of the second wheel over those of the first, positive where they turn against \
             each other, negative of an inner gear or a belt; of a pinion and a rack -1 over the pinion's radius, if both run the same way",
        )
        .of("any"),
    ];
    method_of::<ModelHandle>(Topic::Model, "add_gear")
        .summary(
            "couples the coordinates `s` of two joints exactly, as gears do, a belt, a pinion and its rack, a screw: `s_1 + ratio * s_2` \
             stays what it is at rest. `sim.joint(name)` has its action on the body `from` of the first joint",
        )
        .parameters(vec![
            Parameter::text("name", "its name, unique among joints"),
            Parameter::options("the joints, and the ratio").keys(keys),
        ])
        .see_also(&["add_joint", "add_motor"])
        .example(plate_example(
            "let wheel = |name, x, r| press.add_rigid_body(name, disk(#{ radius: r, cells: [1, 12], center: [x, 0.0] }), #{ density: 1.0 \
             });\n\
             press.add_joint(\"small\", #{ kind: \"point\", from: wheel.call(\"pinion\", 5.0, 0.5), point: [5.0, 0.0] });\n\
             press.add_joint(\"large\", #{ kind: \"point\", from: wheel.call(\"wheel\", 7.0, 1.0), point: [7.0, 0.0] });\n\
             press.add_gear(\"teeth\", #{ joints: [\"small\", \"large\"], ratio: 2.0 });",
        ))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let (joints, ratio) = (joints_of(&options.argument("joints"), &model.0.borrow().model)?, options.number("ratio")?);
            let kind = JointKind::Gear(Gear { joints, ratio });
            let ends = model.0.borrow().model.joints[joints[0]].ends;
            let gear = JointDefinition { name, kind, ends, drive: None, limits: None, friction: None };
            change(call, &model, |data| data.model.joints.push(gear))
        })
}

/// Returns the joints with the names in an argument.
fn joints_of(argument: &Argument, model: &Model) -> Result<[usize; 2], Failure> {
    let names = argument.value().try_cast::<Array>().unwrap_or_default();
    let names: Vec<ImmutableString> = names.into_iter().filter_map(Dynamic::try_cast).collect();
    let [first, second] = names.as_slice() else {
        return Err(argument.wrong(causes::WRONG_TYPE, "must be the names of two joints").hint("such as `joints: [\"axle\", \"shaft\"]`"));
    };
    let known: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
    let index = |name: &str| {
        let place = known.iter().position(|other| *other == name);
        place.ok_or_else(|| argument.unknown_name(format!("there is no joint \"{name}\""), name, &known))
    };
    Ok([index(first)?, index(second)?])
}
