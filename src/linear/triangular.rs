//! Substitution with the factors of one front, for several vectors at once.
//!
//! The vectors follow one another, each with its `p` pivots and then its `u` other numbers. Four columns of the factors are read once for
//! all vectors, which are taken in pairs: eight factors and four columns then stay in registers. Every vector has its own sums in the order
//! that it would have alone.

use pulp::Simd;

use super::tiles::{WIDTH, four};

/// Entries of one vector at a front: those of its pivots, and those of its other unknowns.
type AtFront<'a> = (&'a mut [f64], &'a mut [f64]);

/// Evaluates `$body` for each pair of vectors and for a last single one, inline: in a closure the compiler might not use wide registers.
macro_rules! in_pairs {
    ($vectors:expr, $sides:expr; $at_front:ident => $body:expr) => {{
        let [p, u] = $sides;
        let mut pairs = $vectors.chunks_exact_mut(2 * (p + u));
        for pair in &mut pairs {
            let (first, second) = pair.split_at_mut(p + u);
            let $at_front = [first.split_at_mut(p), second.split_at_mut(p)];
            $body;
        }
        let last = pairs.into_remainder();
        if !last.is_empty() {
            let $at_front = [last.split_at_mut(p)];
            $body;
        }
    }};
}

/// `w := L^-1 w` for the pivot block, then `below -= L_21 w`.
#[inline(always)]
pub(super) fn substitute_lower<S: Simd>(simd: S, diagonal: &[f64], lower: &[f64], sides: [usize; 2], vectors: &mut [f64]) {
    for j in (0..sides[0]).step_by(WIDTH) {
        in_pairs!(vectors, sides; at_front => lower_panel(simd, diagonal, lower, j, at_front));
    }
}

/// `w := U^-1 (w - U_12 right)` for the pivot block.
#[inline(always)]
pub(super) fn substitute_upper<S: Simd>(simd: S, diagonal: &[f64], upper: &[f64], sides: [usize; 2], vectors: &mut [f64]) {
    let [p, u] = sides;
    for j in (0..p).step_by(WIDTH).filter(|_| u > 0) {
        let columns = &upper[j * u..][..WIDTH * u];
        in_pairs!(vectors, sides; at_front => subtract_products(simd, columns, j, at_front));
    }
    for j in (0..p).step_by(WIDTH).rev() {
        in_pairs!(vectors, sides; at_front => upper_panel(simd, diagonal, j, at_front));
    }
}

/// Elimination of the pivots `j..j + WIDTH` from the numbers that follow.
#[inline(always)]
fn lower_panel<S: Simd, const N: usize>(simd: S, diagonal: &[f64], lower: &[f64], j: usize, mut vectors: [AtFront<'_>; N]) {
    let mut factors = [[0.0; WIDTH]; N];
    for (factors, (w, _)) in factors.iter_mut().zip(&mut vectors) {
        let p = w.len();
        for c in 0..WIDTH {
            for r in c + 1..WIDTH {
                w[j + r] -= diagonal[(j + c) * p + j + r] * w[j + c];
            }
        }
        *factors = *four(&w[j..]);
    }
    let (p, u) = (vectors[0].0.len(), vectors[0].1.len());
    combine(simd, &diagonal[j * p..], p, j + WIDTH, &factors, vectors.each_mut().map(|(w, _)| &mut w[j + WIDTH..]));
    if u > 0 {
        combine(simd, &lower[j * u..], u, 0, &factors, vectors.each_mut().map(|(_, below)| &mut below[..]));
    }
}

/// Solution for the pivots `j..j + WIDTH`, and its elimination from those before.
#[inline(always)]
fn upper_panel<S: Simd, const N: usize>(simd: S, diagonal: &[f64], j: usize, mut vectors: [AtFront<'_>; N]) {
    let mut factors = [[0.0; WIDTH]; N];
    let p = vectors[0].0.len();
    for (factors, (w, _)) in factors.iter_mut().zip(&mut vectors) {
        for c in (0..WIDTH).rev() {
            w[j + c] *= diagonal[(j + c) * p + j + c];
            for r in 0..c {
                w[j + r] -= diagonal[(j + c) * p + j + r] * w[j + c];
            }
        }
        *factors = *four(&w[j..]);
    }
    combine(simd, &diagonal[j * p..], p, 0, &factors, vectors.each_mut().map(|(w, _)| &mut w[..j]));
}

/// `target -= sum of four columns times factors` for each vector, rows from `first` on.
#[inline(always)]
fn combine<S: Simd, const N: usize>(
    simd: S,
    columns: &[f64],
    stride: usize,
    first: usize,
    factors: &[[f64; WIDTH]; N],
    targets: [&mut [f64]; N],
) {
    let length = targets[0].len();
    let column = |k: usize| S::as_simd_f64s(&columns[k * stride + first..][..length]).0;
    let (a, b, c, d) = (column(0), column(1), column(2), column(3));
    let factors = factors.map(|factors| factors.map(|factor| simd.splat_f64s(-factor)));
    let mut targets = targets.map(|target| S::as_mut_simd_f64s(&mut target[..length]).0);
    for (i, (((a, b), c), d)) in a.iter().zip(b).zip(c).zip(d).enumerate() {
        for (target, factors) in targets.iter_mut().zip(&factors) {
            let x = &mut target[i];
            let mut sum = simd.mul_add_e_f64s(factors[0], *a, *x);
            sum = simd.mul_add_e_f64s(factors[1], *b, sum);
            sum = simd.mul_add_e_f64s(factors[2], *c, sum);
            *x = simd.mul_add_e_f64s(factors[3], *d, sum);
        }
    }
}

/// `w -= U_12 right` for the pivots `j..j + WIDTH` of each vector, from their columns.
#[inline(always)]
fn subtract_products<S: Simd, const N: usize>(simd: S, columns: &[f64], j: usize, mut vectors: [AtFront<'_>; N]) {
    let u = columns.len() / WIDTH;
    let column = |k: usize| S::as_simd_f64s(&columns[k * u..][..u]).0;
    let (a, b, c, d) = (column(0), column(1), column(2), column(3));
    let rights = vectors.each_ref().map(|(_, right)| S::as_simd_f64s(&right[..u]).0);
    let mut sums = [[simd.splat_f64s(0.0); WIDTH]; N];
    for (i, (((a, b), c), d)) in a.iter().zip(b).zip(c).zip(d).enumerate() {
        for (sums, right) in sums.iter_mut().zip(&rights) {
            let x = right[i];
            sums[0] = simd.mul_add_e_f64s(*a, x, sums[0]);
            sums[1] = simd.mul_add_e_f64s(*b, x, sums[1]);
            sums[2] = simd.mul_add_e_f64s(*c, x, sums[2]);
            sums[3] = simd.mul_add_e_f64s(*d, x, sums[3]);
        }
    }
    for ((w, _), sums) in vectors.iter_mut().zip(sums) {
        for (w, sum) in w[j..].iter_mut().zip(sums) {
            *w -= simd.reduce_sum_f64s(sum);
        }
    }
}
