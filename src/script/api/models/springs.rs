//! Springs between bodies, boundaries and the ground.

use std::sync::Arc;

use rhai::Dynamic;

use super::change::change;
use super::ends::{constants_parameter, end_parameters, ends_of, one_of, text_of};
use super::handle::ModelHandle;
use crate::dynamics::{Elastic, Sides, SpringDefinition, SpringLaw};
use crate::math::catalogue::Interval;
use crate::script::api::examples::{TOUCH, plate_example};
use crate::script::api::time_functions::points_of;
use crate::script::language::arguments::{Arguments, Options};
use crate::script::language::failure::Failure;
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::handle::Handle;
use crate::script::language::parameter::{Absent, Kind, Parameter};

/// Which elongations a spring may feel.
const SIDES: &[&str] = &["both", "tension", "compression"];

/// `add_spring`.
pub fn add_spring() -> Function {
    let optional = |name, kind, what| Parameter::new(name, kind, what).or(Absent::Means("one of `stiffness`, `table`, `energy` is given"));
    let mut keys = end_parameters();
    keys.extend([
        Parameter::number("stiffness", "force / length", Interval::Positive, "force per elongation (plane: per thickness)")
            .or(Absent::Means("one of `stiffness`, `table`, `energy` is given")),
        optional("table", Kind::Array, "points `[elongation, force]` with increasing elongations, linear between them and beyond"),
        optional("energy", Kind::Text, "the energy as text in the elongation `x`, such as `\"k/2*x^2 + c/4*x^4\"`"),
        constants_parameter(),
        Parameter::new("sides", Kind::Choice(SIDES), "which elongations it feels: a cable has `\"tension\"`, a stop `\"compression\"`")
            .or(Absent::Text("both")),
        Parameter::number("rest_length", "length", Interval::NonNegative, "the length at which the elongation is 0")
            .or(Absent::Means("its length in the undeformed bodies")),
    ]);
    Function {
        name: "add_spring",
        form: Form::Method(ModelHandle::receiver()),
        topic: Topic::Model,
        summary: "joins points of bodies, centroids of boundaries or the ground by a spring, linear, by a table or by an energy as text in \
                  the elongation `length - rest_length`: what it stores is part of `potential`, the history has its `length`, `force` and \
                  `energy`",
        parameters: vec![
            Parameter::new("name", Kind::Text, "its name, unique among springs, dampers, chambers and masses"),
            Parameter::new("options", Kind::Options(keys), "ends and law"),
        ],
        returns: "",
        example: plate_example(&format!(
            "{TOUCH}press.add_spring(\"tie rod\", #{{ from: plate, from_point: [1.0, 1.0], to: table, to_point: [1.0, -1.0], stiffness: \
             50.0 }});\npress.add_spring(\"cable\", #{{ from: plate.boundary(\"top\"), to: \"ground\", to_point: [1.0, 3.0],\n    energy: \
             \"k/2*x^2 + k*x^4\", constants: #{{ k: 20.0 }}, sides: \"tension\" }});\nprint(press);"
        )),
        see_also: &["add_damper", "add_chamber", "add_mass", "force", "fix", "tie"],
        body: body(|call| {
            let model = call.receiver::<ModelHandle>();
            let (name, options) = (call.name("name")?, call.options("options")?);
            let (ends, law) = (ends_of(&options, &model)?, law_of(&options)?);
            let rest_length = options.optional_number("rest_length")?;
            change(call, &model, |data| {
                data.model.parts.push(Arc::new(SpringDefinition { name, ends, law, rest_length }));
            })?;
            Ok(Dynamic::UNIT)
        }),
    }
}

fn law_of(options: &Options) -> Result<SpringLaw, Failure> {
    let elastic = match one_of(options, &["stiffness", "table", "energy"])? {
        0 => Elastic::Linear(options.number("stiffness")?),
        1 => {
            let argument = options.argument("table");
            let points = points_of(&argument, ["elongation", "force"])?;
            if points.len() < 2 {
                let failure = argument.fail("the table of a spring needs two points at least");
                return Err(failure.hint("write `[[0.0, 0.0], [0.1, 5.0]]`"));
            }
            Elastic::Table(Arc::new(points))
        }
        _ => {
            let argument = options.argument("energy");
            Elastic::Energy(Arc::new(text_of(options, &argument, "x", "the energy")?), [1.0, 1.0])
        }
    };
    let sides = match options.text("sides")?.as_str() {
        "tension" => Sides::Tension,
        "compression" => Sides::Compression,
        _ => Sides::Both,
    };
    Ok(SpringLaw { elastic, sides })
}
