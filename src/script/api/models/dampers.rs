//! Dissipation: dampers between ends, drag on boundaries, Rayleigh damping of bodies.

use std::sync::Arc;

use super::arguments::{boundary_of, deformable_of};
use super::change::change;
use super::ends::{constants_parameter, end_parameters, ends_of, one_of, text_of};
use super::handle::{BodyHandle, BoundaryHandle, ModelHandle};
use crate::bodies::positive_areas;
use crate::dynamics::{DamperDefinition, DamperElement, DragDefinition, DragTarget, Viscous};
use crate::materials::Viscosity;
use crate::script::api::examples::{TOUCH, plate_example};
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;

/// Parameters of a force as a function of a speed.
fn law_parameters(of_coefficient: &'static str) -> [Parameter; 5] {
    [
        Parameter::number("coefficient", "any", Interval::Positive, of_coefficient).otherwise("`force` is given"),
        Parameter::number("exponent", "1", Interval::Positive, "the force grows with this power of the speed").or(1.0),
        Parameter::number("smoothing", "length/time", Interval::Positive, "speed below which a power less than 1 is linear")
            .otherwise("none, for powers from 1 on"),
        Parameter::text("force", "the force as text in the speed `v`, such as `\"c*v + d*v^3\"`").otherwise("`coefficient` is given"),
        constants_parameter(),
    ]
}

/// Damping force described by the options.
fn law_of(options: &Options) -> Result<Viscous, Failure> {
    let law = if one_of(options, &["coefficient", "force"])? == 0 {
        let (coefficient, exponent) = (options.number("coefficient")?, options.number("exponent")?);
        let smoothing = options.optional_number("smoothing")?;
        if exponent < 1.0 && smoothing.is_none() {
            let failure = options.argument("smoothing").refuse(causes::OPTIONS_TOGETHER, "a power less than 1 needs `smoothing`");
            let failure = failure.cause(format!("the exponent is {}, and the force would jump at rest", number_text(exponent)));
            return Err(failure.hint("give a speed far below those of the motion, below which the force is linear"));
        }
        if exponent == 1.0 {
            Viscous::Linear(coefficient)
        } else {
            Viscous::Power { coefficient, exponent, smoothing: smoothing.unwrap_or(0.0) }
        }
    } else {
        let argument = options.argument("force");
        Viscous::Force(Arc::new(text_of(options, &argument, "v", "the force")?), [1.0, 1.0])
    };
    match law.drives_at() {
        None => Ok(law),
        Some(speed) => {
            let force = number_text(law.force(speed).0);
            let failure = options.argument("force").fail("the force supplies energy instead of damping");
            let failure = failure.cause(format!("at v = {} it is {force}", number_text(speed)));
            Err(failure.hint("let it have the sign of `v` everywhere, and be 0 at rest: `c*v`, `c*v*abs(v)`"))
        }
    }
}

/// Function `add_damper` of scripts.
pub fn add_damper() -> Function {
    let mut keys = end_parameters();
    keys.extend(law_parameters("force at speed 1, `[force (time/length)^exponent]` (plane: per thickness)"));
    method_of::<ModelHandle>(Topic::Model, "add_damper")
        .summary(
            "joins points of bodies, centroids of boundaries or the ground by a damper, whose force opposes the speed at which its ends \
             move apart: linear, a power, or a text; the history has its `speed`, `force` and `dissipation`, the heat of each step",
        )
        .parameters(vec![
            Parameter::text("name", "its name, unique among springs, dampers, chambers and masses"),
            Parameter::options("ends and law").keys(keys),
        ])
        .see_also(&["add_spring", "add_chamber", "viscous"])
        .example(plate_example(&format!(
            "{TOUCH}press.add_damper(\"closer\", #{{ from: plate.boundary(\"top\"), to: \"ground\", to_point: [1.0, 3.0], coefficient: 2.0 \
             }});\npress.add_damper(\"orifice\", #{{ from: plate, from_point: [1.0, 1.0], to: table, to_point: [1.0, -1.0],\n    force: \
             \"c*v*abs(v)\", constants: #{{ c: 0.5 }} }});\nprint(press);"
        )))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let (ends, law) = (ends_of(&options, &model)?, law_of(&options)?);
            change(call, &model, |data| data.model.parts.push(Arc::new(DamperDefinition { name, ends, element: DamperElement(law) })))
        })
}

/// Function `add_drag` of scripts.
pub fn add_drag() -> Function {
    let mut keys = vec![Parameter::object::<BoundaryHandle>("boundary", "the boundary on which it acts")];
    keys.extend(law_parameters("force per area at speed 1, `[stress (time/length)^exponent]`"));
    method_of::<ModelHandle>(Topic::Model, "add_drag")
        .summary(
            "applies the drag of a medium at rest to a boundary: a force per undeformed area against the velocity of each node, linear, a \
             power, or a text in the speed; it takes momentum, and the history has its `dissipation`",
        )
        .parameters(vec![
            Parameter::text("name", "its name, unique among springs, dampers, chambers and masses"),
            Parameter::options("boundary and law").keys(keys),
        ])
        .see_also(&["add_damper", "add_damping"])
        .example(plate_example("press.add_drag(\"air\", #{ boundary: plate.boundary(\"top\"), coefficient: 0.02, exponent: 2.0 });"))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let (argument, law) = (options.argument("boundary"), law_of(&options)?);
            let on = boundary_of(&argument, &model)?;
            let shares = {
                let data = model.0.borrow();
                let body = &data.model.bodies[on.body];
                positive_areas(&body.mesh, &on.boundary, body.formulation.plane)
            };
            if on.boundary.facets.is_empty() {
                return Err(argument
                    .refuse(causes::EMPTY, "drag needs a boundary with facets")
                    .hint("choose a boundary that has facets")
                    .into());
            }
            let on = DragTarget::Nodes(on.body, shares, law);
            change(call, &model, |data| data.model.parts.push(Arc::new(DragDefinition { name, on })))
        })
}

/// Function `add_damping` of scripts.
pub fn add_damping() -> Function {
    let rate = |name, dimension, what| Parameter::number(name, dimension, Interval::NonNegative, what).or(0.0);
    let keys = vec![
        rate("mass", "1/time", "the rate alpha: a mode of circular frequency w loses the share alpha/(2 w) of the critical damping"),
        rate("stiffness", "time", "the time beta: such a mode loses the share beta w/2"),
    ];
    method_of::<ModelHandle>(Topic::Model, "add_damping")
        .summary(
            "damps a body as Rayleigh does: proportional to its mass, as drag that takes momentum and has a column `damping of \
             ….dissipation`, and to its stiffness at rest, as a viscosity of its material, which keeps momenta",
        )
        .parameters(vec![Parameter::object::<BodyHandle>("body", "the body"), Parameter::options("both shares").keys(keys)])
        .see_also(&["add_drag", "add_damper", "viscous"])
        .example(plate_example("press.add_damping(plate, #{ mass: 2.0, stiffness: 1e-4 });"))
        .body(|call, model| {
            let (body, options) = (deformable_of(&call.argument("body"), &model)?, call.options("options")?);
            let (rate, time) = (options.number("mass")?, options.number("stiffness")?);
            let mut definition = body.definition();
            // Lame moduli at rest, from Young's modulus and the ratio of bulk to shear modulus.
            let (material, ratio) = (definition.material.clone(), definition.material.bulk_over_shear());
            let shear = material.youngs_modulus() * (3.0 * ratio + 1.0) / (9.0 * ratio);
            let viscosity = material.viscosity().clone();
            let viscosity =
                Viscosity { shear: viscosity.shear + time * shear, bulk: viscosity.bulk + time * shear * (ratio - 2.0 / 3.0), ..viscosity };
            let material = if time > 0.0 { material.with_viscosity(viscosity) } else { material };
            definition.material = material.clone();
            let name = format!("damping of {}", definition.name);
            let on = DragTarget::Mass(body.index, Box::new(definition), rate);
            change(call, &model, |data| {
                data.model.bodies[body.index].material = material;
                if rate > 0.0 {
                    data.model.parts.push(Arc::new(DragDefinition { name, on }));
                }
            })
        })
}
