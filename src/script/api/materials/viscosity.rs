//! Dissipative materials: viscosity and relaxing branches (Maxwell elements).

use super::handle::MaterialHandle;
use crate::materials::{Branch, Viscosity};
use crate::script::language::prelude::*;

const RUBBER: &str = "let rubber = neo_hookean(#{ youngs_modulus: 1.0, poisson_ratio: 0.4, density: 1.0 });\n";

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![viscous(), relaxing()]
}

fn viscous() -> Function {
    method_of::<MaterialHandle>(Topic::Materials, "viscous")
        .summary(
            "the material with a viscosity of Kelvin and Voigt: a stress 2 eta dE/dt + zeta tr(dE/dt) I on the rate of the strain; its \
             heat is the column `dissipation` of the history; in plane stress elastic and viscous stress vanish together across the plane",
        )
        .parameters(vec![Parameter::options("the viscosities")])
        .keys(vec![
            Parameter::number("shear_viscosity", "stress*time", Interval::NonNegative, "the resistance eta to a rate of strain"),
            Parameter::number(
                "bulk_viscosity",
                "stress*time",
                Interval::NonNegative,
                "the additional resistance zeta to a rate of the volume change",
            )
            .or(0.0),
        ])
        .see_also(&["relaxing", "backward_euler"])
        .example(format!("{RUBBER}let damped = rubber.viscous(#{{ shear_viscosity: 0.01 }});"))
        .body_with_options(|_, MaterialHandle(material), options| {
            let (shear, bulk) = (options.number("shear_viscosity")?, options.number("bulk_viscosity")?);
            let viscosity = Viscosity { shear, bulk, ..material.viscosity().clone() };
            Ok(MaterialHandle(material.with_viscosity(viscosity)))
        })
}

fn relaxing() -> Function {
    method_of::<MaterialHandle>(Topic::Materials, "relaxing")
        .summary(
            "the material with one more branch of Maxwell, which stiffens a sudden strain and then relaxes: the stress 2 mu Y of a strain \
             that fades, dY/dt = dE/dt - Y/tau; several calls make a Prony series",
        )
        .parameters(vec![Parameter::options("the branch")])
        .keys(vec![
            Parameter::number("shear_modulus", "stress", Interval::Positive, "mu, the additional shear modulus for a sudden strain"),
            Parameter::number("relaxation_time", "time", Interval::Positive, "tau, in which its stress falls to 1/e"),
        ])
        .see_also(&["viscous"])
        .example(format!(
            "{RUBBER}let tire = rubber.relaxing(#{{ shear_modulus: 0.5, relaxation_time: 0.1 }})\n    \
             .relaxing(#{{ shear_modulus: 0.2, relaxation_time: 10.0 }});"
        ))
        .body_with_options(|_, MaterialHandle(material), options| {
            let (shear_modulus, relaxation_time) = (options.number("shear_modulus")?, options.number("relaxation_time")?);
            let mut viscosity = material.viscosity().clone();
            viscosity.branches.push(Branch { shear_modulus, relaxation_time });
            Ok(MaterialHandle(material.with_viscosity(viscosity)))
        })
}
