//! Description of a law: its row of the catalogue, and the constants that isotropic laws share.

use super::energy::{EnergyError, StoredEnergy};
use super::laws::Laws;
use crate::math::catalogue::{Interval, Parameter};

/// Volumetric form of a law with several forms; each form is a row, all with the same name and parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VolumetricForm {
    /// Name of the form of this row.
    pub name: &'static str,
    /// All forms of the law, the default first.
    pub all: &'static [&'static str],
}

impl VolumetricForm {
    /// True if this volumetric form is the default form of the law.
    pub fn is_usual(&self) -> bool {
        self.all.first() == Some(&self.name)
    }
}

/// A row of the catalogue of materials.
pub struct MaterialRow {
    /// Name as written in a script.
    pub name: &'static str,
    /// Summary, one sentence: kind of law and range of validity.
    pub summary: &'static str,
    /// The formula and its source, for the reference.
    pub formula: &'static str,
    /// Volumetric form, for laws with several forms; otherwise `None`.
    pub volumetric: Option<VolumetricForm>,
    /// Parameters in the order in which [`super::Material::new`] takes their values; the density is the last.
    pub parameters: &'static [Parameter],
    /// Parameter values of a material about as stiff as Young's modulus 1; stresses scale with it.
    pub(super) example: &'static [f64],
    /// Makes the law from the values of the parameters.
    pub(super) construct: Construct,
}

/// Constructor of a law from the values of its parameters.
pub(super) enum Construct {
    /// Constructor of a hand-written law.
    Formula(fn(&[f64]) -> Laws),
    /// Constructor of a stored energy defined by text.
    Text(fn(&[f64]) -> Result<StoredEnergy, EnergyError>),
}

impl MaterialRow {
    /// True if this row is the law's only or default form, so that the law's name is sufficient.
    pub fn is_usual(&self) -> bool {
        self.volumetric.is_none_or(|form| form.is_usual())
    }

    /// Name of the law, with the volumetric form if it is not the default: `neo_hookean`, `neo_hookean, power`.
    pub fn title(&self) -> String {
        match self.volumetric.filter(|form| !form.is_usual()) {
            Some(form) => format!("{}, {}", self.name, form.name),
            None => self.name.into(),
        }
    }

    /// True if the law has a bulk modulus: its energy has a part that depends on the volume alone, so that all other constants can be
    /// fitted to tests at constant volume.
    pub fn is_incompressible(&self) -> bool {
        self.parameters.iter().any(|parameter| parameter.name == BULK_MODULUS.name)
    }

    /// Energy of a law defined by text, for parameter values by name; missing ones have their defaults, or 1.
    ///
    /// # Errors
    /// Values without a valid energy, or a law that is not written as text.
    pub fn energy(&self, value: impl Fn(&str) -> Option<f64>) -> Result<StoredEnergy, EnergyError> {
        let value = |parameter: &Parameter| value(parameter.name).or(parameter.default).unwrap_or(1.0);
        let values: Vec<f64> = self.parameters.iter().map(value).collect();
        match self.construct {
            Construct::Text(construct) => construct(&values),
            Construct::Formula(_) => StoredEnergy::new("", None, &[]),
        }
    }

    /// Parameter values of a material about as stiff as the given Young's modulus, for examples and tests over all rows.
    pub fn example(&self, modulus: f64, density: f64) -> Vec<f64> {
        let value = |(parameter, value): (&Parameter, &f64)| match parameter.dimension {
            "stress" => value * modulus,
            "mass/volume" => density,
            _ => *value,
        };
        self.parameters.iter().zip(self.example).map(value).collect()
    }
}

impl std::fmt::Debug for MaterialRow {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}", self.title())
    }
}

pub(super) const YOUNGS_MODULUS: Parameter = Parameter {
    name: "youngs_modulus",
    summary: "Young's modulus at zero strain",
    dimension: "stress",
    range: Interval::Positive,
    default: None,
};
pub(super) const POISSON_RATIO: Parameter = Parameter {
    name: "poisson_ratio",
    summary: "Poisson's ratio at zero strain",
    dimension: "1",
    range: Interval::Open(-1.0, 0.5),
    default: None,
};
pub(super) const BULK_MODULUS: Parameter = Parameter {
    name: "bulk_modulus",
    summary: "bulk modulus at zero strain",
    dimension: "stress",
    range: Interval::Positive,
    default: None,
};
pub(super) const DENSITY: Parameter = Parameter {
    name: "density",
    summary: "mass per undeformed volume",
    dimension: "mass/volume",
    range: Interval::Positive,
    default: None,
};

/// Energy of the change of volume `K/4 (J^2 - 1 - 2 ln J)` (Simo and Taylor, Computer Methods in Applied Mechanics and Engineering 33,
/// 1982): infinite for `J -> 0` and `J -> infinity`, without a pressure at `J = 1`.
pub(super) const VOLUMETRIC: &str = "bulk_modulus/4*(J^2 - 1 - 2*ln(J))";

/// Parameter of a law that is a modulus.
pub(super) const fn stress(name: &'static str, range: Interval, summary: &'static str) -> Parameter {
    Parameter { name, summary, dimension: "stress", range, default: None }
}

/// Parameter of a law that is a pure number.
pub(super) const fn number(name: &'static str, range: Interval, summary: &'static str) -> Parameter {
    Parameter { name, summary, dimension: "1", range, default: None }
}

/// Lame's constants `(lambda, mu)` from Young's modulus and Poisson's ratio.
pub(super) fn lame(youngs_modulus: f64, poisson_ratio: f64) -> (f64, f64) {
    let mu = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
    (2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio), mu)
}
