//! Part of the gap that is closed by the height profiles of two triangles (`profiles.rs`), with derivatives; used by `pair.rs` and
//! `polygon.rs`.
//!
//! With the secondary profile `B(L)`, the polynomials `C_u(M)` of the primary profile (`quartic.rs`), and the slope `m` of the primary
//! triangle relative to the plane of projection,
//!
//! ```text
//! C = B + sum_u f_u C_u,     q_i = mu.grad M_i,  mu = m/(1 + |m|^2/2),  t = |mu|^2                                    [length]
//! f = (1 + t/2 + 3 t^2/8 + 7 t^3/16,  -k q_1,  -k q_2,  q_1^2,  2 q_1 q_2,  q_2^2),    k = 1 + t/2 + t^2/2
//! ```
//!
//! In `mu` the series are those of `(1 + |m|^2)^(1/2)` and `m`; the bounded `mu` keeps steep pairs finite. On a polygon `C` has the fourth
//! degree, so that a rule of degree five and four Gauss points per edge are exact for every subdivision of the polygon. Forces follow from
//! the integrals of the secondary shape functions times monomials in the shape functions of both sides, so that points have few operations.
//!
//! The profiles contribute `-int W C dA` to `Phi`. With `A_u = int W C_u` and `F = sum_u f_u A_u`, the derivatives of this contribution,
//! without those of the polygon's edges (`polygon.rs`), are
//!
//! ```text
//! d/dp_j =   int N_j (W grad B + C grad W) dA
//! d/dp_m =   int W M_m grad C dA + (G.grad M_m) m + q_m Q           d/dh_m = - G.grad M_m
//! Q = sum_i dF/dq_i grad M_i,     G = (d mu/d m)(Q + dF/d mu)
//! ```
//!
//! With the stretches `s_1`, `s_2` (`stretch.rs`) the polynomials are proportional to `s_1` and to `s_2`, `s_2^2`, `s_2^3`: the derivatives
//! with respect to `ln s_1` and `ln s_2` are `-int W B dA` and `-sum_u n_u f_u A_u` with `n = (1, 2, 2, 3, 3, 3)`.

use std::ops::Mul;

use super::facet_tilt::{PerPolynomial, Tilt};
use super::forms::{Form, Quadratic};
use super::products::{FUNCTIONS, GAUSS, Products, TIMES, by_shapes, cubic, integral, monomials, on_edge};
use super::quartic::{Closed, DEGREES, Quartic, TERMS};
use super::vertices::{Forces, OfPrimary, PerTriangle, PolygonBorder, Vertex, outward, slope_of};
use crate::contact::numbers::{Each, Number};

/// Powers of `x` and `y` in the terms of a [`Quartic`] that are `x` and `y` times a term up to the third degree.
const NEXT: [[f64; 2]; 10] =
    [[1.0, 1.0], [2.0, 1.0], [1.0, 2.0], [3.0, 1.0], [2.0, 2.0], [1.0, 3.0], [4.0, 1.0], [3.0, 2.0], [2.0, 3.0], [1.0, 4.0]];

/// Number of the integrals in [`Moments`], padded to whole registers: those of [`FUNCTIONS`] times `W`, and of `C N_j`.
const INTEGRALS: usize = FUNCTIONS + 4;

/// Heights over the two triangles of a polygon.
#[derive(Clone, Copy)]
pub struct Heights<'a> {
    /// Height over the secondary triangle.
    pub own: Form,
    /// Polynomials of the gap that the primary triangle closes in the reference configuration, and the stretch of its facet.
    pub closed: &'a Closed,
    pub stretch: f64,
}

/// Number type of the corners of a polygon with height profiles.
pub trait Coordinate: Number {
    /// Integrals of `C (1 - t)^2`, `C (1 - t) t`, and `C t^2` over an edge, `t` from 0 to 1.
    fn closed(closing: &Closing<'_, Self>, ends: [&Vertex<Self>; 2]) -> [Self; 3];
}

impl Coordinate for f64 {
    #[inline(always)]
    fn closed(closing: &Closing<'_, Self>, ends: [&Vertex<Self>; 2]) -> [Self; 3] {
        let [own, other] = at_gauss_points(ends);
        let closed = closing.own.at(own) + closing.other.at(other);
        [weighed(closed, &SQUARES[0]), weighed(closed, &SQUARES[1]), weighed(closed, &SQUARES[2])]
    }
}

impl Coordinate for OfPrimary {
    #[inline(always)]
    fn closed(closing: &Closing<'_, Self>, ends: [&Vertex<Self>; 2]) -> [Self; 3] {
        let [own, other] = at_gauss_points(ends);
        let (closed, mut of) = (closing.own.at(own) + closing.other.at(other), [OfPrimary::from(0.0); 3]);
        let ([by_x, by_y], [x, y]) = (closing.own.rises(), own);
        let slopes = [
            [x * by_x[1] + y * by_x[2] + by_x[0], x * by_y[1] + y * by_y[2] + by_y[0]],
            [cubic(&closing.rises[0], other), cubic(&closing.rises[1], other)],
        ];
        for place in 0..3 {
            of[place].re = weighed(closed, &SQUARES[place]);
        }
        // A corner that moves has less influence on the points of the edge the farther they are from it.
        for side in 0..2 {
            let (from, to) = (ends[0].shape(side), ends[1].shape(side));
            for i in 0..2 {
                let mut integrals = [0.0; 4];
                for place in 0..4 {
                    integrals[place] = weighed(slopes[side][i], &CUBES[place]);
                }
                for place in 0..3 {
                    for lane in 0..6 {
                        let [of_from, of_to] = [from[1 + i].eps[lane], to[1 + i].eps[lane]];
                        of[place].eps[lane] += integrals[place] * of_from + integrals[place + 1] * of_to;
                    }
                }
            }
        }
        of
    }
}

/// Values at the Gauss points of an edge.
type AtGauss = Each<{ GAUSS.len() }>;

/// Weights of the Gauss points for integrals times `(1 - t)^2`, `(1 - t) t`, `t^2`.
const SQUARES: [[f64; GAUSS.len()]; 3] = {
    let (mut weights, mut point) = ([[0.0; GAUSS.len()]; 3], 0);
    while point < GAUSS.len() {
        let (t, share) = GAUSS[point];
        (weights[0][point], weights[1][point]) = (share * (1.0 - t) * (1.0 - t), share * (1.0 - t) * t);
        weights[2][point] = share * t * t;
        point += 1;
    }
    weights
};

/// Weights of the Gauss points for integrals times `(1 - t)^3`, `(1 - t)^2 t`, `(1 - t) t^2`, `t^3`.
const CUBES: [[f64; GAUSS.len()]; 4] = {
    let (mut weights, mut point) = ([[0.0; GAUSS.len()]; 4], 0);
    while point < GAUSS.len() {
        let t = GAUSS[point].0;
        (weights[0][point], weights[1][point]) = (SQUARES[0][point] * (1.0 - t), SQUARES[1][point] * (1.0 - t));
        (weights[2][point], weights[3][point]) = (SQUARES[2][point] * (1.0 - t), SQUARES[2][point] * t);
        point += 1;
    }
    weights
};

/// Sum of values at the Gauss points times weights.
#[inline(always)]
fn weighed(values: AtGauss, weights: &[f64; GAUSS.len()]) -> f64 {
    let [a, b, c, d] = (values * Each(*weights)).0;
    (a + b) + (c + d)
}

/// Second and third shape function of both triangles at the Gauss points of an edge.
#[inline(always)]
fn at_gauss_points<T: Number>(ends: [&Vertex<T>; 2]) -> [[AtGauss; 2]; 2] {
    let (mut at, [from, to]) = ([[Each([0.0; GAUSS.len()]); 2]; 2], ends);
    for side in 0..2 {
        for i in 0..2 {
            let (a, b) = (from.shape(side)[1 + i].re(), to.shape(side)[1 + i].re());
            for point in 0..GAUSS.len() {
                let t = GAUSS[point].0;
                at[side][i].0[point] = a * (1.0 - t) + b * t;
            }
        }
    }
    at
}

/// Height profiles of the two triangles of a polygon, in the plane of projection, for a constant tilt.
pub struct Closing<'a, T> {
    /// Gradients of the shape functions of both triangles.
    gradients: PerTriangle<[T; 2]>,
    /// Height over the secondary triangle.
    own: Quadratic,
    /// Gap that the primary triangle closes, and its derivatives with respect to the second and third shape function.
    other: Quartic,
    rises: [[f64; 10]; 2],
    /// Polynomials of the primary triangle, their factors `f_u`, and the powers of the stretch by which they are multiplied.
    closed: &'a Closed,
    factors: PerPolynomial<f64>,
    powers: PerPolynomial<f64>,
}

/// Integrals over a polygon from which the forces of profiles are computed.
pub struct Moments<T, R> {
    /// Integrals of `W` times `1, x, y, x^2, x y, y^2` in the second and third shape function of the secondary triangle.
    own: [R; 6],
    /// Integrals of `W` times monomials up to the fourth degree in the second and third shape function of the primary triangle.
    other: [R; TERMS],
    /// Integrals `int C N_j` of the closed gap `C`.
    closed: [T; 3],
}

/// Integral number `term` with its derivatives with respect to the plane coordinates of the primary triangle.
#[inline(always)]
fn with_derivatives(value: f64, derivatives: &[[f64; INTEGRALS]; 6], term: usize) -> OfPrimary {
    let mut of = OfPrimary::from(value);
    for lane in 0..6 {
        of.eps[lane] = derivatives[lane][term];
    }
    of
}

impl<'a> Closing<'a, f64> {
    /// Height profiles of the two triangles of a polygon: gradients of the shape functions of both, tilt of the primary one.
    #[inline(always)]
    pub fn new(gradients: PerTriangle<[f64; 2]>, tilt: &Tilt<f64>, heights: Heights<'a>) -> Self {
        let Heights { own, closed, stretch } = heights;
        let (square, tilted) = (stretch * stretch, tilt.factors());
        let powers = [stretch, square, square, square * stretch, square * stretch, square * stretch];
        let (mut factors, mut other) = ([0.0; 6], Quartic::ZERO);
        for u in 0..6 {
            factors[u] = tilted[u] * powers[u];
            for term in 0..TERMS {
                other.0[term] += factors[u] * closed[u].0[term];
            }
        }
        Closing { gradients, own: Quadratic::of_form(&own), other, rises: other.rises(), closed, factors, powers }
    }

    /// Profiles with derivatives, for a constant tilt.
    #[inline(always)]
    pub fn with_gradients<T>(&self, gradients: PerTriangle<[T; 2]>) -> Closing<'a, T> {
        let Closing { own, other, rises, closed, factors, powers, .. } = *self;
        Closing { gradients, own, other, rises, closed, factors, powers }
    }

    /// Integrals `int C N_j dA` over a polygon.
    #[inline(always)]
    pub fn closed(&self, products: &Products) -> [f64; 3] {
        let mut closed = [0.0; 3];
        for j in 0..3 {
            closed[j] = integral(&self.other, &products.other(j)) + self.own.integral(&products.own(j), [0, 1, 2, 3, 4, 5]);
        }
        closed
    }

    /// Closed part `C` of the gap at a point.
    #[inline(always)]
    fn at(&self, [l, m]: &PerTriangle<f64>) -> f64 {
        self.own.at([l[1], l[2]]) + self.other.at([m[1], m[2]])
    }

    /// Integrals over a polygon with the weight function `W` that has these values at the corners of the secondary triangle.
    #[inline(always)]
    pub fn moments<R: Number>(&self, products: &Products, weights: &[R; 3]) -> Moments<f64, R> {
        let (mut own, mut other) = ([R::from(0.0); 6], [R::from(0.0); TERMS]);
        for a in 0..3 {
            let (of_own, of_other) = (products.own(a), products.other(a));
            for term in 0..6 {
                own[term] += weights[a] * of_own[term];
            }
            for term in 0..TERMS {
                other[term] += weights[a] * of_other[term];
            }
        }
        Moments { own, other, closed: self.closed(products) }
    }

    /// Integrals over a polygon, with derivatives with respect to the plane coordinates of the primary triangle. For a displacement `M_c v`
    /// of this triangle `M_k` changes by `-M_c v.grad M_k`, and the polygon at its primary edges by `M_c v.nu`.
    #[inline(always)]
    pub fn moments_with_derivatives(&self, vertices: &[Vertex<f64>], weights: &[f64; 3]) -> Moments<OfPrimary, OfPrimary> {
        let products = Products::new(vertices);
        let Moments { own, other, closed } = self.moments(&products, weights);
        // Integrals of N_j M_c times the slopes of C, and of W M_c times monomials up to the third degree.
        let (mut of_slopes, mut passed) = ([[[0.0; 3]; 2]; 3], [[0.0; 10]; 3]);
        for j in 0..3 {
            let other = products.other(j);
            of_slopes[j] = [by_shapes(&self.rises[0], &other), by_shapes(&self.rises[1], &other)];
        }
        for term in 0..10 {
            let [x, y] = [other[TIMES[0][term]], other[TIMES[1][term]]];
            (passed[0][term], passed[1][term], passed[2][term]) = (other[term] - x - y, x, y);
        }
        let ([_, by_x, by_y], mut derivatives) = (self.gradients[1], [[0.0; INTEGRALS]; 6]);
        for lane in 0..6 {
            let (c, axis) = (lane / 2, lane % 2);
            let (of, of_c, x, y) = (&mut derivatives[lane], &passed[c], by_x[axis], by_y[axis]);
            for term in 0..10 {
                let [power_of_x, power_of_y] = NEXT[term];
                of[TIMES[0][term]] -= x * power_of_x * of_c[term];
                of[TIMES[1][term]] -= y * power_of_y * of_c[term];
            }
            for j in 0..3 {
                of[FUNCTIONS + j] = -(x * of_slopes[j][0][c] + y * of_slopes[j][1][c]);
            }
        }
        for k in 0..vertices.len() {
            if let PolygonBorder::Primary(_) = vertices[k].border {
                self.add_edge([&vertices[k], &vertices[(k + 1) % vertices.len()]], weights, &mut derivatives);
            }
        }
        let zero = OfPrimary::from(0.0);
        let mut of = Moments { own: [zero; 6], other: [zero; TERMS], closed: [zero; 3] };
        for term in 0..TERMS {
            of.other[term] = with_derivatives(other[term], &derivatives, term);
        }
        of.own[0] = of.other[0];
        for term in 1..6 {
            of.own[term] = with_derivatives(own[term], &derivatives, TERMS - 1 + term);
        }
        for j in 0..3 {
            of.closed[j] = with_derivatives(closed[j], &derivatives, FUNCTIONS + j);
        }
        of
    }

    /// Adds the derivatives of the integrals by way of a primary edge.
    #[inline(always)]
    fn add_edge(&self, ends: [&Vertex<f64>; 2], weights: &[f64; 3], derivatives: &mut [[f64; INTEGRALS]; 6]) {
        let (outward, mut sums) = (outward(ends), [[0.0; INTEGRALS]; 3]);
        for (t, share) in GAUSS {
            let shapes = on_edge(ends, t);
            let ([l, m], monomials, closed) = (shapes, monomials(&shapes), self.at(&shapes));
            let weight = weights[0] * l[0] + weights[1] * l[1] + weights[2] * l[2];
            let mut integrands = [0.0; INTEGRALS];
            for term in 0..FUNCTIONS {
                integrands[term] = weight * monomials[term];
            }
            for j in 0..3 {
                integrands[FUNCTIONS + j] = closed * l[j];
            }
            for c in 0..3 {
                let part = share * m[c];
                for term in 0..INTEGRALS {
                    sums[c][term] += part * integrands[term];
                }
            }
        }
        for lane in 0..6 {
            for term in 0..INTEGRALS {
                derivatives[lane][term] += outward[lane % 2] * sums[lane / 2][term];
            }
        }
    }

    /// Integrals of `W f dC` over an edge, as [`Closing::along_edge`], for the derivatives `dC` with respect to parameters: minus those of
    /// the polynomials of the primary triangle (integrals of `W C_u` over the polygon are those of [`Closing::tilting`]), and those with
    /// respect to `ln s_1` and `ln s_2`.
    #[inline(always)]
    pub fn along_edge_by_parameters(&self, ends: [&Vertex<f64>; 2], weight: [f64; 2]) -> [[f64; 2]; 8] {
        let (mut sums, mut parts) = ([[0.0; FUNCTIONS]; 2], [[0.0; 2]; 8]);
        for (t, share) in GAUSS {
            let monomials = monomials(&on_edge(ends, t));
            let part = (weight[0] * (1.0 - t) + weight[1] * t) * share;
            for term in 0..FUNCTIONS {
                sums[0][term] += part * (1.0 - t) * monomials[term];
                sums[1][term] += part * t * monomials[term];
            }
        }
        let products = Products([sums[0], sums[1], [0.0; FUNCTIONS]]);
        for end in 0..2 {
            let other = products.other(end);
            parts[6][end] = self.own.integral(&products.own(end), [0, 1, 2, 3, 4, 5]);
            for u in 0..6 {
                let closed = integral(&self.closed[u], &other);
                parts[u][end] = -self.powers[u] * closed;
                parts[7][end] += DEGREES[u] * self.factors[u] * closed;
            }
        }
        parts
    }
}

impl<T: Number> Closing<'_, T> {
    /// Integrals `A_u` for [`Tilt::forces`].
    #[inline(always)]
    pub fn tilting<R: Number>(&self, moments: &Moments<T, R>) -> PerPolynomial<R> {
        let mut tilting = [R::from(0.0); 6];
        for u in 0..6 {
            tilting[u] = integral(&self.closed[u], &moments.other) * self.powers[u];
        }
        tilting
    }

    /// Integral `int W B dA` of the secondary profile.
    #[inline(always)]
    pub fn secondary<R: Number>(&self, moments: &Moments<T, R>) -> R {
        self.own.integral(&moments.own, [0, 1, 2, 3, 4, 5])
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
            let ([a, by_x, by_y], own) = (self.own.rises()[i], &moments.own);
            let of = |places: [usize; 3]| own[places[0]] * a + own[places[1]] * by_x + own[places[2]] * by_y;
            let [whole, of_x, of_y] = [of([0, 1, 2]), of([1, 3, 4]), of([2, 4, 5])];
            let [own, other] = [[whole - of_x - of_y, of_x, of_y], by_shapes(&self.rises[i], &moments.other)];
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
    pub fn along_edge<R: Number + Mul<T, Output = R>>(&self, ends: [&Vertex<T>; 2], weight: [R; 2]) -> [R; 2]
    where
        T: Coordinate,
    {
        let closed = T::closed(self, ends);
        [weight[0] * closed[0] + weight[1] * closed[1], weight[0] * closed[1] + weight[1] * closed[2]]
    }
}
