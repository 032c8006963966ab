//! Corners of the polygons that two triangles have in common, and what is said of triangles in the plane.

use std::ops::Mul;

use super::vectors::sub;
use crate::contact::numbers::Number;

/// A corner of a polygon with the shape functions of both triangles there, and twice the area between it, the next and the first one.
#[derive(Clone, Copy)]
pub struct Vertex<T> {
    pub p: [T; 2],
    pub of_secondary: [T; 3],
    pub of_primary: [T; 3],
    pub border: Border,
    pub fan: T,
}

/// Triangle on whose border an edge of a polygon lies.
#[derive(Clone, Copy, PartialEq)]
pub enum Border {
    Secondary,
    Primary,
}

/// Values at the corners of both triangles, those of the secondary triangle first.
pub type OfBoth<T> = [[T; 3]; 2];

/// Derivatives with respect to plane coordinates and heights of the corners.
pub struct Forces<R> {
    pub of_p: OfBoth<[R; 2]>,
    pub of_h: OfBoth<R>,
}

impl<T: Copy> Vertex<T> {
    /// Shape functions of the secondary (0) or the primary triangle (1).
    #[inline(always)]
    pub fn shape(&self, side: usize) -> &[T; 3] {
        if side == 0 { &self.of_secondary } else { &self.of_primary }
    }
}

/// Sides of a triangle opposite to its corners: turned by a quarter, over twice the area, they are the gradients of its shape functions.
#[inline(always)]
pub fn sides<T: Number>([a, b, c]: &[[T; 2]; 3]) -> [[T; 2]; 3] {
    [sub(*c, *b), sub(*a, *c), sub(*b, *a)]
}

/// Gradients of the shape functions of a triangle, by twice its area.
#[inline(always)]
pub fn shape_gradients<T: Number>(places: &[[T; 2]; 3], area: T) -> [[T; 2]; 3] {
    let inverse = area.recip();
    let mut gradients = sides(places);
    for j in 0..3 {
        gradients[j] = [-(gradients[j][1] * inverse), gradients[j][0] * inverse];
    }
    gradients
}

/// Gradient of an affine function on a triangle, by the gradients of the shape functions, from its values at the corners.
#[inline(always)]
pub fn slope_of<T: Number, W: Copy + Mul<T, Output = R>, R: Number>(gradients: &[[T; 2]; 3], at: &[W; 3]) -> [R; 2] {
    let along = |i: usize| at[0] * gradients[0][i] + at[1] * gradients[1][i] + at[2] * gradients[2][i];
    [along(0), along(1)]
}

/// Gradient of an affine function on a triangle, by its sides and one over twice its area, from its values at the corners.
#[inline(always)]
pub fn slope<T: Number, W: Copy + Mul<T, Output = R>, R: Number + Mul<T, Output = R>>(
    sides: &[[T; 2]; 3],
    inverse: T,
    at: &[W; 3],
) -> [R; 2] {
    let along = |i: usize| at[0] * sides[0][i] + at[1] * sides[1][i] + at[2] * sides[2][i];
    [-along(1) * inverse, along(0) * inverse]
}
