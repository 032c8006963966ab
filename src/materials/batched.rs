//! Law evaluated for eight elements at a time, by one virtual call per batch of points, compiled for the processor's instruction set.

use super::law::{Increment, Law};
use crate::math::lanes::{Lanes, relabel, relabel_rows};
use crate::math::simd::{Kernel, dispatch};
use crate::math::tensor::Mandel;

/// A law evaluated by one virtual call per batch of strains: `S` Mandel components of eight elements each.
pub trait BatchedLaw<const S: usize>: Send + Sync {
    /// Energies of all strains.
    fn energies_into(&self, strain: &[Components<S>], energy: &mut [Lanes<false>]);
    /// Stresses of all strains.
    fn stresses_into(&self, strain: &[Components<S>], stress: &mut [Components<S>]);
    /// Stresses and tangents of all strains.
    fn responses_into(&self, strain: &[Components<S>], responses: &mut [Response<S>]);
    /// Increment responses for a discrete gradient, one per pair of strains at the start and the end of a step.
    fn increments_into(&self, strain_n: &[Components<S>], strain_n1: &[Components<S>], increments: &mut [IncrementResponse<S>]);
    /// True if the stiffness of the law may jump, so that no quadrature over a step is exact.
    fn has_kinks(&self) -> bool {
        false
    }
}

/// Stress and tangent `[stress]` in eight elements.
#[derive(Clone, Copy, Debug)]
pub struct Response<const S: usize> {
    /// Second Piola-Kirchhoff stress.
    pub stress: Components<S>,
    /// Derivative of the stress with respect to the strain.
    pub tangent: [Components<S>; S],
}

impl<const S: usize> Response<S> {
    /// Zero stress and tangent.
    pub const ZERO: Self = Response { stress: [Lanes::ZERO; S], tangent: [[Lanes::ZERO; S]; S] };
}

/// Response of a law to a strain increment in eight elements, for a discrete gradient.
#[derive(Clone, Copy, Debug)]
pub struct IncrementResponse<const S: usize> {
    /// Response at the mean of the two strains.
    pub mean: Response<S>,
    /// Stress at the end of the strain increment.
    pub stress_end: Components<S>,
    /// Remainder of the discrete gradient, see [`super::Law::remainder`].
    pub remainder: Lanes<false>,
}

impl<const S: usize> IncrementResponse<S> {
    /// Zero stresses and remainder.
    pub const ZERO: Self = IncrementResponse { mean: Response::ZERO, stress_end: [Lanes::ZERO; S], remainder: Lanes::ZERO };
}

/// Mandel components of a strain or stress in eight elements.
pub type Components<const S: usize> = [Lanes<false>; S];

#[inline(always)]
fn load<const FMA: bool, const S: usize>(strain: &Components<S>) -> Mandel<Lanes<FMA>, S> {
    Mandel(relabel(strain))
}

struct Energies<'a, L, const S: usize>(&'a L, &'a [Components<S>], &'a mut [Lanes<false>]);
struct Stresses<'a, L, const S: usize>(&'a L, &'a [Components<S>], &'a mut [Components<S>]);
struct Responses<'a, L, const S: usize>(&'a L, &'a [Components<S>], &'a mut [Response<S>]);
struct Increments<'a, L, const S: usize>(&'a L, &'a [Components<S>], &'a [Components<S>], &'a mut [IncrementResponse<S>]);

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

        impl<L: Law> BatchedLaw<$size> for L {
            fn energies_into(&self, strain: &[Components<$size>], energy: &mut [Lanes<false>]) {
                dispatch(Energies(self, strain, energy));
            }
            fn stresses_into(&self, strain: &[Components<$size>], stress: &mut [Components<$size>]) {
                dispatch(Stresses(self, strain, stress));
            }
            fn responses_into(&self, strain: &[Components<$size>], responses: &mut [Response<$size>]) {
                dispatch(Responses(self, strain, responses));
            }
            fn increments_into(
                &self,
                strain_n: &[Components<$size>],
                strain_n1: &[Components<$size>],
                increments: &mut [IncrementResponse<$size>],
            ) {
                dispatch(Increments(self, strain_n, strain_n1, increments));
            }
        }
    };
}

batch!(3);
batch!(4);
batch!(6);
