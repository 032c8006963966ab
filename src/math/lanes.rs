//! Eight numbers that are computed together, one lane per element, and the transcendental functions that stored energies need.
//!
//! Arrays without intrinsics, vectorized by the compiler for a given instruction set. `FMA` is true if `mul_add` is one instruction there
//! (otherwise it is a slow library call). `ln(1 + x)` and `atanh(z) - z` use the series `atanh z - z = z^3 (1/3 + z^2/5 + z^4/7 + ...)`,
//! `exp(x) - 1` its Taylor series.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Number of lanes of [`Lanes`].
pub const WIDTH: usize = 8;

/// Scalar type of formulas: one number, or a group of numbers with arithmetic lane by lane.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
    + Add<f64, Output = Self>
{
    /// Returns lanes that all hold `x`.
    fn splat(x: f64) -> Self;
    /// `self * b + c`.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// Returns `value` in the lanes where `self > threshold`, 0 in the others.
    fn if_above(self, threshold: f64, value: Self) -> Self;
    /// `atanh(z) - z` with relative accuracy, `|z| < 1`.
    fn atanh_excess(self) -> Self;
    /// `ln(1 + x)` with relative accuracy, `x > -1`; meaningless (but not a panic) outside.
    fn ln_1p(self) -> Self;
}

/// Coefficients of `(atanh z - z) / z^3` in powers of `z^2`; relative truncation error 5e-18 at [`SERIES_LIMIT`].
const EXCESS: [f64; 11] = [1. / 3., 1. / 5., 1. / 7., 1. / 9., 1. / 11., 1. / 13., 1. / 15., 1. / 17., 1. / 19., 1. / 21., 1. / 23.];
/// Coefficients of `(exp(r) - 1 - r) / r^2` in powers of `r`; truncation error 2e-17 relative to `r` at `|r| = ln 2 / 2`.
const EXPONENTIAL: [f64; 12] = [
    1. / 2.,
    1. / 6.,
    1. / 24.,
    1. / 120.,
    1. / 720.,
    1. / 5040.,
    1. / 40320.,
    1. / 362880.,
    1. / 3628800.,
    1. / 39916800.,
    1. / 479001600.,
    1. / 6227020800.,
];
/// Largest `|z|` for the series; `ln_1p` needs at most `(sqrt 2 - 1)/(sqrt 2 + 1) = 0.172`.
const SERIES_LIMIT: f64 = 0.18;

/// Eight numbers, aligned for vector registers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<const FMA: bool>(pub [f64; WIDTH]);

impl<const FMA: bool> Lanes<FMA> {
    /// Zero in every lane.
    pub const ZERO: Self = Lanes([0.0; WIDTH]);

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut result = [0.0; WIDTH];
        for i in 0..WIDTH {
            result[i] = f(self.0[i], other.0[i]);
        }
        Lanes(result)
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut result = [0.0; WIDTH];
        for i in 0..WIDTH {
            result[i] = f(self.0[i]);
        }
        Lanes(result)
    }

    /// The series of `atanh z - z`, for `|z|` up to [`SERIES_LIMIT`].
    #[inline(always)]
    fn excess_series(self) -> Self {
        let square = self * self;
        let mut sum = Self::splat(EXCESS[10]);
        for k in (0..10).rev() {
            sum = sum.mul_add(square, Self::splat(EXCESS[k]));
        }
        sum * (self * square)
    }

    /// `exp(x) - 1` with relative accuracy; infinite above 709, NaN for `x = NaN`.
    #[inline(always)]
    pub fn exp_m1(self) -> Self {
        // x = k ln 2 + r, |r| <= ln 2 / 2: exp(x) - 1 = 2^k (exp(r) - 1) + (2^k - 1). Adding 1.5 * 2^52 rounds to an integer, which the
        // last bits of the sum then contain. ln 2 in two parts, the first with so few digits that k times it is exact.
        const ROUND: f64 = 6_755_399_441_055_744.0;
        const LN_2_HIGH: f64 = f64::from_bits(0x3fe6_2e42_fee0_0000);
        const LN_2_LOW: f64 = f64::from_bits(0x3dea_39ef_3579_3c76);
        let x = self.map(|x| x.clamp(-745.0, 709.0));
        let rounded = x.mul_add(Self::splat(std::f64::consts::LOG2_E), Self::splat(ROUND));
        let k = rounded + -ROUND;
        let r = k.mul_add(Self::splat(-LN_2_LOW), k.mul_add(Self::splat(-LN_2_HIGH), x));
        let mut sum = Self::splat(EXPONENTIAL[11]);
        for coefficient in (0..11).rev() {
            sum = sum.mul_add(r, Self::splat(EXPONENTIAL[coefficient]));
        }
        let small = (sum * r).mul_add(r, r);
        let mut power = [0.0; WIDTH];
        for i in 0..WIDTH {
            let biased = rounded.0[i].to_bits().wrapping_sub(ROUND.to_bits()).wrapping_add(1023);
            // Below 2^-1022 the power is negligible beside the -1.
            power[i] = if k.0[i] < -1022.0 { 0.0 } else { f64::from_bits(biased << 52) };
        }
        let power = Lanes(power);
        let result = power.mul_add(small, power + -1.0);
        self.zip(result, |x, y| if x > 709.0 { f64::INFINITY } else { y })
    }

    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    /// The greater of two, lane by lane; NaN where `self` is NaN.
    #[inline(always)]
    pub fn greater(self, other: Self) -> Self {
        self.zip(other, |a, b| if b > a { b } else { a })
    }

    /// Returns `value` in nonzero lanes of `self`, `otherwise` in zero lanes.
    #[inline(always)]
    pub fn unless_zero(self, value: Self, otherwise: Self) -> Self {
        let mut result = [0.0; WIDTH];
        for i in 0..WIDTH {
            result[i] = if self.0[i] == 0.0 { otherwise.0[i] } else { value.0[i] };
        }
        Lanes(result)
    }

    /// `value` with the sign of `self`.
    #[inline(always)]
    pub fn sign_to(self, value: Self) -> Self {
        self.zip(value, |sign, value| value.copysign(sign))
    }

    #[cold]
    #[inline(never)]
    fn atanh_excess_far(self) -> Self {
        self.map(f64::atanh_excess)
    }
}

/// Converts lanes to those for code with another `FMA`, values unchanged. A loop, because `array::map` is not inlined into functions that
/// enable instructions.
#[inline(always)]
pub fn relabel<const A: bool, const B: bool, const N: usize>(lanes: &[Lanes<A>; N]) -> [Lanes<B>; N] {
    let mut result = [Lanes::ZERO; N];
    for k in 0..N {
        result[k] = Lanes(lanes[k].0);
    }
    result
}

/// [`relabel`] for a matrix.
#[inline(always)]
pub fn relabel_rows<const A: bool, const B: bool, const N: usize, const M: usize>(rows: &[[Lanes<A>; N]; M]) -> [[Lanes<B>; N]; M] {
    let mut result = [[Lanes::ZERO; N]; M];
    for k in 0..M {
        result[k] = relabel(&rows[k]);
    }
    result
}

impl<const FMA: bool> Add for Lanes<FMA> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<const FMA: bool> Sub for Lanes<FMA> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<const FMA: bool> Mul for Lanes<FMA> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl<const FMA: bool> Div for Lanes<FMA> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl<const FMA: bool> Neg for Lanes<FMA> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl<const FMA: bool> Mul<f64> for Lanes<FMA> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.map(|a| a * factor)
    }
}

impl<const FMA: bool> Add<f64> for Lanes<FMA> {
    type Output = Self;
    #[inline(always)]
    fn add(self, term: f64) -> Self {
        self.map(|a| a + term)
    }
}

impl<const FMA: bool> Real for Lanes<FMA> {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Lanes([x; WIDTH])
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        let mut result = [0.0; WIDTH];
        for i in 0..WIDTH {
            result[i] = if FMA { self.0[i].mul_add(b.0[i], c.0[i]) } else { self.0[i] * b.0[i] + c.0[i] };
        }
        Lanes(result)
    }

    #[inline(always)]
    fn if_above(self, threshold: f64, value: Self) -> Self {
        self.zip(value, |s, v| if s > threshold { v } else { 0.0 })
    }

    #[inline(always)]
    fn atanh_excess(self) -> Self {
        let mut far = false;
        for z in self.0 {
            far |= z.abs() > SERIES_LIMIT;
        }
        if far { self.atanh_excess_far() } else { self.excess_series() }
    }

    #[inline(always)]
    fn ln_1p(self) -> Self {
        // 1 + x = 2^k m with m in [sqrt(1/2), sqrt 2): ln(1 + x) = k ln 2 + 2 atanh((m - 1)/(m + 1)).
        const HALF_ROOT_BITS: u64 = 0x3fe6_a09e_667f_3bcd;
        const EXPONENT_ONE: u64 = 0x4330_0000_0000_0000;
        let (mut k, mut scale) = ([0.0; WIDTH], [0.0; WIDTH]);
        for i in 0..WIDTH {
            let biased = (1.0 + self.0[i]).to_bits().wrapping_sub(HALF_ROOT_BITS).wrapping_add(1023 << 52) >> 52;
            k[i] = f64::from_bits(EXPONENT_ONE | biased) - (4_503_599_627_370_496.0 + 1023.0);
            scale[i] = f64::from_bits(2046u64.wrapping_sub(biased) << 52);
        }
        let (k, scale) = (Lanes::<FMA>(k), Lanes::<FMA>(scale));
        let f = self.mul_add(scale, scale + -1.0); // m - 1, exactly x where k = 0
        let y = f / (f + 2.0);
        let half = y + y.excess_series();
        k * std::f64::consts::LN_2 + (half + half)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn splat(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn mul_add(self, b: f64, c: f64) -> f64 {
        self * b + c
    }

    #[inline(always)]
    fn if_above(self, threshold: f64, value: f64) -> f64 {
        if self > threshold { value } else { 0.0 }
    }

    fn atanh_excess(self) -> f64 {
        if self.abs() > SERIES_LIMIT {
            0.5 * (2.0 * self / (1.0 - self)).ln_1p() - self
        } else {
            Lanes::<false>([self; WIDTH]).excess_series().0[0]
        }
    }

    #[inline(always)]
    fn ln_1p(self) -> f64 {
        f64::ln_1p(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ln_1p_agrees_with_the_library_over_all_scales() {
        for i in -60..60 {
            for sign in [-1.0, 1.0] {
                let x = sign * 0.9 * 1.5f64.powi(i);
                if x <= -1.0 {
                    continue;
                }
                let ours = Lanes::<false>([x; WIDTH]).ln_1p().0[3];
                assert!((ours - x.ln_1p()).abs() <= 4e-16 * x.ln_1p().abs(), "x = {x}: {ours} against {}", x.ln_1p());
            }
        }
    }

    #[test]
    fn exp_m1_agrees_with_the_library_over_all_scales() {
        for i in -90..60 {
            for sign in [-1.0, 1.0] {
                let x = sign * 0.9 * 1.3f64.powi(i);
                let (plain, fused) = (Lanes::<false>([x; WIDTH]).exp_m1().0[3], Lanes::<true>([x; WIDTH]).exp_m1().0[3]);
                if x > 709.0 {
                    assert_eq!((plain, fused), (f64::INFINITY, f64::INFINITY));
                    continue;
                }
                let expected = x.exp_m1();
                assert!((plain - expected).abs() <= 5e-16 * expected.abs(), "x = {x}: {plain} against {expected}");
                assert!((fused - expected).abs() <= 5e-16 * expected.abs(), "x = {x}: {fused} against {expected}");
            }
        }
        assert!(Lanes::<false>([f64::NAN; WIDTH]).exp_m1().0[0].is_nan());
        assert_eq!(Lanes::<false>([f64::NEG_INFINITY; WIDTH]).exp_m1().0[0], -1.0);
    }

    #[test]
    fn choices_are_made_lane_by_lane() {
        let x = Lanes::<false>([-2.0, 0.0, 3.0, -0.0, 1.0, 1.0, 1.0, 1.0]);
        let (one, two) = (Lanes::splat(1.0), Lanes::splat(2.0));
        assert_eq!(x.unless_zero(one, two).0[..4], [1.0, 2.0, 1.0, 2.0]);
        assert_eq!(x.sign_to(two).0[..3], [-2.0, 2.0, 2.0]);
        assert_eq!(x.greater(one).0[..4], [1.0, 1.0, 3.0, 1.0]);
        assert_eq!(two.sqrt().0[0], 2f64.sqrt());
    }

    #[test]
    fn excess_has_relative_accuracy_on_both_sides_of_the_series_limit() {
        // Expected value: leading term for tiny z; otherwise the definition, where it does not cancel.
        let tiny = 1e-5f64;
        assert!((tiny.atanh_excess() / (tiny.powi(3) / 3.0) - 1.0).abs() < 1e-9);
        for z in [0.1799f64, 0.1801, 0.5, -0.9] {
            let plain = z.atanh() - z;
            assert!((z.atanh_excess() - plain).abs() < 5e-14 * plain.abs(), "z = {z}");
            assert_eq!(Lanes::<false>([z; WIDTH]).atanh_excess().0[0], z.atanh_excess());
        }
    }
}
