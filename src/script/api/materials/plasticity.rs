//! Elastic-plastic materials: `elastic_plastic`, its back stresses and rate dependence, and hardening curves from tests.

use super::handle::MaterialHandle;
use crate::materials::{BackStress, ElasticPlastic, Hardening, Material, MaterialError, PlasticityError, RateDependence};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe as described};

const STEEL: &str = "let steel = elastic_plastic(#{ youngs_modulus: 210e3, poisson_ratio: 0.3, density: 7.85e-9, yield_stress: 235.0 });\n";

/// Forms of the option `hardening`.
const FORMS: &str = "a modulus; points `[[plastic strain, yield stress], …]`; or an object map, `#{ saturation, exponent, modulus }`, \
                     `#{ strain, exponent }` or `#{ modulus, exponent }`";

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![elastic_plastic(), back_stress(), rate_dependent(), hardening_curve()]
}

fn elastic_plastic() -> Function {
    function(Topic::Materials, "elastic_plastic")
        .summary(
            "a metal: Hencky's law up to a yield stress (von Mises), then plastic flow with hardening; plastic work turns into heat, \
             column `BODY.plastic_work` since the start; field `plastic_strain`. Cells have a mean dilatation by default. Formulas: \
             `docs/tasks/plasticity.md`",
        )
        .parameters(vec![Parameter::options("the constants")])
        .keys(vec![
            Parameter::number("youngs_modulus", "stress", Interval::Positive, "stiffness in uniaxial tension"),
            Parameter::number("poisson_ratio", "1", Interval::Open(-1.0, 0.5), "lateral contraction over extension"),
            Parameter::number("density", "mass/volume", Interval::Positive, "mass per undeformed volume"),
            Parameter::number("yield_stress", "stress", Interval::Positive, "true stress in tension at which flow begins")
                .otherwise("the first of the points of `hardening`"),
            Parameter::new("hardening", Kind::Either(FORMS), "the yield stress as a function of the plastic strain")
                .otherwise("perfect plasticity"),
        ])
        .see_also(&["back_stress", "rate_dependent", "hardening_curve"])
        .example(format!(
            "{STEEL}let aluminum = elastic_plastic(#{{ youngs_modulus: 70e3, poisson_ratio: 0.33, density: 2.7e-9,\n    \
             hardening: [[0.0, 120.0], [0.02, 160.0], [0.1, 200.0]] }});"
        ))
        .body_with_options(|_, options| {
            let (given, hardening) = (options.argument("yield_stress"), options.argument("hardening"));
            let law = if hardening.is_given() { hardening_of(&hardening)? } else { Hardening::NONE };
            let first = if let Hardening::Table(points) = &law { points.first().map(|point| point[1]) } else { None };
            if let (Some(first), true) = (first, given.is_given())
                && first != given.number()?
            {
                let title = format!("the hardening table begins at a yield stress of {}, not at `yield_stress`", number_text(first));
                return Err(given.fail(title).hint("leave `yield_stress` out: the table has it").into());
            }
            let yield_stress = match first {
                Some(first) if !given.is_given() => first,
                _ if given.is_given() => given.number()?,
                _ => return Err(given.missing().into()),
            };
            warn_of_softening(&hardening, &law);
            let constants = ElasticPlastic {
                youngs_modulus: options.number("youngs_modulus")?,
                poisson_ratio: options.number("poisson_ratio")?,
                density: options.number("density")?,
                yield_stress,
                hardening: law,
                back_stresses: Vec::new(),
                rate: RateDependence::None,
            };
            made(&constants, &hardening)
        })
}

/// Warns of a decreasing yield stress: plastic flow then localizes in bands as narrow as the mesh allows.
fn warn_of_softening(argument: &Argument, law: &Hardening) {
    let Hardening::Table(points) = law else { return };
    if let Some(pair) = points.windows(2).find(|pair| pair[1][1] < pair[0][1]) {
        let title = format!("the material softens beyond a plastic strain of {}", number_text(pair[0][0]));
        let call = argument.call();
        call.host.warn(
            Diagnostic::warning(title, call.place(&argument.target()))
                .code("C0308")
                .cause("a softening material flows in a band as narrow as the cells: results depend on the mesh")
                .hint("refine the mesh and compare, or give a `viscosity` with `rate_dependent`, which gives bands a width"),
        );
    }
}

/// Returns the material with some constants; a failure points at `argument`.
fn made(constants: &ElasticPlastic, argument: &Argument) -> Result<MaterialHandle, Box<rhai::EvalAltResult>> {
    let material = Material::elastic_plastic(constants).map_err(|error| {
        let failure = argument.fail(error.to_string()).code(error.code());
        match error {
            MaterialError::Plasticity(PlasticityError::Table { .. } | PlasticityError::ShortTable { .. }) => {
                failure.hint("points are `[plastic strain, yield stress]`, the first at a plastic strain of 0, strains growing")
            }
            _ => failure,
        }
    })?;
    Ok(MaterialHandle(material))
}

/// Hardening law of the option `hardening`.
fn hardening_of(argument: &Argument) -> Result<Hardening, Failure> {
    let value = argument.value();
    if let Some(modulus) = as_number(&value) {
        return Ok(Hardening::Saturating { modulus, saturation: 0.0, exponent: 0.0 });
    }
    if let Some(points) = value.read_lock::<Array>() {
        return Ok(Hardening::Table(points_of(argument, &points)?));
    }
    let Some(map) = value.read_lock::<Map>() else { return Err(argument.wrong_type()) };
    let mut numbers = Vec::new();
    for (key, value) in map.iter() {
        let number = as_number(value).ok_or_else(|| {
            argument.refuse(
                causes::WRONG_TYPE,
                format!("`{key}` of `hardening` is {}, not a number", described(argument.call().engine(), value)),
            )
        })?;
        numbers.push((key.as_str(), number));
    }
    let of = |name: &str| numbers.iter().find(|(key, _)| *key == name).map(|(_, number)| *number);
    match (of("saturation"), of("strain"), of("modulus"), of("exponent"), numbers.len()) {
        (Some(saturation), None, modulus, Some(exponent), 2 | 3) => {
            Ok(Hardening::Saturating { modulus: modulus.unwrap_or(0.0), saturation, exponent })
        }
        (None, Some(strain), None, Some(exponent), 2) => Ok(Hardening::Swift { strain, exponent }),
        (None, None, Some(modulus), Some(exponent), 2) => Ok(Hardening::Ludwik { modulus, exponent }),
        _ => {
            let keys: Vec<String> = numbers.iter().map(|(key, _)| format!("`{key}`")).collect();
            Err(argument
                .refuse(causes::NO_SUCH, format!("no hardening has the constants {}", keys.join(", ")))
                .hint("Voce: `#{ saturation, exponent, modulus }`; Swift: `#{ strain, exponent }`; Ludwik: `#{ modulus, exponent }`"))
        }
    }
}

/// Pairs of numbers in an argument.
fn points_of(argument: &Argument, points: &Array) -> Result<Vec<[f64; 2]>, Failure> {
    let pair = |(index, value): (usize, &Dynamic)| {
        let both = value.read_lock::<Array>().map(|pair| pair.iter().filter_map(as_number).collect::<Vec<f64>>());
        match both.as_deref() {
            Some(&[strain, stress]) => Ok([strain, stress]),
            _ => Err(argument.refuse(
                causes::WRONG_TYPE,
                format!("entry {} is {}, not a pair of numbers", index + 1, described(argument.call().engine(), value)),
            )),
        }
    };
    points.iter().enumerate().map(pair).collect()
}

/// Constants of the elastic-plastic material on which the method is called.
fn receiver(call: &Call) -> Result<ElasticPlastic, Failure> {
    let MaterialHandle(material) = call.receiver();
    material.plasticity().cloned().ok_or_else(|| {
        call.refuse(causes::BODY_KIND, format!("`{}` does not flow plastically", material.name()))
            .hint("make the material with `elastic_plastic`")
    })
}

fn back_stress() -> Function {
    method_of::<MaterialHandle>(Topic::Materials, "back_stress")
        .summary(
            "the elastic-plastic material with one more back stress (kinematic hardening): dX = 2/3 modulus dep - recovery X d alpha, \
             Prager's without recovery, Armstrong and Frederick's with it; there may be four (Chaboche)",
        )
        .parameters(vec![Parameter::options("the back stress")])
        .keys(vec![
            Parameter::number("modulus", "stress", Interval::Positive, "its slope per plastic strain in uniaxial tension"),
            Parameter::number("recovery", "1", Interval::NonNegative, "dynamic recovery: it saturates at modulus over recovery").or(0.0),
        ])
        .see_also(&["elastic_plastic"])
        .example(format!("{STEEL}let cyclic = steel.back_stress(#{{ modulus: 20e3, recovery: 150.0 }}).back_stress(#{{ modulus: 1e3 }});"))
        .body(|call, _| {
            let mut constants = receiver(call)?;
            let options = call.options("options")?;
            constants.back_stresses.push(BackStress { modulus: options.number("modulus")?, recovery: options.number("recovery")? });
            made(&constants, &call.argument("options"))
        })
}

fn rate_dependent() -> Function {
    let optional = |name, dimension, summary| Parameter::number(name, dimension, Interval::Positive, summary).otherwise("none");
    method_of::<MaterialHandle>(Topic::Materials, "rate_dependent")
        .summary(
            "the elastic-plastic material with a yield stress that depends on the rate of the plastic strain: k + viscosity d alpha/dt \
             (Perzyna) or k (1 + factor ln(d alpha/dt / reference_rate)) above that rate (Johnson and Cook, without heat); `settle` and \
             `statics()` neglect rates",
        )
        .parameters(vec![Parameter::options("the dependence: `viscosity` alone, or `factor` and `reference_rate`")])
        .keys(vec![
            optional("viscosity", "stress*time", "overstress per rate (Perzyna)"),
            optional("factor", "1", "C of Johnson and Cook"),
            optional("reference_rate", "1/time", "the rate up to which nothing changes (Johnson and Cook)"),
        ])
        .see_also(&["elastic_plastic", "viscous"])
        .example(format!("{STEEL}let fast = steel.rate_dependent(#{{ factor: 0.022, reference_rate: 1.0 }});"))
        .body(|call, _| {
            let mut constants = receiver(call)?;
            let options = call.options("options")?;
            let number = |name: &str| -> Result<Option<f64>, Failure> { options.optional_number(name) };
            constants.rate = match (number("viscosity")?, number("factor")?, number("reference_rate")?) {
                (Some(viscosity), None, None) => RateDependence::Perzyna { viscosity },
                (None, Some(factor), Some(reference_rate)) => RateDependence::JohnsonCook { factor, reference_rate },
                _ => {
                    let title = "a rate dependence is `viscosity` alone, or `factor` and `reference_rate`";
                    return Err(call.argument("options").fail(title).into());
                }
            };
            made(&constants, &call.argument("options"))
        })
}

fn hardening_curve() -> Function {
    function(Topic::Materials, "hardening_curve")
        .summary(
            "the points `[plastic strain, true yield stress]` of a tensile test whose points are `[engineering strain, engineering \
             stress]`: true strain ln(1 + e), true stress s (1 + e), less the elastic strain; from the first yielding to the largest \
             force, beyond which the specimen necks and a test does not determine the stress",
        )
        .parameters(vec![
            Parameter::array("test", "the points of the test, strains growing"),
            Parameter::options("further data of the specimen"),
        ])
        .keys(vec![
            Parameter::number("youngs_modulus", "stress", Interval::Positive, "stiffness of the specimen"),
            Parameter::number("yield_stress", "stress", Interval::Positive, "true stress at which flow begins"),
        ])
        .returns("Array")
        .see_also(&["elastic_plastic"])
        .example(
            "let curve = hardening_curve([[0.001, 210.0], [0.01, 255.0], [0.05, 310.0], [0.15, 360.0]],\n    \
                  #{ youngs_modulus: 210e3, yield_stress: 235.0 });\n\
                  let steel = elastic_plastic(#{ youngs_modulus: 210e3, poisson_ratio: 0.3, density: 7.85e-9, hardening: curve });",
        )
        .body(|call| {
            let (test, options) = (call.argument("test"), call.options("options")?);
            let points = test.value().read_lock::<Array>().map(|array| array.clone()).ok_or_else(|| test.wrong_type())?;
            let points = points_of(&test, &points)?;
            let (modulus, first) = (options.number("youngs_modulus")?, options.number("yield_stress")?);
            let mut curve = vec![[0.0, first]];
            let mut force = 0.0;
            for (index, &[strain, stress]) in points.iter().enumerate() {
                if strain <= -1.0 || !stress.is_finite() || (index > 0 && strain <= points[index - 1][0]) {
                    return Err(test
                        .refuse(causes::ORDER, format!("the strain of point {} is not above the one before", index + 1))
                        .into());
                }
                if stress < force {
                    break;
                }
                force = stress;
                let (true_stress, true_strain) = (stress * (1.0 + strain), strain.ln_1p());
                let plastic = true_strain - true_stress / modulus;
                if true_stress > first && plastic > curve[curve.len() - 1][0] {
                    curve.push([plastic, true_stress]);
                }
            }
            if curve.len() < 2 {
                let title = "no point of the test is beyond the yield stress";
                return Err(test.fail(title).hint("`yield_stress` is a true stress, strains are parts of 1, not per cent").into());
            }
            let pair = |[strain, stress]: [f64; 2]| Dynamic::from(vec![Dynamic::from(strain), Dynamic::from(stress)] as Array);
            Ok(Dynamic::from(curve.into_iter().map(pair).collect::<Array>()))
        })
}
