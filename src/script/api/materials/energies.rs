//! `hyperelastic`: a material from a stored energy that the script writes as text.
//!
//! A mistake is shown within the energy's text, if the text is a literal of the script.

use super::handle::MaterialHandle;
use crate::materials::{EnergyError, EnergyText, Material, MaterialError, StoredEnergy, functions_of_energies, quantities_of_energies};
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;
use crate::script::language::sources::SourceSpan;
use crate::script::language::values::{as_number, describe};
use crate::script::language::wording::{did_you_mean, listed};

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![hyperelastic()]
}

fn hyperelastic() -> Function {
    let optional = |name, kind, summary| Parameter::new(name, kind, summary).otherwise("none");
    let keys = vec![
        Parameter::text("energy", "the energy per undeformed volume, of invariants, fibers and named constants").of("stress"),
        optional("volumetric", Kind::Text, "a part of it that depends on `J` alone, for elements with mean dilatation").of("stress"),
        optional("fiber", Kind::Array, "direction of the fiber whose squared stretch is `I4`, `[x, y]` or `[x, y, z]`"),
        optional("fibers", Kind::Array, "directions of the fibers of `I4` and `I6`, `[[x, y], [x, y]]`"),
        Parameter::number("density", "mass/volume", Interval::Positive, "mass per undeformed volume"),
    ];
    function(Topic::Materials, "hyperelastic")
        .summary(
            "a material from its stored energy as text, such as `\"mu/2*(I1bar - 3)\"`: quantities are `I1 I2 I3 J I1bar I2bar`, `I4 I6 \
             I4bar I6bar` of fibers, `E11 E22 E33 E12 E23 E13` and `log_strain_squared`; functions `ln exp sqrt pow sinh cosh tanh abs max \
             min`, `pos(x)` for `max(x, 0)` and `stretch_power(a)` for `l1^a + l2^a + l3^a`; every other name is a constant, whose value \
             is one more option",
        )
        .parameters(vec![Parameter::new("options", Kind::OpenOptions(keys), "the energy, its constants and the density")])
        .see_also(&["neo_hookean", "add_body"])
        .example(
            "let rubber = hyperelastic(#{ energy: \"mu/2*(I1 - 3 - 2*ln(J))\", volumetric: \"lambda/2*ln(J)^2\",\n    \
                  mu: 400.0, lambda: 600.0, density: 1000.0 });\n\
                  let tissue = hyperelastic(#{ energy: \"mu/2*(I1bar - 3) + k*pos(I4 - 1)^2\", volumetric: \"5*mu*(J - 1)^2\",\n    \
                  fiber: [1, 1], mu: 10.0, k: 50.0, density: 1000.0 });",
        )
        .body_with_options(|call, options| {
            let energy = text_of(&options.argument("energy"))?;
            let volumetric = options.argument("volumetric").given(text_of)?;
            let constants = constants_of(call, &options, &energy, volumetric.as_ref())?;
            let stored = StoredEnergy { energy, volumetric, fibers: fibers_of(&options)?, constants, factor: 1.0 };
            let material = Material::hyperelastic(stored, options.number("density")?).map_err(|error| match error {
                MaterialError::Energy(error) => {
                    let is_volumetric = options.argument("energy").value().into_string().is_ok_and(|text| *text != *error.text);
                    refused(&options.argument(if is_volumetric { "volumetric" } else { "energy" }), &error)
                }
                error => {
                    let failure = options.argument("energy").fail(error.to_string()).code(error.code());
                    failure.hint("add an energy of the volume, such as `volumetric: \"k/2*(J - 1)^2\"`")
                }
            })?;
            Ok(MaterialHandle(material))
        })
}

/// Stored energy given as text in an argument.
fn text_of(argument: &Argument) -> Result<EnergyText, Failure> {
    EnergyText::parse(&argument.text()?).map_err(|error| refused(argument, &error))
}

/// Returns the failure of an energy with an error; the message points into the text if that is a literal of the script.
pub fn refused(argument: &Argument, error: &EnergyError) -> Failure {
    let failure = argument.fail(error.title.clone()).code(error.code()).label(error.label.clone());
    let place = argument.call().place(&argument.target()).and_then(|place| inside(place, error));
    let failure = if place.is_some() {
        failure.placed(place)
    } else {
        let part = error.text.get(error.span.clone()).filter(|part| !part.is_empty());
        let part = part
            .map_or("at its end".to_string(), |part| format!("at `{part}`, letter {}", error.text[..error.span.start].chars().count() + 1));
        failure.cause(format!("the text is `{}`, the mistake {part}", error.text))
    };
    let failure = if error.cause.is_empty() { failure } else { failure.cause(error.cause.clone()) };
    if error.hint.is_empty() { failure } else { failure.hint(error.hint.clone()) }
}

/// Position of an error inside a string literal of the script; `None` unless the literal contains the text verbatim.
fn inside(place: SourceSpan, error: &EnergyError) -> Option<SourceSpan> {
    let literal = place.text.get(place.range.clone())?;
    let held = literal.get(1..literal.len().checked_sub(1)?)?;
    if *held != *error.text || !(literal.starts_with('"') || literal.starts_with('`')) {
        return None;
    }
    let start = place.range.start + 1 + error.span.start;
    // An error at the end of the text is shown at the closing quote.
    let end = start + error.span.len().max(1);
    Some(SourceSpan { range: start..end, ..place })
}

/// Returns the values of the constants: every key that is no option must be named in a text. Constants without a value are reported by the
/// solver.
fn constants_of(
    call: &Call,
    options: &Options,
    energy: &EnergyText,
    volumetric: Option<&EnergyText>,
) -> Result<Vec<(String, f64)>, Failure> {
    let mut named: Vec<String> = Vec::new();
    for (name, _) in [Some(energy), volumetric].into_iter().flatten().flat_map(EnergyText::constants) {
        if !named.contains(&name) {
            named.push(name);
        }
    }
    let mut constants = Vec::new();
    for (key, value) in options.others() {
        if !named.contains(&key) {
            return Err(unused(call, options, &key, &named));
        }
        let number = as_number(&value).filter(|number| number.is_finite()).ok_or_else(|| {
            let failure = call
                .refuse(causes::OUT_OF_RANGE, format!("the constant `{key}` of the energy must be a finite number"))
                .at(options.target_of(&key, true));
            failure.label(format!("this is {}", describe(call.engine(), &value)))
        })?;
        constants.push((key, number));
    }
    Ok(constants)
}

/// Failure of a key that occurs in no text of the energy.
fn unused(call: &Call, options: &Options, key: &str, named: &[String]) -> Failure {
    let failure = call.refuse(causes::NO_SUCH, format!("`hyperelastic` has no option `{key}`, and the energy names no constant `{key}`"));
    let failure = failure.at(options.target_of(key, false)).label("names nothing");
    let failure = match named {
        [] => failure.cause("the energy names no constants"),
        _ => failure.cause(format!("the energy names {}", listed(named, "and"))),
    };
    if quantities_of_energies().any(|(quantity, _)| quantity == key) || functions_of_energies().any(|(function, _)| function == key) {
        return failure.hint(format!("`{key}` has another meaning in an energy: choose another name for the constant"));
    }
    let keys = ["energy", "volumetric", "fiber", "fibers", "density"];
    failure.hint(did_you_mean(key, named.iter().map(String::as_str).chain(keys)).unwrap_or_else(|| "remove it".into()))
}

/// Fiber directions in the options.
fn fibers_of(options: &Options) -> Result<Vec<[f64; 3]>, Failure> {
    let (one, several) = (options.argument("fiber"), options.argument("fibers"));
    match (one.is_given(), several.is_given()) {
        (false, false) => Ok(Vec::new()),
        (true, false) => Ok(vec![direction(&one, &one.array()?)?]),
        (true, true) => {
            Err(several.refuse(causes::OPTIONS_TOGETHER, "`fiber` and `fibers` are both given").hint("give all directions in `fibers`"))
        }
        (false, true) => {
            let list = several.array()?;
            if list.len() > 2 {
                let failure = several
                    .refuse(causes::COUNT, "`fibers` of `hyperelastic` must have at most two directions")
                    .label(format!("this has {}", list.len()));
                return Err(failure.cause("`I4` belongs to the first of them and `I6` to the second"));
            }
            let entry = |entry: &Dynamic| match entry.read_lock::<Array>() {
                Some(numbers) => direction(&several, &numbers),
                None => Err(several
                    .refuse(causes::NO_DIRECTION, "every entry of `fibers` must be a direction")
                    .hint("write `fibers: [[1, 0], [0, 1]]`")),
            };
            list.iter().map(entry).collect()
        }
    }
}

fn direction(argument: &Argument, numbers: &Array) -> Result<[f64; 3], Failure> {
    let numbers: Option<Vec<f64>> = numbers.iter().map(|number| as_number(number).filter(|number| number.is_finite())).collect();
    let wrong = || argument.refuse(causes::COUNT, "a fiber's direction must be two or three numbers").hint("write `[x, y]` or `[x, y, z]`");
    let mut direction = [0.0; 3];
    match numbers {
        Some(numbers) if (2..=3).contains(&numbers.len()) => direction[..numbers.len()].copy_from_slice(&numbers),
        _ => return Err(wrong()),
    }
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() {
        return Ok(direction);
    }
    Err(argument.refuse(causes::NO_DIRECTION, "a fiber's direction must have a length").label(format!("this has {}", number_text(length))))
}
