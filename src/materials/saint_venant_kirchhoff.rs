//! Saint Venant-Kirchhoff law: stress linear in the Green-Lagrange strain.
//!
//! `W(E) = lambda/2 (tr E)^2 + mu E:E`, `S = lambda (tr E) I + 2 mu E` (Simo and Hughes, Computational Inelasticity, 1998, section 6.4).
//! Quadratic in `E`, so the stress at the mean strain already is the discrete gradient and the remainder is zero.
//! Not for strong compression: the energy stays finite as `J -> 0`.

use super::{DENSITY, Law, Laws, MaterialRow, POISSON_RATIO, YOUNGS_MODULUS, lame};
use crate::math::lanes::Real;
use crate::math::tensor::Tensor;

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "saint_venant_kirchhoff",
    summary: "Saint Venant-Kirchhoff law: stress linear in the Green-Lagrange strain; for large rotations with small strains",
    formula: "W = lambda/2 (tr E)^2 + mu E:E (Simo and Hughes 1998, section 6.4)",
    parameters: &[YOUNGS_MODULUS, POISSON_RATIO, DENSITY],
    construct: |values| {
        let (lambda, mu) = lame(values[0], values[1]);
        Laws::new(SaintVenantKirchhoff { lambda, mu }, values[0])
    },
};

/// The law with Lame's constants `[stress]`.
#[derive(Clone, Copy, Debug)]
struct SaintVenantKirchhoff {
    lambda: f64,
    mu: f64,
}

impl Law for SaintVenantKirchhoff {
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
