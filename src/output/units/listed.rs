//! `units.json`: units of the files of a run, for programs that read them and for comparisons of runs.
//!
//! Not all CSV readers skip comments, so the units are in a file of their own: the declared set, and the unit of each column of
//! `history.csv` and of each field of the frames, as expressions such as `kg/m^3`. Pure numbers have no entry.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::set::ModelUnits;
use crate::dynamics::{NODAL_FIELDS, POINT_FIELDS};
use crate::output::reading::error::{ReadError, bytes_of};

/// Name of the file.
pub const UNITS_FILE: &str = "units.json";

/// Units of the files of a simulation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ListedUnits {
    /// Units as declared.
    pub declared: Vec<String>,
    /// Units of mass, length, time, force, stress and energy.
    pub units: BTreeMap<String, String>,
    /// Units of the columns of the history.
    pub columns: BTreeMap<String, String>,
    /// Units of fields.
    pub fields: BTreeMap<String, String>,
}

impl ListedUnits {
    /// Units of a model's results, without columns.
    pub fn of(units: &ModelUnits) -> Self {
        let nodal = NODAL_FIELDS.iter().map(|field| (field.name, field.dimension));
        let fields = nodal.chain(POINT_FIELDS.iter().map(|field| (field.name, field.dimension)));
        ListedUnits {
            declared: units.set.names().into_iter().map(String::from).collect(),
            units: units.set.overview().into_iter().map(|(name, unit)| (name.to_string(), unit)).collect(),
            columns: BTreeMap::new(),
            fields: noted(fields, units),
        }
    }

    /// Adds columns with their dimensions.
    pub fn add_columns<'a>(&mut self, columns: impl IntoIterator<Item = (&'a str, &'a str)>, units: &ModelUnits) {
        self.columns.extend(noted(columns, units));
    }

    /// Text of the file.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

fn noted<'a>(names: impl IntoIterator<Item = (&'a str, &'a str)>, units: &ModelUnits) -> BTreeMap<String, String> {
    let with_unit = names.into_iter().map(|(name, dimension)| (name.to_string(), units.unit(dimension)));
    with_unit.filter(|(_, unit)| !unit.is_empty()).collect()
}

/// Reads the units beside the files of a simulation; `None` where none were declared.
///
/// # Errors
/// A file that cannot be read or is damaged.
pub fn read_units(folder: &Path) -> Result<Option<ListedUnits>, ReadError> {
    let path = folder.join(UNITS_FILE);
    if !path.is_file() {
        return Ok(None);
    }
    let read = serde_json::from_slice(&bytes_of(&path)?);
    read.map(Some).map_err(|error| ReadError::damaged(&path, format!("it has no units from line {} on", error.line())))
}
