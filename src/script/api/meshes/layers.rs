//! The option `layers` of regions: strips of thin cells along boundaries.

use super::handle::mesh_failure;
use crate::mesh::{Layers, MeshError};
use crate::script::api::remedies::ScriptWords;
use crate::script::language::causes;
use crate::script::language::prelude::*;
use crate::script::language::values::describe;

/// Description of the option `layers`.
pub fn parameter() -> Parameter {
    let keys = vec![
        Parameter::new("boundary", Kind::Either("a boundary's name or an array of names"), "where the layers are"),
        Parameter::number("first", "length", Interval::Positive, "the thickness of the layer at the boundary"),
        Parameter::integer("count", "how many layers there are").within(Interval::Closed(1.0, 1000.0)),
        Parameter::number(
            "growth",
            "1",
            Interval::Closed(0.1, 10.0),
            "the ratio of the thickness of each layer to that of the one before it",
        )
        .or(1.2),
        Parameter::number(
            "along",
            "length",
            Interval::Positive,
            "the length of their cells along the boundary, from which it grows to `size`",
        )
        .otherwise("`size`"),
    ];
    let summary = "strips of thin cells along boundaries: stacks of quadrilaterals (or of triangles, two in place of each), with columns \
                   on the bisectors of corners";
    Parameter::map("layers", summary).otherwise("none").keys(keys)
}

/// Reads the option `layers`.
///
/// # Errors
/// Wrong types, numbers out of range, missing keys.
pub fn layers_of(options: &Options) -> Result<Option<Layers>, Failure> {
    if !options.argument("layers").is_given() {
        return Ok(None);
    }
    let given = options.nested("layers")?;
    let argument = given.argument("boundary");
    if !argument.is_given() {
        return Err(argument.missing());
    }
    let value = argument.value();
    let names: Option<Vec<String>> = match value.read_lock::<Array>() {
        Some(names) => names.iter().map(|name| name.clone().into_string().ok()).collect(),
        None => value.clone().into_string().ok().map(|name| vec![name]),
    };
    let boundaries = names.filter(|names| !names.is_empty()).ok_or_else(|| {
        let failure = argument.wrong(causes::WRONG_TYPE, "must be a boundary's name or an array of names");
        failure
            .label(format!("this is {}", describe(argument.call().engine(), &value)))
            .hint("write `\"race\"` or `[\"inner\", \"outer\"]`")
    })?;
    let (first, count) = (given.number("first")?, given.integer("count")? as usize);
    Ok(Some(Layers { boundaries, first, count, growth: given.number("growth")?, along: given.optional_number("along")? }))
}

/// Returns the failure of a mesh described by options; errors of layers point at the option `layers`.
pub fn failure(options: &Options, error: &MeshError) -> Failure {
    use MeshError::{LayerCorner, LayersCollide, LayersCramped, OddLayers, UnknownLayers};
    let argument = options.argument("layers");
    match error {
        UnknownLayers { .. } | LayersCollide { .. } | LayersCramped { .. } | LayerCorner { .. } | OddLayers { .. } => {
            argument.fail(error.to_string()).code(error.code()).hint(error.remedy())
        }
        _ => mesh_failure(argument.call(), error),
    }
}
