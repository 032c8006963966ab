//! Supports: boundaries that are fixed, or move by prescribed functions of time.

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
    method_of::<ModelHandle>(Topic::Model, "fix")
        .summary("holds the nodes of a boundary, in all directions or in some")
        .parameters(vec![
            boundary_parameter(),
            Parameter::text("components", "the held directions, such as \"x\" or \"xy\"").otherwise("all directions"),
        ])
        .see_also(&["add_body"])
        .example(plate_example("press.fix(plate.boundary(\"left\"));\npress.fix(plate.boundary(\"bottom\"), \"y\");"))
        .body(|call, model| {
            let on = boundary_of(&call.argument("boundary"), &model)?;
            let dimension = model.0.borrow().model.dimension();
            let components = components(&call.argument("components"), dimension)?;
            change(call, &model, |data| data.model.supports.push(Support { on, components }))
        })
}

/// `prescribe`: moves nodes.
pub fn prescribe() -> Function {
    method_of::<ModelHandle>(Topic::Model, "prescribe")
        .summary(
            "moves the nodes of a boundary in given directions by time functions, or turns them about a point (in space: about the axis \
             through it) and moves them along",
        )
        .parameters(vec![boundary_parameter(), Parameter::map("motion", "the motion over time").keys(motion_options())])
        .see_also(&["fix"])
        .example(plate_example(
            "press.prescribe(plate.boundary(\"top\"), #{ y: ramp(0.0, 0.1, -0.05) });\n\
             press.prescribe(plate.boundary(\"bottom\"), #{ angle: |t| deg(90) * t, about: [1.0, 0.5] });",
        ))
        .body(|call, model| {
            let (on, options) = (boundary_of(&call.argument("boundary"), &model)?, call.options("motion")?);
            let dimension = model.0.borrow().model.dimension();
            let displacement = along_axes(&options, dimension)?;
            let turn = match axis_of_turn(&options, dimension, "angle: |t| …")? {
                Some([center, axis]) => Some(AxisRotation { center, axis, angle: amplitude_of(&options.argument("angle"))? }),
                None => None,
            };
            if turn.is_none() && displacement.iter().all(Option::is_none) {
                let failure = call.argument("motion").refuse(causes::NO_DIRECTION, "`prescribe` names no direction");
                return Err(failure.hint("name one, such as `#{ y: ramp(0.0, 1.0, -0.1) }`; `fix` holds nodes where they are").into());
            }
            change(call, &model, |data| data.model.prescriptions.push(Prescription { on, displacement, turn }))
        })
}

/// Options of `prescribe`.
fn motion_options() -> Vec<Parameter> {
    let along = ["x", "y", "z"].map(|name| {
        let free = Parameter::amplitude(name, "the displacement in this direction over time");
        free.of("length").otherwise("free, or none where the nodes turn")
    });
    let angle = Parameter::amplitude("angle", "the angle by which they turn over time, counter-clockwise");
    let about = Parameter::vector("about", "the point about which they turn, moved along with them");
    let axis = Parameter::vector("axis", "the direction of the axis, in space");
    let turn = [angle.of("rad").otherwise("none"), about.of("length").otherwise("the origin"), axis.of("1").otherwise("[0, 0, 1]")];
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
            return Err(argument.refuse(causes::DIMENSION, "the model is plane: there is no direction `z`").hint("remove the option"));
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
            Some(given) => Err(given.wrong(causes::OPTIONS_TOGETHER, "has no meaning without an angle").hint(format!("add `{such_as}`"))),
            None => Ok(None),
        };
    }
    let center = if about.is_given() { about.vector(dimension)? } else { [0.0; 3] };
    let direction = if axis.is_given() { axis.vector(3)? } else { AxisRotation::UPRIGHT };
    if dimension == 2 && direction != AxisRotation::UPRIGHT {
        return Err(axis.refuse(causes::DIMENSION, "the model is plane: it turns about the third axis").hint("remove the option"));
    }
    let size = length(direction);
    if size == 0.0 {
        return Err(axis.wrong(causes::NO_DIRECTION, "has no direction").label("this has length 0").hint("such as `[0.0, 0.0, 1.0]`"));
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
            let failure =
                argument.wrong(causes::WRONG_TYPE, format!("cannot be \"{text}\"")).label(format!("`{letter}` is not a direction here"));
            let space = if dimension == 2 { "the model is plane" } else { "the model is spatial" };
            return Err(failure.cause(space).hint(format!("name the held directions, such as \"x\" or \"{}\"", names.concat())));
        };
        held[index] = true;
    }
    if held == [false; 3] {
        let failure = argument.wrong(causes::NO_DIRECTION, "names no direction");
        return Err(failure.hint("name the held directions, such as \"x\" or \"xy\", or leave the argument out to hold all"));
    }
    Ok(held)
}
