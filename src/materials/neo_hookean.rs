//! Compressible neo-Hookean law.
//!
//! `W = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2`, `C = I + 2 E`, `J^2 = det C` (Bonet and Wood, Nonlinear Continuum Mechanics, 2008,
//! section 6.4.3). Everything is evaluated from `E` without the differences of near-equal numbers that the formula shows: with
//! `x = det C - 1 = 2 tr E + 4 II(E) + 8 det E`, `ln J = ln(1 + x)/2` and `tr E - ln J = (x - ln(1 + x))/2 - 2 II(E) - 4 det E`.
//! The remainder of the discrete gradient has a closed form without cancellation (see [`Law::remainder`] below).

use super::{DENSITY, Law, Laws, MaterialRow, POISSON_RATIO, YOUNGS_MODULUS, lame};
use crate::math::lanes::Real;
use crate::math::tensor::Tensor;

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "neo_hookean",
    summary: "compressible neo-Hookean law: rubber-like, for large strains",
    formula: "W = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2 (Bonet and Wood 2008, section 6.4.3)",
    parameters: &[YOUNGS_MODULUS, POISSON_RATIO, DENSITY],
    construct: |values| {
        let (lambda, mu) = lame(values[0], values[1]);
        Laws::new(NeoHookean { lambda, mu }, values[0])
    },
};

/// The law with Lame's constants `[stress]`.
#[derive(Clone, Copy, Debug)]
struct NeoHookean {
    lambda: f64,
    mu: f64,
}

/// `det C - 1`.
#[inline(always)]
fn growth<T: Tensor>(strain: &T) -> T::Scalar {
    strain.trace() * 2.0 + strain.second_invariant() * 4.0 + strain.determinant() * 8.0
}

/// `cof C = I + 2 (tr E I - E) + 4 cof E`.
#[inline(always)]
fn cofactor_of_c<T: Tensor>(strain: &T) -> T {
    T::identity() * (strain.trace() * 2.0 + 1.0) - *strain * 2.0 + strain.cofactor() * 4.0
}

impl NeoHookean {
    /// Stress, inverse of `C`, and `mu - lambda ln J`.
    #[inline(always)]
    fn evaluate<T: Tensor>(&self, strain: &T) -> (T, T, T::Scalar) {
        // S = mu (I - C^-1) + lambda ln J C^-1, and det C (I - C^-1) = 2 E + 4 (II I - cof E) + 8 det E I, free of cancellation.
        let (second, third, cofactor) = (strain.second_invariant(), strain.determinant(), strain.cofactor());
        let x = strain.trace() * 2.0 + second * 4.0 + third * 8.0;
        let inverse_det = T::Scalar::splat(1.0) / (x + 1.0);
        let log = x.ln_1p() * (0.5 * self.lambda);
        let inverse = (T::identity() * (strain.trace() * 2.0 + 1.0) - *strain * 2.0 + cofactor * 4.0) * inverse_det;
        let shape = *strain * 2.0 + T::identity() * (second * 4.0 + third * 8.0) - cofactor * 4.0;
        (shape * (inverse_det * self.mu) + inverse * log, inverse, -log + self.mu)
    }
}

impl Law for NeoHookean {
    #[inline(always)]
    fn energy<T: Tensor>(&self, strain: &T) -> T::Scalar {
        let x = growth(strain);
        let log = x.ln_1p();
        let y = x / (x + 2.0);
        let excess = x * y - y.atanh_excess() * 2.0; // x - ln(1 + x)
        (excess * 0.5 - strain.second_invariant() * 2.0 - strain.determinant() * 4.0) * self.mu + log * log * (self.lambda / 8.0)
    }

    #[inline(always)]
    fn stress<T: Tensor>(&self, strain: &T) -> T {
        self.evaluate(strain).0
    }

    #[inline(always)]
    fn stress_tangent<T: Tensor>(&self, strain: &T) -> (T, T::Tangent) {
        let (stress, inverse, k) = self.evaluate(strain);
        (stress, T::isotropic_tangent(T::Scalar::splat(self.lambda), k * 2.0, &inverse))
    }

    /// With `det(C_m + s dC) = d + s p + s^2 r + s^3 t` (`s` from -1/2 to 1/2), `A = d + r/4`, `B = p/2 + t/8`, `z = B/A`:
    /// `ln J_1 - ln J_0 = atanh z`, slope of `ln J` over the step `delta = p/(2 d)`, and `(ln J_0 + ln J_1)/2 - ln J_m = ln(1 + u)/4`
    /// with `u = (A^2 - B^2)/d^2 - 1`. The part linear in `E` drops out, and what is left is of second and third order by itself.
    #[inline(always)]
    fn remainder<T: Tensor>(&self, strain_n: &T, strain_n1: &T) -> T::Scalar {
        let (mid, d) = ((*strain_n + *strain_n1) * 0.5, *strain_n1 - *strain_n);
        let x = growth(&mid);
        let inverse = T::Scalar::splat(1.0) / (x + 1.0);
        let log_mid = x.ln_1p() * 0.5;
        // p, r and t over d; dC = 2 dE.
        let p = cofactor_of_c(&mid).dot(&d) * 2.0 * inverse;
        let r = (d.second_invariant() + mid.dot(&d.cofactor()) * 2.0) * 4.0 * inverse;
        let t = d.determinant() * 8.0 * inverse;
        let delta = p * 0.5;
        let rho = r * 0.25; // A/d - 1
        let b = delta + t * 0.125; // B/d
        let z = b / (rho + 1.0);
        let third = z.atanh_excess() - (delta * rho - t * 0.125) / (rho + 1.0); // ln J_1 - ln J_0 - delta
        let u = rho * 2.0 + rho * rho - b * b;
        let y = u / (u + 2.0);
        let second = (y + y.atanh_excess()) * 0.5; // (ln J_0 + ln J_1)/2 - ln J_m
        ((log_mid + second) * self.lambda + -self.mu) * third + second * delta * self.lambda
    }
}
