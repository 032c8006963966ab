//! Corners of overlap polygons, and affine functions on triangles in the plane (`polygon.rs`, `closing.rs`).

use std::ops::Mul;

use super::vectors::sub;
use crate::contact::numbers::{Jet, Number};

/// Largest number of nodes of a facet.
pub const CORNERS: usize = 4;

/// Largest number of nodes of a pair; points with higher indices are the mean points of facets.
pub const NODES: usize = 2 * CORNERS;

/// Corner of a polygon, shape functions of both triangles there, and twice the area of the triangle to the next and the first corner.
#[derive(Clone, Copy)]
pub struct Vertex<T> {
    pub p: [T; 2],
    pub of_secondary: [T; 3],
    pub of_primary: [T; 3],
    pub border: PolygonBorder,
    /// True if the edge that starts there lies between two triangles of one facet.
    pub is_inner: bool,
    pub fan: T,
}

/// Triangle on whose border a polygon edge lies, and the corner at which that side of the triangle starts.
#[derive(Clone, Copy, PartialEq)]
pub enum PolygonBorder {
    Secondary(u8),
    Primary(u8),
}

/// Values at the corners of both triangles, secondary first.
pub type PerTriangle<T> = [[T; 3]; 2];

/// Derivatives of a function with respect to plane coordinates and heights of the corners of both triangles.
pub struct Forces<R> {
    /// Integrals of the gap times the shape functions of the secondary triangle.
    pub open: [f64; 3],
    pub of_p: PerTriangle<[R; 2]>,
    pub of_h: PerTriangle<R>,
}

impl<T: Copy> Vertex<T> {
    /// Shape functions of the secondary (0) or the primary triangle (1).
    #[inline(always)]
    pub fn shape(&self, side: usize) -> &[T; 3] {
        if side == 0 { &self.of_secondary } else { &self.of_primary }
    }
}

/// Largest number of unknowns of a pair.
pub const UNKNOWNS: usize = 3 * NODES;

/// Number with its derivatives with respect to the node positions of a pair.
pub type OfNodes = Jet<UNKNOWNS>;

/// Number with its derivatives with respect to the plane coordinates of a primary triangle.
pub type OfPrimary = Jet<6>;

/// Outward normal of an edge; its length is that of the edge.
#[inline(always)]
pub fn outward<T: Number>([a, b]: [&Vertex<T>; 2]) -> [T; 2] {
    [b.p[1] - a.p[1], a.p[0] - b.p[0]]
}

/// Sides of a triangle opposite its corners; rotated by a right angle and divided by twice the area, they are the shape functions'
/// gradients.
#[inline(always)]
pub fn sides<T: Number>([a, b, c]: &[[T; 2]; 3]) -> [[T; 2]; 3] {
    [sub(*c, *b), sub(*a, *c), sub(*b, *a)]
}

/// Gradients of the shape functions of a triangle; `area` is twice its area.
#[inline(always)]
pub fn shape_gradients<T: Number>(places: &[[T; 2]; 3], area: T) -> [[T; 2]; 3] {
    let inverse = area.recip();
    let mut gradients = sides(places);
    for j in 0..3 {
        gradients[j] = [-(gradients[j][1] * inverse), gradients[j][0] * inverse];
    }
    gradients
}

/// Gradient of an affine function on a triangle, from the gradients of the shape functions and the values at the corners.
#[inline(always)]
pub fn slope_of<T: Number, W: Copy + Mul<T, Output = R>, R: Number>(gradients: &[[T; 2]; 3], at: &[W; 3]) -> [R; 2] {
    let along = |i: usize| at[0] * gradients[0][i] + at[1] * gradients[1][i] + at[2] * gradients[2][i];
    [along(0), along(1)]
}

/// Gradient of an affine function on a triangle, from its sides, 1 over twice its area, and the values at the corners.
#[inline(always)]
pub fn slope<T: Number, W: Copy + Mul<T, Output = R>, R: Number + Mul<T, Output = R>>(
    sides: &[[T; 2]; 3],
    inverse: T,
    at: &[W; 3],
) -> [R; 2] {
    let along = |i: usize| at[0] * sides[0][i] + at[1] * sides[1][i] + at[2] * sides[2][i];
    [-along(1) * inverse, along(0) * inverse]
}
