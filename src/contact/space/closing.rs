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
//!
//! With the stretches `s_1`, `s_2` that multiply the profiles (`stretch.rs`), the derivatives with respect to `ln s_1` and `ln s_2` are
//! `-int W B_1 dA` and `-(1 + |mu|^2/2) A - 2 mu.Q`.

use std::ops::Mul;

use super::forms::{Form, Quadratic, TIMES, derivatives};
use super::vertices::{Forces, OfPrimary, PerTriangle, PolygonBorder, Vertex, outward, slope_of};
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

/// Height profiles of the two triangles of a polygon, in the plane of projection, for a constant tilt.
pub struct Closing<T> {
    /// Gradients of the shape functions of both triangles.
    gradients: PerTriangle<[T; 2]>,
    /// Height profiles.
    heights: [Quadratic; 2],
    /// Affine function `e` in the primary shape functions.
    factor: [f64; 3],
    /// Minus the derivatives of `e`.
    tilts: [f64; 2],
    /// `1 + |mu|^2/2`.
    upright: f64,
}

/// Tilt of a primary triangle against the plane of projection.
pub struct Tilt<T> {
    /// Gradients of the shape functions.
    gradients: [[T; 2]; 3],
    /// Slope `m`.
    slope: [T; 2],
    /// `1/(1 + |m|^2/2)`.
    per: T,
    /// Bounded function `mu` of the slope (`docs/theory.md`).
    mu: [T; 2],
    q: [T; 3],
}

/// Integrals over a polygon from which the forces of profiles are computed.
pub struct Moments<T, R> {
    /// Integrals of `W` times `1, x, y, x^2, x y, y^2` in the second and third shape function of the secondary triangle.
    own: [R; 6],
    /// Integrals of `W` times monomials up to degree three in the second and third shape function of the primary triangle.
    other: [R; 10],
    /// Integrals `int C N_j` of the closed gap `C`.
    closed: [T; 3],
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

/// Shape functions of both triangles on an edge, at the share `t` of its length.
#[inline(always)]
fn on_edge<T: Number>(ends: [&Vertex<T>; 2], t: f64) -> PerTriangle<T> {
    shapes([ends[0], ends[1], ends[1]], &[1.0 - t, t, 0.0])
}

impl<T: Number> Tilt<T> {
    /// Tilt of a primary triangle: gradients of its shape functions, heights of its corners.
    #[inline(always)]
    pub fn new(gradients: [[T; 2]; 3], heights: &[T; 3]) -> Self {
        let slope = slope_of(&gradients, heights);
        let per = (plane_product(slope, slope) * 0.5 + 1.0).recip();
        let mu = [slope[0] * per, slope[1] * per];
        let mut q = [T::from(0.0); 3];
        for k in 0..3 {
            q[k] = plane_product(mu, gradients[k]);
        }
        Tilt { gradients, slope, per, mu, q }
    }

    /// `1 + |mu|^2/2`.
    #[inline(always)]
    fn upright(&self) -> T {
        plane_product(self.mu, self.mu) * 0.5 + 1.0
    }

    /// `(1 + |mu|^2/2) A + times mu.Q`, from `A` and the components of `Q` along the gradients of the second and third shape function: for
    /// `times` 1 the integral of `W` times the primary part of `C`, for 2 and 4 its first and second derivative with respect to `ln s_2`.
    #[inline(always)]
    pub fn closed<R: Number + Mul<T, Output = R>>(&self, [height, first, second]: [R; 3], times: f64) -> R {
        height * self.upright() + (first * self.q[1] + second * self.q[2]) * times
    }

    /// Derivatives of `Phi` by way of the tilt with respect to plane coordinates and height of the corners: `A`, and the components of `Q`
    /// along the gradients of the second and third shape function.
    #[inline(always)]
    pub fn forces<R: Number + Mul<T, Output = R>>(&self, [height, first, second]: [R; 3]) -> [[R; 3]; 3] {
        let ([_, b, c], mu) = (self.gradients, self.mu);
        let tilt = [first * b[0] + second * c[0], first * b[1] + second * c[1]];
        let g = [height * mu[0] + tilt[0], height * mu[1] + tilt[1]];
        let along = plane_product(g, mu);
        let by_slope = [g[0] * self.per - along * mu[0], g[1] * self.per - along * mu[1]];
        let mut forces = [[R::from(0.0); 3]; 3];
        for j in 0..3 {
            let rise = plane_product(by_slope, self.gradients[j]);
            forces[j][2] = -rise;
            for i in 0..2 {
                forces[j][i] = rise * self.slope[i] + tilt[i] * self.q[j];
            }
        }
        forces
    }
}

impl Closing<f64> {
    /// Height profiles of the two triangles of a polygon: gradients of the shape functions of both, tilt of the primary one.
    #[inline(always)]
    pub fn new(gradients: PerTriangle<[f64; 2]>, tilt: &Tilt<f64>, forms: [Form; 2]) -> Self {
        let heights = [Quadratic::of_form(&forms[0]), Quadratic::of_form(&forms[1])];
        let ([by_x, by_y], r) = (heights[1].rises(), derivatives(&forms[1], &tilt.q));
        let upright = tilt.upright();
        let mut factor = [upright, 0.0, 0.0];
        for term in 0..3 {
            factor[term] -= tilt.q[1] * by_x[term] + tilt.q[2] * by_y[term];
        }
        Closing { gradients, heights, factor, tilts: [r[1] - r[0], r[2] - r[0]], upright }
    }

    /// Profiles with derivatives, for a constant tilt.
    #[inline(always)]
    pub fn with_gradients<T>(&self, gradients: PerTriangle<[T; 2]>) -> Closing<T> {
        Closing { gradients, heights: self.heights, factor: self.factor, tilts: self.tilts, upright: self.upright }
    }

    /// Derivatives of the primary part of `C` with respect to the second and third shape function.
    #[inline(always)]
    fn slopes(&self, [_, x, y]: &[f64; 3]) -> [f64; 2] {
        let (rises, e) = (self.heights[1].rises(), &self.factor);
        let (height, factor) = (self.heights[1].at([*x, *y]), e[0] + e[1] * x + e[2] * y);
        let [by_x, by_y] = &rises;
        [
            (by_x[0] + by_x[1] * x + by_x[2] * y) * factor - self.tilts[0] * height,
            (by_y[0] + by_y[1] * x + by_y[2] * y) * factor - self.tilts[1] * height,
        ]
    }

    /// Integrals over a polygon, with derivatives with respect to the plane coordinates of the primary triangle. For a displacement `M_c v`
    /// of this triangle `M_k` changes by `-M_c v.grad M_k`, and the polygon at its primary edges by `M_c v.nu`.
    #[inline(always)]
    pub fn moments_with_derivatives(&self, vertices: &[Vertex<f64>], weights: &[f64; 3]) -> Moments<OfPrimary, OfPrimary> {
        let plain: Moments<f64, f64> = self.moments(vertices, weights);
        let Moments { own, other, closed } = &plain;
        let zero = OfPrimary::from(0.0);
        let mut of = Moments { own: [zero; 6], other: [zero; 10], closed: [zero; 3] };
        of.own.iter_mut().zip(own).for_each(|(of, own)| of.re = *own);
        of.other.iter_mut().zip(other).for_each(|(of, other)| of.re = *other);
        of.closed.iter_mut().zip(closed).for_each(|(of, closed)| of.re = *closed);
        // Integrals of N_j M_c times the slopes of C, and of W M_c times monomials up to degree two.
        let mut of_slopes = [[[0.0; 2]; 3]; 3];
        for k in 1..vertices.len() - 1 {
            for (at, share) in &POINTS {
                let [l, m] = shapes([&vertices[0], &vertices[k], &vertices[k + 1]], at);
                let (area, slopes) = (vertices[k].fan * (0.5 * share), self.slopes(&m));
                for j in 0..3 {
                    for c in 0..3 {
                        let part = area * l[j] * m[c];
                        of_slopes[j][c][0] += part * slopes[0];
                        of_slopes[j][c][1] += part * slopes[1];
                    }
                }
            }
        }
        let mut products = [[0.0; 6]; 3];
        for term in 0..6 {
            let [x, y] = [other[TIMES[0][term]], other[TIMES[1][term]]];
            (products[0][term], products[1][term], products[2][term]) = (other[term] - x - y, x, y);
        }
        let [_, by_x, by_y] = self.gradients[1];
        for lane in 0..6 {
            let (c, axis) = (lane / 2, lane % 2);
            let ([of_1, of_x, of_y, of_xx, of_xy, of_yy], x, y) = (products[c], by_x[axis], by_y[axis]);
            let along_x = [0.0, of_1, 0.0, 2.0 * of_x, of_y, 0.0, 3.0 * of_xx, 2.0 * of_xy, of_yy, 0.0];
            let along_y = [0.0, 0.0, of_1, 0.0, of_x, 2.0 * of_y, 0.0, of_xx, 2.0 * of_xy, 3.0 * of_yy];
            for term in 0..10 {
                of.other[term].eps[lane] = -(x * along_x[term] + y * along_y[term]);
            }
            for j in 0..3 {
                of.closed[j].eps[lane] = -(x * of_slopes[j][c][0] + y * of_slopes[j][c][1]);
            }
        }
        for k in 0..vertices.len() {
            if let PolygonBorder::Primary(_) = vertices[k].border {
                self.add_edge([&vertices[k], &vertices[(k + 1) % vertices.len()]], weights, &mut of);
            }
        }
        of
    }

    /// Adds the derivatives of the integrals by way of a primary edge.
    #[inline(always)]
    fn add_edge(&self, ends: [&Vertex<f64>; 2], weights: &[f64; 3], of: &mut Moments<OfPrimary, OfPrimary>) {
        let outward = outward(ends);
        for (t, share) in GAUSS {
            let [l, m] = on_edge(ends, t);
            let mut moved = [0.0; 6];
            for lane in 0..6 {
                moved[lane] = share * m[lane / 2] * outward[lane % 2];
            }
            let (mut own, mut other) = ([0.0; 6], [0.0; 10]);
            let weight = weights[0] * l[0] + weights[1] * l[1] + weights[2] * l[2];
            add_moments(&mut own, weight, [l[1], l[2]]);
            add_moments(&mut other, weight, [m[1], m[2]]);
            let closed = self.at(&[l, m]);
            for lane in 0..6 {
                for term in 0..6 {
                    of.own[term].eps[lane] += own[term] * moved[lane];
                }
                for term in 0..10 {
                    of.other[term].eps[lane] += other[term] * moved[lane];
                }
                for j in 0..3 {
                    of.closed[j].eps[lane] += closed * l[j] * moved[lane];
                }
            }
        }
    }

    /// Integrals of `W f dC` over an edge, as [`Closing::along_edge`], for the derivatives `dC` with respect to the tilt; integrals of
    /// `-W dC` over the polygon are those of [`Closing::tilting`].
    #[inline(always)]
    pub fn along_edge_by_tilts(&self, ends: [&Vertex<f64>; 2], weight: [f64; 2]) -> [[f64; 2]; 3] {
        let mut sums = [[0.0; 2]; 3];
        for (t, share) in GAUSS {
            let [_, [_, x, y]] = on_edge(ends, t);
            let (height, rises) = (self.heights[1].at([x, y]), self.heights[1].rises());
            let part = (weight[0] * (1.0 - t) + weight[1] * t) * height * share;
            let [by_x, by_y] = rises.map(|of| of[0] + of[1] * x + of[2] * y);
            for (sum, part) in sums.iter_mut().zip([-part, part * by_x, part * by_y]) {
                sum[0] += part * (1.0 - t);
                sum[1] += part * t;
            }
        }
        sums
    }

    /// Integrals of `W f dC` over an edge, as [`Closing::along_edge`], for the derivatives `dC` with respect to `ln s_1` and `ln s_2`.
    #[inline(always)]
    pub fn along_edge_by_stretches(&self, ends: [&Vertex<f64>; 2], weight: [f64; 2]) -> [[f64; 2]; 2] {
        let mut sums = [[0.0; 2]; 2];
        let e = &self.factor;
        for (t, share) in GAUSS {
            let [[_, l_1, l_2], [_, x, y]] = on_edge(ends, t);
            let weight = (weight[0] * (1.0 - t) + weight[1] * t) * share;
            let factor = 2.0 * (e[0] + e[1] * x + e[2] * y) - self.upright;
            let parts = [weight * self.heights[0].at([l_1, l_2]), weight * self.heights[1].at([x, y]) * factor];
            for (sum, part) in sums.iter_mut().zip(parts) {
                sum[0] += part * (1.0 - t);
                sum[1] += part * t;
            }
        }
        sums
    }
}

impl<T: Number> Closing<T> {
    /// Closed part `C` of the gap at a point.
    #[inline(always)]
    fn at(&self, [l, m]: &PerTriangle<T>) -> T {
        let e = &self.factor;
        self.heights[0].at([l[1], l[2]]) + self.heights[1].at([m[1], m[2]]) * (m[1] * e[1] + m[2] * e[2] + e[0])
    }

    /// Integrals `int C N_j dA` over a polygon.
    #[inline(always)]
    pub fn closed(&self, vertices: &[Vertex<T>]) -> [T; 3] {
        let mut closed = [T::from(0.0); 3];
        for k in 1..vertices.len() - 1 {
            for (at, share) in &POINTS {
                let shapes = shapes([&vertices[0], &vertices[k], &vertices[k + 1]], at);
                let part = self.at(&shapes) * (vertices[k].fan * (0.5 * share));
                closed[0] += part;
                closed[1] += part * shapes[0][1];
                closed[2] += part * shapes[0][2];
            }
        }
        closed[0] += -(closed[1] + closed[2]);
        closed
    }

    /// Integrals over a polygon.
    #[inline(always)]
    pub fn moments<W, R>(&self, vertices: &[Vertex<T>], weights: &[W; 3]) -> Moments<T, R>
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
        Moments { own, other, closed }
    }

    /// `A`, and the components of `Q` along the gradients of the second and third shape function, for [`Tilt::forces`].
    #[inline(always)]
    pub fn tilting<R: Number>(&self, other: &Moments<T, R>) -> [R; 3] {
        let (rises, height, other) = (self.heights[1].rises(), &self.heights[1].0, &other.other);
        let mut tilting = [R::from(0.0); 3];
        for term in 0..6 {
            tilting[0] += other[term] * height[term];
            for i in 0..2 {
                let [a, by_x, by_y] = rises[i];
                let [x, y] = [TIMES[0][term], TIMES[1][term]];
                tilting[1 + i] += (other[term] * a + other[x] * by_x + other[y] * by_y) * -height[term];
            }
        }
        tilting
    }

    /// Integral `int W B_1 dA` of the secondary profile.
    #[inline(always)]
    pub fn secondary<R: Number>(&self, moments: &Moments<T, R>) -> R {
        self.heights[0].integral(&moments.own, [0, 1, 2, 3, 4, 5])
    }

    /// Plane vector from its components along the gradients of the second and third shape function of a side.
    #[inline(always)]
    fn along<R: Number + Mul<T, Output = R>>(&self, side: usize, parts: [R; 2]) -> [R; 2] {
        let [_, b, c] = self.gradients[side];
        [parts[0] * b[0] + parts[1] * c[0], parts[0] * b[1] + parts[1] * c[1]]
    }

    /// Adds the forces of the profiles on a polygon for a constant tilt, without those of its edges.
    #[inline(always)]
    pub fn forces_into<W, R>(&self, moments: &Moments<T, R>, weights: &[W; 3], forces: &mut Forces<R>)
    where
        W: Copy + Mul<T, Output = R>,
        R: Number + Mul<T, Output = R>,
    {
        let weight_slope = slope_of(&self.gradients[0], weights);
        let mut of_slopes = [[[R::from(0.0); 2]; 3]; 2];
        for i in 0..2 {
            let ([a, by_x, by_y], own) = (self.heights[0].rises()[i], &moments.own);
            let of = |places: [usize; 3]| own[places[0]] * a + own[places[1]] * by_x + own[places[2]] * by_y;
            let [whole, of_x, of_y] = [of([0, 1, 2]), of([1, 3, 4]), of([2, 4, 5])];
            let mut slope = Quadratic::product(&self.heights[1].rises()[i], &self.factor);
            for term in 0..6 {
                slope.0[term] -= self.tilts[i] * self.heights[1].0[term];
            }
            let [own, other] = [[whole - of_x - of_y, of_x, of_y], slope.by_shapes(&moments.other)];
            for j in 0..3 {
                of_slopes[0][j][i] = own[j];
                of_slopes[1][j][i] = other[j];
            }
        }
        for j in 0..3 {
            let parts = [self.along(0, of_slopes[0][j]), self.along(1, of_slopes[1][j])];
            forces.open[j] -= moments.closed[j].re();
            for i in 0..2 {
                forces.of_p[0][j][i] += parts[0][i] + weight_slope[i] * moments.closed[j];
                forces.of_p[1][j][i] += parts[1][i];
            }
        }
    }

    /// Integrals of `W C f` over an edge for affine `f`, divided by the edge's length: coefficients of the values of `f` at both ends.
    #[inline(always)]
    pub fn along_edge<R: Number + Mul<T, Output = R>>(&self, ends: [&Vertex<T>; 2], weight: [R; 2]) -> [R; 2] {
        let mut sums = [R::from(0.0); 2];
        for (t, share) in GAUSS {
            let part = (weight[0] * (1.0 - t) + weight[1] * t) * (self.at(&on_edge(ends, t)) * share);
            sums[0] += part * (1.0 - t);
            sums[1] += part * t;
        }
        sums
    }
}
