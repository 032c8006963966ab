//! Compressible neo-Hookean law, in two forms of its volumetric part.
//!
//! `W = mu/2 (tr C - 3) - mu ln J + U(J)`, `C = I + 2 E`, `J^2 = det C`. Logarithmic form: `U = lambda/2 (ln J)^2` (Bonet and Wood,
//! Nonlinear Continuum Mechanics, 2008, section 6.4.3), whose pressure falls again beyond `J = e`. Power form:
//! `U = lambda/4 (J^2 - 1 - 2 ln J)` (Ciarlet and Geymonat, Comptes Rendus 295, 1982; Ciarlet, Mathematical Elasticity, 1988, section
//! 4.10), which is polyconvex: `U` is convex, so it stiffens without end. Both are the same at small strains. Everything is evaluated from
//! `E` without the differences of near-equal numbers that the formula shows: with `x = det C - 1 = 2 tr E + 4 II(E) + 8 det E`,
//! `ln J = ln(1 + x)/2` and `tr E - ln J = (x - ln(1 + x))/2 - 2 II(E) - 4 det E`. The remainder of the discrete gradient has a closed form
//! without cancellation (see [`Law::remainder`] below).

use super::law::{Increment, Law};
use super::laws::Laws;
use super::material::{Material, MaterialError};
use super::row::{Construct, DENSITY, MaterialRow, POISSON_RATIO, VolumetricForm, YOUNGS_MODULUS, lame};
use super::volume::{Logarithmic, Power, cofactor_of_c, excess, growth};
use crate::math::lanes::Real;
use crate::math::tensor::Tensor;

const FORMULA: &str = "W = mu/2 (tr C - 3) - mu ln J + U(J); `volumetric` chooses U: \"logarithmic\" lambda/2 (ln J)^2 (Bonet and Wood \
                       2008, section 6.4.3), \"power\" lambda/4 (J^2 - 1 - 2 ln J), which stiffens without end (Ciarlet and Geymonat 1982)";

/// Names of the volumetric forms, the default first.
const FORMS: &[&str] = &["logarithmic", "power"];

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "neo_hookean",
    summary: "compressible neo-Hookean law: rubber-like, for large strains",
    formula: FORMULA,
    volumetric: Some(VolumetricForm { name: "logarithmic", all: FORMS }),
    parameters: &[YOUNGS_MODULUS, POISSON_RATIO, DENSITY],
    example: &[1.0, 0.3, 1.0],
    construct: Construct::Formula(|values| {
        let (lambda, mu) = lame(values[0], values[1]);
        Laws::new(Lame { lambda, mu }).split_into(Lame { lambda: 0.0, mu }, Logarithmic { lambda })
    }),
};

pub(super) const POWER_ROW: MaterialRow = MaterialRow {
    volumetric: Some(VolumetricForm { name: "power", all: FORMS }),
    construct: Construct::Formula(|values| {
        let (lambda, mu) = lame(values[0], values[1]);
        Laws::new(PowerForm(Lame { lambda, mu })).split_into(Lame { lambda: 0.0, mu }, Power { lambda })
    }),
    ..ROW
};

/// Constants of the compressible neo-Hookean law at zero strain.
///
/// ```
/// # use conserva_materials::materials::NeoHookean;
/// let steel = NeoHookean { youngs_modulus: 2.1e11, poisson_ratio: 0.3, density: 7800.0 }.material()?;
/// assert_eq!(steel.density(), 7800.0);
///
/// let error = NeoHookean { youngs_modulus: 2.1e11, poisson_ratio: 0.6, density: 7800.0 }.material().unwrap_err();
/// assert_eq!(error.to_string(), "`poisson_ratio` of `neo_hookean` must be greater than -1 and less than 0.5, but is 0.6");
/// # Ok::<(), conserva_materials::materials::MaterialError>(())
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

    /// The material with these constants whose volumetric part has the power form `lambda/4 (J^2 - 1 - 2 ln J)`.
    ///
    /// ```
    /// # use conserva_materials::materials::NeoHookean;
    /// let foam = NeoHookean { youngs_modulus: 1.0, poisson_ratio: 0.2, density: 0.1 }.material_of_power_form()?;
    /// assert_eq!(foam.volumetric_form().map(|form| form.name), Some("power"));
    /// # Ok::<(), conserva_materials::materials::MaterialError>(())
    /// ```
    ///
    /// # Errors
    /// A constant outside its range.
    pub fn material_of_power_form(self) -> Result<Material, MaterialError> {
        Material::new(&POWER_ROW, &[self.youngs_modulus, self.poisson_ratio, self.density])
    }
}

/// The law with Lame's constants `[stress]`.
#[derive(Clone, Copy, Debug)]
struct Lame {
    lambda: f64,
    mu: f64,
}

impl Lame {
    /// Stress for given `det C` (its inverse), `ln J` and `cof C`; of the power form with `(J^2 - 1)/2` in place of `ln J`:
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
        (excess(x) * 0.5 - strain.second_invariant() * 2.0 - strain.determinant() * 4.0) * self.mu + log * log * (self.lambda / 8.0)
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

    /// With `det(C_m + s dC) = d + s p + s^2 r + s^3 t` (`s` from -1/2 to 1/2), `A = d + r/4`, `B = p/2 + t/8`, `z = B/A`: `ln J_1 - ln J_0
    /// = atanh z`, slope of `ln J` over the step `delta = p/(2 d)`, and `(ln J_0 + ln J_1)/2 - ln J_m = ln(1 + u)/4` with `u = (A^2 -
    /// B^2)/d^2 - 1`. The part linear in `E` drops out, so that all terms are of second and third order. `ln J_1` and `det C_1 = A + B`
    /// follow on the way.
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

/// The law with the power form of its volumetric part: `S = mu (I - C^-1) + lambda/2 (J^2 - 1) C^-1`.
#[derive(Clone, Copy, Debug)]
struct PowerForm(Lame);

impl PowerForm {
    /// With `x = det C - 1`: `lambda J^2 C^-1 (x) C^-1 + (2 mu - lambda x) I_(C^-1)`.
    #[inline(always)]
    fn tangent_of<T: Tensor>(&self, inverse_det: T::Scalar, x: T::Scalar, cofactor: &T) -> T::Tangent {
        let Lame { lambda, mu } = self.0;
        T::isotropic_tangent((x + 1.0) * lambda, x * -lambda + 2.0 * mu, &(*cofactor * inverse_det))
    }
}

impl Law for PowerForm {
    #[inline(always)]
    fn energy<T: Tensor>(&self, strain: &T) -> T::Scalar {
        let Lame { lambda, mu } = self.0;
        excess(growth(strain)) * (0.5 * mu + 0.25 * lambda) - (strain.second_invariant() * 2.0 + strain.determinant() * 4.0) * mu
    }

    #[inline(always)]
    fn stress<T: Tensor>(&self, strain: &T) -> T {
        let x = growth(strain);
        self.0.stress_of(strain, T::Scalar::splat(1.0) / (x + 1.0), x * 0.5, &cofactor_of_c(strain))
    }

    #[inline(always)]
    fn stress_tangent<T: Tensor>(&self, strain: &T) -> (T, T::Tangent) {
        let (x, cofactor) = (growth(strain), cofactor_of_c(strain));
        let inverse_det = T::Scalar::splat(1.0) / (x + 1.0);
        (self.0.stress_of(strain, inverse_det, x * 0.5, &cofactor), self.tangent_of(inverse_det, x, &cofactor))
    }

    #[inline(always)]
    fn remainder<T: Tensor>(&self, strain_n: &T, strain_n1: &T) -> T::Scalar {
        self.increment(strain_n, strain_n1).remainder
    }

    /// Increment response as the sum of that of `-(mu + lambda/2) ln J`, as in the logarithmic form, and that of the polynomial `lambda/4
    /// det C`, whose remainder is `lambda/4 t/4` with `t = 8 det dE`. Terms linear in `E` have no remainder.
    #[inline(always)]
    fn increment<T: Tensor>(&self, strain_n: &T, strain_n1: &T) -> Increment<T> {
        let Lame { lambda, mu } = self.0;
        let (mid, d) = ((*strain_n + *strain_n1) * 0.5, *strain_n1 - *strain_n);
        let (x, cofactor, x_end) = (growth(&mid), cofactor_of_c(&mid), growth(strain_n1));
        let inverse = T::Scalar::splat(1.0) / (x + 1.0);
        let delta = cofactor.dot(&d) * inverse;
        let mut rho = d.second_invariant() * inverse;
        let (mut b, mut defect) = (delta, delta * rho);
        if !T::PLANE {
            rho = (d.second_invariant() + mid.dot(&d.cofactor()) * 2.0) * inverse;
            let eighth = d.determinant() * inverse;
            (b, defect) = (delta + eighth, delta * rho - eighth);
        }
        let inverse_a = T::Scalar::splat(1.0) / (rho + 1.0);
        let third = (b * inverse_a).atanh_excess() - defect * inverse_a; // ln J_1 - ln J_0 - delta
        Increment {
            stress: self.0.stress_of(&mid, inverse, x * 0.5, &cofactor),
            tangent: self.tangent_of(inverse, x, &cofactor),
            stress_end: self.0.stress_of(strain_n1, T::Scalar::splat(1.0) / (x_end + 1.0), x_end * 0.5, &cofactor_of_c(strain_n1)),
            remainder: d.determinant() * (0.5 * lambda) - third * (mu + 0.5 * lambda),
        }
    }
}
