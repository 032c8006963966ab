//! Stored energy defined by a user: one or two texts, values of constants, fiber directions.

use std::ops::Range;
use std::sync::Arc;

use super::error::EnergyError;
use super::graph::{Graph, Id};
use super::law::EnergyLaw;
use super::meaning::{FUNCTIONS, QUANTITIES, Setting, Translation, constants_of};
use super::syntax::{Expression, parse};
use super::variable::Variable;
use super::volumetric::VolumetricEnergy;
use crate::materials::laws::{Kinematics, Laws};
use crate::materials::split::Split;

/// Energy per undeformed volume, as text.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyText {
    text: String,
    expression: Expression,
}

impl EnergyText {
    /// Parses the text of an energy.
    ///
    /// # Errors
    /// A syntax error, with its place in the text.
    pub fn parse(text: &str) -> Result<Self, EnergyError> {
        Ok(EnergyText { text: text.into(), expression: parse(text)? })
    }

    /// Source text of the energy, as written by the user.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Names of the constants, each with the byte range of its first occurrence: all names except quantities and functions.
    pub fn constants(&self) -> Vec<(String, Range<usize>)> {
        constants_of(&self.expression)
    }
}

/// Stored energy `W = energy + volumetric`, with the values of its constants.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredEnergy {
    /// Energy, or its part besides `volumetric`.
    pub energy: EnergyText,
    /// Part that depends on `J` only, treated separately in elements with mean dilatation.
    pub volumetric: Option<EnergyText>,
    /// Fiber directions in the undeformed state, of any nonzero length; at most two.
    pub fibers: Vec<[f64; 3]>,
    /// Constants with their values.
    pub constants: Vec<(String, f64)>,
    /// Factor of the energy.
    pub factor: f64,
}

/// Quantities that an energy may contain, with descriptions.
pub fn quantities_of_energies() -> impl Iterator<Item = (&'static str, &'static str)> {
    QUANTITIES.iter().copied()
}

/// Functions that an energy may call, with descriptions.
pub fn functions_of_energies() -> impl Iterator<Item = (&'static str, &'static str)> {
    FUNCTIONS.iter().map(|(name, summary, _)| (*name, *summary))
}

/// Graph nodes of an energy in one setting.
struct Built {
    graph: Graph,
    rest: Id,
    volumetric: Option<Id>,
}

impl StoredEnergy {
    /// An energy of texts with values for the constants.
    ///
    /// # Errors
    /// A syntax error, with its place in the text.
    pub fn new(energy: &str, volumetric: Option<&str>, constants: &[(&str, f64)]) -> Result<Self, EnergyError> {
        Ok(StoredEnergy {
            energy: EnergyText::parse(energy)?,
            volumetric: volumetric.map(EnergyText::parse).transpose()?,
            fibers: Vec::new(),
            constants: constants.iter().map(|(name, value)| (name.to_string(), *value)).collect(),
            factor: 1.0,
        })
    }

    /// Returns this energy with fibers along directions, which need not be unit vectors.
    pub fn with_fibers(self, fibers: &[[f64; 3]]) -> Self {
        StoredEnergy { fibers: fibers.to_vec(), ..self }
    }

    /// Returns the energy of a body rotated in the plane by an angle with given cosine and sine: fibers are rotated.
    ///
    /// # Errors
    /// The energy depends on components of the strain, whose axes do not rotate.
    pub fn turned(&self, cosine: f64, sine: f64) -> Result<Self, EnergyError> {
        let Built { graph, rest, .. } = self.build(Setting::Space)?;
        if graph.variables(rest).iter().any(|variable| matches!(variable, Variable::Strain(_))) {
            let text = &self.energy.text;
            let error = EnergyError::new(text, 0..text.len(), "an energy of components of the strain cannot be turned", "names components");
            return Err(error.hint("write it with invariants and fibers"));
        }
        let fibers = self.fibers.iter().map(|[x, y, z]| [cosine * x - sine * y, sine * x + cosine * y, *z]).collect();
        Ok(StoredEnergy { fibers, ..self.clone() })
    }

    fn build(&self, setting: Setting) -> Result<Built, EnergyError> {
        let mut graph = Graph::default();
        let mut node = |text: &EnergyText| -> Result<Id, EnergyError> {
            let fibers = self.fibers.len();
            let id =
                Translation { graph: &mut graph, text: &text.text, setting, fibers, constants: &self.constants }.node(&text.expression)?;
            Ok(graph.scaled(self.factor, id))
        };
        let rest = node(&self.energy)?;
        let volumetric = self.volumetric.as_ref().map(&mut node).transpose()?;
        if let (Some(text), Some(id)) = (&self.volumetric, volumetric)
            && graph.variables(id).iter().any(|variable| *variable != Variable::J)
        {
            let error =
                EnergyError::new(&text.text, 0..text.text.len(), "the volumetric energy depends on more than `J`", "not of `J` alone");
            return Err(error.hint("move what depends on other quantities to `energy`"));
        }
        Ok(Built { graph, rest, volumetric })
    }

    fn directions(&self) -> Vec<[f64; 3]> {
        self.fibers.iter().map(|fiber| fiber.map(|x| x / fiber.iter().map(|x| x * x).sum::<f64>().sqrt())).collect()
    }

    /// Law of the whole energy in one setting, and law without the volumetric part.
    fn laws_in<const S: usize>(&self, setting: Setting) -> Result<(EnergyLaw<S>, Option<EnergyLaw<S>>), EnergyError> {
        let (fibers, mut built) = (self.directions(), self.build(setting)?);
        let Some(volumetric) = built.volumetric else { return Ok((EnergyLaw::new(&mut built.graph, built.rest, &fibers), None)) };
        let whole = built.graph.sum(built.rest, volumetric);
        Ok((EnergyLaw::new(&mut built.graph, whole, &fibers), Some(EnergyLaw::new(&mut built.graph, built.rest, &fibers))))
    }

    /// Laws of this energy, as called by the element loop.
    pub(crate) fn laws(&self) -> Result<Laws, EnergyError> {
        let (space, space_rest) = self.laws_in::<6>(Setting::Space)?;
        let (axisymmetric, axisymmetric_rest) = self.laws_in::<4>(Setting::Axisymmetric)?;
        let (plane, plane_rest) = self.laws_in::<3>(Setting::Plane)?;
        let volumetric = {
            let Built { mut graph, volumetric, .. } = self.build(Setting::Space)?;
            volumetric.map(|id| VolumetricEnergy::new(&mut graph, id))
        };
        let split = match (plane_rest, axisymmetric_rest, space_rest, volumetric) {
            (Some(plane), Some(axisymmetric), Some(space), Some(volumetric)) => Some(Split {
                plane: Arc::new(plane),
                axisymmetric: Arc::new(axisymmetric),
                space: Arc::new(space),
                volumetric: Arc::new(volumetric),
            }),
            _ => None,
        };
        Ok(Laws {
            plane: Arc::new(plane),
            axisymmetric: Arc::new(axisymmetric),
            space: Arc::new(space),
            split,
            kinematics: Kinematics::GreenLagrange,
        })
    }

    /// Law in space, without the volumetric part.
    pub(crate) fn in_space(&self) -> Result<EnergyLaw<6>, EnergyError> {
        let Built { mut graph, rest, .. } = self.build(Setting::Space)?;
        Ok(EnergyLaw::new(&mut graph, rest, &self.directions()))
    }

    /// Value of the energy at zero strain `[energy/volume]`, which laws subtract.
    ///
    /// # Errors
    /// A mistake in the text, with its place.
    pub fn at_rest(&self) -> Result<f64, EnergyError> {
        let Built { graph, rest, volumetric } = self.build(Setting::Space)?;
        Ok(graph.rest(rest) + volumetric.map_or(0.0, |id| graph.rest(id)))
    }
}
