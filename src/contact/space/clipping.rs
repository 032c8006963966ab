//! Clipping of a polygon in the plane by a line (Sutherland-Hodgman), for `polygon.rs`.

use super::vertices::PolygonBorder;
use crate::contact::numbers::Number;

/// Largest number of corners: six for a triangle cut by three lines, plus one per cut by rounding.
pub const VERTICES: usize = 9;

/// Corner of a polygon during clipping: plane coordinates, and the border on which the edge that starts there lies.
#[derive(Clone, Copy)]
pub struct Corner<T> {
    pub p: [T; 2],
    pub border: PolygonBorder,
    pub is_inner: bool,
}

/// Twice the area of a triangle, positive counter-clockwise.
#[inline(always)]
pub fn area<T: Number>(a: &[T; 2], b: &[T; 2], c: &[T; 2]) -> T {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Clips a polygon to the left of the line `border`; `side` is the position of its corners relative to the line, positive on the left, and
/// `is_inner` tells that the line lies between two secondary triangles. Returns the new number of corners.
#[inline(always)]
pub fn clip<T: Number>(
    old: &[Corner<T>],
    side: &[T; VERTICES],
    (border, is_inner): (PolygonBorder, bool),
    new: &mut [Corner<T>; VERTICES],
) -> usize {
    let mut left = 0;
    for k in 0..old.len() {
        let next = if k + 1 == old.len() { 0 } else { k + 1 };
        let [is_in, is_next_in] = [side[k].re() >= 0.0, side[next].re() >= 0.0];
        if is_in && left < VERTICES {
            new[left] = old[k];
            left += 1;
        }
        if is_in != is_next_in && left < VERTICES {
            let share = side[k] * (side[k] - side[next]).recip();
            let (from, to) = (&old[k].p, &old[next].p);
            new[left].p = [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])];
            // Where the polygon leaves the half plane, its next side lies on the line.
            (new[left].border, new[left].is_inner) = if is_in { (border, is_inner) } else { (old[k].border, old[k].is_inner) };
            left += 1;
        }
    }
    left
}
