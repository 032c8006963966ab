//! Overlap polygons of a facet pair: a primary triangle clipped by a secondary one, with the shape functions of both, and their
//! contributions to the derivatives of `Phi = int W g dA` with `W = sum w_A N_A` (`pair.rs`).
//!
//! The gradient is that of a moving domain. With the gap `g` and the shape functions `N_j` and `M_m` of the triangles
//!
//! ```text
//! d/dh_m =  int W M_m dA               d/dp_m = - grad h_primary   int W M_m dA                       + sum_edges nu int W g M_m ds
//! d/dh_j = -int W N_j dA               d/dp_j =   grad h_secondary int W N_j dA - grad W int g N_j dA + sum_edges nu int W g N_j ds
//! ```
//!
//! over the polygon edges (normals `nu`) on the triangle's own border. At nearly coinciding edges of both triangles these forces pass
//! gradually from one to the other, which removes the kink of the gradient; a discrete gradient is exact for any gradient that it corrects.
//! Forces on edges between triangles of one facet are left out between flat triangles: those of both polygons there cancel.
//!
//! All called functions are inlined and arrays are filled by loops; otherwise they are compiled without the wide registers of the caller.

use std::ops::Mul;

use super::clipping::{Corner, VERTICES, area, clip};
use super::closing::{Closing, Coordinate, Heights, Moments};
use super::facet_tilt::Tilt;
use super::vertices::{Forces, NODES, OfPrimary, PerTriangle, PolygonBorder, Vertex, outward, shape_gradients, sides, slope, slope_of};
use crate::contact::numbers::Number;
use crate::math::tolerances::FACING_AREA;

/// Part of a primary triangle inside of a secondary one.
#[derive(Clone)]
pub struct Polygon<T> {
    /// Point indices of the triangles' corners.
    pub corners: PerTriangle<usize>,
    /// Twice the areas of the triangles.
    pub areas: [T; 2],
    vertices: [Vertex<T>; VERTICES],
    count: usize,
}

/// Shape functions of a triangle at a point; `inverse` is 1 over twice its area.
#[inline(always)]
pub fn shares<T: Number>([a, b, c]: &[[T; 2]; 3], inverse: T, p: &[T; 2]) -> [T; 3] {
    [area(b, c, p) * inverse, area(c, a, p) * inverse, area(a, b, p) * inverse]
}

/// Integrals of `W g f` over an edge for affine `f`, divided by the edge's length: coefficients of the values of `f` at both ends.
#[inline(always)]
fn along_edge<T: Copy, R: Number + Mul<T, Output = R>>(weight: [R; 2], gap: [T; 2]) -> [R; 2] {
    let (aa, bb) = (weight[0] * gap[0], weight[1] * gap[1]);
    let ab = weight[0] * gap[1] + weight[1] * gap[0];
    [(aa * 3.0 + ab + bb) * (1.0 / 12.0), (aa + ab + bb * 3.0) * (1.0 / 12.0)]
}

/// Triangle to which the force of a polygon edge belongs (0: secondary, 1: primary); `share`: part of the force that belongs to the other
/// triangle.
pub struct EdgeOwner<T> {
    side: usize,
    share: Option<T>,
}

/// Gap at a corner of a polygon, from heights at the corners of the triangles.
#[inline(always)]
fn gap_at<T: Number>(vertex: &Vertex<T>, [below, above]: &PerTriangle<f64>) -> T {
    let [own, other] = [vertex.of_secondary, vertex.of_primary];
    other[0] * above[0] + other[1] * above[1] + other[2] * above[2] - (own[0] * below[0] + own[1] * below[1] + own[2] * below[2])
}

/// Weight function at a corner of a polygon, from its values at the corners of the secondary triangle.
#[inline(always)]
fn weight_at<T: Number, W: Copy + Mul<T, Output = R>, R: Number>(vertex: &Vertex<T>, weights: &[W; 3]) -> R {
    let shape = vertex.of_secondary;
    weights[0] * shape[0] + weights[1] * shape[1] + weights[2] * shape[2]
}

/// Distributes the force of an edge, given by its coefficients at both ends, to the corners of triangle `side`.
#[inline(always)]
fn push<T: Copy, R: Number + Mul<T, Output = R>>(
    of_p: &mut [[R; 2]; 3],
    ends: [&Vertex<T>; 2],
    side: usize,
    outward: [T; 2],
    edge: [R; 2],
) {
    let (from, to) = (ends[0].shape(side), ends[1].shape(side));
    for j in 0..3 {
        let moved = edge[0] * from[j] + edge[1] * to[j];
        of_p[j][0] += moved * outward[0];
        of_p[j][1] += moved * outward[1];
    }
}

impl<T: Number> Polygon<T> {
    /// Empty polygon, to be filled by [`Polygon::set`].
    #[inline(always)]
    pub fn empty() -> Self {
        let zero = T::from(0.0);
        let (border, is_inner) = (PolygonBorder::Primary(0), false);
        let vertex = Vertex { p: [zero; 2], of_secondary: [zero; 3], of_primary: [zero; 3], border, is_inner, fan: zero };
        Polygon { corners: [[0; 3]; 2], areas: [zero; 2], vertices: [vertex; VERTICES], count: 0 }
    }

    /// Clips a primary triangle by a secondary one, given by point indices and plane coordinates of their corners; `false` without overlap
    /// or for triangles that do not face each other.
    #[inline(always)]
    pub fn set(&mut self, corners: PerTriangle<usize>, places: &PerTriangle<[T; 2]>) -> bool {
        let [[s_0, s_1, s_2], [m_0, m_1, m_2]] = places;
        let areas = [area(s_0, s_1, s_2), area(m_0, m_1, m_2)];
        if areas[0].re() <= 0.0 || areas[1].re() <= FACING_AREA * areas[0].re() {
            return false;
        }
        // The third corner may be the mean point of a facet, between whose triangles the second and the third side lie.
        let [on_secondary, on_primary] = [corners[0][2] >= NODES, corners[1][2] >= NODES];
        let corner = |p: &[T; 2], side: u8, is_inner: bool| Corner { p: *p, border: PolygonBorder::Primary(side), is_inner };
        let mut first = [corner(m_0, 0, false); VERTICES];
        (first[1], first[2]) = (corner(m_1, 1, on_primary), corner(m_2, 2, on_primary));
        let mut second = first;
        let (mut now, mut next, mut count) = (&mut first, &mut second, 3);
        for (start, from, to, is_inner) in [(0, s_0, s_1, false), (1, s_1, s_2, on_secondary), (2, s_2, s_0, on_secondary)] {
            let (mut side, mut is_cut) = ([T::from(0.0); VERTICES], false);
            for k in 0..count {
                side[k] = area(from, to, &now[k].p);
                is_cut |= side[k].re() < 0.0;
            }
            if is_cut {
                count = clip(&now[..count], &side, (PolygonBorder::Secondary(start), is_inner), next);
                std::mem::swap(&mut now, &mut next);
            }
            if count < 3 {
                return false;
            }
        }
        let inverse = [areas[0].recip(), areas[1].recip()];
        (self.corners, self.areas, self.count) = (corners, areas, count);
        for k in 0..count {
            let (vertex, p) = (&mut self.vertices[k], &now[k].p);
            (vertex.p, vertex.border, vertex.is_inner) = (*p, now[k].border, now[k].is_inner);
            vertex.of_secondary = shares(&places[0], inverse[0], p);
            vertex.of_primary = shares(&places[1], inverse[1], p);
            vertex.fan = area(&now[0].p, p, &now[if k + 1 == count { 0 } else { k + 1 }].p);
        }
        true
    }

    /// Corners of the polygon.
    #[inline(always)]
    pub fn vertices(&self) -> &[Vertex<T>] {
        &self.vertices[..self.count]
    }

    /// Edge that starts at corner `k`, and the indices of its ends.
    #[inline(always)]
    fn edge(&self, k: usize) -> ([&Vertex<T>; 2], [usize; 2]) {
        let next = if k + 1 == self.count { 0 } else { k + 1 };
        ([&self.vertices[k], &self.vertices[next]], [k, next])
    }

    /// Triangles that bear the force of an edge: the one on whose border the edge lies, and in part the other one if its border is nearer
    /// than `band` times its height; half each where both coincide. This makes the forces continuous, without resultant or moment.
    #[inline(always)]
    fn bearer(&self, ends: [&Vertex<T>; 2], band: f64) -> EdgeOwner<T> {
        let side = if matches!(ends[0].border, PolygonBorder::Secondary(_)) { 0 } else { 1 };
        if band <= 0.0 {
            return EdgeOwner { side, share: None };
        }
        let [a, b] = [ends[0].shape(1 - side), ends[1].shape(1 - side)];
        let mut nearest = 0;
        for j in 1..3 {
            if a[j].re() + b[j].re() < a[nearest].re() + b[nearest].re() {
                nearest = j;
            }
        }
        let depth = (a[nearest] + b[nearest]) * 0.5;
        if depth.re() >= band {
            return EdgeOwner { side, share: None };
        }
        let near = T::from(1.0) - depth * (1.0 / band);
        EdgeOwner { side, share: Some(near * near * 0.5) }
    }

    /// Integral of the product of two affine functions as a linear form: returns the coefficients of the corner values of one function,
    /// given the corner values `other` of the other function. Exact.
    #[inline(always)]
    pub fn counting<R: Number + Mul<T, Output = R>>(&self, other: &[R; VERTICES]) -> [R; VERTICES] {
        let mut counts = [R::from(0.0); VERTICES];
        for k in 1..self.count - 1 {
            let fan = self.vertices[k].fan * (1.0 / 24.0);
            let sum = other[0] + other[k] + other[k + 1];
            for place in [0, k, k + 1] {
                counts[place] += (sum + other[place]) * fan;
            }
        }
        counts
    }

    /// Integrals of an affine function, given by [`Polygon::counting`], times the shape functions of a triangle.
    #[inline(always)]
    pub fn integrals<R: Number + Mul<T, Output = R>>(&self, counts: &[R; VERTICES], side: usize) -> [R; 3] {
        let mut integrals = [R::from(0.0); 3];
        for (k, vertex) in self.vertices().iter().enumerate() {
            let shape = vertex.shape(side);
            for j in 0..3 {
                integrals[j] += counts[k] * shape[j];
            }
        }
        integrals
    }

    /// Gaps at the corners, from heights at the corners of the triangles.
    #[inline(always)]
    pub fn gaps(&self, heights: &PerTriangle<f64>) -> [T; VERTICES] {
        let mut gaps = [T::from(0.0); VERTICES];
        for (k, vertex) in self.vertices().iter().enumerate() {
            gaps[k] = gap_at(vertex, heights);
        }
        gaps
    }

    /// Weight function at the corners of the polygon, from its values at the corners of the secondary triangle.
    #[inline(always)]
    fn weights<W: Copy + Mul<T, Output = R>, R: Number>(&self, weights: &[W; 3]) -> [R; VERTICES] {
        let mut at = [R::from(0.0); VERTICES];
        for (k, vertex) in self.vertices().iter().enumerate() {
            at[k] = weight_at(vertex, weights);
        }
        at
    }

    /// Contribution to the derivatives of `Phi`, from plane coordinates, heights and (secondary) weights at the triangles' corners, for a
    /// constant tilt of the height profiles.
    #[inline(always)]
    pub fn forces<W, R>(
        &self,
        places: &PerTriangle<[T; 2]>,
        heights: &PerTriangle<f64>,
        closing: &Option<(Closing<'_, T>, Moments<T, R>)>,
        weights: &[W; 3],
        band: f64,
    ) -> Forces<R>
    where
        T: Coordinate,
        W: Copy + Mul<T, Output = R>,
        R: Number + Mul<T, Output = R>,
        f64: Mul<T, Output = T>,
    {
        let (weight, gap) = (self.weights(weights), self.gaps(heights));
        let (of_weight, of_gap) = (self.counting(&weight), self.counting(&gap));
        let inverse = [self.areas[0].recip(), self.areas[1].recip()];
        let (own, other) = (sides(&places[0]), sides(&places[1]));
        let weight_slope: [R; 2] = slope(&own, inverse[0], weights);
        let rises: [[T; 2]; 2] = [slope(&own, inverse[0], &heights[0]), slope(&other, inverse[1], &heights[1])];
        let (on_own, on_other, open) = (self.integrals(&of_weight, 0), self.integrals(&of_weight, 1), self.integrals(&of_gap, 0));
        let zero = R::from(0.0);
        let mut forces = Forces { open: [open[0].re(), open[1].re(), open[2].re()], of_p: [[[zero; 2]; 3]; 2], of_h: [[zero; 3]; 2] };
        for j in 0..3 {
            forces.of_h[0][j] = -on_own[j];
            forces.of_h[1][j] = on_other[j];
            for i in 0..2 {
                forces.of_p[0][j][i] = on_own[j] * rises[0][i] - weight_slope[i] * open[j];
                forces.of_p[1][j][i] = -(on_other[j] * rises[1][i]);
            }
        }
        if let Some((closing, moments)) = closing {
            closing.forces_into(moments, weights, &mut forces);
        }
        self.edges_into(heights, closing, weights, band, &mut forces);
        forces
    }

    /// Adds the forces of the edges.
    #[inline(always)]
    pub fn edges_into<W, R>(
        &self,
        heights: &PerTriangle<f64>,
        closing: &Option<(Closing<'_, T>, Moments<T, R>)>,
        weights: &[W; 3],
        band: f64,
        forces: &mut Forces<R>,
    ) where
        T: Coordinate,
        W: Copy + Mul<T, Output = R>,
        R: Number + Mul<T, Output = R>,
    {
        for k in 0..self.count {
            let (ends, _) = self.edge(k);
            if ends[0].is_inner && closing.is_none() {
                continue;
            }
            let outward = outward(ends);
            let weight = [weight_at(ends[0], weights), weight_at(ends[1], weights)];
            let mut edge = along_edge(weight, [gap_at(ends[0], heights), gap_at(ends[1], heights)]);
            if let Some((closing, _)) = closing {
                let closed = closing.along_edge(ends, weight);
                edge[0] -= closed[0];
                edge[1] -= closed[1];
            }
            let EdgeOwner { side, share } = self.bearer(ends, band);
            match share {
                Some(share) => {
                    let passed = [edge[0] * share, edge[1] * share];
                    push(&mut forces.of_p[side], ends, side, outward, [edge[0] - passed[0], edge[1] - passed[1]]);
                    push(&mut forces.of_p[1 - side], ends, 1 - side, outward, passed);
                }
                None => push(&mut forces.of_p[side], ends, side, outward, edge),
            }
        }
    }
}

impl Polygon<OfPrimary> {
    /// Copies the edges of a polygon with the derivatives of their ends; without `all`, edges between two triangles of one facet are left
    /// out. A corner of the primary triangle moves with it; where sides of both triangles cross, the corner moves along the secondary side.
    /// Areas are not copied.
    #[inline(always)]
    pub fn follow(&mut self, polygon: &Polygon<f64>, own: &[[f64; 2]; 3], gradients: &PerTriangle<[f64; 2]>, all: bool) {
        const LANES: usize = 6;
        (self.corners, self.count) = (polygon.corners, polygon.count);
        let (mut border, mut is_inner) = (polygon.vertices[polygon.count - 1].border, polygon.vertices[polygon.count - 1].is_inner);
        for k in 0..polygon.count {
            let (from, to) = (&polygon.vertices[k], &mut self.vertices[k]);
            (to.border, to.is_inner) = (from.border, from.is_inner);
            let is_left_out = !all && is_inner && from.is_inner;
            is_inner = from.is_inner;
            if is_left_out {
                border = from.border;
                continue;
            }
            // Displacement of the corner for a displacement of the primary triangle there.
            let moved = match (border, from.border) {
                (PolygonBorder::Secondary(_), PolygonBorder::Secondary(_)) => [[0.0; 2]; 2],
                (PolygonBorder::Primary(_), PolygonBorder::Primary(_)) => [[1.0, 0.0], [0.0, 1.0]],
                (PolygonBorder::Secondary(on), PolygonBorder::Primary(by)) | (PolygonBorder::Primary(by), PolygonBorder::Secondary(on)) => {
                    // The shape function of the opposite corner is zero along a side.
                    let (along, across) = (own[(usize::from(on) + 2) % 3], gradients[1][(usize::from(by) + 2) % 3]);
                    let product = along[0] * across[0] + along[1] * across[1];
                    // Parallel sides have no crossing; a corner between them stays.
                    let inverse = if product == 0.0 { 0.0 } else { product.recip() };
                    let [x, y] = [along[0] * inverse, along[1] * inverse];
                    [[x * across[0], x * across[1]], [y * across[0], y * across[1]]]
                }
            };
            border = from.border;
            for i in 0..2 {
                to.p[i].re = from.p[i];
                for lane in 0..LANES {
                    to.p[i].eps[lane] = from.of_primary[lane / 2] * moved[i][lane % 2];
                }
            }
            for j in 0..3 {
                (to.of_secondary[j].re, to.of_primary[j].re) = (from.of_secondary[j], from.of_primary[j]);
                for lane in 0..LANES {
                    let (x, y) = (to.p[0].eps[lane], to.p[1].eps[lane]);
                    to.of_secondary[j].eps[lane] = gradients[0][j][0] * x + gradients[0][j][1] * y;
                    let [of_x, of_y] = gradients[1][j];
                    to.of_primary[j].eps[lane] = of_x * x + of_y * y - from.of_primary[lane / 2] * gradients[1][j][lane % 2];
                }
            }
        }
    }
}

/// Derivatives of forces with respect to the heights of six corners, the factors of the polynomials of the closed gap, and the logarithms
/// of both facets' stretches, see [`Polygon::passed`].
pub type OfHeights = [f64; 14];

impl Polygon<f64> {
    /// Height profiles of both triangles, and the tilt of the primary one.
    #[inline(always)]
    pub fn closing<'a>(
        &self,
        places: &PerTriangle<[f64; 2]>,
        heights: &PerTriangle<f64>,
        curved: Heights<'a>,
    ) -> (Closing<'a, f64>, Tilt<f64>) {
        let gradients = [shape_gradients(&places[0], self.areas[0]), shape_gradients(&places[1], self.areas[1])];
        let tilt = Tilt::new(gradients[1], &heights[1]);
        (Closing::new(gradients, &tilt, curved), tilt)
    }

    /// Forces of a polygon of flat triangles without those of its edges, with their derivatives. For a displacement `M_c v` of the primary
    /// triangle `M_m` changes by `-M_c v.grad M_m`, the gap by `-M_c v.grad h_primary`, and the polygon at its primary edges by `M_c v.nu`.
    #[inline(always)]
    pub fn moved_forces(&self, gradients: &PerTriangle<[f64; 2]>, heights: &PerTriangle<f64>, weights: &[f64; 3]) -> Forces<OfPrimary> {
        let (weight, gap): ([f64; VERTICES], _) = (self.weights(weights), self.gaps(heights));
        let (of_weight, of_gap) = (self.counting(&weight), self.counting(&gap));
        let (on_own, on_other, open) = (self.integrals(&of_weight, 0), self.integrals(&of_weight, 1), self.integrals(&of_gap, 0));
        let weight_slope: [f64; 2] = slope_of(&gradients[0], weights);
        let rises: [[f64; 2]; 2] = [slope_of(&gradients[0], &heights[0]), slope_of(&gradients[1], &heights[1])];
        let mut integrals = [[OfPrimary::from(0.0); 3]; 3];
        let mut rise = [OfPrimary::from(rises[1][0]), OfPrimary::from(rises[1][1])];
        for j in 0..3 {
            let mut shape = [0.0; VERTICES];
            shape.iter_mut().zip(self.vertices()).for_each(|(shape, vertex)| *shape = vertex.of_secondary[j]);
            let products = self.integrals(&self.counting(&shape), 1);
            (integrals[0][j].re, integrals[1][j].re, integrals[2][j].re) = (on_own[j], on_other[j], open[j]);
            for lane in 0..6 {
                let (c, a) = (lane / 2, lane % 2);
                integrals[1][j].eps[lane] = -gradients[1][j][a] * on_other[c];
                integrals[2][j].eps[lane] = -rises[1][a] * products[c];
            }
        }
        for lane in 0..6 {
            for i in 0..2 {
                rise[i].eps[lane] = -gradients[1][lane / 2][i] * rises[1][lane % 2];
            }
        }
        for k in 0..self.count {
            let (ends, [a, b]) = self.edge(k);
            let PolygonBorder::Primary(_) = ends[0].border else { continue };
            let (out, weight, gap) = (outward(ends), [weight[a], weight[b]], [gap[a], gap[b]]);
            let (mut from, mut to) = ([0.0; 6], [0.0; 6]);
            for lane in 0..6 {
                from[lane] = ends[0].of_primary[lane / 2] * out[lane % 2];
                to[lane] = ends[1].of_primary[lane / 2] * out[lane % 2];
            }
            for j in 0..3 {
                let own = [ends[0].of_secondary[j], ends[1].of_secondary[j]];
                let other = [ends[0].of_primary[j], ends[1].of_primary[j]];
                let parts = [along_edge(weight, own), along_edge(weight, other), along_edge(gap, own)];
                for (integrals, part) in integrals.iter_mut().zip(parts) {
                    for lane in 0..6 {
                        integrals[j].eps[lane] += part[0] * from[lane] + part[1] * to[lane];
                    }
                }
            }
        }
        let (zero, [on_own, on_other, open]) = (OfPrimary::from(0.0), integrals);
        let mut forces = Forces { open: [0.0; 3], of_p: [[[zero; 2]; 3]; 2], of_h: [[zero; 3]; 2] };
        for j in 0..3 {
            (forces.of_h[0][j], forces.of_h[1][j]) = (-on_own[j], on_other[j]);
            for i in 0..2 {
                forces.of_p[0][j][i] = on_own[j] * rises[0][i] - open[j] * weight_slope[i];
                forces.of_p[1][j][i] = -(on_other[j] * rise[i]);
            }
        }
        forces
    }

    /// Derivatives of the forces that pass gradually between edges within the band, with respect to heights, tilts and stretches; `None`
    /// without such forces.
    #[inline(always)]
    pub fn passed(&self, closing: Option<&Closing<'_, f64>>, weights: &[f64; 3], band: f64) -> Option<[OfHeights; 12]> {
        let passes = |k: usize| !(self.vertices[k].is_inner && closing.is_none()) && self.bearer(self.edge(k).0, band).share.is_some();
        // No closure, which would be compiled without the wide registers.
        if (0..self.count).any(passes) { Some(self.passed_forces(closing, weights, band)) } else { None }
    }

    /// Derivatives of [`Polygon::passed`].
    #[inline(always)]
    fn passed_forces(&self, closing: Option<&Closing<'_, f64>>, weights: &[f64; 3], band: f64) -> [OfHeights; 12] {
        let mut passed = [OfHeights::default(); 12];
        let weight: [f64; VERTICES] = self.weights(weights);
        for k in 0..self.count {
            let (ends, [a, b]) = self.edge(k);
            if ends[0].is_inner && closing.is_none() {
                continue;
            }
            let EdgeOwner { side, share: Some(share) } = self.bearer(ends, band) else { continue };
            let weight = [weight[a], weight[b]];
            let mut edges = [[0.0; 2]; 14];
            for (column, (from, up)) in [(0, -share), (1, share)].into_iter().flat_map(|of| [of; 3]).enumerate() {
                edges[column] = along_edge(weight, ends.map(|end| up * end.shape(from)[column % 3]));
            }
            if let Some(closing) = closing {
                for (edge, of_edge) in edges[6..].iter_mut().zip(closing.along_edge_by_parameters(ends, weight)) {
                    *edge = of_edge.map(|part| -share * part);
                }
            }
            for (column, edge) in edges.into_iter().enumerate() {
                for (side, edge) in [(side, edge.map(|part| -part)), (1 - side, edge)] {
                    let mut of_p = [[0.0; 2]; 3];
                    push(&mut of_p, ends, side, outward(ends), edge);
                    for (row, force) in passed[6 * side..].iter_mut().zip(of_p.as_flattened()) {
                        row[column] += force;
                    }
                }
            }
        }
        passed
    }
}
