//! Discrete derivative of the tensor logarithm.
//!
//! For `C_1 = sum c_1i n_1i n_1i` and `C_0` likewise, `ln C_1 - ln C_0 = sum_ij ln[c_1i, c_0j] P_1i (C_1 - C_0) P_0j` with the divided
//! difference `ln[a, b] = (ln a - ln b)/(a - b)` (Daletskii and Krein, Voronezh. Gos. Univ. Trudy Sem. Funkcional. Anal. 1, 1956). Its
//! adjoint `A : T = sym sum_ij ln[c_1i, c_0j] P_1i T P_0j` maps a stress `T` on the logarithmic strain to one on `C`. Components refer to
//! the principal directions of `C_1`; `R_ij = n_1i . n_0j` relates these to the principal directions of `C_0`.

use std::hint::black_box;

use crate::math::lanes::{Lanes, Real, WIDTH};
use crate::math::tensor::{mandel_pairs, mandel_scale};
use crate::math::tolerances::{CLOSE_STRETCHES, NEAR_STRETCHES, WIDE_STRETCHES};

/// A matrix of three rows.
pub(super) type Matrix<const FMA: bool> = [[Lanes<FMA>; 3]; 3];

/// Exclusive upper bound of the index in the series of `ln[a, b, c]`, which gives 5, 8 and 16 terms, for a spread up to
/// [`CLOSE_STRETCHES`], [`NEAR_STRETCHES`], [`WIDE_STRETCHES`]: truncation error below 1e-17.
const TERMS: [i32; 3] = [7, 10, 18];

/// True if tensors of `S` Mandel components can have the shear component of the directions `i` and `j`.
#[inline(always)]
pub(super) const fn linked<const S: usize>(i: usize, j: usize) -> bool {
    S == 6 || i == j || (i < 2 && j < 2)
}

/// Index of component `(i, j)` among the Mandel components of three directions.
#[inline(always)]
pub(super) const fn place(i: usize, j: usize) -> usize {
    crate::math::tensor::mandel_index::<3>(i, j)
}

/// `ln[a, b]`, with relative accuracy also where they are equal.
#[inline(always)]
pub(super) fn first_difference<const FMA: bool>(a: Lanes<FMA>, b: Lanes<FMA>) -> Lanes<FMA> {
    let sum = a + b;
    let ratio = (a - b) / sum;
    let excess = ratio.unless_zero(ratio.atanh_excess() / ratio, Lanes::ZERO);
    (excess + 1.0) * 2.0 / sum
}

/// `ln[a, b, c]`: a series about the mean, or for a wide spread the recursion over the outermost pair.
#[inline(always)]
pub(super) fn second_difference<const FMA: bool>(a: Lanes<FMA>, b: Lanes<FMA>, c: Lanes<FMA>) -> Lanes<FMA> {
    let mean = (a + b + c) * (1.0 / 3.0);
    let inverse = Lanes::splat(1.0) / mean;
    let (x, y, z) = ((a - mean) * inverse, (b - mean) * inverse, (c - mean) * inverse);
    let mut spread = 0.0f64;
    for lane in 0..WIDTH {
        spread = spread.max((x.0[lane] - y.0[lane]).abs()).max((y.0[lane] - z.0[lane]).abs()).max((x.0[lane] - z.0[lane]).abs());
    }
    let terms = if spread < CLOSE_STRETCHES {
        TERMS[0]
    } else if spread < NEAR_STRETCHES {
        TERMS[1]
    } else {
        TERMS[2]
    };
    // Complete homogeneous polynomials of one, two and three of the distances from the mean.
    let one = Lanes::<FMA>::splat(1.0);
    let (mut h_1, mut h_2, mut h_3) = (one, one, one);
    let (mut sum, mut sign) = (one * -0.5, 1.0);
    for k in 3..terms {
        h_1 = h_1 * x;
        h_2 = y.mul_add(h_2, h_1);
        h_3 = z.mul_add(h_3, h_2);
        sum = h_3.mul_add(Lanes::splat(sign / f64::from(k)), sum);
        sign = -sign;
    }
    let near = sum * inverse * inverse;
    if spread <= WIDE_STRETCHES { near } else { of_wide_spread(near, [a, b, c]) }
}

/// `ln[a, b, c]` in each lane: by recursion for a wide spread, otherwise `near`.
#[cold]
#[inline(never)]
fn of_wide_spread<const FMA: bool>(near: Lanes<FMA>, all: [Lanes<FMA>; 3]) -> Lanes<FMA> {
    let mut result = near;
    for lane in 0..WIDTH {
        let mut values = all.map(|value| value.0[lane]);
        values.sort_by(f64::total_cmp);
        let [low, middle, high] = values;
        if high - low > WIDE_STRETCHES * (low + middle + high) / 3.0 {
            let first = |a: f64, b: f64| first_difference::<false>(Lanes::splat(a), Lanes::splat(b)).0[0];
            result.0[lane] = (first(high, middle) - first(middle, low)) / (high - low);
        }
    }
    result
}

/// The linear map of symmetric tensors `D` to `sym sum_k D_ik H^i_km`, from the matrices `H^i`.
#[inline(always)]
pub(super) fn symmetric_map<const FMA: bool, const S: usize>(h: &[Matrix<FMA>; 3]) -> [[Lanes<FMA>; S]; S] {
    let mut map = [[Lanes::ZERO; S]; S];
    for (row, &(i, m)) in mandel_pairs::<S>().iter().enumerate() {
        let half = 0.5 / mandel_scale(i, m);
        for k in 0..3 {
            if linked::<S>(i, k) {
                let entry = &mut map[row][place(i, k)];
                *entry = h[i][k][m].mul_add(Lanes::splat(half * mandel_scale(i, k)), *entry);
            }
            if linked::<S>(m, k) {
                let entry = &mut map[row][place(m, k)];
                *entry = h[m][k][i].mul_add(Lanes::splat(half * mandel_scale(m, k)), *entry);
            }
        }
    }
    map
}

/// `A` as a map of tensors in the principal directions of `C_1`: the matrices `N^i_km = sum_j ln[c_1i, c_0j] R_kj R_mj` of
/// [`symmetric_map`].
#[inline(always)]
pub(super) fn adjoint<const FMA: bool, const S: usize>(stretches: [&[Lanes<FMA>; 3]; 2], r: &Matrix<FMA>) -> [Matrix<FMA>; 3] {
    let [c_0, c_1] = stretches;
    let mut n = [[[Lanes::ZERO; 3]; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            if !linked::<S>(i, j) {
                continue;
            }
            let quotient = first_difference(c_1[i], c_0[j]);
            for k in 0..3 {
                for m in k..3 {
                    if linked::<S>(i, k) && linked::<S>(i, m) {
                        n[i][k][m] = (quotient * r[k][j]).mul_add(r[m][j], n[i][k][m]);
                    }
                }
            }
        }
        for k in 0..3 {
            for m in 0..k {
                n[i][k][m] = n[i][m][k];
            }
        }
    }
    n
}

/// Derivative of `A : T` with respect to `C_1` for a fixed `T`, both in the principal directions of `C_1`: the matrices
/// `H^i_km = sum_j ln[c_1i, c_1k, c_0j] (T R)_kj R_mj` of [`symmetric_map`].
#[inline(always)]
pub(super) fn curvature<const FMA: bool, const S: usize>(
    stretches: [&[Lanes<FMA>; 3]; 2],
    r: &Matrix<FMA>,
    stress: &Matrix<FMA>,
) -> [Matrix<FMA>; 3] {
    let [c_0, c_1] = stretches;
    let mut turned = [[Lanes::ZERO; 3]; 3];
    for k in 0..3 {
        for j in 0..3 {
            for l in 0..3 {
                if linked::<S>(k, l) && linked::<S>(l, j) {
                    turned[k][j] = stress[k][l].mul_add(r[l][j], turned[k][j]);
                }
            }
        }
    }
    let mut h = [[[Lanes::ZERO; 3]; 3]; 3];
    for i in 0..3 {
        for k in i..3 {
            if !linked::<S>(i, k) {
                continue;
            }
            for j in 0..3 {
                if !linked::<S>(k, j) {
                    continue;
                }
                let quotient = second_difference(c_1[i], c_1[k], c_0[j]);
                for m in 0..3 {
                    if linked::<S>(m, j) {
                        h[i][k][m] = (quotient * turned[k][j]).mul_add(r[m][j], h[i][k][m]);
                        if i != k {
                            h[k][i][m] = (quotient * turned[i][j]).mul_add(r[m][j], h[k][i][m]);
                        }
                    }
                }
            }
        }
    }
    h
}

/// The map `T -> W T W^T` of symmetric tensors as a matrix of Mandel components.
#[inline(always)]
pub(super) fn congruence<const FMA: bool, const S: usize>(w: &Matrix<FMA>) -> [[Lanes<FMA>; S]; S] {
    let mut map = [[Lanes::ZERO; S]; S];
    for (row, &(a, b)) in mandel_pairs::<S>().iter().enumerate() {
        for (column, &(i, j)) in mandel_pairs::<S>().iter().enumerate() {
            let factor = 0.5 * mandel_scale(i, j) / mandel_scale(a, b) * if i == j { 1.0 } else { 2.0 };
            map[row][column] = w[a][i].mul_add(w[b][j], w[a][j] * w[b][i]) * factor;
        }
    }
    map
}

/// A matrix times a tensor.
#[inline(always)]
pub(super) fn applied<const FMA: bool, const S: usize>(map: &[[Lanes<FMA>; S]; S], tensor: &[Lanes<FMA>; S]) -> [Lanes<FMA>; S] {
    let mut result = [Lanes::ZERO; S];
    for k in 0..S {
        for l in 0..S {
            result[k] = map[k][l].mul_add(tensor[l], result[k]);
        }
    }
    result
}

/// The transpose of a matrix times a tensor.
#[inline(always)]
pub(super) fn applied_back<const FMA: bool, const S: usize>(map: &[[Lanes<FMA>; S]; S], tensor: &[Lanes<FMA>; S]) -> [Lanes<FMA>; S] {
    let mut result = [Lanes::ZERO; S];
    for k in 0..S {
        for l in 0..S {
            result[k] = map[l][k].mul_add(tensor[l], result[k]);
        }
    }
    result
}

/// Returns `S`, a number of rows, hidden from the optimizer, which otherwise unrolls loops over rows and over columns: a longer time to
/// compile without a gain in speed.
#[inline(always)]
pub(super) fn rows<const S: usize>() -> usize {
    black_box(S).min(S)
}

/// Matrix product `A B`.
#[inline(always)]
pub(super) fn product<const FMA: bool, const S: usize>(a: &[[Lanes<FMA>; S]; S], b: &[[Lanes<FMA>; S]; S]) -> [[Lanes<FMA>; S]; S] {
    let mut result = [[Lanes::ZERO; S]; S];
    for k in 0..rows::<S>() {
        for m in 0..S {
            for l in 0..S {
                result[k][l] = a[k][m].mul_add(b[m][l], result[k][l]);
            }
        }
    }
    result
}

/// Matrix product `A B^T`.
#[inline(always)]
pub(super) fn product_with_transpose<const FMA: bool, const S: usize>(
    a: &[[Lanes<FMA>; S]; S],
    b: &[[Lanes<FMA>; S]; S],
) -> [[Lanes<FMA>; S]; S] {
    let mut result = [[Lanes::ZERO; S]; S];
    for k in 0..rows::<S>() {
        result[k] = applied(b, &a[k]);
    }
    result
}

/// Double contraction.
#[inline(always)]
pub(super) fn dot<const FMA: bool, const S: usize>(a: &[Lanes<FMA>; S], b: &[Lanes<FMA>; S]) -> Lanes<FMA> {
    let mut sum = Lanes::ZERO;
    for k in 0..S {
        sum = a[k].mul_add(b[k], sum);
    }
    sum
}

/// Deviatoric part of the tensor.
#[inline(always)]
pub(super) fn deviator<const FMA: bool, const S: usize>(tensor: &[Lanes<FMA>; S]) -> [Lanes<FMA>; S] {
    let mean = trace(tensor) * (1.0 / 3.0);
    let mut result = *tensor;
    for component in result.iter_mut().take(3) {
        *component = *component - mean;
    }
    result
}

/// Sum of the direct components.
#[inline(always)]
pub(super) fn trace<const FMA: bool, const S: usize>(tensor: &[Lanes<FMA>; S]) -> Lanes<FMA> {
    tensor[0] + tensor[1] + tensor[2]
}

/// Sum `s A + B`.
#[inline(always)]
pub(super) fn plus<const FMA: bool, const S: usize>(a: &[Lanes<FMA>; S], s: Lanes<FMA>, b: &[Lanes<FMA>; S]) -> [Lanes<FMA>; S] {
    let mut result = *b;
    for k in 0..S {
        result[k] = a[k].mul_add(s, b[k]);
    }
    result
}

/// Multiple `s A`.
#[inline(always)]
pub(super) fn times<const FMA: bool, const S: usize>(a: &[Lanes<FMA>; S], s: Lanes<FMA>) -> [Lanes<FMA>; S] {
    let mut result = *a;
    for component in &mut result {
        *component = *component * s;
    }
    result
}
