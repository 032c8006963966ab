//! Floor 1: stored-energy laws on the Green-Lagrange strain; formulas only, one file each.

use crate::math::catalogue::Parameter;

/// A row of the catalogue of materials.
#[derive(Debug)]
pub struct MaterialRow {
    /// Name as written in a script.
    pub name: &'static str,
    /// One sentence: what it is and where it holds.
    pub summary: &'static str,
    /// The formula and its source, for the reference.
    pub formula: &'static str,
    /// Parameters in the order in which [`Material::new`] takes their values; the density is the last.
    pub parameters: &'static [Parameter],
}

/// The catalogue of materials.
pub static CATALOGUE: &[MaterialRow] = &[];

/// A material: a row of the catalogue with the values of its parameters.
#[derive(Clone, Debug)]
pub struct Material {
    row: &'static MaterialRow,
    values: Vec<f64>,
}

impl Material {
    /// The material of a row with the values of its parameters, in the row's order and inside their ranges (checked by the caller).
    pub fn new(row: &'static MaterialRow, values: &[f64]) -> Self {
        assert_eq!(row.parameters.len(), values.len(), "one value for each parameter");
        Material { row, values: values.to_vec() }
    }

    /// Its row of the catalogue.
    pub fn row(&self) -> &'static MaterialRow {
        self.row
    }

    /// Values of the parameters, in the row's order.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Mass per reference volume `[mass/volume]`.
    pub fn density(&self) -> f64 {
        *self.values.last().expect("every row has a density")
    }
}
