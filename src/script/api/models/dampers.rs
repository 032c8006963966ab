//! Dampers between bodies, boundaries and the ground.

use std::sync::Arc;

use rhai::Dynamic;

use super::change::change;
use super::ends::{constants_parameter, end_parameters, ends_of, one_of, text_of};
use super::handle::ModelHandle;
use crate::dynamics::{DamperDefinition, Viscous};
use crate::math::catalogue::Interval;
use crate::script::api::examples::{TOUCH, plate_example};
use crate::script::language::arguments::{Arguments, Options};
use crate::script::language::digits::number_text;
use crate::script::language::failure::Failure;
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::handle::Handle;
use crate::script::language::parameter::{Absent, Kind, Parameter};

/// The keys of a force by a speed.
fn law_parameters(of_coefficient: &'static str) -> [Parameter; 5] {
    [
        Parameter::number("coefficient", of_coefficient, Interval::Positive, "force at speed 1 (plane: per thickness)")
            .or(Absent::Means("`force` is given")),
        Parameter::number("exponent", "1", Interval::Positive, "the force grows with this power of the speed").or(Absent::Number(1.0)),
        Parameter::number("smoothing", "length/time", Interval::Positive, "speed below which a power less than 1 is linear")
            .or(Absent::Means("none, for powers from 1 on")),
        Parameter::new("force", Kind::Text, "the force as text in the speed `v`, such as `\"c*v + d*v^3\"`")
            .or(Absent::Means("`coefficient` is given")),
        constants_parameter(),
    ]
}

/// The force that options describe.
fn law_of(options: &Options) -> Result<Viscous, Failure> {
    let law = if one_of(options, &["coefficient", "force"])? == 0 {
        let (coefficient, exponent) = (options.number("coefficient")?, options.number("exponent")?);
        let smoothing = options.optional_number("smoothing")?;
        if exponent < 1.0 && smoothing.is_none() {
            let failure = options.argument("smoothing").fail("a power less than 1 needs `smoothing`");
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
            let failure = options.argument("force").fail("the force drives where it should damp");
            let failure = failure.cause(format!("at v = {} it is {force}", number_text(speed)));
            Err(failure.hint("let it have the sign of `v` everywhere, and be 0 at rest: `c*v`, `c*v*abs(v)`"))
        }
    }
}

/// `add_damper`.
pub fn add_damper() -> Function {
    let mut keys = end_parameters();
    keys.extend(law_parameters("force (time/length)^exponent"));
    Function {
        name: "add_damper",
        form: Form::Method(ModelHandle::receiver()),
        topic: Topic::Model,
        summary: "joins points of bodies, centroids of boundaries or the ground by a damper, which pulls against the speed at which its ends \
                  part: linear, a power, or a text; the history has its `speed`, `force` and `dissipation`, the heat of each step",
        parameters: vec![
            Parameter::new("name", Kind::Text, "its name, unique among springs, dampers, chambers and masses"),
            Parameter::new("options", Kind::Options(keys), "ends and law"),
        ],
        returns: "",
        example: plate_example(&format!(
            "{TOUCH}press.add_damper(\"closer\", #{{ from: plate.boundary(\"top\"), to: \"ground\", to_point: [1.0, 3.0], coefficient: 2.0 \
             }});\npress.add_damper(\"orifice\", #{{ from: plate, from_point: [1.0, 1.0], to: table, to_point: [1.0, -1.0],\n    force: \
             \"c*v*abs(v)\", constants: #{{ c: 0.5 }} }});\nprint(press);"
        )),
        see_also: &["add_spring", "add_chamber", "with_viscosity"],
        body: body(|call| {
            let model = call.receiver::<ModelHandle>();
            let (name, options) = (call.name("name")?, call.options("options")?);
            let (ends, law) = (ends_of(&options, &model)?, law_of(&options)?);
            change(call, &model, |data| data.model.parts.push(Arc::new(DamperDefinition { name, ends, law })))?;
            Ok(Dynamic::UNIT)
        }),
    }
}
