//! A material: a law with the values of its constants, which are checked here and nowhere else.

use std::sync::Arc;

use thiserror::Error;

use super::batched::{BatchedLaw, Response};
use super::energy::{EnergyError, StoredEnergy};
use super::hencky;
use super::history::{HistoryLaw, HistoryLaws};
use super::law::Law;
use super::laws::{Kinematics, Laws};
use super::plasticity::{ElasticPlastic, PlasticLaw, PlasticityError};
use super::row::{Construct, MaterialRow, VolumetricForm, YOUNGS_MODULUS};
use super::split::Split;
use super::viscosity::Viscosity;
use crate::math::catalogue::{Interval, OutOfRange};
use crate::math::lanes::Lanes;
use crate::math::tolerances::RESIDUAL_STRESS;

/// Errors of material constants.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MaterialError {
    /// A constant outside its range.
    #[error("`{constant}` of `{law}` {fault}")]
    Constant {
        /// Name of the law.
        law: &'static str,
        /// Name of the constant.
        constant: &'static str,
        /// The range and the value.
        fault: OutOfRange,
    },
    /// Too many constants, or too few.
    #[error("`{law}` has {expected} constants, but {given} are given")]
    Count {
        /// Name of the law.
        law: &'static str,
        /// Number of constants of the law.
        expected: usize,
        /// Number of given constants.
        given: usize,
    },
    /// Stored energy that is invalid with the given constants.
    #[error(transparent)]
    Energy(#[from] EnergyError),
    /// Invalid constants of plasticity.
    #[error(transparent)]
    Plasticity(#[from] PlasticityError),
    /// Law without resistance to volume changes.
    #[error("`{law}` resists no change of the volume at rest with these constants")]
    Slack {
        /// Name of the law.
        law: &'static str,
    },
}

impl MaterialError {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            MaterialError::Constant { .. } => "C0301",
            MaterialError::Count { .. } => "C0302",
            MaterialError::Energy(error) => error.code(),
            MaterialError::Plasticity(error) => error.code(),
            MaterialError::Slack { .. } => "C0303",
        }
    }
}

/// Origin of the law of a material.
#[derive(Clone)]
enum Origin {
    /// A row of the catalogue with the values of its parameters.
    Row(&'static MaterialRow, Vec<f64>),
    /// A text of the user's.
    Text,
    /// Name of a law defined outside of the crate.
    Outside(&'static str),
}

/// Material: a row of the catalogue with parameter values, or a stored energy defined by the user.
#[derive(Clone)]
pub struct Material {
    origin: Origin,
    /// Stored energy of a law defined by text; otherwise `None`.
    energy: Option<StoredEnergy>,
    density: f64,
    laws: Laws,
    youngs_modulus: f64,
    viscosity: Viscosity,
    history: Option<HistoryLaws>,
    plasticity: Option<Arc<ElasticPlastic>>,
}

impl std::fmt::Debug for Material {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}{:?}", self.name(), self.constants())
    }
}

/// Name of the law with plastic flow.
pub const ELASTIC_PLASTIC: &str = "elastic_plastic";

/// Name of the law of materials defined by a stored energy.
pub const HYPERELASTIC: &str = "hyperelastic";

impl Material {
    /// Material of a row with parameter values in the row's order; some laws have a struct with named fields for this.
    ///
    /// # Errors
    /// The first value that is outside its range, or another number of values than the row has parameters; values without a valid energy.
    pub fn new(row: &'static MaterialRow, values: &[f64]) -> Result<Self, MaterialError> {
        if row.parameters.len() != values.len() {
            return Err(MaterialError::Count { law: row.name, expected: row.parameters.len(), given: values.len() });
        }
        for (parameter, &value) in row.parameters.iter().zip(values) {
            parameter.range.check(value).map_err(|fault| MaterialError::Constant { law: row.name, constant: parameter.name, fault })?;
        }
        let (laws, energy) = match row.construct {
            Construct::Formula(construct) => (construct(values), None),
            Construct::Text(construct) => {
                let energy = construct(values)?;
                (energy.laws()?, Some(energy))
            }
        };
        let given = row.parameters.iter().position(|parameter| parameter.name == YOUNGS_MODULUS.name);
        let youngs_modulus = given.map_or_else(|| modulus_at_rest(&*laws.space), |index| values[index]);
        let density = *values.last().expect("every row has a density");
        Material::sound(Origin::Row(row, values.to_vec()), energy, density, laws, youngs_modulus)
    }

    /// Material of a stored energy defined by text.
    ///
    /// ```
    /// # use conserva_materials::materials::{Material, StoredEnergy};
    /// let energy = StoredEnergy::new("mu/2*(I1bar - 3)", Some("k/2*(J - 1)^2"), &[("mu", 1.0), ("k", 100.0)])?;
    /// let rubber = Material::hyperelastic(energy, 1e-3)?;
    /// assert!((rubber.youngs_modulus() - 9.0 * 100.0 / (3.0 * 100.0 + 1.0)).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A mistake in the text, with its place; an invalid density.
    pub fn hyperelastic(energy: StoredEnergy, density: f64) -> Result<Self, MaterialError> {
        let wrong = |fault| MaterialError::Constant { law: HYPERELASTIC, constant: "density", fault };
        Interval::Positive.check(density).map_err(wrong)?;
        let laws = energy.laws()?;
        let youngs_modulus = modulus_at_rest(&*laws.space);
        Material::sound(Origin::Text, Some(energy), density, laws, youngs_modulus)
    }

    /// Material of an isotropic law defined outside of the crate (example: `examples/law.rs`).
    ///
    /// # Errors
    /// An invalid density; a law without stiffness against changes of volume.
    pub fn of_law(name: &'static str, law: impl Law + Clone, density: f64) -> Result<Self, MaterialError> {
        let wrong = |fault| MaterialError::Constant { law: name, constant: "density", fault };
        Interval::Positive.check(density).map_err(wrong)?;
        let laws = Laws::new(law);
        let youngs_modulus = modulus_at_rest(&*laws.space);
        Material::sound(Origin::Outside(name), None, density, laws, youngs_modulus)
    }

    /// An elastic-plastic material: Hencky's law with the flow of [`ElasticPlastic`].
    ///
    /// # Errors
    /// The first constant that is outside its range.
    pub fn elastic_plastic(constants: &ElasticPlastic) -> Result<Self, MaterialError> {
        let values = [constants.youngs_modulus, constants.poisson_ratio, constants.density];
        let elastic = Material::new(&hencky::ROW, &values).map_err(|error| match error {
            MaterialError::Constant { constant, fault, .. } => MaterialError::Constant { law: ELASTIC_PLASTIC, constant, fault },
            error => error,
        })?;
        constants.check()?;
        let laws = [true, false].map(|has_volume| PlasticLaw::new(constants, has_volume));
        Ok(Material { plasticity: Some(Arc::new(constants.clone())), ..elastic.with_history(laws) })
    }

    /// Returns the material of a law with history variables that is defined outside of the crate. `elastic` provides the stiffness at rest;
    /// cells evaluate the law point by point.
    pub fn of_history_law<H: HistoryLaw<4> + HistoryLaw<6> + Clone + 'static>(name: &'static str, elastic: Self, law: H) -> Self {
        let laws = Laws { split: None, ..elastic.laws.clone() };
        Material { origin: Origin::Outside(name), energy: None, laws, ..elastic.with_history([law.clone(), law]) }
    }

    /// Replaces the law by one with history variables; the elastic law still defines the stiffness at rest. The second of `laws` has no
    /// volumetric energy, for cells with a dilatation of their own.
    fn with_history<H: HistoryLaw<4> + HistoryLaw<6> + 'static>(self, laws: [H; 2]) -> Self {
        Material { history: Some(HistoryLaws::new(laws)), ..self }
    }

    /// Elastic material; refused if its stiffness is unsuitable as a scale for contact and tolerances.
    fn sound(origin: Origin, energy: Option<StoredEnergy>, density: f64, laws: Laws, youngs_modulus: f64) -> Result<Self, MaterialError> {
        let (viscosity, youngs_modulus) = (Viscosity::default(), youngs_modulus.abs());
        let material = Material { origin, energy, density, laws, youngs_modulus, viscosity, history: None, plasticity: None };
        if youngs_modulus > 0.0 && youngs_modulus.is_finite() { Ok(material) } else { Err(MaterialError::Slack { law: material.name() }) }
    }

    /// Returns the material in other units; `factor` maps a dimension, such as `"stress"`, to the factor of its values.
    ///
    /// # Errors
    /// The name of the first constant for whose dimension `factor` returns `None`.
    pub fn rescaled(&self, factor: impl Fn(&str) -> Option<f64>) -> Result<Self, String> {
        let unknown = |name: &str| format!("the dimension of the constant `{name}` is not known");
        let material = match (&self.origin, &self.energy) {
            (Origin::Row(row, values), _) => {
                let scaled = row.parameters.iter().zip(values).map(|(parameter, value)| {
                    factor(parameter.dimension).map(|factor| value * factor).ok_or_else(|| unknown(parameter.name))
                });
                Material::new(row, &scaled.collect::<Result<Vec<f64>, String>>()?)
            }
            (Origin::Text, Some(energy)) => {
                let stress = factor("stress").ok_or_else(|| unknown("energy"))?;
                let density = self.density * factor("mass/volume").ok_or_else(|| unknown("density"))?;
                Material::hyperelastic(StoredEnergy { factor: energy.factor * stress, ..energy.clone() }, density)
            }
            (Origin::Outside(name), _) => return Err(format!("`{name}` is written beside the program, which does not know its constants")),
            (Origin::Text, None) => return Ok(self.clone()),
        };
        let viscosity = if self.viscosity.is_none() {
            Viscosity::default()
        } else {
            let factor = |dimension: &str| factor(dimension).ok_or_else(|| unknown("viscosity"));
            self.viscosity.rescaled(factor("stress")?, factor("time")?)
        };
        let mut material = material.map_err(|error| error.to_string())?;
        if let Some(constants) = &self.plasticity {
            let factor = |dimension: &str| factor(dimension).ok_or_else(|| unknown(dimension));
            let constants = constants.rescaled(factor("stress")?, factor("mass/volume")?, factor("time")?);
            material = Material::elastic_plastic(&constants).map_err(|error| error.to_string())?;
        }
        Ok(Material { viscosity, ..material })
    }

    /// Returns the material of a body rotated in the plane by an angle with given cosine and sine.
    ///
    /// # Errors
    /// An energy that depends on components of the strain.
    pub fn turned(&self, cosine: f64, sine: f64) -> Result<Self, MaterialError> {
        let Some(energy) = &self.energy else { return Ok(self.clone()) };
        let energy = energy.turned(cosine, sine)?;
        Ok(Material { laws: energy.laws()?, energy: Some(energy), ..self.clone() })
    }

    /// Name of the law.
    pub fn name(&self) -> &'static str {
        match &self.origin {
            _ if self.plasticity.is_some() => ELASTIC_PLASTIC,
            Origin::Row(row, _) => row.name,
            Origin::Text => HYPERELASTIC,
            Origin::Outside(name) => name,
        }
    }

    /// Form of the volumetric part, for laws with several forms; otherwise `None`.
    pub fn volumetric_form(&self) -> Option<VolumetricForm> {
        match &self.origin {
            Origin::Row(row, _) => row.volumetric,
            Origin::Text | Origin::Outside(_) => None,
        }
    }

    /// Names and values of the constants in the row's order; the density is the last.
    pub fn constants(&self) -> Vec<(&str, f64)> {
        let mut constants = self.elastic_constants();
        let flow = self.plasticity.iter().map(|flow| ("yield_stress", flow.yield_stress));
        constants.splice(constants.len() - 1..constants.len() - 1, flow);
        constants
    }

    fn elastic_constants(&self) -> Vec<(&str, f64)> {
        match (&self.origin, &self.energy) {
            (Origin::Row(row, values), _) => row.parameters.iter().map(|parameter| parameter.name).zip(values.iter().copied()).collect(),
            (_, energy) => {
                let constants = energy.iter().flat_map(|energy| &energy.constants);
                constants.map(|(name, value)| (name.as_str(), *value)).chain([("density", self.density)]).collect()
            }
        }
    }

    /// Stored energy of a law defined by text; otherwise `None`.
    pub fn energy(&self) -> Option<&StoredEnergy> {
        self.energy.as_ref()
    }

    /// Mass per undeformed volume `[mass/volume]`.
    pub fn density(&self) -> f64 {
        self.density
    }

    /// Young's modulus at zero strain `[stress]`; the mean over all directions for anisotropic laws.
    pub fn youngs_modulus(&self) -> f64 {
        self.youngs_modulus
    }

    /// Largest modulus at zero strain `[stress]`, for uniaxial strain: the scale of force round-off, far above Young's modulus for nearly
    /// incompressible laws.
    pub fn stiffness(&self) -> f64 {
        let mut response = [Response::ZERO];
        self.laws.space.responses_into(&[[Lanes::ZERO; 6]], &mut response);
        let diagonal = (0..3).map(|k| response[0].tangent[k][k].0[0]);
        diagonal.fold(self.youngs_modulus, f64::max)
    }

    /// Returns the viscosity of the material.
    pub fn viscosity(&self) -> &Viscosity {
        &self.viscosity
    }

    /// Returns this material with another viscosity.
    pub fn with_viscosity(self, viscosity: Viscosity) -> Self {
        Material { viscosity, ..self }
    }

    /// Constants of the plastic flow, if any.
    pub fn plasticity(&self) -> Option<&ElasticPlastic> {
        self.plasticity.as_deref()
    }

    /// Laws with history variables; `None` if the stress depends on the present strain only.
    pub fn history(&self) -> Option<&HistoryLaws> {
        self.history.as_ref()
    }

    /// Strain measure of the law.
    pub fn kinematics(&self) -> Kinematics {
        self.laws.kinematics
    }

    /// The law in plane strain.
    pub fn plane(&self) -> Arc<dyn BatchedLaw<3>> {
        self.laws.plane.clone()
    }

    /// Law with a stretched, unsheared third direction: rotational symmetry, plane stress.
    pub fn axisymmetric(&self) -> Arc<dyn BatchedLaw<4>> {
        self.laws.axisymmetric.clone()
    }

    /// The law in space.
    pub fn space(&self) -> Arc<dyn BatchedLaw<6>> {
        self.laws.space.clone()
    }

    /// Bulk modulus and mean shear modulus at zero strain `[stress]`; means over all directions for anisotropic laws.
    pub fn moduli_at_rest(&self) -> [f64; 2] {
        moduli_at_rest(&*self.laws.space)
    }

    /// Bulk modulus over mean shear modulus at zero strain; infinite without a shear modulus.
    pub fn bulk_over_shear(&self) -> f64 {
        let [bulk, shear] = self.moduli_at_rest();
        bulk / shear
    }

    /// True for nearly incompressible materials: Poisson's ratio of 0.49 or more, or plastic flow. Cells that keep the volume at every
    /// point lock.
    pub fn hardly_changes_volume(&self) -> bool {
        self.plasticity.is_some() || self.bulk_over_shear() >= HARDLY_CHANGES_VOLUME
    }

    /// Law split into a part that depends on the volume only and the remainder; `None` without such a form.
    pub fn split(&self) -> Option<&Split> {
        self.laws.split.as_ref()
    }
}

/// Ratio of bulk to shear modulus from which a law counts as nearly incompressible: that of a Poisson's ratio of 0.49.
const HARDLY_CHANGES_VOLUME: f64 = 49.0;

/// Bulk modulus and mean shear modulus of the tangent at zero strain (Voigt 1889; Hill, Proc. Phys. Soc. A 65, 1952); 0 below round-off.
fn moduli_at_rest(law: &dyn BatchedLaw<6>) -> [f64; 2] {
    let mut response = [Response::ZERO];
    law.responses_into(&[[Lanes::ZERO; 6]], &mut response);
    let c = response[0].tangent.map(|row| row.map(|entry| entry.0[0]));
    let (direct, crossed) = (c[0][0] + c[1][1] + c[2][2], c[0][1] + c[1][2] + c[0][2]);
    // Because of Mandel components the shear diagonal is twice a shear modulus.
    let (bulk, shear) = ((direct + 2.0 * crossed) / 9.0, (direct - crossed + 1.5 * (c[3][3] + c[4][4] + c[5][5])) / 15.0);
    let nothing = RESIDUAL_STRESS * c.iter().flatten().map(|entry| entry.abs()).fold(0.0, f64::max);
    [bulk, shear].map(|modulus| if modulus.abs() <= nothing { 0.0 } else { modulus })
}

/// Young's modulus of the isotropic law with the moduli of `law` at zero strain.
fn modulus_at_rest(law: &dyn BatchedLaw<6>) -> f64 {
    let [bulk, shear] = moduli_at_rest(law);
    if bulk == 0.0 {
        return 0.0;
    }
    // Without a shear modulus the law may still resist shear by its stress at zero strain; the bulk modulus is the scale then.
    if shear == 0.0 { bulk } else { 9.0 * bulk * shear / (3.0 * bulk + shear) }
}
