//! Floor 1: stored-energy laws on the Green-Lagrange strain; formulas only, one file each.
//!
//! A law is written once on [`Tensor`], for plane strain and for space. [`Batch`] wraps it behind a virtual call per batch of points (never
//! per point), compiled for the instructions of the processor. A new law is one file and one row of [`CATALOGUE`].

mod neo_hookean;
mod saint_venant_kirchhoff;

use std::sync::Arc;

use crate::math::catalogue::{Interval, Parameter};
use crate::math::lanes::{Lanes, Real, relabel, relabel_rows};
use crate::math::simd::{Kernel, dispatch};
use crate::math::tensor::{Mandel, Tensor};
use crate::math::tolerances::STRAIN_QUOTIENT;

/// A stored-energy function `W(E)` of the Green-Lagrange strain, per reference volume `[energy/volume]`.
pub trait Law: Send + Sync + 'static {
    /// `W(E)`, with relative accuracy at small strain.
    fn energy<T: Tensor>(&self, strain: &T) -> T::Scalar;
    /// Second Piola-Kirchhoff stress `S = dW/dE` `[stress]`.
    fn stress<T: Tensor>(&self, strain: &T) -> T;
    /// Stress and tangent `d2W/dE2` `[stress]`.
    fn stress_tangent<T: Tensor>(&self, strain: &T) -> (T, T::Tangent);
    /// `W(E1) - W(E0) - S((E0 + E1)/2):(E1 - E0)`, without cancellation.
    ///
    /// The default is a five-point Lobatto rule for the line integral of `S - S_mid` below `|dE| = 5e-3` and the plain difference above.
    /// One decision for all lanes of a batch, by its largest increment.
    #[inline(always)]
    fn remainder<T: Tensor>(&self, strain_n: &T, strain_n1: &T) -> T::Scalar {
        let (mid, d) = ((*strain_n + *strain_n1) * 0.5, *strain_n1 - *strain_n);
        let stress_mid = self.stress(&mid);
        let difference = self.energy(strain_n1) - self.energy(strain_n) - stress_mid.dot(&d);
        let slope = |s: f64| (self.stress(&(mid + d * s)) - stress_mid).dot(&d);
        let s = 0.5 * (3.0f64 / 7.0).sqrt();
        let line = (slope(-0.5) + slope(0.5)) * 0.05 + (slope(-s) + slope(s)) * (49.0 / 180.0);
        let square = d.dot(&d);
        let limit = STRAIN_QUOTIENT * STRAIN_QUOTIENT;
        line + square.if_above(limit, difference - line)
    }
    /// What a discrete gradient needs of an increment; a law for which some of it follows from the rest says so here.
    #[inline(always)]
    fn increment<T: Tensor>(&self, strain_n: &T, strain_n1: &T) -> Increment<T> {
        let (stress, tangent) = self.stress_tangent(&((*strain_n + *strain_n1) * 0.5));
        Increment { stress, tangent, stress_end: self.stress(strain_n1), remainder: self.remainder(strain_n, strain_n1) }
    }
}

/// What a discrete gradient needs of an increment of the strain.
#[derive(Clone, Copy, Debug)]
pub struct Increment<T: Tensor> {
    /// Stress at the mean of the two strains `[stress]`.
    pub stress: T,
    /// Tangent there `[stress]`.
    pub tangent: T::Tangent,
    /// Stress at the end `[stress]`.
    pub stress_end: T,
    /// [`Law::remainder`].
    pub remainder: T::Scalar,
}

/// A law behind a virtual call per batch of strains: `S` Mandel components of eight elements each.
pub trait Batch<const S: usize>: Send + Sync {
    /// Energies of all strains.
    fn energies_into(&self, strain: &[Strain<S>], energy: &mut [Lanes<false>]);
    /// Stresses of all strains.
    fn stresses_into(&self, strain: &[Strain<S>], stress: &mut [Strain<S>]);
    /// Stresses and tangents of all strains.
    fn responses_into(&self, strain: &[Strain<S>], responses: &mut [Response<S>]);
    /// What a discrete gradient needs of all pairs of strains.
    fn increments_into(&self, strain_n: &[Strain<S>], strain_n1: &[Strain<S>], increments: &mut [IncrementResponse<S>]);
}

/// Stress and tangent `[stress]` in eight elements.
#[derive(Clone, Copy, Debug)]
pub struct Response<const S: usize> {
    /// Second Piola-Kirchhoff stress.
    pub stress: Strain<S>,
    /// Its derivative with respect to the strain.
    pub tangent: [Strain<S>; S],
}

impl<const S: usize> Response<S> {
    /// No stress.
    pub const ZERO: Self = Response { stress: [Lanes::ZERO; S], tangent: [[Lanes::ZERO; S]; S] };
}

/// What a discrete gradient needs of an increment of the strain in eight elements.
#[derive(Clone, Copy, Debug)]
pub struct IncrementResponse<const S: usize> {
    /// At the mean of the two strains.
    pub mean: Response<S>,
    /// Stress at the end.
    pub stress_end: Strain<S>,
    /// [`Law::remainder`].
    pub remainder: Lanes<false>,
}

impl<const S: usize> IncrementResponse<S> {
    /// No stress.
    pub const ZERO: Self = IncrementResponse { mean: Response::ZERO, stress_end: [Lanes::ZERO; S], remainder: Lanes::ZERO };
}

/// Mandel components of a strain or stress in eight elements.
pub type Strain<const S: usize> = [Lanes<false>; S];

#[inline(always)]
fn load<const FMA: bool, const S: usize>(strain: &Strain<S>) -> Mandel<Lanes<FMA>, S> {
    Mandel(relabel(strain))
}

struct Energies<'a, L, const S: usize>(&'a L, &'a [Strain<S>], &'a mut [Lanes<false>]);
struct Stresses<'a, L, const S: usize>(&'a L, &'a [Strain<S>], &'a mut [Strain<S>]);
struct Responses<'a, L, const S: usize>(&'a L, &'a [Strain<S>], &'a mut [Response<S>]);
struct Increments<'a, L, const S: usize>(&'a L, &'a [Strain<S>], &'a [Strain<S>], &'a mut [IncrementResponse<S>]);

macro_rules! batch {
    ($size:literal) => {
        impl<L: Law> Kernel for Energies<'_, L, $size> {
            type Output = ();
            #[inline(always)]
            fn run<const FMA: bool>(self) {
                for (strain, energy) in self.1.iter().zip(self.2) {
                    *energy = Lanes(self.0.energy(&load::<FMA, $size>(strain)).0);
                }
            }
        }

        impl<L: Law> Kernel for Stresses<'_, L, $size> {
            type Output = ();
            #[inline(always)]
            fn run<const FMA: bool>(self) {
                for (strain, stress) in self.1.iter().zip(self.2) {
                    *stress = relabel(&self.0.stress(&load::<FMA, $size>(strain)).0);
                }
            }
        }

        impl<L: Law> Kernel for Responses<'_, L, $size> {
            type Output = ();
            #[inline(always)]
            fn run<const FMA: bool>(self) {
                for (strain, response) in self.1.iter().zip(self.2) {
                    let (stress, tangent) = self.0.stress_tangent(&load::<FMA, $size>(strain));
                    (response.stress, response.tangent) = (relabel(&stress.0), relabel_rows(&tangent));
                }
            }
        }

        impl<L: Law> Kernel for Increments<'_, L, $size> {
            type Output = ();
            #[inline(always)]
            fn run<const FMA: bool>(self) {
                for ((strain_n, strain_n1), increment) in self.1.iter().zip(self.2).zip(self.3) {
                    let Increment { stress, tangent, stress_end, remainder } =
                        self.0.increment(&load::<FMA, $size>(strain_n), &load::<FMA, $size>(strain_n1));
                    (increment.mean.stress, increment.mean.tangent) = (relabel(&stress.0), relabel_rows(&tangent));
                    (increment.stress_end, increment.remainder) = (relabel(&stress_end.0), Lanes(remainder.0));
                }
            }
        }

        impl<L: Law> Batch<$size> for L {
            fn energies_into(&self, strain: &[Strain<$size>], energy: &mut [Lanes<false>]) {
                dispatch(Energies(self, strain, energy));
            }
            fn stresses_into(&self, strain: &[Strain<$size>], stress: &mut [Strain<$size>]) {
                dispatch(Stresses(self, strain, stress));
            }
            fn responses_into(&self, strain: &[Strain<$size>], responses: &mut [Response<$size>]) {
                dispatch(Responses(self, strain, responses));
            }
            fn increments_into(
                &self,
                strain_n: &[Strain<$size>],
                strain_n1: &[Strain<$size>],
                increments: &mut [IncrementResponse<$size>],
            ) {
                dispatch(Increments(self, strain_n, strain_n1, increments));
            }
        }
    };
}

batch!(3);
batch!(6);

/// A row of the catalogue of materials.
pub struct MaterialRow {
    /// Name as written in a script.
    pub name: &'static str,
    /// One sentence: what it is and where it holds.
    pub summary: &'static str,
    /// The formula and its source, for the reference.
    pub formula: &'static str,
    /// Parameters in the order in which [`Material::new`] takes their values; the density is the last.
    pub parameters: &'static [Parameter],
    /// Makes the law from the values of the parameters.
    construct: fn(&[f64]) -> Laws,
}

impl std::fmt::Debug for MaterialRow {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}", self.name)
    }
}

/// The catalogue of materials.
pub static CATALOGUE: &[MaterialRow] = &[neo_hookean::ROW, saint_venant_kirchhoff::ROW];

const YOUNGS_MODULUS: Parameter = Parameter {
    name: "youngs_modulus",
    summary: "Young's modulus at zero strain",
    dimension: "stress",
    range: Interval::Positive,
    default: None,
};
const POISSON_RATIO: Parameter = Parameter {
    name: "poisson_ratio",
    summary: "Poisson's ratio at zero strain",
    dimension: "1",
    range: Interval::Open(-1.0, 0.5),
    default: None,
};
const DENSITY: Parameter = Parameter {
    name: "density",
    summary: "mass per undeformed volume",
    dimension: "mass/volume",
    range: Interval::Positive,
    default: None,
};

/// Lame's constants `(lambda, mu)` from Young's modulus and Poisson's ratio.
fn lame(youngs_modulus: f64, poisson_ratio: f64) -> (f64, f64) {
    let mu = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
    (2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio), mu)
}

/// One law as the plane and the spatial kernels call it, and the modulus that scales contact and tolerances.
#[derive(Clone)]
struct Laws {
    plane: Arc<dyn Batch<3>>,
    space: Arc<dyn Batch<6>>,
    youngs_modulus: f64,
}

impl Laws {
    fn new<L: Law + Clone>(law: L, youngs_modulus: f64) -> Self {
        Laws { plane: Arc::new(law.clone()), space: Arc::new(law), youngs_modulus }
    }
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
    /// The material of a row with the values of its parameters, in the row's order and inside their ranges (checked by the caller).
    ///
    /// # Panics
    /// When the number of values is not that of the row's parameters.
    pub fn new(row: &'static MaterialRow, values: &[f64]) -> Self {
        assert_eq!(row.parameters.len(), values.len(), "one value for each parameter");
        Material { row, values: values.to_vec(), laws: (row.construct)(values) }
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
    pub fn plane(&self) -> Arc<dyn Batch<3>> {
        self.laws.plane.clone()
    }

    /// The law in space.
    pub fn space(&self) -> Arc<dyn Batch<6>> {
        self.laws.space.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::WIDTH;

    /// Strains of a few sizes in the plane and in space, with increments of a few sizes; reproducible.
    fn pairs<const S: usize>() -> Vec<(Strain<S>, Strain<S>)> {
        let mut seed = 7u64;
        let mut random = move || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut all = Vec::new();
        for size in [1e-6, 1e-3, 0.2] {
            for step in [1e-7, 1e-4, 1e-2, 0.2] {
                let n: [f64; S] = std::array::from_fn(|_| size * random());
                let d: [f64; S] = std::array::from_fn(|_| step * random());
                let at = |s: f64| std::array::from_fn(|k| Lanes([n[k] + s * d[k]; WIDTH]));
                all.push((at(0.0), at(1.0)));
            }
        }
        all
    }

    fn energy<const S: usize>(law: &dyn Batch<S>, strain: &Strain<S>) -> f64 {
        let mut energy = [Lanes::ZERO];
        law.energies_into(&[*strain], &mut energy);
        energy[0].0[5]
    }

    fn stress_tangent<const S: usize>(law: &dyn Batch<S>, strain: &Strain<S>) -> ([f64; S], [[f64; S]; S]) {
        let (mut response, mut only_stress) = ([Response::ZERO], [[Lanes::ZERO; S]]);
        law.responses_into(&[*strain], &mut response);
        law.stresses_into(&[*strain], &mut only_stress);
        assert_eq!(response[0].stress, only_stress[0], "the two calls agree");
        (response[0].stress.map(|c| c.0[2]), response[0].tangent.map(|row| row.map(|c| c.0[2])))
    }

    fn increment<const S: usize>(law: &dyn Batch<S>, strain_n: &Strain<S>, strain_n1: &Strain<S>) -> IncrementResponse<S> {
        let mut increment = [IncrementResponse::ZERO];
        law.increments_into(&[*strain_n], &[*strain_n1], &mut increment);
        increment[0]
    }

    fn shifted<const S: usize>(strain: &Strain<S>, component: usize, by: f64) -> Strain<S> {
        let mut moved = *strain;
        moved[component] = moved[component] + by;
        moved
    }

    fn contract<const S: usize>(name: &str, law: &dyn Batch<S>) {
        let rest = [Lanes::ZERO; S];
        let (stress, tangent) = stress_tangent(law, &rest);
        assert_eq!(energy(law, &rest), 0.0, "{name}: no energy at rest");
        assert_eq!(stress, [0.0; S], "{name}: no stress at rest");
        // Tangent at rest: uniaxial modulus lambda + 2 mu and, because of Mandel components, 2 mu on the shear diagonal.
        let (lambda, mu) = lame(1000.0, 0.3);
        assert!((tangent[0][0] - lambda - 2.0 * mu).abs() < 1e-12 * mu, "{name}: modulus at rest");
        assert!((tangent[S - 1][S - 1] - 2.0 * mu).abs() < 1e-12 * mu, "{name}: shear modulus at rest");
        for (n, n1) in pairs::<S>() {
            let (stress, tangent) = stress_tangent(law, &n1);
            let h = 1e-5;
            for k in 0..S {
                // Central differences: truncation h^2 and round-off eps/h, both near 1e-10 of the modulus.
                let (up, down) = (shifted(&n1, k, h), shifted(&n1, k, -h));
                let difference = (energy(law, &up) - energy(law, &down)) / (2.0 * h);
                assert!((difference - stress[k]).abs() < 1e-5 * mu * 1e-1, "{name}: stress {k} {difference} {}", stress[k]);
                let (above, below) = (stress_tangent(law, &up).0, stress_tangent(law, &down).0);
                for l in 0..S {
                    let difference = (above[l] - below[l]) / (2.0 * h);
                    assert!((difference - tangent[l][k]).abs() < 2e-7 * mu, "{name}: tangent {l}{k} {difference} {}", tangent[l][k]);
                }
            }
            // The remainder against its definition, where that does not cancel, and against its size where it does.
            let mid: Strain<S> = std::array::from_fn(|k| (n[k] + n1[k]) * 0.5);
            let d: [f64; S] = std::array::from_fn(|k| n1[k].0[0] - n[k].0[0]);
            let work: f64 = stress_tangent(law, &mid).0.iter().zip(d).map(|(s, d)| s * d).sum();
            let plain = energy(law, &n1) - energy(law, &n) - work;
            let IncrementResponse { mean, stress_end, remainder } = increment(law, &n, &n1);
            let remainder = remainder.0[0];
            let expected = stress_tangent(law, &mid);
            assert!(mean.tangent.iter().flatten().zip(expected.1.iter().flatten()).all(|(a, b)| (a.0[2] - b).abs() < 1e-14 * mu), "{name}");
            for k in 0..S {
                assert!((mean.stress[k].0[2] - expected.0[k]).abs() < 1e-15 * mu, "{name}: stress {k} at the mean");
                // Round-off of logarithms of order one, times a modulus.
                assert!((stress_end[k].0[2] - stress[k]).abs() < 1e-14 * mu, "{name}: stress {k} at the end");
            }
            let scale = energy(law, &n1).abs() + energy(law, &n).abs() + work.abs();
            assert!((remainder - plain).abs() < 1e-14 * scale, "{name}: remainder {remainder} against {plain}");
        }
    }

    #[test]
    fn every_law_fulfils_the_contract_in_plane_strain_and_in_space() {
        for row in CATALOGUE {
            let values: Vec<f64> = row.parameters.iter().map(|p| if p.name == "poisson_ratio" { 0.3 } else { 1000.0 }).collect();
            let material = Material::new(row, &values);
            contract::<3>(row.name, &*material.plane());
            contract::<6>(row.name, &*material.space());
        }
    }

    #[test]
    fn default_remainder_is_exact_for_a_cubic_energy() {
        struct Sampled(f64);
        impl Law for Sampled {
            fn energy<T: Tensor>(&self, e: &T) -> T::Scalar {
                let t = e.trace();
                t * t * t * self.0
            }
            fn stress<T: Tensor>(&self, e: &T) -> T {
                T::identity() * (e.trace() * e.trace() * (3.0 * self.0))
            }
            fn stress_tangent<T: Tensor>(&self, e: &T) -> (T, T::Tangent) {
                (self.stress(e), T::isotropic_tangent(e.trace() * (6.0 * self.0), T::Scalar::splat(0.0), &T::identity()))
            }
        }
        // W = c (tr E)^3: remainder exactly c (tr dE)^3 / 4 at every step size, below and above the threshold.
        for step in [1e-7, 1e-3, 0.1] {
            let (n, n1) = ([Lanes::splat(0.1); 3], [Lanes::splat(0.1 + step); 3]);
            let remainder = increment::<3>(&Sampled(5.0), &n, &n1).remainder.0[0];
            let exact = 5.0 * (2.0 * step).powi(3) / 4.0;
            // The plain difference (step 0.1) has the round-off of the energies.
            let round_off = if step < STRAIN_QUOTIENT { 15.0 * 0.4f64.powi(2) * step } else { 5.0 * 0.4f64.powi(3) };
            assert!((remainder - exact).abs() < 1e-15 * round_off, "step {step}: {remainder} {exact}");
        }
    }
}
