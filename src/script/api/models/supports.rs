//! Supports: boundaries that are fixed, or move by prescribed functions of time.

use rhai::Dynamic;

use super::arguments::{boundary_of, boundary_parameter};
use super::change::change;
use super::handle::ModelHandle;
use crate::dynamics::{Amplitude, AxisRotation, Prescription, Support};
use crate::math::norms::length;
use crate::script::api::examples::plate_example;
use crate::script::api::time_functions::amplitude_of;
use crate::script::language::prelude::*;

/// `fix`: fixes nodes at their positions.
pub fn fix() -> Function {
    Function {
        name: "fix",
        form: Form::Method(ModelHandle::receiver()),
        topic: Topic::Model,
        summary: "holds the nodes of a boundary, in all directions or in some",
        parameters: vec![
            boundary_parameter(),
            Parameter::new("components", Kind::Text, "the held directions, such as \"x\" or \"xy\"").or(Absent::Means("all directions")),
        ],
        returns: "",
        example: plate_example("press.fix(plate.boundary(\"left\"));\npress.fix(plate.boundary(\"bottom\"), \"y\");"),
        see_also: &["add_body"],
        body: body(|call| {
            let model = call.receiver::<ModelHandle>();
            let on = boundary_of(&call.argument("boundary"), &model)?;
            let dimension = model.0.borrow().model.dimension();
            let components = components(&call.argument("components"), dimension)?;
            change(call, &model, |data| data.model.supports.push(Support { on, components }))?;
            Ok(Dynamic::UNIT)
        }),
    }
}

/// `prescribe`: moves nodes.
pub fn prescribe() -> Function {
    Function {
        name: "prescribe",
        form: Form::Method(ModelHandle::receiver()),
        topic: Topic::Model,
        summary: "moves the nodes of a boundary in given directions by time functions, or turns them about a point (in space: about \
                  the axis through it) and moves them along",
        parameters: vec![boundary_parameter(), Parameter::new("motion", Kind::Options(motion_options()), "the motion over time")],
        returns: "",
        example: plate_example(
            "press.prescribe(plate.boundary(\"top\"), #{ y: ramp(0.0, 0.1, -0.05) });\n\
             press.prescribe(plate.boundary(\"bottom\"), #{ angle: |t| deg(90) * t, about: [1.0, 0.5] });",
        ),
        see_also: &["fix"],
        body: body(|call| {
            let model = call.receiver::<ModelHandle>();
            let (on, options) = (boundary_of(&call.argument("boundary"), &model)?, call.options("motion")?);
            let dimension = model.0.borrow().model.dimension();
            let displacement = along_axes(&options, dimension)?;
            let turn = match axis_of_turn(&options, dimension, "angle: |t| …")? {
                Some([center, axis]) => Some(AxisRotation { center, axis, angle: amplitude_of(&options.argument("angle"))? }),
                None => None,
            };
            if turn.is_none() && displacement.iter().all(Option::is_none) {
                let failure = call.argument("motion").fail("`prescribe` names no direction").code(causes::NO_DIRECTION);
                return Err(failure.hint("name one, such as `#{ y: ramp(0.0, 1.0, -0.1) }`; `fix` holds nodes where they are").into());
            }
            change(call, &model, |data| data.model.prescriptions.push(Prescription { on, displacement, turn }))?;
            Ok(Dynamic::UNIT)
        }),
    }
}

/// Options of `prescribe`.
fn motion_options() -> Vec<Parameter> {
    let along = ["x", "y", "z"].map(|name| {
        let free = Parameter::new(name, Kind::Amplitude, "the displacement in this direction over time");
        free.of("length").or(Absent::Means("free, or none where the nodes turn"))
    });
    let angle = Parameter::new("angle", Kind::Amplitude, "the angle by which they turn over time, counter-clockwise");
    let about = Parameter::new("about", Kind::Vector, "the point about which they turn, moved along with them");
    let axis = Parameter::new("axis", Kind::Vector, "the direction of the axis, in space");
    let turn = [
        angle.of("rad").or(Absent::Means("none")),
        about.of("length").or(Absent::Means("the origin")),
        axis.of("1").or(Absent::Means("[0, 0, 1]")),
    ];
    along.into_iter().chain(turn).collect()
}

/// Returns the functions of time for the axes `x`, `y`, `z` from options.
///
/// # Errors
/// `z` in a plane model, or a value that is no function of time.
pub(super) fn along_axes(options: &Options, dimension: usize) -> Result<[Option<Amplitude>; 3], Failure> {
    let mut along = [const { None }; 3];
    for (component, name) in ["x", "y", "z"].into_iter().enumerate() {
        let argument = options.argument(name);
        if !argument.is_given() {
            continue;
        }
        if component >= dimension {
            let failure = argument.fail("the model is plane: there is no direction `z`").code(causes::DIMENSION);
            return Err(failure.hint("remove the option"));
        }
        along[component] = Some(amplitude_of(&argument)?);
    }
    Ok(along)
}

/// Returns a point and the unit vector of the rotation axis in the options `about` and `axis`; `None` without `angle`. `such_as` is an
/// example of `angle` for messages.
///
/// # Errors
/// An axis without an angle or of zero length, or an axis in a plane model.
pub(super) fn axis_of_turn(options: &Options, dimension: usize, such_as: &str) -> Result<Option<[[f64; 3]; 2]>, Failure> {
    let [about, axis] = ["about", "axis"].map(|name| options.argument(name));
    if !options.argument("angle").is_given() {
        return match [about, axis].into_iter().find(Argument::is_given) {
            Some(given) => Err(given
                .fail(format!("{} has no meaning without an angle", given.title()))
                .code(causes::OPTIONS_TOGETHER)
                .hint(format!("add `{such_as}`"))),
            None => Ok(None),
        };
    }
    let center = if about.is_given() { about.vector(dimension)? } else { [0.0; 3] };
    let direction = if axis.is_given() { axis.vector(3)? } else { AxisRotation::UPRIGHT };
    if dimension == 2 && direction != AxisRotation::UPRIGHT {
        return Err(axis.fail("the model is plane: it turns about the third axis").code(causes::DIMENSION).hint("remove the option"));
    }
    let size = length(direction);
    if size == 0.0 {
        return Err(axis
            .fail(format!("{} has no direction", axis.title()))
            .code(causes::NO_DIRECTION)
            .label("this has length 0")
            .hint("such as `[0.0, 0.0, 1.0]`"));
    }
    Ok(Some([center, direction.map(|x| x / size)]))
}

fn components(argument: &Argument, dimension: usize) -> Result<[bool; 3], Failure> {
    let mut held = [false; 3];
    if !argument.is_given() {
        held[..dimension].fill(true);
        return Ok(held);
    }
    let text = argument.text()?;
    let names = &["x", "y", "z"][..dimension];
    for letter in text.chars() {
        let Some(index) = names.iter().position(|name| name.chars().eq([letter])) else {
            let failure = argument
                .fail(format!("{} cannot be \"{text}\"", argument.title()))
                .code(causes::WRONG_TYPE)
                .label(format!("`{letter}` is not a direction here"));
            let space = if dimension == 2 { "the model is plane" } else { "the model is spatial" };
            return Err(failure.cause(space).hint(format!("name the held directions, such as \"x\" or \"{}\"", names.concat())));
        };
        held[index] = true;
    }
    if held == [false; 3] {
        let failure = argument.fail(format!("{} names no direction", argument.title())).code(causes::NO_DIRECTION);
        return Err(failure.hint("name the held directions, such as \"x\" or \"xy\", or leave the argument out to hold all"));
    }
    Ok(held)
}
