//! Part of the gap that is closed by the height profiles of two triangles (`profiles.rs`), with derivatives; used by `pair.rs` and
//! `polygon.rs`.
//!
//! With the secondary profile `B_1(L)`, the primary profile `B_2(M)`, and the slope `m` of the primary triangle relative to the plane of
//! projection,
//!
//! ```text
//! C = B_1 + B_2 (1 + |mu|^2/2) - B_2 mu.grad B_2,      mu = m/(1 + |m|^2/2)                     [length]
//! ```
//!
//! A point of the primary curve at the height `B` over `xi` projects to `xi + m B/c`, lower than the triangle there by `c B`, `c^2 = 1 +
//! |m|^2`. `C` equals `B_1 + c B_2(p - m B_2/c)` to second order in `m`; the bounded `mu` keeps steep pairs finite. On a polygon `C` is a
//! cubic polynomial, so that a rule of degree four and three Gauss points per edge are exact for every subdivision of the polygon.
//!
//! The profiles contribute `-int W C dA` to `Phi`. With `q_k = mu.grad M_k`, `e = 1 + |mu|^2/2 - sum q_k dB_2/dM_k`, `A = int W B_2`, `Q =
//! -int W B_2 grad B_2` and `G = (d mu/d m)(A mu + Q)`, the derivatives of this contribution, without those of the polygon's edges
//! (`polygon.rs`), are
//!
//! ```text
//! d/dp_j =   int N_j (W grad B_1 + C grad W) dA
//! d/dp_m =   int W M_m grad C dA + (G.grad M_m) m + q_m Q           d/dh_m = - G.grad M_m
//! ```

use std::ops::Mul;

use super::profiles::{Form, derivatives, value};
use super::vertices::{Forces, PerTriangle, Vertex, shape_gradients, slope_of};
use crate::contact::numbers::Number;

/// Quadrature points of a triangle (area coordinates) and weights, exact to degree four (Dunavant, IJNME 21, 1985).
pub const POINTS: [([f64; 3], f64); 6] = {
    const A: f64 = 0.445_948_490_915_964_9;
    const B: f64 = 0.091_576_213_509_770_74;
    const OF_A: f64 = 0.223_381_589_678_011_47;
    const OF_B: f64 = 0.109_951_743_655_321_87;
    const FAR_A: f64 = 1.0 - 2.0 * A;
    const FAR_B: f64 = 1.0 - 2.0 * B;
    [
        ([FAR_A, A, A], OF_A),
        ([A, FAR_A, A], OF_A),
        ([A, A, FAR_A], OF_A),
        ([FAR_B, B, B], OF_B),
        ([B, FAR_B, B], OF_B),
        ([B, B, FAR_B], OF_B),
    ]
};

/// Three Gauss points on [0, 1] with their weights.
const GAUSS: [(f64, f64); 3] = [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Height profiles of the two triangles of a polygon, in the plane of projection.
pub struct Closing<T> {
    forms: OfBoth2<Form>,
    /// Gradients of the shape functions of both triangles.
    gradients: PerTriangle<[T; 2]>,
    /// Slope `m` of the primary triangle, `1/(1 + |m|^2/2)`, and `mu`.
    slope: [T; 2],
    per: T,
    mu: [T; 2],
    /// `even`: `1 + |mu|^2/2`; `q`: `q_k`; `r`: `2 sum_k b_ik q_k` with the coefficients `b` of the primary profile.
    even: T,
    q: [T; 3],
    r: [T; 3],
}

/// Pair of values, one per side, secondary first.
type OfBoth2<T> = [T; 2];

/// Integrals over a polygon from which the forces of profiles are computed.
struct Integrals<T, R> {
    /// Integrals `int W N_j` and `int W M_j` times the derivatives of `B_1` and `C` with respect to the second and third shape function
    /// minus that with respect to the first one.
    of_slopes: [[[R; 2]; 3]; 2],
    /// Integrals `int C N_j` of the closed gap `C`.
    closed: [T; 3],
    /// Integral `A`; `tilt`: components of `Q` along the gradients of the second and third shape function.
    height: R,
    tilt: [R; 2],
}

#[inline(always)]
fn plane_product<T: Copy, R: Number + Mul<T, Output = R>>(a: [R; 2], b: [T; 2]) -> R {
    a[0] * b[0] + a[1] * b[1]
}

/// Differences of the second and third number from the first one.
#[inline(always)]
fn differences<T: Number>(of: &[T; 3]) -> [T; 2] {
    [of[1] - of[0], of[2] - of[0]]
}

/// Shape functions of both triangles at a point, given by its area coordinates in three corners of a polygon.
#[inline(always)]
fn shapes<T: Number>(corners: [&Vertex<T>; 3], at: &[f64; 3]) -> PerTriangle<T> {
    let mut shapes = [[T::from(0.0); 3]; 2];
    for side in 0..2 {
        let [a, b, c] = corners.map(|corner| corner.shape(side));
        for j in 0..2 {
            shapes[side][j] = a[j] * at[0] + b[j] * at[1] + c[j] * at[2];
        }
        shapes[side][2] = -(shapes[side][0] + shapes[side][1]) + 1.0;
    }
    shapes
}

impl<T: Number> Closing<T> {
    /// Height profiles of the two triangles of a polygon: double areas of the triangles, plane coordinates and heights of their corners.
    #[inline(always)]
    pub fn new(areas: &[T; 2], places: &PerTriangle<[T; 2]>, heights: &PerTriangle<f64>, forms: [Form; 2]) -> Self
    where
        f64: Mul<T, Output = T>,
    {
        let gradients = [shape_gradients(&places[0], areas[0]), shape_gradients(&places[1], areas[1])];
        let slope = slope_of(&gradients[1], &heights[1]);
        let per = (plane_product(slope, slope) * 0.5 + 1.0).recip();
        let mu = [slope[0] * per, slope[1] * per];
        let zero = T::from(0.0);
        let mut q = [zero; 3];
        for k in 0..3 {
            q[k] = plane_product(mu, gradients[1][k]);
        }
        let even = plane_product(mu, mu) * 0.5 + 1.0;
        Closing { forms, gradients, slope, per, mu, even, q, r: derivatives(&forms[1], &q) }
    }

    /// Factor `e` of the primary height, from the derivatives of the primary profile.
    #[inline(always)]
    fn factor(&self, rises: &[T; 3]) -> T {
        self.even - (self.q[0] * rises[0] + self.q[1] * rises[1] + self.q[2] * rises[2])
    }

    /// Closed part `C` of the gap at a point.
    #[inline(always)]
    fn at(&self, [l, m]: &PerTriangle<T>) -> T {
        let [own, other] = [derivatives(&self.forms[0], l), derivatives(&self.forms[1], m)];
        value(&own, l) + value(&other, m) * self.factor(&other)
    }

    /// Integrals `int C N_j dA` over a polygon.
    #[inline(always)]
    pub fn closed(&self, vertices: &[Vertex<T>]) -> [T; 3] {
        let mut closed = [T::from(0.0); 3];
        for k in 1..vertices.len() - 1 {
            for (at, share) in &POINTS {
                let shapes = shapes([&vertices[0], &vertices[k], &vertices[k + 1]], at);
                let part = self.at(&shapes) * (vertices[k].fan * (0.5 * share));
                for j in 0..3 {
                    closed[j] += part * shapes[0][j];
                }
            }
        }
        closed
    }

    #[inline(always)]
    fn integrals<W, R>(&self, vertices: &[Vertex<T>], weights: &[W; 3]) -> Integrals<T, R>
    where
        W: Copy + Mul<T, Output = R>,
        R: Number + Mul<T, Output = R>,
    {
        let (zero, none) = (R::from(0.0), T::from(0.0));
        let mut sums = Integrals { of_slopes: [[[zero; 2]; 3]; 2], closed: [none; 3], height: zero, tilt: [zero; 2] };
        for k in 1..vertices.len() - 1 {
            for (at, share) in &POINTS {
                let [l, m] = shapes([&vertices[0], &vertices[k], &vertices[k + 1]], at);
                let area = vertices[k].fan * (0.5 * share);
                let weight = (weights[0] * l[0] + weights[1] * l[1] + weights[2] * l[2]) * area;
                let [own, other] = [derivatives(&self.forms[0], &l), derivatives(&self.forms[1], &m)];
                let (height, factor) = (value(&other, &m), self.factor(&other));
                let closed = (value(&own, &l) + height * factor) * area;
                let (own, rises, tilts) = (differences(&own), differences(&other), differences(&self.r));
                let weighted = weight * height;
                sums.height += weighted;
                let mut of_primary = [none; 2];
                for i in 0..2 {
                    sums.tilt[i] -= weighted * rises[i];
                    of_primary[i] = rises[i] * factor - height * tilts[i];
                }
                for j in 0..3 {
                    sums.closed[j] += closed * l[j];
                    let parts = [weight * l[j], weight * m[j]];
                    for i in 0..2 {
                        sums.of_slopes[0][j][i] += parts[0] * own[i];
                        sums.of_slopes[1][j][i] += parts[1] * of_primary[i];
                    }
                }
            }
        }
        sums
    }

    /// Plane vector from its components along the gradients of the second and third shape function of a side.
    #[inline(always)]
    fn along<R: Number + Mul<T, Output = R>>(&self, side: usize, parts: [R; 2]) -> [R; 2] {
        let [_, b, c] = self.gradients[side];
        [parts[0] * b[0] + parts[1] * c[0], parts[0] * b[1] + parts[1] * c[1]]
    }

    /// Product `(d mu/d m) g`.
    #[inline(always)]
    fn by_slope<R: Number + Mul<T, Output = R>>(&self, g: [R; 2]) -> [R; 2] {
        let along = plane_product(g, self.mu);
        [g[0] * self.per - along * self.mu[0], g[1] * self.per - along * self.mu[1]]
    }

    /// Adds the forces of the profiles on a polygon, without those of its edges.
    #[inline(always)]
    pub fn forces_into<W, R>(&self, vertices: &[Vertex<T>], weights: &[W; 3], forces: &mut Forces<R>)
    where
        W: Copy + Mul<T, Output = R>,
        R: Number + Mul<T, Output = R>,
    {
        let sums: Integrals<T, R> = self.integrals(vertices, weights);
        let weight_slope = slope_of(&self.gradients[0], weights);
        let tilt = self.along(1, sums.tilt);
        let by_mu = [sums.height * self.mu[0] + tilt[0], sums.height * self.mu[1] + tilt[1]];
        let by_slope = self.by_slope(by_mu);
        for j in 0..3 {
            let rise = plane_product(by_slope, self.gradients[1][j]);
            forces.of_h[1][j] -= rise;
            let parts = [self.along(0, sums.of_slopes[0][j]), self.along(1, sums.of_slopes[1][j])];
            for i in 0..2 {
                forces.of_p[0][j][i] += parts[0][i] + weight_slope[i] * sums.closed[j];
                forces.of_p[1][j][i] += parts[1][i] + rise * self.slope[i] + tilt[i] * self.q[j];
            }
        }
    }

    /// Integrals of `W C f` over an edge for affine `f`, divided by the edge's length: coefficients of the values of `f` at both ends.
    #[inline(always)]
    pub fn along_edge<R: Number + Mul<T, Output = R>>(&self, ends: [&Vertex<T>; 2], weight: [R; 2]) -> [R; 2] {
        let mut sums = [R::from(0.0); 2];
        for (t, share) in GAUSS {
            let shapes = shapes([ends[0], ends[1], ends[1]], &[1.0 - t, t, 0.0]);
            let part = (weight[0] * (1.0 - t) + weight[1] * t) * (self.at(&shapes) * share);
            sums[0] += part * (1.0 - t);
            sums[1] += part * t;
        }
        sums
    }
}

impl Closing<f64> {
    /// Derivatives of [`Closing::along_edge`] with respect to the height of a primary corner.
    pub fn along_edge_by_height(&self, ends: [&Vertex<f64>; 2], weight: [f64; 2], corner: usize) -> [f64; 2] {
        let moved = self.by_slope(self.gradients[1][corner]);
        let mut sums = [0.0; 2];
        for (t, share) in GAUSS {
            let [_, m] = shapes([ends[0], ends[1], ends[1]], &[1.0 - t, t, 0.0]);
            let rises = derivatives(&self.forms[1], &m);
            let rise = slope_of(&self.gradients[1], &rises);
            let slope = value(&rises, &m) * (plane_product(self.mu, moved) - plane_product(rise, moved));
            let part = (weight[0] * (1.0 - t) + weight[1] * t) * slope * share;
            sums[0] += part * (1.0 - t);
            sums[1] += part * t;
        }
        sums
    }

    /// Second derivatives of `-int W C dA` with respect to the heights of the primary corners.
    pub fn by_heights(&self, vertices: &[Vertex<f64>], weights: &[f64; 3]) -> [[f64; 3]; 3] {
        let sums: Integrals<f64, f64> = self.integrals(vertices, weights);
        let (tilt, [m, mu]) = (self.along(1, sums.tilt), [self.slope, self.mu]);
        let g: [f64; 2] = std::array::from_fn(|i| sums.height * mu[i] + tilt[i]);
        let along = plane_product(m, g);
        // Derivative of (d mu/d m) g at constant g, plus that of g.
        let square = self.per * self.per;
        let of_slope = |a: usize, b: usize| {
            let unit = if a == b { 1.0 } else { 0.0 };
            let column = self.by_slope(std::array::from_fn(|i| if i == b { 1.0 } else { 0.0 }));
            square * (2.0 * self.per * along * m[a] * m[b] - g[a] * m[b] - m[a] * g[b] - unit * along)
                + sums.height * self.by_slope(column)[a]
        };
        let second = [[of_slope(0, 0), of_slope(0, 1)], [of_slope(1, 0), of_slope(1, 1)]];
        let gradients = &self.gradients[1];
        let of_pair = |k: usize, l: usize| -(0..2).map(|a| gradients[k][a] * plane_product(second[a], gradients[l])).sum::<f64>();
        std::array::from_fn(|k| std::array::from_fn(|l| of_pair(k, l)))
    }
}
