//! Rigid bodies and exact joints.

use rhai::ImmutableString;

use super::arguments::body_of;
use super::building::refuse_or_warn_of_surface;
use super::change::change;
use super::ends::GROUND;
use super::handle::{BodyHandle, ModelHandle};
use super::joint_friction::{friction_of, friction_options};
use crate::bodies::{Formulation, Inertia};
use crate::dynamics::{Anchor, BodyDefinition, JointDefinition, JointKind, Model, ModelError};
use crate::materials::{Material, NeoHookean};
use crate::math::tolerances;
use crate::mesh::Mesh;
use crate::script::api::examples::plate_example;
use crate::script::api::meshes::handle::MeshHandle;
use crate::script::api::remedies::ScriptWords;
use crate::script::api::time_functions::amplitude_of;
use crate::script::language::digits::{brief, vector_text};
use crate::script::language::prelude::*;

/// Poisson's ratio of the material of a rigid body; it has no effect, because only the density is used.
const ANY_RATIO: f64 = 0.3;

/// Function `add_rigid_body` of scripts.
pub fn add_rigid_body() -> Function {
    method_of::<ModelHandle>(Topic::Model, "add_rigid_body")
        .summary("adds a body that does not deform: its mass and inertia are those of its mesh, or given by numbers")
        .parameters(vec![
            Parameter::text("name", "its name, unique in the model"),
            Parameter::object::<MeshHandle>("mesh", "its undeformed mesh: its shape in pictures, and its surface"),
            Parameter::options("its density, or mass and inertia"),
        ])
        .keys(vec![
            Parameter::number("density", "mass/length^3", Interval::Positive, "density of the mesh, for mass and inertia")
                .otherwise("`mass` is given"),
            Parameter::number("mass", "mass", Interval::Positive, "its mass (plane: per thickness), in place of a density")
                .otherwise("that of the mesh"),
            Parameter::new(
                "inertia",
                Kind::Either("a number, or an array of 3 or 6 numbers"),
                "moments of inertia about the center of mass: in the plane one number, in space those about the axes x, y and z \
                     through it, `[xx, yy, zz]`, and then the products `int rho x y dV`: `[xx, yy, zz, xy, yz, xz]`",
            )
            .of("mass * length^2")
            .otherwise("that of the mesh, with this mass"),
            Parameter::vector("center", "its center of mass at rest").of("length").otherwise("that of the mesh"),
        ])
        .see_also(&["add_joint", "add_body", "add_contact", "initial_velocity"])
        .example(plate_example(
            "let hoop = ring(#{ inner_radius: 1.0, outer_radius: 1.2, cells: [1, 24], center: [5.0, 0.0] });\n\
             let cage = press.add_rigid_body(\"cage\", hoop, #{ density: 1.0 });\n\
             let rod = press.add_rigid_body(\"rod\", rectangle(#{ size: [2.0, 0.1], cells: [4, 1], origin: [8.0, 0.0] }), #{ mass: 2.0, \
             inertia: 0.7 });",
        ))
        .body(|call, model| {
            let (name, mesh) = (call.name("name")?, call.handle::<MeshHandle>("mesh")?.mesh());
            if let Err(error) = mesh.check() {
                let failure = call.argument("mesh").fail(error.to_string()).code(error.code()).label("the mesh cannot be computed with");
                return Err(failure.hint(error.remedy()).into());
            }
            refuse_or_warn_of_surface(call, &mesh)?;
            let options = call.options("options")?;
            let (material, inertia) = mass_of(&options, &mesh)?;
            let definition = BodyDefinition { name, mesh, material, formulation: Formulation::default(), rigid: Some(inertia) };
            change(call, &model, |data| data.model.bodies.push(definition))?;
            let index = model.0.borrow().model.bodies.len() - 1;
            Ok(BodyHandle { model, index })
        })
}

/// Material of a rigid body with the given density.
fn material_of(argument: &Argument, density: f64) -> Result<Material, Failure> {
    let made = NeoHookean { youngs_modulus: density, poisson_ratio: ANY_RATIO, density }.material();
    made.map_err(|error| argument.fail(error.to_string()).code(error.code()))
}

/// Returns material (for the density) and inertia of a rigid body.
fn mass_of(options: &Options, mesh: &Mesh) -> Result<(Material, Inertia), Failure> {
    let (density, mass) = (options.optional_number("density")?, options.optional_number("mass")?);
    let argument = options.argument("mass");
    let density = match (density, mass) {
        (None, None) => {
            let failure = argument.refuse(causes::OPTIONS_TOGETHER, "a rigid body needs a mass");
            return Err(failure
                .hint("give `density`, from which the mass of its mesh follows, or `mass` and, if it is not that of the mesh, `inertia`"));
        }
        (Some(_), Some(_)) => {
            let failure = argument.refuse(causes::OPTIONS_TOGETHER, "`density` and `mass` say the same thing twice");
            return Err(failure.hint("leave one of them out: the density is that of the mesh's volume"));
        }
        (Some(density), None) => density,
        (None, Some(mass)) => mass / mesh.measure(),
    };
    let material = material_of(&argument, density)?;
    let of_mesh = Inertia::of_mesh(mesh, &material, Formulation::default());
    let mut inertia = of_mesh.map_err(|inverted| argument.fail(format!("cell {} of the mesh is inside out", inverted.cell)))?;
    let center = options.argument("center");
    if center.is_given() {
        inertia.center = center.vector(mesh.dimension())?;
    }
    let moments = options.argument("inertia");
    if moments.is_given() {
        inertia = moments_of(&moments, &inertia, mesh.dimension())?;
    }
    Ok((material, inertia))
}

/// Returns the inertia given by numbers.
fn moments_of(argument: &Argument, of_mesh: &Inertia, dimension: usize) -> Result<Inertia, Failure> {
    let value = argument.value();
    let array = value.clone().try_cast::<Array>();
    let numbers: Option<Vec<f64>> = match &array {
        Some(array) => array.iter().map(number_of).collect(),
        None => number_of(&value).map(|number| vec![number]),
    };
    match (dimension, numbers.as_deref()) {
        (2, Some(&[moment])) => Ok(Inertia::in_plane(of_mesh.mass, of_mesh.center, moment)),
        (3, Some(&[xx, yy, zz])) => Ok(Inertia::of_moments(of_mesh.mass, of_mesh.center, [[xx, 0.0, 0.0], [0.0, yy, 0.0], [0.0, 0.0, zz]])),
        (3, Some(&[xx, yy, zz, xy, yz, xz])) => {
            Ok(Inertia::of_moments(of_mesh.mass, of_mesh.center, [[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]]))
        }
        _ => {
            let wanted = if dimension == 2 { "one number in the plane" } else { "an array of 3 or 6 numbers in space" };
            let failure = argument.wrong(causes::WRONG_TYPE, format!("must be {wanted}"));
            Err(failure.hint(if dimension == 2 {
                "the moment about the axis across the plane, such as `inertia: 0.7`"
            } else {
                "moments about x, y and z through the center of mass, such as `inertia: [1.0, 1.0, 2.0]`; then products xy, yz, xz"
            }))
        }
    }
}

fn number_of(value: &Dynamic) -> Option<f64> {
    value.as_float().ok().or_else(|| value.as_int().ok().map(|whole| whole as f64)).filter(|number| number.is_finite())
}

/// Names of [`JointKind`] in scripts.
const KINDS: [&str; 7] = ["point", "hinge", "slider", "slot", "weld", "link", "cable"];

/// Parameters of a joint.
fn joint_options() -> Vec<Parameter> {
    let mut all = vec![
        Parameter::new(
            "kind",
            Kind::Choice(&KINDS),
            "what it leaves free: turning about a point (`point`: a hinge in the plane, a ball joint in space), turning about an axis in \
             space (`hinge`), moving along a line without turning (`slider`), moving along a line of `to` and turning (`slot`), nothing \
             (`weld`), all but the distance of two points (`link`), or all as long as they are not farther apart than `length` (`cable`)",
        ),
        Parameter::object::<BodyHandle>("from", "the body that it holds"),
        Parameter::new("to", Kind::Either("a Body or \"ground\""), "the body that it holds it to, or the ground").or(GROUND),
        Parameter::vector("point", "where it is at rest: any point of a rigid body, a node of one that deforms").of("length"),
        Parameter::vector("to_point", "the point of `to`, where that is another one: the other end of a link")
            .of("length")
            .otherwise("`point`"),
        Parameter::vector("axis", "the axis of a hinge, or the direction of a slider or a slot, at rest")
            .of("length")
            .otherwise("the kind needs none"),
        Parameter::number("length", "length", Interval::Positive, "the length of a cable, at which it is taut")
            .otherwise("the distance of both points at rest"),
        Parameter::amplitude(
            "drive",
            "what a motor prescribes over time: the angle by which `from` turns in a hinge, in the plane in a point joint, about `axis` or \
             counter-clockwise, the travel in a slider or a slot, both 0 at the start; the distance of a link, the length of a cable",
        )
        .otherwise("nothing is prescribed"),
        Parameter::array(
            "limits",
            "`[least, largest]` angle or travel, at which it meets a stop without friction and bounces without loss; of a link the \
             distances between which it is free",
        )
        .otherwise("none"),
    ];
    all.extend(friction_options());
    all
}

/// Function `add_joint` of scripts.
pub fn add_joint() -> Function {
    method_of::<ModelHandle>(Topic::Model, "add_joint")
        .summary("joins two bodies, or a body and the ground, exactly: by constraints, without stiffness and without play")
        .parameters(vec![
            Parameter::text("name", "its name, unique among joints"),
            Parameter::options("what it joins, and how").keys(joint_options()),
        ])
        .see_also(&["add_rigid_body", "add_motor", "add_spring", "tie", "fix"])
        .example(plate_example(
            "let rod = press.add_rigid_body(\"rod\", rectangle(#{ size: [2.0, 0.1], cells: [4, 1], origin: [2.0, 0.0] }), #{ density: 1.0 \
             });\n\
             press.add_joint(\"hinge\", #{ kind: \"point\", from: rod, to: plate, point: [2.0, 0.0] });\n\
             press.add_joint(\"rail\", #{ kind: \"slot\", from: rod, point: [4.0, 0.05], axis: [0.0, 1.0], limits: [-0.5, 0.5] });",
        ))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let from = body_of(&options.argument("from"), &model)?.index;
            let to = options.argument("to");
            let is_ground = !to.is_given() || to.value().read_lock::<ImmutableString>().is_some_and(|word| *word == GROUND);
            let to = if is_ground { None } else { Some(body_of(&to, &model)?.index) };
            let (kind, dimension) = (kind_of(&options, &model.0.borrow().model)?, model.0.borrow().model.dimension());
            let point = options.argument("point").vector(dimension)?;
            let to_point = options.argument("to_point").given(|given| given.vector(dimension))?.unwrap_or(point);
            let mut ends = [Anchor { body: to, point: to_point }, Anchor { body: Some(from), point }];
            if kind == JointKind::Weld {
                refuse_weld_of_deformable(&name, &options.argument("kind"), &model.0.borrow().model, &ends)?;
            }
            for (end, argument) in ends.iter_mut().zip(["to_point", "point"]) {
                snap(&options.argument(argument), &model.0.borrow().model, end)?;
            }
            let drive = options.argument("drive").given(amplitude_of)?;
            let mut joint = JointDefinition { name, kind, ends, drive, limits: limits_of(&options)?, friction: None };
            joint.friction = friction_of(&options, &joint, dimension)?;
            set_length(&options, &mut joint)?;
            change(call, &model, |data| data.model.joints.push(joint))
        })
}

/// Kind and direction of a joint.
fn kind_of(options: &Options, model: &Model) -> Result<JointKind, Failure> {
    let (word, axis) = (options.text("kind")?, options.argument("axis"));
    let needs = matches!(word.as_str(), "hinge" | "slider" | "slot");
    if axis.is_given() && !needs {
        let failure = axis.wrong(causes::OPTIONS_TOGETHER, format!("has no meaning for a joint of the kind \"{word}\""));
        return Err(failure.hint("leave it out, or take the kind \"hinge\", \"slider\" or \"slot\""));
    }
    if word == "hinge" && model.dimension() == 2 {
        let failure = options.argument("kind").refuse(causes::DIMENSION, "a hinge about an axis is one in space, and the bodies are plane");
        return Err(failure.hint("in the plane take `kind: \"point\"` without `axis`: it leaves turning about the point free"));
    }
    if needs && !axis.is_given() {
        let what = if word == "hinge" { "the axis about which it turns" } else { "the direction of its line" };
        let failure = options.argument("kind").refuse(causes::OPTIONS_TOGETHER, format!("a {word} needs `axis`: {what}"));
        let example = if model.dimension() == 3 { "[0.0, 0.0, 1.0]" } else { "[1.0, 0.0]" };
        return Err(failure.hint(format!("give it, such as `axis: {example}`")));
    }
    let direction = if needs { axis.vector(model.dimension())? } else { [0.0; 3] };
    Ok(match word.as_str() {
        "hinge" => JointKind::Hinge(direction),
        "slider" => JointKind::Slider(direction),
        "slot" => JointKind::Slot(direction),
        "weld" => JointKind::Weld,
        "link" => JointKind::Link,
        "cable" => JointKind::Cable(0.0),
        _ => JointKind::Point,
    })
}

/// Least and largest coordinate of a joint, from the option `limits`.
fn limits_of(options: &Options) -> Result<Option<[f64; 2]>, Failure> {
    let argument = options.argument("limits");
    if !argument.is_given() {
        return Ok(None);
    }
    let values = argument.value().try_cast::<Array>().unwrap_or_default();
    match values.iter().map(number_of).collect::<Option<Vec<f64>>>().as_deref() {
        Some(&[least, largest]) if least < largest => Ok(Some([least, largest])),
        _ => {
            let failure = argument.wrong(causes::WRONG_TYPE, "must be two numbers, the least and the largest");
            Err(failure.hint("such as `limits: [deg(-30), deg(45)]`, or `limits: [0.0, 0.5]`"))
        }
    }
}

/// Sets the length of a cable.
fn set_length(options: &Options, joint: &mut JointDefinition) -> Result<(), Failure> {
    let given = options.optional_number("length")?;
    let argument = options.argument("length");
    match joint.kind {
        JointKind::Cable(_) => {
            let distance = joint.distance().iter().map(|x| x * x).sum::<f64>().sqrt();
            joint.kind = JointKind::Cable(given.unwrap_or(distance));
            Ok(())
        }
        _ if given.is_none() => Ok(()),
        _ => Err(argument
            .refuse(causes::OPTIONS_TOGETHER, "only a cable has a `length`")
            .hint("leave it out: a link keeps the distance of its points in the undeformed model")),
    }
}

/// Refuses a weld at a node of a deformable body, which has no directions.
fn refuse_weld_of_deformable(name: &str, kind: &Argument, model: &Model, ends: &[Anchor; 2]) -> Result<(), Failure> {
    let deformable = ends.iter().filter_map(|end| end.body).find(|&body| model.bodies[body].rigid.is_none());
    let Some(body) = deformable.map(|body| &model.bodies[body]) else { return Ok(()) };
    let reason = format!("a weld needs directions, and a node of body \"{}\", which deforms, has none", body.name);
    let error = ModelError::Unsound { what: "joint", name: name.into(), reason, remedy: "" };
    Err(kind.fail(error.to_string()).code(error.code()).hint(
        "`model.tie(name, #{ secondary: body.boundary(…), primary: … })` welds a boundary to another body, `model.add_coupling` its mean \
         motion to a rigid one, and `model.fix` holds it to the ground",
    ))
}

/// Moves an end of a joint to the nearest node if its body is deformable.
fn snap(argument: &Argument, model: &Model, end: &mut Anchor) -> Result<(), Failure> {
    let Some(index) = end.body.filter(|&body| model.bodies[body].rigid.is_none()) else { return Ok(()) };
    let (body, (node, distance), start) = (&model.bodies[index], model.nearest_node(index, end.point), model.start(index));
    let cell = (body.mesh.measure() / body.mesh.cell_count() as f64).powf(1.0 / body.mesh.dimension() as f64);
    if distance > tolerances::SAME_NODE * cell {
        let failure = argument.refuse(causes::OTHER_OWNER, format!("there is no node of body \"{}\" at this point", body.name));
        let place = vector_text(&start[node as usize][..body.mesh.dimension()]);
        let failure = failure.label(format!("the nearest is at {place}, {} away", brief(distance)));
        return Err(failure.hint("a joint holds a body that deforms at a node: give its place, or refine the mesh to have one there"));
    }
    end.point = start[node as usize];
    Ok(())
}
