//! Description of a model in words, as `print` shows it.

use super::data::ModelData;
use super::joint_friction::friction_text;
use crate::contact::{FacetShape, Obstacle, ObstacleInSpace, TurningAxis};
use crate::dynamics::{
    Amplitude, AxisRotation, BodyBoundary, BodyDefinition, Coordinate, Coupling, CouplingKind, Gear, Interaction, JointKind, Model,
    ObstacleRotation, Partner, Prescription,
};
use crate::script::api::meshes::handle::describe_mesh;
use crate::script::language::digits::{number_text, vector_text};
use crate::script::language::wording::joined;

/// Function that adds the unit of a dimension to a number.
pub type AddUnit<'a> = &'a dyn Fn(String, &str) -> String;

/// A number as it is, where no units are declared.
pub fn without_unit(number: String, _dimension: &str) -> String {
    number
}

/// Describes a model: name, bodies, supports, loads and contact, one line each; `told` adds the unit of a dimension to a number.
pub fn describe_model(data: &ModelData, told: AddUnit) -> String {
    let model = &data.model;
    // The unit of a function of time stands behind its name.
    let named = |name: &str, dimension: &str| match told(String::new(), dimension) {
        unit if unit.is_empty() => name.to_string(),
        unit => format!("{name} [{}]", unit.trim()),
    };
    let mut lines = vec![format!("model \"{}\"", model.name)];
    let rigid = |body: &BodyDefinition| if body.rigid.is_some() { "rigid body" } else { "body" };
    lines.extend(model.bodies.iter().map(|body| format!("  {} \"{}\": {}", rigid(body), body.name, describe_mesh(&body.mesh))));
    lines.extend(model.supports.iter().map(|support| {
        let names = ["x", "y", "z"].into_iter().zip(support.components).take(model.dimension()).filter(|(_, held)| *held);
        format!("  fixed \"{}\" in {}", model.boundary_name(&support.on), names.map(|(name, _)| name).collect::<Vec<_>>().join(", "))
    }));
    lines.extend(model.prescriptions.iter().flat_map(|given| {
        let boundary = model.boundary_name(&given.on);
        let unit_of = |what: &str| if what.starts_with("angle") { "angle" } else { "length" };
        let line = move |(what, function): (String, String)| {
            format!("  prescribed {} of \"{boundary}\": {function}", named(&what, unit_of(&what)))
        };
        prescribed(given).into_iter().map(line).collect::<Vec<_>>()
    }));
    lines.extend(model.couplings.iter().map(|coupling| format!("  {}", describe_coupling(model, coupling))));
    lines.extend(data.loads.iter().map(|load| match told(String::new(), load.dimension) {
        unit if unit.is_empty() => format!("  {}", load.title),
        unit => format!("  {}, in {}", load.title, unit.trim()),
    }));
    if model.gravity != [0.0; 3] {
        lines.push(format!("  gravity {}", told(vector_text(&model.gravity[..model.dimension()]), "length/time^2")));
    }
    lines.extend(model.joints.iter().map(|joint| {
        if let JointKind::Gear(Gear { joints, ratio }) = joint.kind {
            let [first, second] = joints.map(|index| &model.joints[index].name);
            return format!("  gear \"{}\" of joints \"{first}\" and \"{second}\" with the ratio {}", joint.name, number_text(ratio));
        }
        let names =
            joint.ends.iter().rev().map(|end| end.body.map_or("the ground".into(), |body| format!("\"{}\"", model.bodies[body].name)));
        let at = told(vector_text(&joint.ends[1].point[..model.dimension()]), "length");
        let what = joint.kind.coordinate(model.dimension()).map_or("", Coordinate::name);
        let drive = joint.drive.as_ref().map_or(String::new(), |drive| format!(", {what} {}", drive.describe()));
        let limits = joint.limits.map_or(String::new(), |[least, largest]| format!(", {what} from {least} to {largest}"));
        let names = joined(&names.collect::<Vec<_>>(), "and");
        let friction = joint.friction.map_or(String::new(), |friction| format!(", {}", friction_text(&friction)));
        format!("  joint \"{}\": {} of {names} at {at}{drive}{limits}{friction}", joint.name, joint.kind.name())
    }));
    lines.extend(model.parts.iter().map(|part| format!("  {}", part.describe())));
    lines.extend(describe_contacts(model, told));
    lines.join("\n")
}

/// Returns the prescribed directions or angles with their functions of time, such as `x` and `ramp(0, 1, 0.1)`.
pub fn prescribed(given: &Prescription) -> Vec<(String, String)> {
    let along = ["x", "y", "z"].into_iter().zip(&given.displacement);
    let along = along.filter_map(|(name, function)| Some((name.to_string(), function.as_ref()?.describe())));
    let turn = given.turn.iter().map(|turn| {
        let axis = if turn.axis == AxisRotation::UPRIGHT { String::new() } else { format!(" and the axis {}", vector_text(&turn.axis)) };
        let center = if axis.is_empty() { &turn.center[..2] } else { &turn.center[..] };
        (format!("angle about {}{axis}", vector_text(center)), turn.angle.describe())
    });
    along.chain(turn).collect()
}

/// Returns the description of a coupling.
fn describe_coupling(model: &Model, Coupling { name, kind }: &Coupling) -> String {
    let dimension = model.dimension();
    match kind {
        CouplingKind::Plane { on, normal } => {
            let boundary = model.boundary_name(on);
            format!("symmetry \"{name}\": \"{boundary}\" held along {}", vector_text(&normal[..dimension]))
        }
        CouplingKind::Reference { on, to, is_rigid } => {
            let kind = if *is_rigid { "rigid" } else { "distributing" };
            format!("{kind} coupling \"{name}\": \"{}\" to body \"{}\"", model.boundary_name(on), model.bodies[*to].name)
        }
        CouplingKind::Periodic { from, to, turn, offset, follows } => {
            let [from, to] = [from, to].map(|on| model.boundary_name(on));
            let turn = turn.map_or(String::new(), |turn| format!(", turned by {} rad", number_text(turn.angle)));
            let given = ["x", "y", "z"].into_iter().zip(offset).filter_map(|(name, function)| Some((name, function.as_ref()?)));
            let moved: String = given.map(|(name, function)| format!(", {name}: {}", function.describe())).collect();
            let follows = follows.map_or(String::new(), |body| format!(", following \"{}\"", model.bodies[body].name));
            format!("periodic pair \"{name}\": from \"{from}\" to \"{to}\"{turn}{moved}{follows}")
        }
    }
}

/// Describes contacts, obstacles and ties, one line each.
fn describe_contacts<'a>(model: &'a Model, told: AddUnit<'a>) -> impl Iterator<Item = String> + 'a {
    let named = |on: &BodyBoundary| format!("\"{}\"", model.boundary_name(on));
    model.interactions.iter().map(move |interaction| {
        let Interaction { name, secondary, partner, equality, friction, restitution, .. } = interaction;
        let secondary = named(secondary);
        let line = match partner {
            Partner::Surfaces(primary) => {
                let kind = if *equality { "bilateral contact" } else { "contact" };
                let primary: Vec<String> = primary.iter().map(named).collect();
                format!("  {kind} \"{name}\": secondary {secondary}, primary {}", joined(&primary, "and"))
            }
            Partner::Itself => format!("  contact \"{name}\": {secondary} with itself"),
            Partner::Obstacle { shape, motion, turn } => {
                format!("  contact \"{name}\": secondary {secondary}, {}", describe_obstacle(shape, motion, turn.as_ref(), told))
            }
            Partner::Tied { to, .. } => format!("  tie \"{name}\": secondary {secondary}, primary {}", named(to)),
        };
        let facets = match (&interaction.facets, &interaction.shapes) {
            (Some(FacetShape::Straight), _) => ", with straight facets",
            (_, [None, None]) => "",
            _ => ", with exact shapes",
        };
        let friction = if friction.is_some() { ", with friction" } else { "" };
        let restitution = restitution.map_or_else(String::new, |restitution| format!(", restitution {}", number_text(restitution)));
        format!("{line}{facets}{friction}{restitution}")
    })
}

/// Shape, place and motion of a rigid obstacle; `told` adds the unit of a dimension to a number.
pub fn describe_obstacle(obstacle: &Obstacle, motion: &[Option<Amplitude>; 3], turn: Option<&ObstacleRotation>, told: AddUnit) -> String {
    let (length, place) = (|x: &f64| told(number_text(*x), "length"), |x: &[f64]| told(vector_text(x), "length"));
    let shape = match obstacle {
        Obstacle::HalfPlane { point, normal } => format!("plane through {} with normal {}", place(point), vector_text(normal)),
        Obstacle::Disk { center, radius } => format!("disk of radius {} around {}", length(radius), place(center)),
        Obstacle::Ring { center, radius } => format!("ring of inner radius {} around {}", length(radius), place(center)),
        Obstacle::Polyline { points } => format!("polyline through {} points", points.len()),
        Obstacle::InSpace(shape) => describe_in_space(shape, told),
    };
    let motions = motion.iter().map(Option::as_ref).chain([turn.map(|turn| &turn.angle)]);
    let moved = ["x", "y", "z", "angle"].iter().zip(motions).filter_map(|(name, motion)| Some((name, motion?)));
    let moved: Vec<String> = moved.map(|(name, motion)| format!("{name}: {}", motion.describe())).collect();
    let about = turn.and_then(|turn| turn.about).map_or_else(String::new, |TurningAxis { center, direction }| match obstacle {
        Obstacle::InSpace(_) => format!(" about {} along {}", place(&center), vector_text(&direction)),
        _ => format!(" about {}", place(&center[..2])),
    });
    if moved.is_empty() { format!("rigid {shape}") } else { format!("rigid {shape}, moving by {}{about}", moved.join(", ")) }
}

fn describe_in_space(shape: &ObstacleInSpace, told: AddUnit) -> String {
    let (length, place) = (|x: &f64| told(number_text(*x), "length"), |x: &[f64; 3]| told(vector_text(x), "length"));
    let round = |what: &str, radius: &f64, is_hollow: &bool| {
        format!("{}{what} of {}radius {}", if *is_hollow { "hollow " } else { "" }, if *is_hollow { "inner " } else { "" }, length(radius))
    };
    match shape {
        ObstacleInSpace::Plane { point, normal } => format!("plane through {} with normal {}", place(point), vector_text(normal)),
        ObstacleInSpace::Sphere { center, radius, is_hollow, .. } => {
            format!("{} around {}", round("sphere", radius, is_hollow), place(center))
        }
        ObstacleInSpace::Cylinder { point, axis, radius, is_hollow } => {
            format!("{} around {} along {}", round("cylinder", radius, is_hollow), place(point), vector_text(axis))
        }
        ObstacleInSpace::FiniteCylinder { center, axis, radius, length: long, edge } => {
            let (round, edge) = (round("cylinder", radius, &false), length(edge));
            let (center, axis) = (place(center), vector_text(axis));
            format!("{round} and length {}, its edges of radius {edge}, around {center} along {axis}", length(long))
        }
        ObstacleInSpace::Cone { tip, axis, angle, is_hollow } => {
            let kind = if *is_hollow { "hollow cone" } else { "cone" };
            format!("{kind} from {} along {} with the half angle {}", place(tip), vector_text(axis), number_text(*angle))
        }
        ObstacleInSpace::Torus { center, axis, radius, tube, is_hollow } => {
            let (tube, center) = (round("tube", tube, is_hollow), place(center));
            format!("torus of radius {} and a {tube} around {center} along {}", length(radius), vector_text(axis))
        }
        ObstacleInSpace::Facets(facets) => format!("surface of {} triangles", facets.triangles().len()),
    }
}
