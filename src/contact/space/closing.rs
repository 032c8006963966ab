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
//! A point of the primary curve at the height `B` over `xi` projects to `xi + m B/c`, lower than the triangle there by `c B`,
//! `c^2 = 1 + |m|^2`. `C` equals `B_1 + c B_2(p - m B_2/c)` to second order in `m`; the bounded `mu` keeps steep pairs finite. On a polygon
//! `C` is a cubic polynomial, so that a rule of degree four and three Gauss points per edge are exact for every subdivision of the polygon.
//! Forces follow from the moments of `W` in the shape functions of both sides, so that points have few operations.
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
    q: [T; 3],
    /// Differences of `2 sum_k b_ik q_k` with the coefficients `b` of the primary form.
    tilts: [T; 2],
    /// Height profiles, and the affine function `e`.
    heights: [Quadratic<f64>; 2],
    factor: [T; 3],
}

/// Pair of values: for the secondary side, then for the primary side.
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

/// Polynomial of second degree in two of the shape functions of a triangle, the first of which follows: coefficients of
/// `1, x, y, x^2, x y, y^2`.
#[derive(Clone, Copy)]
struct Quadratic<T>([T; 6]);

/// Places of `x` and of `y` times the terms of a [`Quadratic`] among `1, x, y, x^2, x y, y^2, x^3, x^2 y, x y^2, y^3`.
const TIMES: [[usize; 6]; 2] = [[1, 3, 4, 6, 7, 8], [2, 4, 5, 7, 8, 9]];

impl Quadratic<f64> {
    /// Height profile of a triangle.
    #[inline(always)]
    fn of_form(&[a, b, c, ab, bc, ca]: &Form) -> Self {
        Quadratic([a, 2.0 * (ab - a), 2.0 * (ca - a), a + b - 2.0 * ab, 2.0 * (a + bc - ab - ca), a + c - 2.0 * ca])
    }

    #[inline(always)]
    fn at<T: Number>(&self, [x, y]: [T; 2]) -> T {
        let c = &self.0;
        (x * c[3] + y * c[4] + c[1]) * x + (y * c[5] + c[2]) * y + c[0]
    }

    /// Derivatives by `x` and by `y`: coefficients of `1, x, y`.
    #[inline(always)]
    fn rises(&self) -> [[f64; 3]; 2] {
        let c = &self.0;
        [[c[1], 2.0 * c[3], c[4]], [c[2], c[4], 2.0 * c[5]]]
    }
}

impl<T: Number> Quadratic<T> {
    /// Product of two affine functions.
    #[inline(always)]
    fn product(a: &[f64; 3], b: &[T; 3]) -> Self {
        Quadratic([b[0] * a[0], b[1] * a[0] + b[0] * a[1], b[2] * a[0] + b[0] * a[2], b[1] * a[1], b[2] * a[1] + b[1] * a[2], b[2] * a[2]])
    }

    /// Integral from moments of the terms, which are at `places`.
    #[inline(always)]
    fn integral<R: Number + Mul<T, Output = R>, const N: usize>(&self, moments: &[R; N], places: [usize; 6]) -> R {
        let mut sum = moments[places[0]] * self.0[0];
        for term in 1..6 {
            sum += moments[places[term]] * self.0[term];
        }
        sum
    }

    /// Integrals of the polynomial times the three shape functions.
    #[inline(always)]
    fn by_shapes<R: Number + Mul<T, Output = R>>(&self, moments: &[R; 10]) -> [R; 3] {
        let [of_x, of_y] = [self.integral(moments, TIMES[0]), self.integral(moments, TIMES[1])];
        [self.integral(moments, [0, 1, 2, 3, 4, 5]) - of_x - of_y, of_x, of_y]
    }
}

/// Adds moments `1, x, y, x^2, x y, y^2` and, for ten of them, those of third degree.
#[inline(always)]
fn add_moments<T: Copy, R: Number + Mul<T, Output = R>, const N: usize>(moments: &mut [R; N], weight: R, [x, y]: [T; 2]) {
    let (of_x, of_y) = (weight * x, weight * y);
    let (xx, yy) = (of_x * x, of_y * y);
    let parts = [weight, of_x, of_y, xx, of_x * y, yy];
    for k in 0..6 {
        moments[k] += parts[k];
    }
    if N == 10 {
        let parts = [xx * x, xx * y, yy * x, yy * y];
        for k in 0..4 {
            moments[6 + k] += parts[k];
        }
    }
}

#[inline(always)]
fn plane_product<T: Copy, R: Number + Mul<T, Output = R>>(a: [R; 2], b: [T; 2]) -> R {
    a[0] * b[0] + a[1] * b[1]
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
        let heights = [Quadratic::of_form(&forms[0]), Quadratic::of_form(&forms[1])];
        let ([by_x, by_y], r) = (heights[1].rises(), derivatives(&forms[1], &q));
        let mut factor = [plane_product(mu, mu) * 0.5 + 1.0, zero, zero];
        for term in 0..3 {
            factor[term] += -(q[1] * by_x[term] + q[2] * by_y[term]);
        }
        Closing { forms, gradients, slope, per, mu, q, tilts: [r[1] - r[0], r[2] - r[0]], heights, factor }
    }

    /// Closed part `C` of the gap at a point.
    #[inline(always)]
    fn at(&self, [l, m]: &PerTriangle<T>) -> T {
        let e = &self.factor;
        self.heights[0].at([l[1], l[2]]) + self.heights[1].at([m[1], m[2]]) * (e[1] * m[1] + e[2] * m[2] + e[0])
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
        let (mut own, mut other, mut closed) = ([zero; 6], [zero; 10], [none; 3]);
        for k in 1..vertices.len() - 1 {
            for (at, share) in &POINTS {
                let [l, m] = shapes([&vertices[0], &vertices[k], &vertices[k + 1]], at);
                let area = vertices[k].fan * (0.5 * share);
                let weight = (weights[0] * l[0] + weights[1] * l[1] + weights[2] * l[2]) * area;
                add_moments(&mut own, weight, [l[1], l[2]]);
                add_moments(&mut other, weight, [m[1], m[2]]);
                let part = self.at(&[l, m]) * area;
                closed[0] += part;
                closed[1] += part * l[1];
                closed[2] += part * l[2];
            }
        }
        closed[0] += -(closed[1] + closed[2]);
        let (rises, height) = ([self.heights[0].rises(), self.heights[1].rises()], &self.heights[1].0);
        let mut of_height = other[0] * height[0];
        for term in 1..6 {
            of_height += other[term] * height[term];
        }
        let mut sums = Integrals { of_slopes: [[[zero; 2]; 3]; 2], closed, height: of_height, tilt: [zero; 2] };
        for i in 0..2 {
            let [a, by_x, by_y] = rises[0][i];
            let of = |places: [usize; 3]| own[places[0]] * a + own[places[1]] * by_x + own[places[2]] * by_y;
            let [whole, of_x, of_y] = [of([0, 1, 2]), of([1, 3, 4]), of([2, 4, 5])];
            let mut slope = Quadratic::product(&rises[1][i], &self.factor);
            for term in 0..6 {
                slope.0[term] += -(self.tilts[i] * height[term]);
                let [a, by_x, by_y] = rises[1][i];
                let [x, y] = [TIMES[0][term], TIMES[1][term]];
                sums.tilt[i] += -((other[term] * a + other[x] * by_x + other[y] * by_y) * height[term]);
            }
            let [own, other] = [[whole - of_x - of_y, of_x, of_y], slope.by_shapes(&other)];
            for j in 0..3 {
                sums.of_slopes[0][j][i] = own[j];
                sums.of_slopes[1][j][i] = other[j];
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
