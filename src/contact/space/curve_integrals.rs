//! Integrals of an overlap polygon for the weights along the normal of curved facets (`curve_slip.rs`), and their derivatives with respect
//! to the corners of both triangles.
//!
//! With the shape functions `N_a` of the secondary and `M_c` of the primary triangle, `s` one of them, the height profiles `B_1`, `B_2` and
//! components `i`, `e` in the plane, the integrals over a polygon are
//!
//! ```text
//! v_asi = f_asi - H_a grad_i s  (s secondary),    v_asi = f_asi + K_a grad_i s  (s primary)
//! f_asi = int N_a s grad_i B_1 dA,    H_a = int N_a B_1 dA,    K_a = int N_a B_2 dA
//! ```
//!
//! A corner `m` that moves along `e` carries the functions of its triangle with it, at a fixed point by `-N_m grad_e`, and the edges on the
//! border of its triangle:
//!
//! ```text
//! d f_asi/dp_me = - grad_e N_a f_msi - grad_e s f_ami (s secondary) - grad_i N_m f_ase - grad_i grad_e B_1 int N_a N_m s dA + edges
//! d f_asi/dp_me = - grad_e s f_ami (s primary) + edges                                                          (m primary)
//! d grad_i s/dp_me = - grad_e s grad_i m        (s, m of one triangle)
//! edges = sum int N_a s grad_i B_1 w ds         w = m nu_e: normal velocity of the edges on the border of the triangle of m
//! ```
//!
//! All integrals of the interior are of third degree, those along edges of fourth. Slopes of height profiles jump between the triangles of
//! a facet, so that edges there count. Where edges of both triangles coincide, `w` is that of a polygon that is clipped with numbers that
//! carry derivatives (as in `weights.rs`).

use std::ops::Range;

use super::forms::{Form, derivatives, value};
use super::polygon::Polygon;
use super::vertices::{PerTriangle, PolygonBorder, Vertex, outward, shape_gradients};
use super::weights::{Edges, OfCorners, SHAPES, Slopes, carrying, coincides};
use crate::contact::numbers::Number;

/// Quadrature points of a triangle (area coordinates) and weights, exact to degree three.
pub const CUBIC: [([f64; 3], f64); 4] = [
    ([1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], -0.5625),
    ([0.6, 0.2, 0.2], 0.520_833_333_333_333_3),
    ([0.2, 0.6, 0.2], 0.520_833_333_333_333_3),
    ([0.2, 0.2, 0.6], 0.520_833_333_333_333_3),
];

/// Quadrature points of an edge (coordinate from 0 to 1) and weights, exact to degree five.
const QUINTIC: [(f64, f64); 3] = [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Corners of a triangle in area coordinates.
const UNIT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Values for the shape functions of both triangles.
type Row<T> = [T; SHAPES];

/// Vectors `v` for each component and each secondary corner, separated into the parts proportional to the secondary and to the primary
/// profile.
pub type Parts<T> = [[[Row<T>; 3]; 2]; 2];

/// Shape functions and height profiles of two triangles.
struct Shapes<T> {
    forms: [Form; 2],
    /// Gradients of all shape functions along both axes, zero for those of the other triangle.
    gradients: [[Row<T>; 2]; 2],
    /// Slopes of the height profiles at the corners of their triangles, along both axes.
    rises: [[[T; 3]; 2]; 2],
}

impl<T: Number> Shapes<T> {
    #[inline(always)]
    fn new(polygon: &Polygon<T>, places: &PerTriangle<[T; 2]>, forms: &[Form; 2]) -> Self {
        let zero = T::from(0.0);
        let mut shapes = Shapes { forms: *forms, gradients: [[[zero; SHAPES]; 2]; 2], rises: [[[zero; 3]; 2]; 2] };
        for side in 0..2 {
            let gradients = shape_gradients(&places[side], polygon.areas[side]);
            for k in 0..3 {
                let slopes = derivatives(&forms[side], &UNIT[k]);
                for i in 0..2 {
                    shapes.gradients[side][i][3 * side + k] = gradients[k][i];
                    shapes.rises[side][i][k] = gradients[0][i] * slopes[0] + gradients[1][i] * slopes[1] + gradients[2][i] * slopes[2];
                }
            }
        }
        shapes
    }

    /// Slope of the secondary profile along axis `i` at a point.
    #[inline(always)]
    fn rise(&self, i: usize, at: &Row<T>) -> T {
        let [a, b, c] = self.rises[0][i];
        a * at[0] + b * at[1] + c * at[2]
    }

    /// Height of the profile of a triangle at a point.
    #[inline(always)]
    fn height(&self, side: usize, at: &Row<T>) -> T {
        let own = [at[3 * side], at[3 * side + 1], at[3 * side + 2]];
        value(&derivatives(&self.forms[side], &own), &own)
    }
}

/// Shape functions of both triangles at a corner of the polygon.
#[inline(always)]
fn at<T: Number>(vertex: &Vertex<T>) -> Row<T> {
    let mut at = [T::from(0.0); SHAPES];
    at[..3].copy_from_slice(&vertex.of_secondary);
    at[3..6].copy_from_slice(&vertex.of_primary);
    at
}

/// Integrals over a polygon.
struct Interior<T> {
    /// `int N_a N_k s dA` for each `a`, `k`, `s`.
    own: [[Row<T>; 3]; 3],
    /// `f_asi` for each `i`, `a`, `s`.
    along: [[Row<T>; 3]; 2],
    /// `H_a` and `K_a`.
    heights: [[T; 3]; 2],
    /// `int N_a M_m grad_e B_2 dA` for each `e`, `a`, `m`.
    passed: [[[T; 3]; 3]; 2],
}

impl<T: Number> Interior<T> {
    #[inline(always)]
    fn new(polygon: &Polygon<T>, shapes: &Shapes<T>) -> Self {
        let zero = T::from(0.0);
        let (mut own, mut other) = ([[[zero; SHAPES]; 3]; 3], [[[zero; SHAPES]; 3]; 3]);
        let vertices = polygon.vertices();
        let first = at(&vertices[0]);
        for k in 1..vertices.len() - 1 {
            let [second, third] = [at(&vertices[k]), at(&vertices[k + 1])];
            for (shares, weight) in &CUBIC {
                let (mut here, area) = ([zero; SHAPES], vertices[k].fan * (0.5 * weight));
                for s in 0..SHAPES {
                    here[s] = first[s] * shares[0] + second[s] * shares[1] + third[s] * shares[2];
                }
                for a in 0..3 {
                    let part = area * here[a];
                    for k in 0..3 {
                        let [of_own, of_other] = [part * here[k], part * here[3 + k]];
                        for s in 0..SHAPES {
                            own[a][k][s] += of_own * here[s];
                            other[a][k][s] += of_other * here[s];
                        }
                    }
                }
            }
        }
        let mut interior = Interior { own, along: [[[zero; SHAPES]; 3]; 2], heights: [[zero; 3]; 2], passed: [[[zero; 3]; 3]; 2] };
        for k in 0..3 {
            let [first, second] = [derivatives(&shapes.forms[0], &UNIT[k]), derivatives(&shapes.forms[1], &UNIT[k])];
            for a in 0..3 {
                for i in 0..2 {
                    for s in 0..SHAPES {
                        interior.along[i][a][s] += own[a][k][s] * shapes.rises[0][i][k];
                    }
                    for m in 0..3 {
                        interior.passed[i][a][m] += other[a][k][3 + m] * shapes.rises[1][i][k];
                    }
                }
                for j in 0..3 {
                    interior.heights[0][a] += own[a][k][j] * (0.5 * first[j]);
                    interior.heights[1][a] += other[a][k][3 + j] * (0.5 * second[j]);
                }
            }
        }
        interior
    }

    #[inline(always)]
    fn parts(&self, shapes: &Shapes<T>) -> Parts<T> {
        let mut parts = [[[[T::from(0.0); SHAPES]; 3]; 2]; 2];
        for i in 0..2 {
            for a in 0..3 {
                for s in 0..SHAPES {
                    parts[0][i][a][s] = self.along[i][a][s] - self.heights[0][a] * shapes.gradients[0][i][s];
                    parts[1][i][a][s] = self.heights[1][a] * shapes.gradients[1][i][s];
                }
            }
        }
        parts
    }
}

/// Vectors `v` of a polygon whose triangles have the given corners and height profiles, without the sign of primary shape functions.
#[inline(always)]
pub fn parts<T: Number>(polygon: &Polygon<T>, places: &PerTriangle<[T; 2]>, forms: &[Form; 2]) -> Parts<T> {
    let shapes = Shapes::new(polygon, places, forms);
    Interior::new(polygon, &shapes).parts(&shapes)
}

/// Derivatives of `H_a` and `K_a` with respect to all corners.
type HeightSlopes = [[[[f64; 2]; 6]; 3]; 2];

/// Normal velocity of a point at an end of an edge, times the length of the edge, for each corner and both directions.
type Velocity = [[f64; 2]; 6];

/// Normal velocities of the ends of an edge on the border of one triangle.
#[inline(always)]
fn velocities(ends: &[Row<f64>; 2], begin: usize, out: [f64; 2]) -> [Velocity; 2] {
    let mut velocities = [[[0.0; 2]; 6]; 2];
    for end in 0..2 {
        for m in begin..begin + 3 {
            for e in 0..2 {
                velocities[end][m][e] = ends[end][m] * out[e];
            }
        }
    }
    velocities
}

/// Normal velocities of the ends of an edge whose corners carry their derivatives.
#[inline(always)]
fn velocities_of([from, to]: [&Vertex<OfCorners>; 2], out: [f64; 2]) -> [Velocity; 2] {
    let mut velocities = [[[0.0; 2]; 6]; 2];
    for m in 0..6 {
        for e in 0..2 {
            let lane = 2 * m + e;
            velocities[0][m][e] = from.p[0].eps[lane] * out[0] + from.p[1].eps[lane] * out[1];
            velocities[1][m][e] = to.p[0].eps[lane] * out[0] + to.p[1].eps[lane] * out[1];
        }
    }
    velocities
}

/// Vectors `v` of a polygon and their derivatives.
pub struct CurveSlopes {
    /// Vectors `v`.
    pub parts: Parts<f64>,
    /// Derivatives of the sum of both parts with respect to the corners, for each component and each secondary corner.
    pub slopes: [[Slopes; 3]; 2],
}

impl CurveSlopes {
    /// Vectors of no polygon.
    #[inline(always)]
    pub fn empty() -> Self {
        CurveSlopes { parts: [[[[0.0; SHAPES]; 3]; 2]; 2], slopes: [[[[[0.0; SHAPES]; 2]; 6]; 3]; 2] }
    }

    /// Computes the integrals of a polygon whose triangles have the given corners and height profiles; `moving` is a buffer.
    #[inline(always)]
    pub fn set(&mut self, polygon: &Polygon<f64>, places: &PerTriangle<[f64; 2]>, forms: &[Form; 2], moving: &mut Polygon<OfCorners>) {
        let shapes = Shapes::new(polygon, places, forms);
        let interior = Interior::new(polygon, &shapes);
        self.parts = interior.parts(&shapes);
        self.slopes = [[[[[0.0; SHAPES]; 2]; 6]; 3]; 2];
        let mut of_heights = [[[[0.0; 2]; 6]; 3]; 2];
        let is_clipped = coincides(polygon, Edges::All);
        if is_clipped {
            moving.set(polygon.corners, &carrying(places));
        }
        let (vertices, moving) = (polygon.vertices(), moving.vertices());
        for (k, from) in vertices.iter().enumerate() {
            let next = if k + 1 == vertices.len() { 0 } else { k + 1 };
            let (ends, out) = ([at(from), at(&vertices[next])], outward([from, &vertices[next]]));
            if is_clipped && moving.len() == vertices.len() {
                self.edge_into(&shapes, &ends, 0..6, velocities_of([&moving[k], &moving[next]], out), &mut of_heights);
            } else {
                let begin = if matches!(from.border, PolygonBorder::Primary(_)) { 3 } else { 0 };
                self.edge_into(&shapes, &ends, begin..begin + 3, velocities(&ends, begin, out), &mut of_heights);
            }
        }
        let (Interior { along, heights, passed, .. }, own) = (&interior, &shapes.gradients[0]);
        for a in 0..3 {
            for e in 0..2 {
                for m in 0..3 {
                    of_heights[0][a][m][e] -= own[e][a] * heights[0][m] + along[e][a][m];
                    of_heights[1][a][m][e] -= own[e][a] * heights[1][m];
                    of_heights[1][a][3 + m][e] -= passed[e][a][m];
                }
            }
        }
        for i in 0..2 {
            for a in 0..3 {
                self.interior_into(&shapes, &interior, &of_heights, [i, a]);
            }
        }
    }

    /// Adds the contributions of an edge that some of the corners move, to the derivatives of `f`, `H` and `K`.
    #[inline(always)]
    fn edge_into(
        &mut self,
        shapes: &Shapes<f64>,
        ends: &[Row<f64>; 2],
        corners: Range<usize>,
        velocities: [Velocity; 2],
        of_heights: &mut HeightSlopes,
    ) {
        let (mut along, mut heights) = ([[[[0.0; SHAPES]; 3]; 2]; 2], [[[0.0; 3]; 2]; 2]);
        for (place, weight) in QUINTIC {
            let mut here = [0.0; SHAPES];
            for s in 0..SHAPES {
                here[s] = ends[0][s] * (1.0 - place) + ends[1][s] * place;
            }
            let rises = [shapes.rise(0, &here), shapes.rise(1, &here)];
            let above = [shapes.height(0, &here), shapes.height(1, &here)];
            for (end, share) in [weight * (1.0 - place), weight * place].into_iter().enumerate() {
                for a in 0..3 {
                    let part = share * here[a];
                    for i in 0..2 {
                        heights[end][i][a] += part * above[i];
                        let part = part * rises[i];
                        for s in 0..SHAPES {
                            along[end][i][a][s] += part * here[s];
                        }
                    }
                }
            }
        }
        for corner in corners {
            for e in 0..2 {
                let [from, to] = [velocities[0][corner][e], velocities[1][corner][e]];
                for i in 0..2 {
                    for a in 0..3 {
                        of_heights[i][a][corner][e] += heights[0][i][a] * from + heights[1][i][a] * to;
                        for s in 0..SHAPES {
                            self.slopes[i][a][corner][e][s] += along[0][i][a][s] * from + along[1][i][a][s] * to;
                        }
                    }
                }
            }
        }
    }

    /// Adds the contributions of the interior to the derivatives of component `i` for the secondary corner `a`.
    #[inline(always)]
    fn interior_into(&mut self, shapes: &Shapes<f64>, interior: &Interior<f64>, of_heights: &HeightSlopes, [i, a]: [usize; 2]) {
        let (Interior { own: products, along, heights, .. }, [own, other]) = (interior, &shapes.gradients);
        for m in 0..3 {
            for e in 0..2 {
                let bend = shapes.rises[0][e][0] * own[i][0] + shapes.rises[0][e][1] * own[i][1] + shapes.rises[0][e][2] * own[i][2];
                let turn = along[i][a][m] - heights[0][a] * own[i][m];
                let row = &mut self.slopes[i][a][m][e];
                for s in 0..SHAPES {
                    row[s] += of_heights[1][a][m][e] * other[i][s]
                        - of_heights[0][a][m][e] * own[i][s]
                        - turn * own[e][s]
                        - own[e][a] * along[i][m][s]
                        - own[i][m] * along[e][a][s]
                        - bend * products[a][m][s];
                }
                let turn = along[i][a][3 + m] + heights[1][a] * other[i][3 + m];
                let row = &mut self.slopes[i][a][3 + m][e];
                for s in 0..SHAPES {
                    row[s] += of_heights[1][a][3 + m][e] * other[i][s] - of_heights[0][a][3 + m][e] * own[i][s] - turn * other[e][s];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives of the integrals against numbers that carry them, for triangles in general position and with coinciding edges.
    #[test]
    fn derivatives_are_those_of_the_clipped_polygons() {
        let forms = [[0.02, -0.01, 0.03, 0.1, 0.02, 0.06], [-0.01, 0.02, 0.0, -0.07, -0.03, 0.05]];
        let noise = |k: usize, seed: usize| 0.3 * (1.7 * k as f64 + 2.3 * seed as f64).sin();
        let mut count = 0;
        for seed in 0..60 {
            // The first and the second side of both triangles lie on common lines in a third of the cases each.
            let (own, mut other) = ([[0.0, 0.0], [1.0, 0.0], [0.25, 1.0]], [[0.75, 0.0], [-0.25, 0.0], [0.5, 0.75]]);
            match seed % 3 {
                0 => (0..3).for_each(|j| (0..2).for_each(|i| other[j][i] += noise(2 * j + i, seed))),
                1 => other[2][0] += noise(0, seed),
                _ => other = [own[1], own[0], own[2]],
            }
            let (places, corners) = ([own, [other[1], other[0], other[2]]], [[0, 1, 2], [4, 5, 6]]);
            let mut polygon = Polygon::empty();
            if !polygon.set(corners, &places) {
                continue;
            }
            count += 1;
            let (mut all, mut moving) = (CurveSlopes::empty(), Polygon::empty());
            all.set(&polygon, &places, &forms, &mut moving);
            moving.set(polygon.corners, &carrying(&places));
            let carrying = std::array::from_fn(|side| {
                std::array::from_fn(|j| std::array::from_fn(|i| OfCorners::unknown(places[side][j][i], Some(6 * side + 2 * j + i))))
            });
            let jets = parts(&moving, &carrying, &forms);
            for i in 0..2 {
                for (a, s) in (0..3).flat_map(|a| (0..6).map(move |s| (a, s))) {
                    let sum = jets[0][i][a][s] + jets[1][i][a][s];
                    assert!((sum.re - all.parts[0][i][a][s] - all.parts[1][i][a][s]).abs() < 1e-16);
                    for lane in 0..12 {
                        let slope = all.slopes[i][a][lane / 2][lane % 2][s];
                        assert!((slope - sum.eps[lane]).abs() < 1e-14, "{seed} {i} {a} {s} {lane}: {slope} {}", sum.eps[lane]);
                    }
                }
            }
        }
        assert!(count > 50, "{count} of 60 overlap");
    }
}
