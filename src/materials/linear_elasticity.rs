//! Linear elasticity: small strains of small displacements.
//!
//! `W = lambda/2 (tr e)^2 + mu e:e`, `e = sym(grad u)` (Hughes, The Finite Element Method, 2000, section 2.7): the Saint Venant-Kirchhoff
//! energy of the linear strain. Not invariant under rotations: a rotation by 0.1 causes a strain of 0.005. Therefore not in the catalogue,
//! whose laws are invariant, but in a list of its own.

use super::laws::{Kinematics, Laws};
use super::material::{Material, MaterialError};
use super::row::{Construct, DENSITY, MaterialRow, POISSON_RATIO, YOUNGS_MODULUS, lame};
use super::saint_venant_kirchhoff::Lame;

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "linear_elasticity",
    summary: "linear elasticity of small displacements; not for rotations",
    formula: "W = lambda/2 (tr e)^2 + mu e:e, e = sym(grad u) (Hughes 2000, section 2.7)",
    volumetric: None,
    parameters: &[YOUNGS_MODULUS, POISSON_RATIO, DENSITY],
    example: &[1.0, 0.3, 1.0],
    construct: Construct::Formula(|values| {
        let (lambda, mu) = lame(values[0], values[1]);
        Laws { kinematics: Kinematics::Linear, ..Laws::new(Lame { lambda, mu }) }
    }),
};

/// Constants of linear elasticity.
///
/// ```
/// # use conserva_materials::materials::{Kinematics, LinearElasticity};
/// let steel = LinearElasticity { youngs_modulus: 2.1e11, poisson_ratio: 0.3, density: 7800.0 }.material()?;
/// assert_eq!(steel.kinematics(), Kinematics::Linear);
/// # Ok::<(), conserva_materials::materials::MaterialError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearElasticity {
    /// Young's modulus `[stress]`.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Mass per undeformed volume `[mass/volume]`.
    pub density: f64,
}

impl LinearElasticity {
    /// Material with these constants.
    ///
    /// # Errors
    /// A constant outside its range.
    pub fn material(self) -> Result<Material, MaterialError> {
        Material::new(&ROW, &[self.youngs_modulus, self.poisson_ratio, self.density])
    }
}
