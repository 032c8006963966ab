//! Quantities with a unit: `quantity(210, "GPa")`, its short forms, and numbers of the script in another unit.

use super::declared::{DeclaredUnits, refused_unit};
use crate::output::{Dimension, Unit, UnitSet};
use crate::script::api::numbers::entrywise;
use crate::script::language::prelude::*;

/// Short forms of `quantity`: name, unit, summary.
const SHORT: &[(&str, &str, &str)] = &[
    ("mm", "mm", "a length in millimeters as a number in the declared units"),
    ("m_s", "m/s", "a velocity in meters per second as a number in the declared units"),
    ("rpm", "rpm", "a speed of rotation in turns per minute as an angular velocity in the declared units"),
    ("kn", "kN", "a force in kilonewtons as a number in the declared units"),
    ("mpa", "MPa", "a stress in megapascals as a number in the declared units"),
    ("gpa", "GPa", "a stress in gigapascals as a number in the declared units"),
    ("kg_m3", "kg/m^3", "a density in kilograms per cubic meter as a number in the declared units"),
];

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    let mut all = vec![quantity(), in_unit()];
    all.extend(SHORT.iter().map(|&(name, unit, summary)| short(name, unit, summary)));
    all
}

fn value_parameter(summary: &'static str) -> Parameter {
    Parameter::number("value", "any", Interval::Finite, summary)
}

fn unit_parameter() -> Parameter {
    Parameter::text("unit", "the unit: a name with a prefix if it has one, or a product such as `\"kg/m^3\"`, `\"N*m\"`, `\"mm/s^2\"`")
}

fn quantity() -> Function {
    function(Topic::Numbers, "quantity")
        .summary("a quantity with a unit, converted to the units declared with `units`; angles need no declaration")
        .parameters(vec![value_parameter("the number before the unit, or an array of numbers entry by entry"), unit_parameter()])
        .returns("number")
        .see_also(&["units", "in_unit", "gpa", "kg_m3", "mm", "deg"])
        .example(
            "units(\"mm-N-t\");\nprint(quantity(210, \"GPa\")); // 210000\nprint(quantity(7850, \"kg/m^3\")); // 7.85e-9\n\
                  print(quantity([0, 9.81], \"m/s^2\"));",
        )
        .body(|call| converted(call, &unit_of(call)?, UnitSet::value))
}

fn in_unit() -> Function {
    function(Topic::Numbers, "in_unit")
        .summary("a number in the declared units as one in another unit, for prints, results and axes: the inverse of `quantity`")
        .parameters(vec![value_parameter("the number, or an array of numbers entry by entry"), unit_parameter()])
        .returns("number")
        .see_also(&["quantity", "units"])
        .example("units(\"mm-N-t\");\nprint(in_unit(2500.0, \"kN\")); // 2.5\nprint(in_unit(PI, \"deg\"));")
        .body(|call| converted(call, &unit_of(call)?, UnitSet::value_in))
}

fn short(name: &'static str, unit: &'static str, summary: &'static str) -> Function {
    function(Topic::Numbers, name)
        .summary(summary)
        .parameters(vec![value_parameter("the number, or an array of numbers entry by entry")])
        .returns("number")
        .see_also(&["quantity", "units"])
        .example(format!("units(\"mm-N-t\");\nprint({name}(5)); // quantity(5, \"{unit}\")"))
        .body(move |call| {
            let unit = Unit::parse(unit).map_err(|error| refused_unit(call.fail(error.to_string()), &error))?;
            converted(call, &unit, UnitSet::value)
        })
}

fn unit_of(call: &Call) -> Result<Unit, Failure> {
    Unit::parse(&call.text("unit")?).map_err(|error| refused_unit(call.argument("unit").fail(error.to_string()), &error))
}

/// The argument `value`, converted between a unit and the declared units.
fn converted(call: &Call, unit: &Unit, convert: fn(&UnitSet, f64, &Unit) -> f64) -> Result<Dynamic, Box<rhai::EvalAltResult>> {
    let set = match DeclaredUnits::set(call.host) {
        Some(set) => set,
        // Angles are pure numbers in all sets of units.
        None if unit.dimension == Dimension::default() => UnitSet::si(),
        None => {
            let failure =
                call.fail(format!("{} needs the units of this script, which are not declared", call.function.title())).code("C1078");
            let hint = "declare them at the top: `units(\"SI\")` for m, kg and s, `units(\"mm-N-t\")` for mm, N, t, s and MPa";
            return Err(failure.hint(hint).into());
        }
    };
    Ok(entrywise(&call.argument("value"), |x| convert(&set, x, unit))?)
}
