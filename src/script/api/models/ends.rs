//! Options common to springs and dampers: their ends, and laws as text with constants.

use super::arguments::{body_boundary, body_of, node_at};
use super::handle::{BodyHandle, BoundaryHandle, ModelHandle};
use crate::bodies::{BarycentricMap, nodal_areas};
use crate::dynamics::End;
use crate::materials::{EnergyError, ScalarText};
use crate::math::norms::diameter;
use crate::math::tolerances::SAME_NODE;
use crate::script::api::materials::energies::refused;
use crate::script::language::causes;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};
use crate::script::language::wording::did_you_mean;

/// Name of the ground as an end.
pub const GROUND: &str = "ground";

/// Parameters for the two ends of a spring or damper.
pub fn end_parameters() -> Vec<Parameter> {
    let end = |name, which: &'static str| Parameter::new(name, Kind::Either("a Body, a boundary of one, or \"ground\""), which);
    let point = |name| {
        let what =
            "a point of the body while it is undeformed: the nearest node, of a rigid body or the ground that point; none for a boundary";
        Parameter::vector(name, what).of("length").otherwise("the centroid of the boundary, which then is the end")
    };
    vec![end("from", "what is at one end"), point("from_point"), end("to", "what is at the other end"), point("to_point")]
}

/// Returns the two ends.
///
/// # Errors
/// A value is not an end, or a point is missing or outside of the body.
pub fn ends_of(options: &Options, model: &ModelHandle) -> Result<[End; 2], Failure> {
    let ends = [end_of(options, model, "from", "from_point")?, end_of(options, model, "to", "to_point")?];
    match ends.iter().all(|end| end.body().is_none()) {
        true => Err(options
            .argument("to")
            .refuse(causes::OTHER_OWNER, "both ends are on the ground")
            .hint("give a body or a boundary for one of them")),
        false => Ok(ends),
    }
}

fn end_of(options: &Options, model: &ModelHandle, key: &str, point_key: &str) -> Result<End, Failure> {
    let (argument, point) = (options.argument(key), options.argument(point_key));
    if !argument.is_given() {
        return Err(argument.missing());
    }
    let value = argument.value();
    if value.is::<BoundaryHandle>() {
        let on = body_boundary(&argument, argument.handle()?, model)?;
        if point.is_given() {
            let failure =
                point.refuse(causes::OPTIONS_TOGETHER, format!("`{point_key}` is given beside a boundary, whose centroid is the end"));
            return Err(failure.hint(format!("leave it out, or give the body as `{key}`")));
        }
        let data = model.0.borrow();
        let body = &data.model.bodies[on.body];
        let shares = nodal_areas(&body.mesh, &on.boundary, body.formulation.plane);
        if shares.is_empty() {
            return Err(argument
                .refuse(causes::EMPTY, format!("boundary \"{}\" is empty", on.boundary.name))
                .hint("choose a boundary that has facets"));
        }
        return Ok(End::mean(on.body, &shares));
    }
    if !(value.is::<BodyHandle>() || value.read_lock::<rhai::ImmutableString>().is_some_and(|word| *word == GROUND)) {
        return Err(argument.wrong_type().hint(format!("write `{key}: body, {point_key}: [x, y]`, a boundary, or \"{GROUND}\"")));
    }
    if !point.is_given() {
        return Err(point
            .refuse(causes::OPTIONS_TOGETHER, format!("`{point_key}` is missing"))
            .hint(format!("give the point at which the end is, `{point_key}: [x, y]`")));
    }
    if value.is::<BodyHandle>() {
        let body = body_of(&argument, model)?;
        return match on_rigid(&point, &body)? {
            Some(shares) => Ok(End::Mean(body.index, shares)),
            None => Ok(End::Node(body.index, node_at(&point, &body)?)),
        };
    }
    let dimension = model.0.borrow().model.dimension();
    Ok(End::Ground(point.vector(dimension)?))
}

/// Returns a point on a rigid body by the weights of its masters, if the point is no node.
fn on_rigid(argument: &Argument, body: &BodyHandle) -> Result<Option<Vec<(u32, f64)>>, Failure> {
    let definition = body.definition();
    let Some(frame) = definition.rigid.and_then(|_| BarycentricMap::new(&definition.mesh)) else { return Ok(None) };
    let point = argument.vector(definition.mesh.dimension())?;
    if body.model.0.borrow().model.nearest_node(body.index, point).1 <= SAME_NODE * diameter(definition.mesh.points.iter()) {
        return Ok(None);
    }
    Ok(Some(frame.masters.iter().copied().zip(frame.shares(point)).collect()))
}

/// Parameter `constants`: values of the named constants in a formula that is given as text.
pub fn constants_parameter() -> Parameter {
    Parameter::new("constants", Kind::Either("an object map of numbers"), "values of the names in the text").otherwise("none")
}

/// Returns a function of one variable that an argument gives as text, with the constants in the options; `what` describes it, such as `the
/// energy`.
///
/// # Errors
/// A mistake, shown within the text, or invalid constants.
pub fn text_of(options: &Options, argument: &Argument, variable: &str, what: &str) -> Result<ScalarText, Failure> {
    let text = argument.text()?;
    let names: Vec<String> = ScalarText::constants_of(&text, variable).into_iter().map(|(name, _)| name).collect();
    let (given, mut constants) = (options.argument("constants"), Vec::new());
    if given.is_given() {
        let map = given.value();
        let map = map.read_lock::<Map>().map(|map| map.clone()).ok_or_else(|| given.wrong_type().hint("write `constants: #{ k: 3.0 }`"))?;
        for (name, value) in map {
            let number = as_number(&value).filter(|number| number.is_finite());
            let Some(number) = number else {
                let failure = given.refuse(causes::OUT_OF_RANGE, format!("the constant `{name}` must be a finite number"));
                return Err(failure.label(format!("it is {}", describe(argument.call().engine(), &value))));
            };
            if !names.iter().any(|known| *known == *name) {
                let failure = given.refuse(causes::NO_SUCH, format!("{what} names no constant `{name}`"));
                let suggestion = did_you_mean(&name, names.iter().map(String::as_str)).unwrap_or_else(|| "remove it".into());
                return Err(failure.hint(suggestion));
            }
            constants.push((name.to_string(), number));
        }
    }
    let in_words = |error: EnergyError| {
        let unknown = names.iter().find(|name| error.title.contains("no value") && error.text.get(error.span.clone()) == Some(name));
        match unknown {
            Some(name) => EnergyError { hint: format!("give the constant its value, `constants: #{{ {name}: 1.0 }}`").into(), ..error },
            None => error,
        }
    };
    let function = ScalarText::new(&text, variable, &constants, what).map_err(|error| refused(argument, &in_words(error)))?;
    match function.is_undefined_at(&[0.0]) {
        Some(_) => Err(argument
            .refuse(causes::OUT_OF_RANGE, format!("{what} has no finite value and slope at `{variable}` = 0"))
            .hint("check its text at this value")),
        None => Ok(function),
    }
}

/// Requires exactly one of these keys; returns its index among them.
///
/// # Errors
/// No key or several are given.
pub fn one_of(options: &Options, keys: &[&str]) -> Result<usize, Failure> {
    let listed = keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
    let given: Vec<usize> = (0..keys.len()).filter(|&k| options.argument(keys[k]).is_given()).collect();
    match given[..] {
        [one] => Ok(one),
        [] => {
            Err(options.argument(keys[0]).refuse(causes::OPTIONS_TOGETHER, format!("one of {listed} is missing")).hint("give one of them"))
        }
        [first, second, ..] => {
            let failure = options
                .argument(keys[second])
                .refuse(causes::OPTIONS_TOGETHER, format!("`{}` and `{}` are both given", keys[first], keys[second]));
            Err(failure.hint(format!("give one of {listed}")))
        }
    }
}
