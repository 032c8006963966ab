//! A material: a law with the values of its constants, which are checked here and nowhere else.

use std::sync::Arc;

use thiserror::Error;

use super::batched::BatchedLaw;
use super::row::{Laws, MaterialRow};
use crate::math::catalogue::OutOfRange;

/// Constants that make no material.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
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
        /// How many it has.
        expected: usize,
        /// How many are given.
        given: usize,
    },
}

/// A material: a row of the catalogue with the values of its parameters.
#[derive(Clone)]
pub struct Material {
    row: &'static MaterialRow,
    values: Vec<f64>,
    laws: Laws,
}

impl std::fmt::Debug for Material {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}{:?}", self.row.name, self.values)
    }
}

impl Material {
    /// The material of a row with the values of its parameters, in the row's order; a law has a struct with named fields for this.
    ///
    /// # Errors
    /// The first value that is outside its range, or another number of values than the row has parameters.
    pub fn new(row: &'static MaterialRow, values: &[f64]) -> Result<Self, MaterialError> {
        if row.parameters.len() != values.len() {
            return Err(MaterialError::Count { law: row.name, expected: row.parameters.len(), given: values.len() });
        }
        for (parameter, &value) in row.parameters.iter().zip(values) {
            parameter.range.check(value).map_err(|fault| MaterialError::Constant { law: row.name, constant: parameter.name, fault })?;
        }
        Ok(Material { row, values: values.to_vec(), laws: (row.construct)(values) })
    }

    /// Its row of the catalogue.
    pub fn row(&self) -> &'static MaterialRow {
        self.row
    }

    /// Values of the parameters, in the row's order.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Mass per undeformed volume `[mass/volume]`.
    pub fn density(&self) -> f64 {
        *self.values.last().expect("every row has a density")
    }

    /// Young's modulus at zero strain `[stress]`.
    pub fn youngs_modulus(&self) -> f64 {
        self.laws.youngs_modulus
    }

    /// The law in plane strain.
    pub fn plane(&self) -> Arc<dyn BatchedLaw<3>> {
        self.laws.plane.clone()
    }

    /// The law in space.
    pub fn space(&self) -> Arc<dyn BatchedLaw<6>> {
        self.laws.space.clone()
    }
}
