//! Nodes of boundaries that equations couple: planes of symmetry, periodic pairs, reference bodies.

use super::arguments::{body_of, boundary_of, boundary_parameter};
use super::change::change;
use super::handle::{BodyHandle, BoundaryHandle, ModelHandle};
use super::supports::{along_axes, axis_of_turn};
use crate::dynamics::{Coupling, CouplingKind, Sector};
use crate::math::norms::length;
use crate::script::api::examples::plate_example;
use crate::script::language::prelude::*;

fn name_parameter() -> Parameter {
    Parameter::text("name", "its name, unique among symmetries, periodic pairs and couplings")
}

/// Function `add_symmetry` of scripts.
pub fn add_symmetry() -> Function {
    let normal = Parameter::vector("normal", "the direction in which nodes are held; any length").of("1");
    method_of::<ModelHandle>(Topic::Model, "add_symmetry")
        .summary(
            "holds the nodes of a boundary in its plane, at any angle, and lets them slide there: a plane of symmetry, rollers on a slope. \
             `sim.reaction(name)` has its force, the history has it as `name.reaction.force_x` and so on",
        )
        .parameters(vec![name_parameter(), boundary_parameter(), normal.otherwise("that of the boundary, which must be flat")])
        .see_also(&["fix", "add_periodic", "reaction"])
        .example(plate_example("press.add_symmetry(\"middle\", plate.boundary(\"left\"));\nprint(press);"))
        .body(|call, model| {
            let name = call.name("name")?;
            let (given, normal) = (call.argument("boundary"), call.argument("normal"));
            let on = boundary_of(&given, &model)?;
            let (dimension, flat) = {
                let data = model.0.borrow();
                (data.model.dimension(), data.model.flat_normal(&on))
            };
            let normal = match (normal.is_given(), flat) {
                (true, _) => direction(&normal, dimension)?,
                (false, Some(normal)) => normal,
                (false, None) => {
                    let failure = given.wrong(causes::NO_DIRECTION, "is not flat: it has no single normal");
                    return Err(failure.hint("take a boundary in one plane, or give the direction in which its nodes are held").into());
                }
            };
            change(call, &model, |data| data.model.couplings.push(Coupling { name, kind: CouplingKind::Plane { on, normal } }))
        })
}

/// Kinds of a coupling to a rigid body.
const KINDS: &[&str] = &["distributing", "rigid"];

/// `add_coupling`.
pub fn add_coupling() -> Function {
    let keys = vec![
        Parameter::object::<BoundaryHandle>("boundary", "a boundary of a body that deforms"),
        Parameter::object::<BodyHandle>("to", "the rigid body that is the reference point: any mesh, any place"),
        Parameter::new(
            "kind",
            Kind::Choice(KINDS),
            "`distributing`: the mean motion of the boundary, translation and rotation, is that of the rigid body, which adds no \
             stiffness; `rigid`: each node moves as a point of the rigid body",
        )
        .or("distributing"),
    ];
    method_of::<ModelHandle>(Topic::Model, "add_coupling")
        .summary(
            "couples a boundary to a reference point, a rigid body on which forces, torques, joints, springs and motions act: its mean \
             motion alone (distributing), or all of its nodes (rigid). `sim.reaction(name)` has its force on the boundary, the history has \
             it as `name.reaction.force_x` and so on",
        )
        .parameters(vec![name_parameter(), Parameter::options("boundary, reference body, kind").keys(keys)])
        .see_also(&["add_rigid_body", "tie", "add_bolt", "add_joint", "reaction"])
        .example(plate_example(
            "let grip = press.add_rigid_body(\"grip\", rectangle(#{ size: [0.2, 0.2], cells: [1, 1], origin: [3.0, 0.4] }), #{ density: \
             1.0 });\n\
             press.add_coupling(\"pull\", #{ boundary: plate.boundary(\"right\"), to: grip });\nprint(press);",
        ))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let [boundary, to] = ["boundary", "to"].map(|name| options.argument(name));
            if let Some(missing) = [&boundary, &to].into_iter().find(|argument| !argument.is_given()) {
                return Err(missing.missing().into());
            }
            let on = boundary_of(&boundary, &model)?;
            let (to, is_rigid) = (body_of(&to, &model)?.index, options.text("kind")? == "rigid");
            change(call, &model, |data| data.model.couplings.push(Coupling { name, kind: CouplingKind::Reference { on, to, is_rigid } }))
        })
}

/// Function `add_periodic` of scripts.
pub fn add_periodic() -> Function {
    let side = |name, summary| Parameter::object::<BoundaryHandle>(name, summary);
    let along = ["x", "y", "z"].map(|name| {
        let moves = Parameter::amplitude(name, "how `to` moves against `from` in this direction over time, a mean strain");
        moves.of("length").otherwise("not at all")
    });
    let keys = vec![
        side("from", "a boundary"),
        side("to", "the boundary opposite, with the same nodes, moved or turned"),
        Parameter::new("angle", Kind::Number, "the angle by which a turn carries `from` onto `to`, counter-clockwise: a sector of a wheel")
            .of("rad")
            .otherwise("it is moved and not turned"),
        Parameter::vector("about", "a point of the axis of that turn").of("length").otherwise("the origin"),
        Parameter::vector("axis", "the direction of the axis, in space").of("1").otherwise("[0, 0, 1]"),
    ];
    let follows = Parameter::object::<BodyHandle>(
        "follows",
        "a rigid body as which `to` moves against `from`: where it is, is the mean strain, a force on it the mean stress over the side",
    );
    let keys = keys.into_iter().chain([follows.otherwise("none")]).chain(along).collect();
    method_of::<ModelHandle>(Topic::Model, "add_periodic")
        .summary(
            "lets every node of a boundary move as the node opposite to it on another one, so that the model is one cell of a pattern that \
             goes on: a cell of a material, with a mean strain over time, or by `angle` a sector of a wheel, all sectors moving alike. \
             `sim.reaction(name)` has its force on `to`, the history has it as `name.reaction.force_x` and so on",
        )
        .parameters(vec![name_parameter(), Parameter::options("what is opposite").keys(keys)])
        .see_also(&["add_symmetry", "prescribe", "tie", "reaction"])
        .example(plate_example(
            "press.add_periodic(\"sides\", #{ from: plate.boundary(\"left\"), to: plate.boundary(\"right\"), x: ramp(0.0, 1.0, 0.1) });\n\
             print(press);",
        ))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let dimension = model.0.borrow().model.dimension();
            let [from, to] = ["from", "to"].map(|name| boundary_of(&options.argument(name), &model));
            let offset = along_axes(&options, dimension)?;
            let turn = match axis_of_turn(&options, dimension, "angle: deg(60)")? {
                Some([center, axis]) => Some(Sector { center, axis, angle: options.number("angle")? }),
                None => None,
            };
            let follows = options.argument("follows");
            let follows = if follows.is_given() { Some(body_of(&follows, &model)?.index) } else { None };
            let kind = CouplingKind::Periodic { from: from?, to: to?, turn, offset, follows };
            change(call, &model, |data| data.model.couplings.push(Coupling { name, kind }))
        })
}

/// Nonzero vector in an argument.
fn direction(argument: &Argument, dimension: usize) -> Result<[f64; 3], Failure> {
    let vector = argument.vector(dimension)?;
    if length(vector) == 0.0 {
        let failure = argument.wrong(causes::NO_DIRECTION, "has no direction").label("this has length 0");
        return Err(failure.hint("such as `[1.0, 0.0]`, in space `[0.0, 0.0, 1.0]`"));
    }
    Ok(vector)
}
