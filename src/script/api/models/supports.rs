//! Supports: boundaries that are held, or moved as time functions say.

use rhai::Dynamic;

use super::arguments::{boundary_of, boundary_parameter};
use super::change::change;
use super::handle::ModelHandle;
use crate::dynamics::{Prescription, Support};
use crate::script::api::examples::plate_example;
use crate::script::api::time_functions::amplitude_of;
use crate::script::language::arguments::{Argument, Arguments};
use crate::script::language::failure::Failure;
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::handle::Handle;
use crate::script::language::parameter::{Absent, Kind, Parameter};

/// `fix`: holds nodes where they are.
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
        summary: "moves the nodes of a boundary in given directions as time functions say",
        parameters: vec![
            boundary_parameter(),
            Parameter::new(
                "displacements",
                Kind::Options(
                    ["x", "y", "z"]
                        .map(|name| {
                            let free = Parameter::new(name, Kind::Amplitude, "the displacement in this direction over time");
                            free.of("length").or(Absent::Means("free"))
                        })
                        .into(),
                ),
                "displacements over time",
            ),
        ],
        returns: "",
        example: plate_example("press.prescribe(plate.boundary(\"top\"), #{ y: ramp(0.0, 0.1, -0.05) });"),
        see_also: &["fix"],
        body: body(|call| {
            let model = call.receiver::<ModelHandle>();
            let (on, options) = (boundary_of(&call.argument("boundary"), &model)?, call.options("displacements")?);
            let dimension = model.0.borrow().model.dimension();
            let mut prescriptions = Vec::new();
            for (component, name) in ["x", "y", "z"].into_iter().enumerate() {
                let argument = options.argument(name);
                if !argument.is_given() {
                    continue;
                }
                if component >= dimension {
                    let failure = argument.fail("the model is plane: there is no direction `z`");
                    return Err(failure.hint("remove the option").into());
                }
                let displacement = amplitude_of(&argument)?;
                prescriptions.push(Prescription { on: on.clone(), component, displacement });
            }
            if prescriptions.is_empty() {
                let failure = call.argument("displacements").fail("`prescribe` names no direction");
                return Err(failure.hint("name one, such as `#{ y: ramp(0.0, 1.0, -0.1) }`; `fix` holds nodes where they are").into());
            }
            change(call, &model, |data| data.model.prescriptions.extend(prescriptions))?;
            Ok(Dynamic::UNIT)
        }),
    }
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
                argument.fail(format!("{} cannot be \"{text}\"", argument.title())).label(format!("`{letter}` is not a direction here"));
            let space = if dimension == 2 { "the model is plane" } else { "the model is spatial" };
            return Err(failure.cause(space).hint(format!("name the held directions, such as \"x\" or \"{}\"", names.concat())));
        };
        held[index] = true;
    }
    if held == [false; 3] {
        let failure = argument.fail(format!("{} names no direction", argument.title()));
        return Err(failure.hint("name the held directions, such as \"x\" or \"xy\", or leave the argument out to hold all"));
    }
    Ok(held)
}
