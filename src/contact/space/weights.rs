//! Mortar weights of a facet pair in space with their derivatives: `int N_A N_B dA` and `-int N_A M_C dA` over the overlap.
//!
//! Over a polygon (`polygon.rs`) with the shape functions `N_a` of the secondary and `M_c` of the primary triangle, `s` one of them, the
//! derivatives with respect to the plane coordinates of the corners are those of a moving domain,
//!
//! ```text
//! d/dp_j int N_a s dA = - grad N_a int N_j s dA - grad s int N_j N_a dA (s secondary) + sum_edges nu int N_a s N_j ds
//! d/dp_m int N_a s dA =                         - grad s int N_a M_m dA (s primary)   + sum_edges nu int N_a s M_m ds
//! ```
//!
//! for a secondary corner `j` and a primary corner `m`, with the edges on the border of the corner's own triangle. The chain rule to node
//! positions is that of gaps (`view.rs`).
//!
//! Weights have a kink where edges of both facets coincide. Which triangle such an edge belongs to is decided by round-off, and derivatives
//! by edges made resting arches crawl (`tests/scripts/rigid_friction_in_space.rhai`). Where an edge on the border of the overlap coincides
//! with one of the other facet, polygons with coinciding edges are clipped with numbers that carry derivatives, so that corners move with
//! the sides that define them. Edges between triangles of one facet are not left out there, because coinciding ones need not cancel.

use super::clipping::VERTICES;
use super::polygon::Polygon;
use super::vectors::Vec3;
use super::vertices::{CORNERS, NODES, OfNodes, PerTriangle, PolygonBorder, Vertex, outward, shape_gradients};
use super::view::{POINTS, View};
use crate::contact::numbers::{Each, Jet};
use crate::math::simd::Kernel;
use crate::math::tolerances::SAME_PLACE;

/// Computation of the weights of a pair, compiled for the instruction set of the processor.
pub struct MortarWeights<'a> {
    pub view: &'a View<f64>,
    pub polygons: &'a [Polygon<f64>],
}

/// Number of corners of two triangles, padded to whole registers.
pub const SHAPES: usize = 8;

/// Derivatives of the integrals of a shape function with those of both triangles, with respect to the plane coordinates of their corners.
pub type Slopes = [[[f64; SHAPES]; 2]; 6];

/// Number with its derivatives with respect to the plane coordinates of the corners of both triangles.
pub type OfCorners = Jet<12>;

/// Corners of both triangles as numbers that carry the derivatives with respect to all their plane coordinates.
#[inline(always)]
pub fn carrying(places: &PerTriangle<[f64; 2]>) -> PerTriangle<[OfCorners; 2]> {
    let mut carrying = [[[OfCorners::from(0.0); 2]; 3]; 2];
    for side in 0..2 {
        for j in 0..3 {
            for i in 0..2 {
                carrying[side][j][i].re = places[side][j][i];
                carrying[side][j][i].eps[6 * side + 2 * j + i] = 1.0;
            }
        }
    }
    carrying
}

/// Sums over polygons: for each secondary point (nodes, then the mean point), the integrals of its shape function with those of all points.
pub struct Values([[f64; POINTS]; CORNERS + 1]);

impl Values {
    /// Sums over no polygon.
    #[inline(always)]
    pub fn empty() -> Self {
        Values([[0.0; POINTS]; CORNERS + 1])
    }

    /// Adds the integrals of a polygon to the points of its triangles.
    #[inline(always)]
    pub fn add(&mut self, corners: &PerTriangle<usize>, integrals: &[[f64; SHAPES]; 3]) {
        for a in 0..3 {
            let row = corners[0][a].min(CORNERS);
            for s in 0..6 {
                let sign = if s < 3 { 1.0 } else { -1.0 };
                self.0[row][corners[s / 3][s % 3]] += sign * integrals[a][s];
            }
        }
    }

    /// Values of secondary node `node` for each node, with the shares of the mean points.
    #[inline(always)]
    pub fn of_node(&self, view: &View<f64>, node: usize) -> [f64; NODES] {
        let share = 1.0 / view.counts[0] as f64;
        let mut values = self.0[node];
        for s in 0..POINTS {
            values[s] += share * self.0[CORNERS][s];
        }
        let mut of_nodes = [0.0; NODES];
        of_nodes.copy_from_slice(&values[..NODES]);
        for mean in [NODES, NODES + 1] {
            let (nodes, share) = view.shares(mean);
            for node in nodes {
                of_nodes[node] += share * values[mean];
            }
        }
        of_nodes
    }
}

/// Sums over polygons with their derivatives with respect to the plane coordinates of all points.
pub struct Sums {
    /// Sums without derivatives.
    pub values: Values,
    slopes: [[[[f64; POINTS]; 2]; POINTS]; CORNERS + 1],
}

impl Sums {
    /// Sums over no polygon.
    #[inline(always)]
    pub fn empty() -> Self {
        Sums { values: Values::empty(), slopes: [[[[0.0; POINTS]; 2]; POINTS]; CORNERS + 1] }
    }

    #[inline(always)]
    fn add(&mut self, view: &View<f64>, polygon: &Polygon<f64>, edges: Edges) {
        let places = view.places(&polygon.corners);
        let gradients = [shape_gradients(&places[0], polygon.areas[0]), shape_gradients(&places[1], polygon.areas[1])];
        let mut integrals = [[0.0; SHAPES]; 3];
        for a in 0..3 {
            let mut own = [0.0; VERTICES];
            for (k, vertex) in polygon.vertices().iter().enumerate() {
                own[k] = vertex.of_secondary[a];
            }
            let counts = polygon.counting(&own);
            let (secondary, primary) = (polygon.integrals(&counts, 0), polygon.integrals(&counts, 1));
            for c in 0..3 {
                (integrals[a][c], integrals[a][3 + c]) = (secondary[c], primary[c]);
            }
        }
        let mut slopes = [[[[0.0; SHAPES]; 2]; 6]; 3];
        for a in 0..3 {
            for i in 0..2 {
                for j in 0..3 {
                    for s in 0..SHAPES {
                        slopes[a][j][i][s] -= gradients[0][a][i] * integrals[j][s];
                    }
                    for s in 0..3 {
                        slopes[a][j][i][s] -= gradients[0][s][i] * integrals[j][a];
                        slopes[a][3 + j][i][3 + s] -= gradients[1][s][i] * integrals[a][3 + j];
                    }
                }
            }
        }
        edges_into(polygon, edges, &mut slopes);
        self.add_to_points(&polygon.corners, &integrals, &slopes);
    }

    /// Adds a polygon that is clipped again with numbers that carry the derivatives.
    #[inline(always)]
    fn add_clipped(&mut self, view: &View<f64>, polygon: &Polygon<f64>) {
        let mut clipped = Polygon::empty();
        clipped.set(polygon.corners, &carrying(&view.places(&polygon.corners)));
        let (mut integrals, mut slopes) = ([[0.0; SHAPES]; 3], [[[[0.0; SHAPES]; 2]; 6]; 3]);
        for a in 0..3 {
            let mut own = [OfCorners::from(0.0); VERTICES];
            for (k, vertex) in clipped.vertices().iter().enumerate() {
                own[k] = vertex.of_secondary[a];
            }
            let counts = clipped.counting(&own);
            for side in 0..2 {
                for (c, integral) in clipped.integrals(&counts, side).into_iter().enumerate() {
                    integrals[a][3 * side + c] = integral.re;
                    for lane in 0..12 {
                        slopes[a][lane / 2][lane % 2][3 * side + c] = integral.eps[lane];
                    }
                }
            }
        }
        self.add_to_points(&polygon.corners, &integrals, &slopes);
    }

    /// Adds the integrals of a polygon, and their derivatives, to the points of its triangles.
    #[inline(always)]
    pub fn add_to_points(&mut self, corners: &PerTriangle<usize>, integrals: &[[f64; SHAPES]; 3], slopes: &[Slopes; 3]) {
        let points = [corners[0][0], corners[0][1], corners[0][2], corners[1][0], corners[1][1], corners[1][2]];
        self.values.add(corners, integrals);
        for a in 0..3 {
            let row = points[a].min(CORNERS);
            for s in 0..6 {
                let sign = if s < 3 { 1.0 } else { -1.0 };
                for corner in 0..6 {
                    for i in 0..2 {
                        self.slopes[row][points[corner]][i][points[s]] += sign * slopes[a][corner][i][s];
                    }
                }
            }
        }
    }

    /// Sums of secondary node `node`, with the shares of the mean points: values, and derivatives with respect to the nodes' plane
    /// coordinates, both for each node.
    #[inline(always)]
    pub fn of_node(&self, view: &View<f64>, node: usize) -> ([f64; NODES], [[Each<NODES>; 2]; NODES]) {
        let share = 1.0 / view.counts[0] as f64;
        let mut slopes = self.slopes[node];
        for point in 0..POINTS {
            for i in 0..2 {
                for s in 0..POINTS {
                    slopes[point][i][s] += share * self.slopes[CORNERS][point][i][s];
                }
            }
        }
        let mut of_p = [[Each([0.0; NODES]); 2]; NODES];
        for mean in [NODES, NODES + 1] {
            let (nodes, share) = view.shares(mean);
            for node in nodes {
                for i in 0..2 {
                    for s in 0..POINTS {
                        slopes[node][i][s] += share * slopes[mean][i][s];
                    }
                }
            }
        }
        for k in 0..NODES {
            for i in 0..2 {
                of_p[k][i].0.copy_from_slice(&slopes[k][i][..NODES]);
                for mean in [NODES, NODES + 1] {
                    let (nodes, share) = view.shares(mean);
                    for node in nodes {
                        of_p[k][i].0[node] += share * slopes[k][i][mean];
                    }
                }
            }
        }
        (self.values.of_node(view, node), of_p)
    }
}

/// Edges of the polygons of a facet pair.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Edges {
    /// All edges.
    All,
    /// Edges on the border of a facet, without those between triangles of one facet.
    Outer,
}

impl Edges {
    /// True if the edge that begins at a vertex is one of these.
    #[inline(always)]
    fn contain(self, from: &Vertex<f64>) -> bool {
        self == Edges::All || !from.is_inner
    }
}

/// True if one of the edges of a polygon lies on sides of both triangles.
#[inline(always)]
pub fn coincides(polygon: &Polygon<f64>, edges: Edges) -> bool {
    let vertices = polygon.vertices();
    let mut found = false;
    for (k, from) in vertices.iter().enumerate() {
        let to = &vertices[if k + 1 == vertices.len() { 0 } else { k + 1 }];
        let mut is_on = [false; 2];
        for side in 0..2 {
            for j in 0..3 {
                is_on[side] |= from.shape(side)[j].abs() <= SAME_PLACE && to.shape(side)[j].abs() <= SAME_PLACE;
            }
        }
        found |= is_on == [true; 2] && edges.contain(from);
    }
    found
}

/// Adds the contributions of the edges on the borders of both triangles; those between triangles of one facet cancel in the sum over its
/// triangles.
#[inline(always)]
fn edges_into(polygon: &Polygon<f64>, edges: Edges, slopes: &mut [Slopes; 3]) {
    let vertices = polygon.vertices();
    for (k, from) in vertices.iter().enumerate() {
        if !edges.contain(from) {
            continue;
        }
        let to = &vertices[if k + 1 == vertices.len() { 0 } else { k + 1 }];
        let (side, out) = (usize::from(matches!(from.border, PolygonBorder::Primary(_))), outward([from, to]));
        let mut ends = [[0.0; SHAPES]; 2];
        for (end, vertex) in ends.iter_mut().zip([from, to]) {
            end[..3].copy_from_slice(&vertex.of_secondary);
            end[3..6].copy_from_slice(&vertex.of_primary);
        }
        for a in 0..3 {
            let (at_from, at_to) = (ends[0][a] * (1.0 / 12.0), ends[1][a] * (1.0 / 12.0));
            // Integral of a product of three affine functions along the edge, as coefficients of the third one at both ends.
            let mut edge = [[0.0; SHAPES]; 2];
            for s in 0..SHAPES {
                let (aa, bb) = (at_from * ends[0][s], at_to * ends[1][s]);
                let ab = at_from * ends[1][s] + at_to * ends[0][s];
                edge[0][s] = aa * 3.0 + ab + bb;
                edge[1][s] = aa + ab + bb * 3.0;
            }
            for j in 3 * side..3 * side + 3 {
                for i in 0..2 {
                    let [first, second] = [ends[0][j] * out[i], ends[1][j] * out[i]];
                    for s in 0..SHAPES {
                        slopes[a][j][i][s] += edge[0][s] * first + edge[1][s] * second;
                    }
                }
            }
        }
    }
}

impl Kernel for MortarWeights<'_> {
    type Output = [[OfNodes; NODES]; CORNERS];

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Self::Output {
        let mut sums = Sums::empty();
        let mut has_coinciding = false;
        for polygon in self.polygons {
            has_coinciding |= coincides(polygon, Edges::Outer);
        }
        for polygon in self.polygons {
            if has_coinciding && coincides(polygon, Edges::All) {
                sums.add_clipped(self.view, polygon);
            } else {
                sums.add(self.view, polygon, if has_coinciding { Edges::All } else { Edges::Outer });
            }
        }
        let mut weights = [[OfNodes::from(0.0); NODES]; CORNERS];
        for a in 0..self.view.counts[0] {
            let (values, of_p) = sums.of_node(self.view, a);
            let slopes: [Vec3<Each<NODES>>; NODES] = self.view.spread(&of_p, &[Each([0.0; NODES]); NODES]);
            for s in 0..NODES {
                weights[a][s].re = values[s];
                for node in 0..NODES {
                    for i in 0..3 {
                        weights[a][s].eps[3 * node + i] = slopes[node][i].0[s];
                    }
                }
            }
        }
        weights
    }
}
