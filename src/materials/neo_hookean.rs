//! Compressible neo-Hookean law.
//!
//! `W = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2`, `C = I + 2 E`, `J^2 = det C` (Bonet and Wood, Nonlinear Continuum Mechanics, 2008,
//! section 6.4.3). Everything is evaluated from `E` without the differences of near-equal numbers that the formula shows: with
//! `x = det C - 1 = 2 tr E + 4 II(E) + 8 det E`, `ln J = ln(1 + x)/2` and `tr E - ln J = (x - ln(1 + x))/2 - 2 II(E) - 4 det E`.
//! The remainder of the discrete gradient has a closed form without cancellation (see [`Law::remainder`] below).

use super::law::{Increment, Law};
use super::laws::Laws;
use super::material::{Material, MaterialError};
use super::row::{Construct, DENSITY, MaterialRow, POISSON_RATIO, YOUNGS_MODULUS, lame};
use super::split::VolumetricLaw;
use super::volume::{cofactor_of_c, growth};
use crate::math::lanes::{Lanes, Real};
use crate::math::tensor::Tensor;

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "neo_hookean",
    summary: "compressible neo-Hookean law: rubber-like, for large strains",
    formula: "W = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2 (Bonet and Wood 2008, section 6.4.3)",
    parameters: &[YOUNGS_MODULUS, POISSON_RATIO, DENSITY],
    example: &[1.0, 0.3, 1.0],
    construct: Construct::Formula(|values| {
        let (lambda, mu) = lame(values[0], values[1]);
        Laws::new(Lame { lambda, mu }).split_into(Lame { lambda: 0.0, mu }, Logarithmic { lambda })
    }),
};

/// Constants of the compressible neo-Hookean law at zero strain.
///
/// ```
/// # use conserva::materials::NeoHookean;
/// let steel = NeoHookean { youngs_modulus: 2.1e11, poisson_ratio: 0.3, density: 7800.0 }.material()?;
/// assert_eq!(steel.density(), 7800.0);
///
/// let error = NeoHookean { youngs_modulus: 2.1e11, poisson_ratio: 0.6, density: 7800.0 }.material().unwrap_err();
/// assert_eq!(error.to_string(), "`poisson_ratio` of `neo_hookean` must be greater than -1 and less than 0.5, but is 0.6");
/// # Ok::<(), conserva::materials::MaterialError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// Young's modulus `[stress]`.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Mass per undeformed volume `[mass/volume]`.
    pub density: f64,
}

impl NeoHookean {
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
struct Lame {
    lambda: f64,
    mu: f64,
}

/// `U(J) = lambda/2 (ln J)^2`.
#[derive(Clone, Copy, Debug)]
struct Logarithmic {
    lambda: f64,
}

impl VolumetricLaw for Logarithmic {
    fn energies_into(&self, change: &[Lanes<false>], energy: &mut [Lanes<false>]) {
        for (change, energy) in change.iter().zip(energy) {
            let log = change.ln_1p();
            *energy = log * log * (0.5 * self.lambda);
        }
    }

    fn responses_into(&self, change: &[Lanes<false>], responses: &mut [[Lanes<false>; 2]]) {
        for (change, response) in change.iter().zip(responses) {
            let (log, inverse) = (change.ln_1p(), Lanes::splat(1.0) / (*change + 1.0));
            let slope = inverse * self.lambda;
            *response = [slope * log, slope * inverse * (-log + 1.0)];
        }
    }
}

impl Lame {
    /// Stress for given `det C` (its inverse), `ln J` and `cof C`:
    /// `S = mu (I - C^-1) + lambda ln J C^-1`, and `det C (I - C^-1) = 2 E + 4 (II I - cof E) + 8 det E I`, free of cancellation.
    #[inline(always)]
    fn stress_of<T: Tensor>(&self, strain: &T, inverse_det: T::Scalar, log: T::Scalar, cofactor: &T) -> T {
        let second = strain.second_invariant() * 4.0;
        let shape = if T::PLANE {
            (*strain * 2.0).plus_identity(second)
        } else {
            (*strain * 2.0).plus_identity(second + strain.determinant() * 8.0) - strain.cofactor() * 4.0
        };
        shape.mul_add(inverse_det * self.mu, &(*cofactor * (log * inverse_det * self.lambda)))
    }

    #[inline(always)]
    fn tangent_of<T: Tensor>(&self, inverse_det: T::Scalar, log: T::Scalar, cofactor: &T) -> T::Tangent {
        let k = log * -(2.0 * self.lambda) + 2.0 * self.mu;
        T::isotropic_tangent(T::Scalar::splat(self.lambda), k, &(*cofactor * inverse_det))
    }
}

impl Law for Lame {
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
        let x = growth(strain);
        self.stress_of(strain, T::Scalar::splat(1.0) / (x + 1.0), x.ln_1p() * 0.5, &cofactor_of_c(strain))
    }

    #[inline(always)]
    fn stress_tangent<T: Tensor>(&self, strain: &T) -> (T, T::Tangent) {
        let (x, cofactor) = (growth(strain), cofactor_of_c(strain));
        let (inverse_det, log) = (T::Scalar::splat(1.0) / (x + 1.0), x.ln_1p() * 0.5);
        (self.stress_of(strain, inverse_det, log, &cofactor), self.tangent_of(inverse_det, log, &cofactor))
    }

    #[inline(always)]
    fn remainder<T: Tensor>(&self, strain_n: &T, strain_n1: &T) -> T::Scalar {
        self.increment(strain_n, strain_n1).remainder
    }

    /// With `det(C_m + s dC) = d + s p + s^2 r + s^3 t` (`s` from -1/2 to 1/2), `A = d + r/4`, `B = p/2 + t/8`, `z = B/A`:
    /// `ln J_1 - ln J_0 = atanh z`, slope of `ln J` over the step `delta = p/(2 d)`, and `(ln J_0 + ln J_1)/2 - ln J_m = ln(1 + u)/4`
    /// with `u = (A^2 - B^2)/d^2 - 1`. The part linear in `E` drops out, and what is left is of second and third order by itself.
    /// `ln J_1` and `det C_1 = A + B` follow on the way.
    #[inline(always)]
    fn increment<T: Tensor>(&self, strain_n: &T, strain_n1: &T) -> Increment<T> {
        let (mid, d) = ((*strain_n + *strain_n1) * 0.5, *strain_n1 - *strain_n);
        let (x, cofactor) = (growth(&mid), cofactor_of_c(&mid));
        let inverse = T::Scalar::splat(1.0) / (x + 1.0);
        let log_mid = x.ln_1p() * 0.5;
        // r and t over d; dC = 2 dE.
        let delta = cofactor.dot(&d) * inverse;
        let mut rho = d.second_invariant() * inverse; // A/d - 1 = r/(4 d)
        let (mut b, mut defect) = (delta, delta * rho); // B/d and delta A/d - B/d
        if !T::PLANE {
            rho = (d.second_invariant() + mid.dot(&d.cofactor()) * 2.0) * inverse;
            let eighth = d.determinant() * inverse; // t/(8 d)
            (b, defect) = (delta + eighth, delta * rho - eighth);
        }
        let (a, u) = (rho + 1.0, rho * (rho + 2.0) - b * b);
        // One division for 1/A, 1/(A + B) and 1/(u + 2).
        let (end, two) = (a + b, u + 2.0);
        let inverses = T::Scalar::splat(1.0) / (a * end * two);
        let inverse_a = inverses * (end * two);
        let third = (b * inverse_a).atanh_excess() - defect * inverse_a; // ln J_1 - ln J_0 - delta
        let y = u * (inverses * (a * end));
        let second = (y + y.atanh_excess()) * 0.5; // (ln J_0 + ln J_1)/2 - ln J_m
        let log_end = log_mid + second + (third + delta) * 0.5;
        Increment {
            stress: self.stress_of(&mid, inverse, log_mid, &cofactor),
            tangent: self.tangent_of(inverse, log_mid, &cofactor),
            stress_end: self.stress_of(strain_n1, inverse * (inverses * (a * two)), log_end, &cofactor_of_c(strain_n1)),
            remainder: ((log_mid + second) * self.lambda + -self.mu) * third + second * delta * self.lambda,
        }
    }
}
