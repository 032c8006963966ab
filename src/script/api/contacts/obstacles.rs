//! Rigid obstacles: shapes that other bodies touch, at rest or displaced over time.

use crate::contact::{Obstacle, ObstacleInSpace, TurningAxis};
use crate::dynamics::{Amplitude, ObstacleRotation};
use crate::script::api::models::description::{describe_obstacle, without_unit};
use crate::script::api::time_functions::amplitude_of;
use crate::script::language::digits::vector_text;
use crate::script::language::prelude::*;

/// A rigid obstacle with its motion.
#[derive(Clone)]
pub struct ObstacleHandle {
    /// Shape and place.
    pub obstacle: Obstacle,
    /// Displacement over time for each direction.
    pub motion: [Option<Amplitude>; 3],
    /// Rotation over time.
    pub turn: Option<ObstacleRotation>,
}

impl Handle for ObstacleHandle {
    const NAME: &'static str = "Obstacle";
    const MAKER: &'static str = "make one with `rigid_plane`, `rigid_disk`, `rigid_ring` or `rigid_polyline`, in space with `rigid_plane`, \
                                 `rigid_sphere`, `rigid_cylinder`, `rigid_cone`, `rigid_torus`, `rigid_box` or `rigid_surface`";

    fn describe(&self) -> String {
        describe_obstacle(&self.obstacle, &self.motion, self.turn.as_ref(), &without_unit)
    }
}

/// Kinds of obstacle shapes, which determine the options for their motion.
#[derive(Clone, Copy, PartialEq)]
pub enum Moves {
    /// A half plane, in space a plane.
    Plane,
    /// A disk or ring.
    Round,
    /// A polyline.
    Polyline,
    /// A body of revolution in space.
    AboutAxis,
    /// A box.
    Box,
    /// A surface of facets.
    Surface,
}

impl Moves {
    fn is_in_space(self) -> bool {
        matches!(self, Moves::AboutAxis | Moves::Box | Moves::Surface)
    }

    /// Meanings of an angle, of a missing point and of a missing axis for a kind of shape, for the reference.
    fn rotation(self) -> [&'static str; 3] {
        match self {
            Moves::Plane => [
                "the angle by which it has turned over time: in the plane its border tilts about a point, counter-clockwise; in space it \
                 turns about its normal through `point`, as a right-handed screw, with effect on friction only as on a turntable, or tilts \
                 about another axis",
                "`point`",
                "in space the normal",
            ],
            Moves::Round => [
                "the angle by which it has turned over time, counter-clockwise: about its center, which affects friction only, or about \
                 another point, as a cam does",
                "its center",
                "",
            ],
            Moves::Polyline => ["the angle by which it has turned over time, counter-clockwise", "", ""],
            Moves::AboutAxis => [
                "the angle by which it has turned over time, as a right-handed screw: about its own axis, which affects friction only, or \
                 about another one",
                "a point of its own axis",
                "its own axis",
            ],
            Moves::Box => ["the angle by which it has turned over time, as a right-handed screw", "its middle", "the `axis` of the box"],
            Moves::Surface => ["the angle by which it has turned over time, as a right-handed screw", "", "along z"],
        }
    }
}

fn motion_parameter(moves: Moves) -> Parameter {
    let component = |name| Parameter::amplitude(name, "the displacement in this direction over time").of("length");
    let [angle, point, axis] = moves.rotation();
    let has_axis = !axis.is_empty();
    let axes = if has_axis { &["x", "y", "z"][..] } else { &["x", "y"] };
    let mut components: Vec<Parameter> = axes.iter().map(|&name| component(name).otherwise("none")).collect();
    components.push(Parameter::amplitude("angle", angle).of("rad").otherwise("none"));
    let about = Parameter::vector("about", "a point of the axis about which it turns; the point moves with the obstacle");
    let about = about.of("length").otherwise(if point.is_empty() { "needed with an `angle`" } else { point });
    components.push(about);
    if has_axis {
        components.push(Parameter::vector("axis", "the axis about which it turns, of any length").of("1").otherwise(axis));
    }
    Parameter::map("motion", "how the obstacle moves over time").otherwise("at rest").keys(components)
}

/// Returns the rotation in the options `motion` of an obstacle with the options `options`.
fn rotation_of(moves: Moves, obstacle: &Obstacle, options: &Options, motion: &Options) -> Result<Option<ObstacleRotation>, Failure> {
    let is_in_space = matches!(obstacle, Obstacle::InSpace(_));
    let (angle, about) = (motion.argument("angle"), motion.argument("about"));
    let axis = (!moves.rotation()[2].is_empty()).then(|| motion.argument("axis")).filter(Argument::is_given);
    if !angle.is_given() {
        let given = axis.as_ref().or(Some(&about).filter(|about| about.is_given()));
        return given.map_or(Ok(None), |given| {
            let failure = given.wrong(causes::OPTIONS_TOGETHER, "has no meaning without an `angle`");
            Err(failure.hint("give the `angle` over time, such as `|t| 2.0 * t`, or leave this out"))
        });
    }
    if let Some(axis) = axis.as_ref().filter(|_| !is_in_space) {
        let failure = axis.refuse(causes::DIMENSION, "an obstacle of the plane turns about a point");
        return Err(failure.hint("leave the axis out, or give a point and a normal of 3 numbers"));
    }
    let angle = amplitude_of(&angle)?;
    let own = own_axis(moves, obstacle);
    let has_own = moves == Moves::Round || moves == Moves::AboutAxis || (moves == Moves::Plane && is_in_space);
    if has_own && !about.is_given() && axis.is_none() {
        return Ok(Some(ObstacleRotation { angle, about: None }));
    }
    let center = match (about.is_given(), own) {
        (true, _) => about.vector(if is_in_space { 3 } else { 2 })?,
        (false, Some([center, _])) => center,
        (false, None) => {
            let failure = about.refuse(causes::MISSING, "a rotation needs a point of its axis");
            return Err(failure.label("this has an `angle` alone").hint("write `about: [0.0, 0.0]`, in space `about: [0.0, 0.0, 0.0]`"));
        }
    };
    let of_shape = match moves {
        Moves::Box if options.argument("axis").is_given() => direction(&options.argument("axis"))?,
        _ => own.map_or([0.0, 0.0, 1.0], |[_, axis]| axis),
    };
    let axis = axis.as_ref().map_or(Ok(of_shape), direction)?;
    Ok(Some(ObstacleRotation { angle, about: Some(TurningAxis::new(center, axis)) }))
}

/// Point and direction of the axis that a shape has by itself; `None` for polylines and surfaces.
fn own_axis(moves: Moves, obstacle: &Obstacle) -> Option<[[f64; 3]; 2]> {
    let up = [0.0, 0.0, 1.0];
    match obstacle {
        Obstacle::HalfPlane { point: [x, y], .. } | Obstacle::Disk { center: [x, y], .. } | Obstacle::Ring { center: [x, y], .. } => {
            Some([[*x, *y, 0.0], up])
        }
        Obstacle::Polyline { .. } => None,
        Obstacle::InSpace(shape) => match shape {
            ObstacleInSpace::Plane { point, normal } => Some([*point, *normal]),
            ObstacleInSpace::Sphere { center, axis, .. }
            | ObstacleInSpace::Cylinder { point: center, axis, .. }
            | ObstacleInSpace::FiniteCylinder { center, axis, .. }
            | ObstacleInSpace::Cone { tip: center, axis, .. }
            | ObstacleInSpace::Torus { center, axis, .. } => Some([*center, *axis]),
            ObstacleInSpace::Facets(facets) => (moves == Moves::Box).then(|| {
                let (points, share) = (facets.points(), 1.0 / facets.points().len() as f64);
                [std::array::from_fn(|i| points.iter().map(|point| share * point[i]).sum()), up]
            }),
        },
    }
}

/// Obstacle functions that correspond to each other in the plane and in space, for messages.
const IN_PLANE: &[&str] = &["add_contact", "rigid_plane", "rigid_disk", "rigid_ring", "rigid_polyline"];
const IN_SPACE: &[&str] =
    &["add_contact", "rigid_plane", "rigid_sphere", "rigid_cylinder", "rigid_cone", "rigid_torus", "rigid_box", "rigid_surface"];

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![rigid_plane(), rigid_disk(), rigid_ring(), rigid_polyline()]
}

/// Returns a function that makes an obstacle of a shape, with a prescribed motion.
pub fn shape(
    name: &'static str,
    summary: &'static str,
    mut keys: Vec<Parameter>,
    moves: Moves,
    example: &'static str,
    make: fn(&Options) -> Result<Obstacle, Failure>,
) -> Function {
    keys.push(motion_parameter(moves));
    function(Topic::Contact, name)
        .summary(summary)
        .parameters(vec![Parameter::options("shape, place and motion").keys(keys)])
        .see_also(if moves.is_in_space() || moves == Moves::Plane { IN_SPACE } else { IN_PLANE })
        .example(example)
        .body_with_options(move |_, options| {
            let obstacle = make(&options)?;
            let nested = options.nested("motion")?;
            let over_time = |name: &'static str| nested.argument(name).given(amplitude_of);
            let along_z = if moves.is_in_space() || moves == Moves::Plane { over_time("z")? } else { None };
            let motion = [over_time("x")?, over_time("y")?, along_z];
            let turn = rotation_of(moves, &obstacle, &options, &nested)?;
            if motion[2].is_some() && !matches!(obstacle, Obstacle::InSpace(_)) {
                let argument = nested.argument("z");
                let failure = argument.refuse(causes::DIMENSION, "an obstacle of the plane does not move along z");
                return Err(failure.hint("leave it out, or give a point and a normal of 3 numbers").into());
            }
            Ok(ObstacleHandle { obstacle, motion, turn })
        })
}

/// Parameter of a point.
pub fn point(name: &'static str, summary: &'static str) -> Parameter {
    Parameter::vector(name, summary).of("length")
}

/// Parameter of a radius.
pub fn radius(summary: &'static str) -> Parameter {
    Parameter::number("radius", "length", Interval::Positive, summary)
}

/// Vector in space in an argument; refused if zero.
pub fn direction(argument: &Argument) -> Result<[f64; 3], Failure> {
    let vector = argument.vector(3)?;
    if vector == [0.0; 3] {
        let failure = argument.wrong(causes::NO_DIRECTION, "has no direction");
        return Err(failure.label("this has length 0").hint("give a direction, such as `[0.0, 0.0, 1.0]`"));
    }
    Ok(vector)
}

fn rigid_plane() -> Function {
    shape(
        "rigid_plane",
        "a rigid plane as the other side of a contact: all behind it is rigid; in the plane a half plane",
        vec![
            point("point", "a point of its border, of 2 or, in space, of 3 numbers"),
            Parameter::vector("normal", "the outward normal of its border, of any length: bodies are on that side").of("1"),
        ],
        Moves::Plane,
        "let ground = rigid_plane(#{ point: [0.0, 0.0], normal: [0.0, 1.0] });",
        |options| {
            let (argument, point) = (options.argument("normal"), options.argument("point"));
            if point.numbers()?.len() == 3 {
                let (point, normal) = (point.vector(3)?, direction(&argument)?);
                return Ok(Obstacle::InSpace(ObstacleInSpace::Plane { point, normal }));
            }
            let (point, normal) = (point.vector(2)?, argument.vector(2)?);
            if normal == [0.0; 3] {
                let failure = argument.wrong(causes::NO_DIRECTION, "has no direction");
                return Err(failure.label("this has length 0").hint("give the direction away from the plane, such as `[0.0, 1.0]`"));
            }
            Ok(Obstacle::HalfPlane { point: [point[0], point[1]], normal: [normal[0], normal[1]] })
        },
    )
}

fn rigid_disk() -> Function {
    shape(
        "rigid_disk",
        "a rigid disk as the other side of a contact; bodies are outside of it",
        vec![point("center", "its center"), radius("its radius")],
        Moves::Round,
        "let roller = rigid_disk(#{ center: [0.0, 2.0], radius: 0.5, motion: #{ y: ramp(0.0, 1.0, -0.7) } });",
        |options| {
            let center = options.argument("center").vector(2)?;
            Ok(Obstacle::Disk { center: [center[0], center[1]], radius: options.number("radius")? })
        },
    )
}

fn rigid_ring() -> Function {
    shape(
        "rigid_ring",
        "a rigid ring as the other side of a contact; bodies are inside of it",
        vec![point("center", "its center"), radius("its inner radius")],
        Moves::Round,
        "let drum = rigid_ring(#{ center: [0.0, 0.0], radius: 2.0 });",
        |options| {
            let center = options.argument("center").vector(2)?;
            Ok(Obstacle::Ring { center: [center[0], center[1]], radius: options.number("radius")? })
        },
    )
}

fn rigid_polyline() -> Function {
    shape(
        "rigid_polyline",
        "straight rigid facets as the other side of a contact: the obstacle is on the left of the way through the points",
        vec![Parameter::array("points", "an array of points `[x, y]`; closed when the last is the first").of("length")],
        Moves::Polyline,
        "let stairs = rigid_polyline(#{ points: [[4.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]] });",
        |options| {
            let argument = options.argument("points");
            let points = argument.points()?;
            if points.len() < 2 {
                let failure = argument.wrong(causes::COUNT, "must have at least 2 points");
                return Err(failure.label(format!("this has {}", points.len())).hint("name the ends of at least one facet"));
            }
            if let Some(twice) = points.windows(2).find(|pair| pair[0] == pair[1]) {
                let failure = argument.wrong(causes::NO_DIRECTION, "has a facet of length 0");
                return Err(failure.label(format!("{} comes twice in a row", vector_text(&twice[0]))).hint("leave out one of the two"));
            }
            Ok(Obstacle::Polyline { points })
        },
    )
}
