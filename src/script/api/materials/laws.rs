//! Laws of the catalogue in scripts: one function for each row.

use super::handle::MaterialHandle;
use crate::materials::{CATALOGUE, LINEAR, Material, MaterialError, MaterialRow, VolumetricForm};
use crate::math::catalogue;
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;
use crate::script::language::wording::{did_you_mean, joined};

/// Option that selects the form of the volumetric part.
const VOLUMETRIC: &str = "volumetric";

/// Options of a law: its constants, and its form if there are several.
fn options_of(row: &MaterialRow) -> Vec<Parameter> {
    let form = row.volumetric.map(|VolumetricForm { all, .. }| {
        Parameter::new(VOLUMETRIC, Kind::Choice(all), "the form of the volumetric part of the energy").or(all[0])
    });
    row.parameters.iter().map(Parameter::of_catalogue).chain(form).collect()
}

/// Returns the row of the law with the form `name`.
fn of_form(row: &'static MaterialRow, name: &str) -> &'static MaterialRow {
    let is_wanted = |other: &&MaterialRow| other.name == row.name && other.volumetric.is_some_and(|form| form.name == name);
    CATALOGUE.iter().find(is_wanted).unwrap_or(row)
}

fn constructor(row: &'static MaterialRow) -> Function {
    let is_given = |(parameter, value): &(&catalogue::Parameter, f64)| parameter.default.is_none_or(|default| default != *value);
    let values = row.parameters.iter().zip(row.example(1000.0, 1000.0)).filter(is_given);
    let values: Vec<String> = values.map(|(parameter, value)| format!("{}: {}", parameter.name, number_text(value))).collect();
    function(Topic::Materials, row.name)
        .summary(row.summary)
        .parameters(vec![Parameter::options("the constants of the law").keys(options_of(row))])
        .see_also(&["add_body"])
        .example(format!("let material = {}(#{{ {} }});", row.name, values.join(", ")))
        .body_with_options(move |call, options| {
            let values = row.parameters.iter().map(|parameter| options.number(parameter.name)).collect::<Result<Vec<f64>, _>>()?;
            let row = if row.volumetric.is_some() { of_form(row, &options.text(VOLUMETRIC)?) } else { row };
            let material = Material::new(row, &values).map_err(|error| match error {
                MaterialError::Energy(error) => call
                    .fail(format!("{} with these constants", error.title))
                    .code(error.code())
                    .cause(format!("its energy is `{}`", error.text)),
                error => call.fail(error.to_string()).code(error.code()),
            })?;
            Ok(MaterialHandle(material))
        })
}

/// Script functions of this topic.
pub fn functions() -> Vec<Function> {
    let mut all: Vec<Function> = CATALOGUE.iter().filter(|row| row.is_usual()).chain(LINEAR).map(constructor).collect();
    all.push(
        column_of::<MaterialHandle>(Topic::Materials, "constant")
            .summary("the value of a constant of the law by its name")
            .parameters(vec![Parameter::text("name", "the name of the constant")])
            .returns("number")
            .example("let steel = neo_hookean(#{ youngs_modulus: 1e5, poisson_ratio: 0.3, density: 1e-3 }); print(steel.density);")
            .body(|call, MaterialHandle(material)| {
                let name = call.text("name")?;
                let constants = material.constants();
                match constants.iter().find(|(known, _)| *known == name) {
                    Some((_, value)) => Ok(Dynamic::from(*value)),
                    None => {
                        let names: Vec<String> = constants.iter().map(|(name, _)| format!("`{name}`")).collect();
                        let failure = call.refuse(causes::NO_SUCH, format!("the material has no constant `{name}`"));
                        let failure = failure.cause(format!("its constants are {}", joined(&names, "and")));
                        let suggestion = did_you_mean(&name, constants.iter().map(|(name, _)| *name));
                        Err(failure.hint(suggestion.unwrap_or_else(|| "use one of these names".into())).into())
                    }
                }
            }),
    );
    all
}
