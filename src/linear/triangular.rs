//! Substitution with the factors of one front.

use pulp::Simd;

use super::tiles::{WIDTH, four};

/// `w := L^-1 w` for the pivot block, then `below -= L_21 w`.
#[inline(always)]
pub(super) fn substitute_lower<S: Simd>(simd: S, diagonal: &[f64], lower: &[f64], w: &mut [f64], below: &mut [f64]) {
    let (p, u) = (w.len(), below.len());
    for j in (0..p).step_by(WIDTH) {
        for c in 0..WIDTH {
            for r in c + 1..WIDTH {
                w[j + r] -= diagonal[(j + c) * p + j + r] * w[j + c];
            }
        }
        let factors = *four(&w[j..]);
        combine(simd, &diagonal[j * p..], p, j + WIDTH, factors, &mut w[j + WIDTH..]);
        if u > 0 {
            combine(simd, &lower[j * u..], u, 0, factors, below);
        }
    }
}

/// `target -= sum of four columns times factors`, rows from `first` on.
#[inline(always)]
fn combine<S: Simd>(simd: S, columns: &[f64], stride: usize, first: usize, factors: [f64; WIDTH], target: &mut [f64]) {
    let length = target.len();
    let column = |k: usize| S::as_simd_f64s(&columns[k * stride + first..][..length]).0;
    let (a, b, c, d) = (column(0), column(1), column(2), column(3));
    let factor = |k: usize| simd.splat_f64s(-factors[k]);
    let factors = [factor(0), factor(1), factor(2), factor(3)];
    for ((((x, a), b), c), d) in S::as_mut_simd_f64s(target).0.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        let mut sum = simd.mul_add_e_f64s(factors[0], *a, *x);
        sum = simd.mul_add_e_f64s(factors[1], *b, sum);
        sum = simd.mul_add_e_f64s(factors[2], *c, sum);
        *x = simd.mul_add_e_f64s(factors[3], *d, sum);
    }
}

/// `w := U^-1 (w - U_12 right)` for the pivot block.
#[inline(always)]
pub(super) fn substitute_upper<S: Simd>(simd: S, diagonal: &[f64], upper: &[f64], w: &mut [f64], right: &[f64]) {
    let (p, u) = (w.len(), right.len());
    if u > 0 {
        let right = S::as_simd_f64s(right).0;
        for (w, columns) in w.chunks_exact_mut(WIDTH).zip(upper.chunks_exact(WIDTH * u)) {
            let column = |k: usize| S::as_simd_f64s(&columns[k * u..][..u]).0;
            let (a, b, c, d) = (column(0), column(1), column(2), column(3));
            let mut sums = [simd.splat_f64s(0.0); WIDTH];
            for ((((x, a), b), c), d) in right.iter().zip(a).zip(b).zip(c).zip(d) {
                sums[0] = simd.mul_add_e_f64s(*a, *x, sums[0]);
                sums[1] = simd.mul_add_e_f64s(*b, *x, sums[1]);
                sums[2] = simd.mul_add_e_f64s(*c, *x, sums[2]);
                sums[3] = simd.mul_add_e_f64s(*d, *x, sums[3]);
            }
            for (w, sum) in w.iter_mut().zip(sums) {
                *w -= simd.reduce_sum_f64s(sum);
            }
        }
    }
    for j in (0..p).step_by(WIDTH).rev() {
        for c in (0..WIDTH).rev() {
            w[j + c] *= diagonal[(j + c) * p + j + c];
            for r in 0..c {
                w[j + r] -= diagonal[(j + c) * p + j + r] * w[j + c];
            }
        }
        let factors = *four(&w[j..]);
        combine(simd, &diagonal[j * p..], p, 0, factors, &mut w[..j]);
    }
}
