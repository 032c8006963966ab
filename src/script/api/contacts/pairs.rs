//! Interactions of surfaces: contact pairs, obstacles, self-contact, ties.
//!
//! Every call that adds a pair checks the model at once. Suspicious definitions (a surface that faces away, a tie without nodes) are
//! reported by `model.check()` and are warnings of `simulate`.

use rhai::EvalAltResult;

use super::friction::{friction_of, friction_parameter};
use super::methods::{
    chosen_method, facets_of, facets_parameter, method_parameter, rule_parameters, rules_of, shape_parameters, shapes_of,
};
use super::obstacles::ObstacleHandle;
use crate::contact::Obstacle;
use crate::dynamics::{BodyBoundary, Interaction, Partner};
use crate::mesh::Boundary;
use crate::script::api::examples::{TOUCH, plate_example};
use crate::script::api::models::arguments::{body_boundary, boundary_of};
use crate::script::api::models::change::change;
use crate::script::api::models::handle::{BoundaryHandle, ModelHandle};
use crate::script::language::prelude::*;
use crate::script::language::values::describe;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![add_contact(), add_self_contact(), tie()]
}

fn add_contact() -> Function {
    let [update, penalty, augmented] = rule_parameters();
    let [secondary_shape, primary_shape] = shape_parameters();
    method_of::<ModelHandle>(Topic::Contact, "add_contact")
        .summary("lets a boundary touch others, or a rigid obstacle, with friction or without")
        .parameters(vec![name_parameter(), Parameter::options("sides and method")])
        .keys(vec![
            Parameter::new(
                "secondary",
                Kind::Either("a Boundary or an array of them"),
                "the side that carries the contact pressure (slave, nonmortar): one boundary, or several of one body",
            ),
            Parameter::new(
                "primary",
                Kind::Either("a Boundary, an array of them, or an Obstacle"),
                "the other side (master, mortar): one boundary, several of them as one surface, or a rigid obstacle",
            ),
            method_parameter(),
            facets_parameter(),
            secondary_shape,
            primary_shape,
            update,
            penalty,
            augmented,
            friction_parameter(),
            restitution_parameter(),
            Parameter::flag(
                "equality",
                "whether every covered node is closed and tension allowed (the bilateral constraints of the paper); its friction is \
                     bounded by the magnitude of the pressure, as in a guide with contact on both sides",
            )
            .or(false),
        ])
        .see_also(&["mortar", "rigid_plane", "add_self_contact", "tie"])
        .example(plate_example(&format!(
            "{TOUCH}press.add_contact(\"lid\", #{{ secondary: plate.boundary(\"top\"), primary: rigid_plane(#{{ point: [0.0, 1.1], normal: \
             [0.0, -1.0] }}) }});"
        )))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let secondary = secondary_of(call, &options.argument("secondary"), &model)?;
            let partner = partner_of(call, &options.argument("primary"), &model)?;
            let (method, facets) = (chosen_method(&options)?, facets_of(&options)?);
            let has_obstacle = matches!(partner, Partner::Obstacle { .. });
            let has_curves = {
                let model = &model.0.borrow().model;
                model.dimension() == 3 || model.bodies[secondary.body].rigid.is_some()
            };
            let has_arcs = has_obstacle && !has_curves && !matches!(partner, Partner::Obstacle { shape: Obstacle::Polyline { .. }, .. });
            let shapes = shapes_of(&options, has_obstacle, has_arcs)?;
            let ((update, enforcement), equality) = (rules_of(&options)?, options.flag("equality")?);
            let idle = if has_curves || has_arcs { &["method"][..] } else { &["method", "facets"] };
            if let Some(argument) = idle.iter().map(|name| options.argument(name)).find(|given| has_obstacle && given.is_given()) {
                let failure = argument.wrong(causes::BODY_KIND, "has no meaning for a rigid obstacle");
                let failure = failure.cause("an obstacle has no facets to integrate over: the gap of a node is its distance");
                return Err(failure.hint("leave the option out").into());
            }
            let (friction, restitution) = (friction_of(&options)?, options.optional_number("restitution")?);
            let interaction =
                Interaction { name, secondary, partner, method, facets, shapes, update, enforcement, equality, friction, restitution };
            add(call, &model, interaction)
        })
}

fn add_self_contact() -> Function {
    let [update, penalty, augmented] = rule_parameters();
    method_of::<ModelHandle>(Topic::Contact, "add_self_contact")
        .summary("lets a boundary touch itself where it folds, with friction or without")
        .parameters(vec![name_parameter(), Parameter::options("surface and method")])
        .keys(vec![
            Parameter::object::<BoundaryHandle>("surface", "the boundary that may touch itself"),
            method_parameter(),
            facets_parameter(),
            update,
            penalty,
            augmented,
            friction_parameter(),
        ])
        .see_also(&["add_contact"])
        .example(plate_example("press.add_self_contact(\"fold\", #{ surface: plate.boundary(\"top\") });"))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let surface = boundary_of(&options.argument("surface"), &model)?;
            let (method, facets) = (chosen_method(&options)?, facets_of(&options)?);
            let ((update, enforcement), friction) = (rules_of(&options)?, friction_of(&options)?);
            let touching = Interaction::new(&name, surface, Partner::Itself);
            add(call, &model, Interaction { method, facets, update, enforcement, friction, ..touching })
        })
}

fn tie() -> Function {
    method_of::<ModelHandle>(Topic::Contact, "tie")
        .summary("holds two boundaries together although their meshes do not match")
        .parameters(vec![name_parameter(), Parameter::options("sides")])
        .keys(vec![
            Parameter::object::<BoundaryHandle>("secondary", "the side with the multipliers, better the finer one"),
            Parameter::object::<BoundaryHandle>("primary", "the other side"),
            Parameter::number("reach", "length", Interval::Positive, "the distance at rest within which the two are tied")
                .otherwise("half of the shortest secondary facet"),
        ])
        .see_also(&["add_contact"])
        .example(plate_example(
            "let lid = press.add_body(\"lid\", rectangle(#{ size: [2.0, 0.5], cells: [7, 1], origin: [0.0, 1.0] }), steel);\n\
             press.tie(\"weld\", #{ secondary: lid.boundary(\"bottom\"), primary: plate.boundary(\"top\") });",
        ))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let secondary = boundary_of(&options.argument("secondary"), &model)?;
            let to = boundary_of(&options.argument("primary"), &model)?;
            let reach = options.optional_number("reach")?;
            add(call, &model, Interaction::new(&name, secondary, Partner::Tied { to, reach }))
        })
}

/// Restitution of the impacts of rigid bodies.
fn restitution_parameter() -> Parameter {
    Parameter::number("restitution", "1", Interval::Closed(0.0, 1.0), "the coefficient of restitution of impacts between rigid sides")
        .otherwise("1 with the update rules that keep the energy, `persistency` and `velocity`; 0 with `gap`")
}

fn name_parameter() -> Parameter {
    Parameter::text("name", "its name, unique in the model")
}

/// Adds an interaction with its place in the script.
fn add(call: &Call, model: &ModelHandle, interaction: Interaction) -> Result<(), Box<EvalAltResult>> {
    let note = (interaction.name.clone(), call.place(&Default::default()));
    change(call, model, |data| {
        data.model.add_interaction(interaction);
        data.contacts.push(note);
    })
}

/// Contact partner of a contact in an argument.
fn partner_of(call: &Call, argument: &Argument, model: &ModelHandle) -> Result<Partner, Failure> {
    let value = argument.value();
    if let Some(obstacle) = value.clone().try_cast::<ObstacleHandle>() {
        return Ok(Partner::Obstacle { shape: obstacle.obstacle, motion: obstacle.motion, turn: obstacle.turn });
    }
    if let Some(boundary) = value.clone().try_cast::<BoundaryHandle>() {
        return Ok(Partner::Surfaces(vec![body_boundary(argument, boundary, model)?]));
    }
    Ok(Partner::Surfaces(boundaries_of(call, argument, model)?))
}

/// Returns the secondary side of a contact: boundaries of one body.
fn secondary_of(call: &Call, argument: &Argument, model: &ModelHandle) -> Result<BodyBoundary, Failure> {
    if let Some(boundary) = argument.value().try_cast::<BoundaryHandle>() {
        return body_boundary(argument, boundary, model);
    }
    let sides = boundaries_of(call, argument, model)?;
    let body = sides[0].body;
    if sides.iter().any(|side| side.body != body) {
        let failure = argument.wrong(causes::OTHER_OWNER, "has boundaries of several bodies");
        return Err(failure.hint("define a contact for each body; several bodies may be the `primary` side of each"));
    }
    let boundaries: Vec<Boundary> = sides.into_iter().map(|side| side.boundary).collect();
    Ok(BodyBoundary { body, boundary: Boundary::union(&boundaries) })
}

/// Returns the boundaries in an array, at least one.
fn boundaries_of(call: &Call, argument: &Argument, model: &ModelHandle) -> Result<Vec<BodyBoundary>, Failure> {
    let value = argument.value();
    let Some(entries) = value.read_lock::<Array>() else { return Err(argument.wrong_type()) };
    let mut surfaces = Vec::new();
    for entry in entries.iter() {
        let Some(boundary) = entry.clone().try_cast::<BoundaryHandle>() else {
            let failure = argument.refuse(causes::WRONG_TYPE, format!("every entry of {} must be a Boundary", argument.title()));
            let failure = failure.label(format!("this contains {}", describe(call.engine(), entry)));
            return Err(failure.hint("write `[first.boundary(\"top\"), second.boundary(\"top\")]`; an obstacle is a contact of its own"));
        };
        surfaces.push(body_boundary(argument, boundary, model)?);
    }
    if surfaces.is_empty() {
        return Err(argument.wrong(causes::EMPTY, "is empty").hint("name at least one boundary of a body"));
    }
    Ok(surfaces)
}
