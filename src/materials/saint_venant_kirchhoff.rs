//! Saint Venant-Kirchhoff law: stress linear in the Green-Lagrange strain.
//!
//! `W(E) = lambda/2 (tr E)^2 + mu E:E`, `S = lambda (tr E) I + 2 mu E` (Simo and Hughes, Computational Inelasticity, 1998, section 6.4).
//! Quadratic in `E`, so the stress at the mean strain already is the discrete gradient and the remainder is zero.
//! Not for strong compression: the energy stays finite as `J -> 0`.

use super::law::Law;
use super::laws::Laws;
use super::material::{Material, MaterialError};
use super::row::{Construct, DENSITY, MaterialRow, POISSON_RATIO, YOUNGS_MODULUS, lame};
use crate::math::lanes::Real;
use crate::math::tensor::Tensor;

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "saint_venant_kirchhoff",
    summary: "Saint Venant-Kirchhoff law: stress linear in the Green-Lagrange strain; for large rotations with small strains",
    formula: "W = lambda/2 (tr E)^2 + mu E:E (Simo and Hughes 1998, section 6.4)",
    volumetric: None,
    parameters: &[YOUNGS_MODULUS, POISSON_RATIO, DENSITY],
    example: &[1.0, 0.3, 1.0],
    construct: Construct::Formula(|values| {
        let (lambda, mu) = lame(values[0], values[1]);
        Laws::new(Lame { lambda, mu })
    }),
};

/// Constants of the Saint Venant-Kirchhoff law at zero strain.
///
/// ```
/// # use conserva_materials::materials::SaintVenantKirchhoff;
/// let steel = SaintVenantKirchhoff { youngs_modulus: 2.1e11, poisson_ratio: 0.3, density: 7800.0 }.material()?;
/// assert_eq!(steel.density(), 7800.0);
///
/// let error = SaintVenantKirchhoff { youngs_modulus: 2.1e11, poisson_ratio: 0.6, density: 7800.0 }.material().unwrap_err();
/// assert_eq!(error.to_string(), "`poisson_ratio` of `saint_venant_kirchhoff` must be greater than -1 and less than 0.5, but is 0.6");
/// # Ok::<(), conserva_materials::materials::MaterialError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaintVenantKirchhoff {
    /// Young's modulus `[stress]`.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Mass per undeformed volume `[mass/volume]`.
    pub density: f64,
}

impl SaintVenantKirchhoff {
    /// The material with these constants.
    ///
    /// # Errors
    /// A constant outside its range.
    pub fn material(self) -> Result<Material, MaterialError> {
        Material::new(&ROW, &[self.youngs_modulus, self.poisson_ratio, self.density])
    }
}

/// The law with Lame's constants `[stress]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lame {
    pub(super) lambda: f64,
    pub(super) mu: f64,
}

impl Law for Lame {
    #[inline(always)]
    fn energy<T: Tensor>(&self, strain: &T) -> T::Scalar {
        let trace = strain.trace();
        trace * trace * (0.5 * self.lambda) + strain.dot(strain) * self.mu
    }

    #[inline(always)]
    fn stress<T: Tensor>(&self, strain: &T) -> T {
        T::identity() * (strain.trace() * self.lambda) + *strain * (2.0 * self.mu)
    }

    #[inline(always)]
    fn stress_tangent<T: Tensor>(&self, strain: &T) -> (T, T::Tangent) {
        let (lambda, mu) = (T::Scalar::splat(self.lambda), T::Scalar::splat(2.0 * self.mu));
        (self.stress(strain), T::isotropic_tangent(lambda, mu, &T::identity()))
    }

    #[inline(always)]
    fn remainder<T: Tensor>(&self, _: &T, _: &T) -> T::Scalar {
        T::Scalar::splat(0.0)
    }
}
