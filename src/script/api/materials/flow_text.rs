//! Description of an elastic-plastic material as a script.

use crate::materials::{ElasticPlastic, Hardening, RateDependence};
use crate::script::language::digits::number_text;

/// Returns the script text that makes a material with these constants.
pub(super) fn describe(constants: &ElasticPlastic) -> String {
    let number = |name: &str, value: f64| format!("{name}: {}", number_text(value));
    let mut entries = vec![
        number("youngs_modulus", constants.youngs_modulus),
        number("poisson_ratio", constants.poisson_ratio),
        number("density", constants.density),
        number("yield_stress", constants.yield_stress),
    ];
    match &constants.hardening {
        Hardening::Saturating { modulus, saturation, .. } if *saturation == 0.0 && *modulus == 0.0 => {}
        Hardening::Saturating { modulus, saturation, .. } if *saturation == 0.0 => entries.push(number("hardening", *modulus)),
        Hardening::Saturating { modulus, saturation, exponent } => {
            let all = [number("saturation", *saturation), number("exponent", *exponent), number("modulus", *modulus)];
            entries.push(format!("hardening: #{{ {} }}", all.join(", ")));
        }
        Hardening::Swift { strain, exponent } => {
            entries.push(format!("hardening: #{{ {}, {} }}", number("strain", *strain), number("exponent", *exponent)));
        }
        Hardening::Ludwik { modulus, exponent } => {
            entries.push(format!("hardening: #{{ {}, {} }}", number("modulus", *modulus), number("exponent", *exponent)));
        }
        Hardening::Table(points) => {
            let all: Vec<String> = points.iter().map(|[strain, k]| format!("[{}, {}]", number_text(*strain), number_text(*k))).collect();
            entries.push(format!("hardening: [{}]", all.join(", ")));
        }
    }
    let mut text = format!("elastic_plastic(#{{ {} }})", entries.join(", "));
    for back in &constants.back_stresses {
        text += &format!(".back_stress(#{{ {}, {} }})", number("modulus", back.modulus), number("recovery", back.recovery));
    }
    match constants.rate {
        RateDependence::None => {}
        RateDependence::Perzyna { viscosity } => text += &format!(".rate_dependent(#{{ {} }})", number("viscosity", viscosity)),
        RateDependence::JohnsonCook { factor, reference_rate } => {
            text += &format!(".rate_dependent(#{{ {}, {} }})", number("factor", factor), number("reference_rate", reference_rate));
        }
    }
    text
}
