//! Numbers of a simulation as texts with their units, for the prompt and `print`.

use super::handle::SimulationHandle;
use crate::output::{ModelUnits, pretty_unit};
use crate::script::language::digits::{brief, brief_vector};

/// Units of the numbers in a text; `None` where the script declares none.
#[derive(Clone)]
pub struct ScriptOutput(Option<ModelUnits>);

impl ScriptOutput {
    /// Units of a simulation.
    pub fn of(handle: &SimulationHandle) -> Self {
        ScriptOutput(handle.0.units.clone())
    }

    /// A number with the unit of its dimension.
    pub fn number(&self, value: f64, dimension: &str) -> String {
        self.with_unit(brief(value), dimension)
    }

    /// A vector with the unit of its dimension.
    pub fn vector(&self, values: &[f64], dimension: &str) -> String {
        self.with_unit(brief_vector(values), dimension)
    }

    /// A moment with its unit: in the plane its third component.
    pub fn moment(&self, moment: &[f64; 3], dimension: usize) -> String {
        if dimension == 2 { self.number(moment[2], "force * length") } else { self.vector(moment, "force * length") }
    }

    fn with_unit(&self, text: String, dimension: &str) -> String {
        match self.0.as_ref().map(|units| units.unit(dimension)).filter(|unit| !unit.is_empty()) {
            Some(unit) => format!("{text} {}", pretty_unit(&unit)),
            None => text,
        }
    }
}
