//! The polygons that a pair of facets has in common: a primary triangle cut by a secondary one, with the shape functions of both.

use crate::contact::numbers::Number;
use crate::math::tolerances::FACING_AREA;

/// Corners of a polygon: a triangle cut by three lines has six at most, rounding may leave one more at each cut.
pub const VERTICES: usize = 9;

/// A corner of a polygon that is being cut: its place, what the edge that begins there lies on.
#[derive(Clone, Copy)]
struct Corner<T> {
    p: [T; 2],
    border: Border,
}

/// A corner of a polygon with the shape functions of both triangles there, and twice the area between it, the next and the first one.
pub struct Vertex<T> {
    pub p: [T; 2],
    pub of_secondary: [T; 3],
    pub of_primary: [T; 3],
    pub border: Border,
    pub fan: T,
}

/// What an edge of a polygon lies on.
#[derive(Clone, Copy, PartialEq)]
pub enum Border {
    Secondary,
    Primary,
}

/// A secondary triangle cut out of a primary one.
pub struct Polygon<T> {
    /// Corners of the triangles in the list of points.
    pub secondary: [usize; 3],
    pub primary: [usize; 3],
    /// Twice their areas.
    pub areas: [T; 2],
    pub vertices: Vec<Vertex<T>>,
}

/// Twice the area of a triangle, positive counter-clockwise.
#[inline(always)]
fn area<T: Number>(a: &[T; 2], b: &[T; 2], c: &[T; 2]) -> T {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Cuts off what is on the right of a line from a polygon of so many corners; returns how many are left.
#[inline(always)]
fn clip<T: Number>(corners: &mut [Corner<T>; VERTICES], count: usize, [from, to]: [&[T; 2]; 2]) -> usize {
    let mut side = [T::from(0.0); VERTICES];
    (0..count).for_each(|k| side[k] = area(from, to, &corners[k].p));
    let is_in = |k: usize| side[k].re() >= 0.0;
    if (0..count).all(is_in) {
        return count;
    }
    let (old, mut left) = (*corners, 0);
    let mut push = |corner: Corner<T>| {
        if left < VERTICES {
            corners[left] = corner;
            left += 1;
        }
    };
    for k in 0..count {
        let next = (k + 1) % count;
        if is_in(k) {
            push(old[k]);
        }
        if is_in(k) != is_in(next) {
            let share = side[k] / (side[k] - side[next]);
            let p: [T; 2] = std::array::from_fn(|i| old[k].p[i] + share * (old[next].p[i] - old[k].p[i]));
            // Leaving, the line itself follows.
            push(Corner { p, border: if is_in(k) { Border::Secondary } else { old[k].border } });
        }
    }
    left
}

/// Shape functions of a triangle at a point, by one over twice its area.
#[inline(always)]
fn shares<T: Number>([a, b, c]: [&[T; 2]; 3], inverse: T, p: &[T; 2]) -> [T; 3] {
    [area(b, c, p) * inverse, area(c, a, p) * inverse, area(a, b, p) * inverse]
}

/// The corners with the shape functions of both triangles.
#[inline(always)]
fn vertices<T: Number>(corners: &[Corner<T>], [secondary, primary]: [[&[T; 2]; 3]; 2], areas: [T; 2]) -> Vec<Vertex<T>> {
    let [of_secondary, of_primary] = areas.map(T::recip);
    let mut vertices = Vec::with_capacity(corners.len());
    for (k, Corner { p, border }) in corners.iter().enumerate() {
        vertices.push(Vertex {
            p: *p,
            of_secondary: shares(secondary, of_secondary, p),
            of_primary: shares(primary, of_primary, p),
            border: *border,
            fan: area(&corners[0].p, p, &corners[(k + 1) % corners.len()].p),
        });
    }
    vertices
}

/// A triangle that an edge of a polygon goes with: its share of it, all of it where there is none; its corners and its shape functions at
/// both ends of the edge.
pub struct Bearer<'a, T> {
    pub share: Option<T>,
    pub corners: [usize; 3],
    pub at: [&'a [T; 3]; 2],
}

impl<T: Number> Polygon<T> {
    /// The part of a primary triangle within a secondary one, by the numbers and places of their corners; nothing where they have none in
    /// common or do not face each other.
    #[inline(always)]
    pub fn new([secondary, primary]: [[usize; 3]; 2], places: [[&[T; 2]; 3]; 2]) -> Option<Self> {
        let [[s_0, s_1, s_2], [m_0, m_1, m_2]] = places;
        let areas = [area(s_0, s_1, s_2), area(m_0, m_1, m_2)];
        if areas[0].re() <= 0.0 || areas[1].re() <= FACING_AREA * areas[0].re() {
            return None;
        }
        let mut corners = [m_0, m_1, m_2, m_0, m_0, m_0, m_0, m_0, m_0].map(|p| Corner { p: *p, border: Border::Primary });
        let mut count = 3;
        for line in [[s_0, s_1], [s_1, s_2], [s_2, s_0]] {
            count = if count < 3 { 0 } else { clip(&mut corners, count, line) };
        }
        (count >= 3).then(|| Polygon { secondary, primary, areas, vertices: vertices(&corners[..count], places, areas) })
    }

    /// Which triangles an edge of the polygon goes with. An edge goes with the triangle on whose border it lies, and in part with the other
    /// one where that has its own border nearer than `band` of its height, half with either where both coincide: forces do not jump there,
    /// and have neither a resultant nor a moment of their own.
    #[inline(always)]
    pub fn bearers(&self, [k, next]: [usize; 2], band: f64) -> [Option<Bearer<'_, T>>; 2] {
        let (a, b) = (&self.vertices[k], &self.vertices[next]);
        let own = (self.secondary, [&a.of_secondary, &b.of_secondary]);
        let other = (self.primary, [&a.of_primary, &b.of_primary]);
        let (bearer, neighbor) = if a.border == Border::Secondary { (own, other) } else { (other, own) };
        let bears = |share, (corners, at)| Some(Bearer { share, corners, at });
        let depth = |j: usize| (neighbor.1[0][j].re() + neighbor.1[1][j].re()) * 0.5;
        let nearest = (1..3).fold(0, |least, j| if depth(j) < depth(least) { j } else { least });
        if band > 0.0 && depth(nearest) < band {
            let depth = (neighbor.1[0][nearest] + neighbor.1[1][nearest]) * 0.5;
            let near = T::from(1.0) - depth * (1.0 / band);
            let share = near * near * 0.5;
            [bears(Some(T::from(1.0) - share), bearer), bears(Some(share), neighbor)]
        } else {
            [bears(None, bearer), None]
        }
    }

    /// Integral of a product of two affine functions, from their values at the corners: exact.
    #[inline(always)]
    pub fn integral<'a>(&'a self, f: impl Fn(usize) -> &'a T, g: impl Fn(usize) -> &'a T) -> T {
        let mut sum = T::from(0.0);
        for k in 1..self.vertices.len() - 1 {
            let ([f_0, f_1, f_2], [g_0, g_1, g_2]) = ([0, k, k + 1].map(&f), [0, k, k + 1].map(&g));
            let products = *f_0 * *g_0 + *f_1 * *g_1 + *f_2 * *g_2 + (*f_0 + *f_1 + *f_2) * (*g_0 + *g_1 + *g_2);
            sum += self.vertices[k].fan * products * (1.0 / 24.0);
        }
        sum
    }
}
