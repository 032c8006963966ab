//! Discrete gradient of a function of quadratic invariants (Gonzalez, CMAME 190, 2000; Hesch and Betsch 2007, equations 4 and 5).
//!
//! `g = grad f(pi_m) + a d`, `d = pi_1 - pi_0`, `pi_m = (pi_0 + pi_1)/2`, `a = R / d.d`, with the remainder
//! `R = f(pi_1) - f(pi_0) - grad f(pi_m).d`. Because every invariant is quadratic, `Dpi(q_mid)(q_1 - q_0) = d` exactly, so
//! `Dpi(q_mid)^T g` is directional to round-off for every step size. The remainder cancels when evaluated as written; the caller evaluates
//! it without cancellation.

use crate::math::lanes::Real;

/// Square of an increment below which a discrete gradient has no correction, 28 decades above the smallest normal number. Smaller squares
/// lose digits, and their reciprocals overflow: far from the load of a long bar strains are 1e-160, and the first step failed. At an
/// increment of 1e-140 the correction is 1e-140 of the gradient of any smooth function. Tested in `tests/scripts/first_steps.rhai`.
pub const LEAST_SQUARE: f64 = 1e28 * f64::MIN_POSITIVE;

/// Algorithmic gradient `g` and its derivative `T = dg/dpi_1` (not symmetric).
///
/// `d`: increment of the invariants; `gradient` and `hessian`: of `f` at the mean invariants; `gradient_end`: at `pi_1`;
/// `remainder`: `R` above. The correction and its derivative are dropped where `d.d <= threshold`, and where `d.d` underflows.
#[inline(always)]
pub fn discrete_gradient<R: Real, const K: usize>(
    d: &[R; K],
    gradient: &[R; K],
    hessian: &[[R; K]; K],
    gradient_end: &[R; K],
    remainder: R,
    threshold: R,
) -> ([R; K], [[R; K]; K]) {
    let square = dot(d, d);
    let inverse = (square - threshold).if_above(LEAST_SQUARE, R::splat(1.0) / square);
    let a = remainder * inverse;
    let mut g = *gradient;
    let mut tangent = *hessian;
    for k in 0..K {
        g[k] = a.mul_add(d[k], gradient[k]);
    }
    for k in 0..K {
        let slope = dot(&hessian[k], d) * 0.5;
        let da = (gradient_end[k] - gradient[k] - slope - (a + a) * d[k]) * inverse;
        for (l, row) in tangent.iter_mut().enumerate() {
            row[k] = d[l].mul_add(da, hessian[l][k] * 0.5);
        }
        tangent[k][k] = tangent[k][k] + a;
    }
    (g, tangent)
}

/// Sum of products.
#[inline(always)]
fn dot<R: Real, const K: usize>(a: &[R; K], b: &[R; K]) -> R {
    let mut sum = a[0] * b[0];
    for k in 1..K {
        sum = a[k].mul_add(b[k], sum);
    }
    sum
}
