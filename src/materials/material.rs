//! A material: a law with the values of its constants, which are checked here and nowhere else.

use std::sync::Arc;

use thiserror::Error;

use super::batched::{BatchedLaw, Response};
use super::row::{Kinematics, Laws, MaterialRow, YOUNGS_MODULUS};
use super::split::Split;
use crate::math::catalogue::OutOfRange;
use crate::math::lanes::Lanes;

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
    youngs_modulus: f64,
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
        let laws = (row.construct)(values);
        let given = row.parameters.iter().position(|parameter| parameter.name == YOUNGS_MODULUS.name);
        let youngs_modulus = given.map_or_else(|| modulus_at_rest(&*laws.space), |index| values[index]);
        Ok(Material { row, values: values.to_vec(), laws, youngs_modulus })
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

    /// Young's modulus at zero strain `[stress]`, of a law that is not isotropic a mean over all directions.
    pub fn youngs_modulus(&self) -> f64 {
        self.youngs_modulus
    }

    /// The strain that the law takes.
    pub fn kinematics(&self) -> Kinematics {
        self.laws.kinematics
    }

    /// The law in plane strain.
    pub fn plane(&self) -> Arc<dyn BatchedLaw<3>> {
        self.laws.plane.clone()
    }

    /// The law where the third direction is stretched but not sheared: rotational symmetry, plane stress.
    pub fn axisymmetric(&self) -> Arc<dyn BatchedLaw<4>> {
        self.laws.axisymmetric.clone()
    }

    /// The law in space.
    pub fn space(&self) -> Arc<dyn BatchedLaw<6>> {
        self.laws.space.clone()
    }

    /// The law as the sum of a part that depends on the volume alone and the rest, if it is written so.
    pub fn split(&self) -> Option<&Split> {
        self.laws.split.as_ref()
    }
}

/// Young's modulus from the tangent at zero strain: of the isotropic one with the same bulk modulus and the same mean shear modulus
/// (Voigt 1889; Hill, Proc. Phys. Soc. A 65, 1952).
fn modulus_at_rest(law: &dyn BatchedLaw<6>) -> f64 {
    let mut response = [Response::ZERO];
    law.responses_into(&[[Lanes::ZERO; 6]], &mut response);
    let c = response[0].tangent.map(|row| row.map(|entry| entry.0[0]));
    let (direct, crossed) = (c[0][0] + c[1][1] + c[2][2], c[0][1] + c[1][2] + c[0][2]);
    // Because of Mandel components the shear diagonal is twice a shear modulus.
    let (bulk, shear) = ((direct + 2.0 * crossed) / 9.0, (direct - crossed + 1.5 * (c[3][3] + c[4][4] + c[5][5])) / 15.0);
    9.0 * bulk * shear / (3.0 * bulk + shear)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials::{CATALOGUE, LinearElasticity};

    #[test]
    fn the_modulus_at_rest_is_the_one_that_was_given() {
        for row in
            CATALOGUE.iter().chain([LinearElasticity { youngs_modulus: 1.0, poisson_ratio: 0.0, density: 1.0 }.material().unwrap().row()])
        {
            if row.parameters[0].name == YOUNGS_MODULUS.name {
                let material = Material::new(row, &[1234.5, 0.37, 1.0]).unwrap();
                assert!((modulus_at_rest(&*material.space()) - 1234.5).abs() < 1e-12 * 1234.5, "{}", row.name);
            }
        }
    }
}
