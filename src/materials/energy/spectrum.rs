//! Functions of the principal stretches: `sum f(e_i)` over the principal strains, with their derivatives.
//!
//! Stretches and strains are tied by `l^2 = 1 + 2 e`. The derivative of `sum f(e_i)` is `sum f'(e_i) n_i n_i`, the second one
//! `sum f''(e_i) P_i P_i + sum over i < j of 2 f'[e_i, e_j] Q_ij Q_ij` with `P_i = n_i n_i`, `Q_ij = sym n_i n_j` and divided differences
//! `f'[a, b] = (f'(a) - f'(b))/(a - b)`, which have forms that hold at equal strains, too (Ogden, Non-Linear Elastic Deformations, 1984,
//! section 6.1). Principal strains and directions: `math/principal.rs`.

use crate::math::lanes::{Lanes, Real, relabel, relabel_rows};
use crate::math::principal::{PrincipalAxes, principal};
use crate::math::tensor::{Mandel, mandel_pairs, mandel_scale};

/// A function of a principal strain.
#[derive(Clone, Copy, Debug)]
pub(super) enum Principal {
    /// Power of the principal stretch, `l^a - 1`.
    Power(f64),
    /// Squared logarithmic strain, `(ln l)^2`.
    LogSquared,
}

impl Principal {
    /// Slope of the function at zero strain.
    pub(super) fn slope_at_rest(self) -> f64 {
        match self {
            Principal::Power(a) => a,
            Principal::LogSquared => 0.0,
        }
    }
}

/// Principal strains and shared data of their functions.
#[derive(Clone, Copy)]
pub(super) struct Spectrum<const FMA: bool> {
    strains: [Lanes<FMA>; 3],
    directions: [[Lanes<FMA>; 3]; 3],
    /// Logarithms `ln(1 + 2 e)` of the squared stretches, `e` the principal strains.
    logs: [Lanes<FMA>; 3],
    /// Inverse squared stretches `1/(1 + 2 e)`.
    inverses: [Lanes<FMA>; 3],
}

impl<const FMA: bool> Spectrum<FMA> {
    pub(super) const ZERO: Self =
        Spectrum { strains: [Lanes::ZERO; 3], directions: [[Lanes::ZERO; 3]; 3], logs: [Lanes::ZERO; 3], inverses: [Lanes::ZERO; 3] };

    #[inline(always)]
    pub(super) fn new<const S: usize>(strain: &Mandel<Lanes<FMA>, S>) -> Self {
        let (zero, one) = (Lanes::ZERO, Lanes::splat(1.0));
        let PrincipalAxes { values: strains, directions } = principal(&strain.0);
        let (mut logs, mut inverses) = ([zero; 3], [one; 3]);
        for i in 0..3 {
            if S != 3 || i < 2 {
                logs[i] = (strains[i] * 2.0).ln_1p();
                inverses[i] = one / (strains[i] * 2.0 + 1.0);
            }
        }
        Spectrum { strains, directions, logs, inverses }
    }

    /// Converts the spectrum to one for code with another `FMA`, values unchanged.
    #[inline(always)]
    pub(super) fn relabel<const OTHER: bool>(&self) -> Spectrum<OTHER> {
        Spectrum {
            strains: relabel(&self.strains),
            directions: relabel_rows(&self.directions),
            logs: relabel(&self.logs),
            inverses: relabel(&self.inverses),
        }
    }

    /// Sum of a function over the principal strains, `sum f(e_i)`.
    #[inline(always)]
    pub(super) fn sum(&self, function: Principal) -> Lanes<FMA> {
        let mut sum = Lanes::ZERO;
        for log in self.logs {
            sum = sum
                + match function {
                    Principal::Power(a) => (log * (0.5 * a)).exp_m1(),
                    Principal::LogSquared => log * log * 0.25,
                };
        }
        sum
    }

    /// Change of the derivative from that at zero strain, `sum (f'(e_i) - f'(0)) n_i n_i`.
    #[inline(always)]
    pub(super) fn slope_variation<const S: usize>(&self, function: Principal) -> Mandel<Lanes<FMA>, S> {
        let mut sum = Mandel([Lanes::ZERO; S]);
        for i in 0..3 {
            let (log, inverse) = (self.logs[i], self.inverses[i]);
            let slope = match function {
                Principal::Power(a) => ((log * (0.5 * a)).exp_m1() - self.strains[i] * 2.0) * inverse * a,
                Principal::LogSquared => log * inverse,
            };
            let dyad = self.dyad::<S>(i, i);
            for k in 0..S {
                sum.0[k] = dyad[k].mul_add(slope, sum.0[k]);
            }
        }
        sum
    }

    /// Adds `weight` times the second derivative.
    #[inline(always)]
    pub(super) fn add_curvature<const S: usize>(&self, function: Principal, weight: Lanes<FMA>, tangent: &mut [[Lanes<FMA>; S]; S]) {
        for i in 0..3 {
            let (log, inverse) = (self.logs[i], self.inverses[i]);
            let curvature = match function {
                Principal::Power(a) => ((log * (0.5 * a)).exp_m1() + 1.0) * inverse * inverse * (a * (a - 2.0)),
                Principal::LogSquared => (-log + 1.0) * inverse * inverse * 2.0,
            };
            add_square(&self.dyad::<S>(i, i), weight * curvature, tangent);
            for j in i + 1..3 {
                // In the plane the third direction is not sheared.
                if S == 6 || j < 2 {
                    add_square(&self.dyad::<S>(i, j), weight * self.divided_difference(function, i, j) * 2.0, tangent);
                }
            }
        }
    }

    /// `(f'(e_i) - f'(e_j))/(e_i - e_j)`, by `d = (1 + 2 e_i)/(1 + 2 e_j) - 1`.
    #[inline(always)]
    fn divided_difference(&self, function: Principal, i: usize, j: usize) -> Lanes<FMA> {
        let inverse = self.inverses[j];
        let d = (self.strains[i] - self.strains[j]) * inverse * 2.0;
        let log = d.ln_1p();
        match function {
            Principal::Power(a) => {
                let p = 0.5 * a - 1.0;
                let quotient = d.unless_zero((log * p).exp_m1() / d, Lanes::splat(p));
                ((self.logs[j] * (0.5 * a)).exp_m1() + 1.0) * inverse * inverse * quotient * (2.0 * a)
            }
            Principal::LogSquared => {
                let quotient = d.unless_zero(log / d, Lanes::splat(1.0));
                (quotient - self.logs[j]) * self.inverses[i] * inverse * 2.0
            }
        }
    }

    /// Mandel components of `sym n_i n_j`.
    #[inline(always)]
    fn dyad<const S: usize>(&self, i: usize, j: usize) -> [Lanes<FMA>; S] {
        let (a, b) = (&self.directions[i], &self.directions[j]);
        let mut dyad = [Lanes::ZERO; S];
        for (k, &(p, q)) in mandel_pairs::<S>().iter().enumerate() {
            dyad[k] = a[p].mul_add(b[q], a[q] * b[p]) * (0.5 / mandel_scale(p, q));
        }
        dyad
    }
}

#[inline(always)]
fn add_square<const FMA: bool, const S: usize>(dyad: &[Lanes<FMA>; S], weight: Lanes<FMA>, tangent: &mut [[Lanes<FMA>; S]; S]) {
    for k in 0..S {
        let scaled = dyad[k] * weight;
        for l in 0..S {
            tangent[k][l] = scaled.mul_add(dyad[l], tangent[k][l]);
        }
    }
}
