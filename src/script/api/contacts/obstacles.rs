//! Rigid obstacles: shapes that other bodies touch, at rest or displaced over time.

use rhai::Dynamic;

use crate::contact::{Obstacle, ObstacleInSpace};
use crate::dynamics::Amplitude;
use crate::math::catalogue::Interval;
use crate::script::api::models::description::describe_obstacle;
use crate::script::api::time_functions::amplitude_of;
use crate::script::language::arguments::{Argument, Arguments, Options};
use crate::script::language::causes;
use crate::script::language::digits::vector_text;
use crate::script::language::failure::Failure;
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::handle::Handle;
use crate::script::language::parameter::{Absent, Kind, Parameter};

/// A rigid obstacle with its motion.
#[derive(Clone)]
pub struct ObstacleHandle {
    /// Shape and place.
    pub obstacle: Obstacle,
    /// Displacement over time for each direction.
    pub motion: [Option<Amplitude>; 3],
    /// Rotation angle about the center over time.
    pub turn: Option<Amplitude>,
}

impl Handle for ObstacleHandle {
    const NAME: &'static str = "Obstacle";
    const MAKER: &'static str = "make one with `rigid_plane`, `rigid_disk`, `rigid_ring` or `rigid_polyline`, in space with `rigid_plane`, \
                                 `rigid_sphere`, `rigid_cylinder`, `rigid_cone`, `rigid_torus`, `rigid_box` or `rigid_surface`";

    fn describe(&self) -> String {
        describe_obstacle(&self.obstacle, &self.motion, self.turn.as_ref())
    }
}

/// Possible motions of an obstacle.
#[derive(Clone, Copy, PartialEq)]
pub enum Moves {
    /// Along x and y.
    InPlane,
    /// Along x and y, and rotating about its center.
    Round,
    /// Along x, y and z.
    InSpace,
    /// Along x, y and z, and rotating about its axis.
    AboutAxis,
    /// Along x, y and z, and in space rotating about its normal.
    AboutNormal,
}

impl Moves {
    fn is_in_space(self) -> bool {
        matches!(self, Moves::InSpace | Moves::AboutAxis | Moves::AboutNormal)
    }
}

fn motion_parameter(moves: Moves) -> Parameter {
    let component = |name| Parameter::new(name, Kind::Amplitude, "the displacement in this direction over time").of("length");
    let axes = if moves.is_in_space() { &["x", "y", "z"][..] } else { &["x", "y"] };
    let mut components: Vec<Parameter> = axes.iter().map(|&name| component(name).or(Absent::Means("none"))).collect();
    let about = match moves {
        Moves::Round => Some("the angle by which it has turned about its center, counter-clockwise, over time: friction feels it"),
        Moves::AboutAxis => Some("the angle by which it has turned about its axis, as a right-handed screw, over time: friction feels it"),
        Moves::AboutNormal => Some(
            "the angle by which it has turned in space about the normal through `point`, as a right-handed screw, over time: friction \
             feels it, as on a turntable",
        ),
        _ => None,
    };
    if let Some(angle) = about {
        components.push(Parameter::new("angle", Kind::Amplitude, angle).of("rad").or(Absent::Means("none")));
    }
    let summary = match about {
        Some(_) => "how the obstacle moves over time",
        None => "how the obstacle is displaced over time; what turns is a rigid body with a joint whose `drive` is the angle",
    };
    Parameter::new("motion", Kind::Options(components), summary).or(Absent::Means("at rest"))
}

/// Alternatives in the plane and in space, for messages.
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
    Function {
        name,
        form: Form::Function,
        topic: Topic::Contact,
        summary,
        parameters: vec![Parameter::new("options", Kind::Options(keys), "shape, place and motion")],
        returns: ObstacleHandle::NAME,
        example: example.into(),
        see_also: if moves.is_in_space() { IN_SPACE } else { IN_PLANE },
        body: body(move |call| {
            let options = call.options("options")?;
            let obstacle = make(&options)?;
            let nested = options.nested("motion")?;
            let over_time = |name: &'static str| {
                let argument = nested.argument(name);
                if argument.is_given() { amplitude_of(&argument).map(Some) } else { Ok(None) }
            };
            let along_z = if moves.is_in_space() { over_time("z")? } else { None };
            let motion = [over_time("x")?, over_time("y")?, along_z];
            let turns = matches!(moves, Moves::Round | Moves::AboutAxis | Moves::AboutNormal);
            let turn = if turns { over_time("angle")? } else { None };
            if turn.is_some() && moves == Moves::AboutNormal && !matches!(obstacle, Obstacle::InSpace(_)) {
                let failure = nested.argument("angle").fail("a border of the plane does not turn about its normal").code(causes::DIMENSION);
                return Err(failure.hint("leave it out, or take a rigid body whose boundary is moved with `prescribe`").into());
            }
            if motion[2].is_some() && !matches!(obstacle, Obstacle::InSpace(_)) {
                let argument = nested.argument("z");
                let failure = argument.fail("an obstacle of the plane does not move along z").code(causes::DIMENSION);
                return Err(failure.hint("leave it out, or give a point and a normal of 3 numbers").into());
            }
            Ok(Dynamic::from(ObstacleHandle { obstacle, motion, turn }))
        }),
    }
}

/// Parameter of a point.
pub fn point(name: &'static str, summary: &'static str) -> Parameter {
    Parameter::new(name, Kind::Vector, summary).of("length")
}

/// Parameter of a radius.
pub fn radius(summary: &'static str) -> Parameter {
    Parameter::number("radius", "length", Interval::Positive, summary)
}

/// Vector in space in an argument; refused if zero.
pub fn direction(argument: &Argument) -> Result<[f64; 3], Failure> {
    let vector = argument.vector(3)?;
    if vector == [0.0; 3] {
        let failure = argument.fail(format!("{} has no direction", argument.title())).code(causes::NO_DIRECTION);
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
            Parameter::new("normal", Kind::Vector, "the outward normal of its border, of any length: bodies are on that side").of("1"),
        ],
        Moves::AboutNormal,
        "let ground = rigid_plane(#{ point: [0.0, 0.0], normal: [0.0, 1.0] });",
        |options| {
            let (argument, point) = (options.argument("normal"), options.argument("point"));
            if point.numbers()?.len() == 3 {
                let (point, normal) = (point.vector(3)?, direction(&argument)?);
                return Ok(Obstacle::InSpace(ObstacleInSpace::Plane { point, normal }));
            }
            let (point, normal) = (point.vector(2)?, argument.vector(2)?);
            if normal == [0.0; 3] {
                let failure = argument.fail(format!("{} has no direction", argument.title())).code(causes::NO_DIRECTION);
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
        vec![Parameter::new("points", Kind::Array, "an array of points `[x, y]`; closed when the last is the first").of("length")],
        Moves::InPlane,
        "let stairs = rigid_polyline(#{ points: [[4.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]] });",
        |options| {
            let argument = options.argument("points");
            let points = argument.points()?;
            if points.len() < 2 {
                let failure = argument.fail(format!("{} must have at least 2 points", argument.title())).code(causes::COUNT);
                return Err(failure.label(format!("this has {}", points.len())).hint("name the ends of at least one facet"));
            }
            if let Some(twice) = points.windows(2).find(|pair| pair[0] == pair[1]) {
                let failure = argument.fail(format!("{} has a facet of length 0", argument.title())).code(causes::NO_DIRECTION);
                return Err(failure.label(format!("{} comes twice in a row", vector_text(&twice[0]))).hint("leave out one of the two"));
            }
            Ok(Obstacle::Polyline { points })
        },
    )
}
