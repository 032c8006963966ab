//! Integrals over overlap polygons and edges of secondary shape functions times monomials in the shape functions of both triangles (for
//! `closing.rs`).

use super::quartic::{Quartic, TERMS};
use super::vertices::{PerTriangle, Vertex};
use crate::contact::numbers::Number;

/// Quadrature points of a triangle (area coordinates) and weights, exact to degree five (Radon, Monatshefte fuer Mathematik 52, 1948).
pub const POINTS: [([f64; 3], f64); 7] = {
    const A: f64 = 0.101_286_507_323_456_34;
    const B: f64 = 0.470_142_064_105_115_1;
    const OF_A: f64 = 0.125_939_180_544_827_15;
    const OF_B: f64 = 0.132_394_152_788_506_2;
    const FAR_A: f64 = 1.0 - 2.0 * A;
    const FAR_B: f64 = 1.0 - 2.0 * B;
    [
        ([1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], 0.225),
        ([FAR_A, A, A], OF_A),
        ([A, FAR_A, A], OF_A),
        ([A, A, FAR_A], OF_A),
        ([FAR_B, B, B], OF_B),
        ([B, FAR_B, B], OF_B),
        ([B, B, FAR_B], OF_B),
    ]
};

/// Four Gauss points on [0, 1] with their weights.
pub const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Places of `x` and of `y` times the terms up to the third degree among those of a [`Quartic`].
pub const TIMES: [[usize; 10]; 2] = [[1, 3, 4, 6, 7, 8, 10, 11, 12, 13], [2, 4, 5, 7, 8, 9, 11, 12, 13, 14]];

/// Number of functions of [`Products`]: monomials in the primary shape functions, then those in the secondary ones without the constant.
pub const FUNCTIONS: usize = TERMS + 5;

/// Integrals over a polygon of the secondary shape functions times monomials.
pub struct Products(pub [[f64; FUNCTIONS]; 3]);

/// Shape functions of both triangles on an edge, at the share `t` of its length.
#[inline(always)]
pub fn on_edge<T: Number>(ends: [&Vertex<T>; 2], t: f64) -> PerTriangle<T> {
    let mut shapes = [[T::from(0.0); 3]; 2];
    for side in 0..2 {
        let [a, b] = ends.map(|end| end.shape(side));
        for j in 0..3 {
            shapes[side][j] = a[j] * (1.0 - t) + b[j] * t;
        }
    }
    shapes
}

/// Shape functions of both triangles at a point, given by its area coordinates in three corners of a polygon.
#[inline(always)]
fn shapes([a, b, c]: [&Vertex<f64>; 3], at: &[f64; 3]) -> PerTriangle<f64> {
    let mut shapes = [[0.0; 3]; 2];
    for side in 0..2 {
        let (a, b, c) = (a.shape(side), b.shape(side), c.shape(side));
        for j in 0..3 {
            shapes[side][j] = a[j] * at[0] + b[j] * at[1] + c[j] * at[2];
        }
    }
    shapes
}

/// Monomials at a point with these shape functions.
#[inline(always)]
pub fn monomials([[_, u, v], [_, x, y]]: &PerTriangle<f64>) -> [f64; FUNCTIONS] {
    let (xx, xy, yy) = (x * x, x * y, y * y);
    let mut of = [1.0; FUNCTIONS];
    (of[1], of[2], of[TERMS], of[TERMS + 1]) = (*x, *y, *u, *v);
    of[3..6].copy_from_slice(&[xx, xy, yy]);
    of[6..10].copy_from_slice(&[xx * x, xx * y, x * yy, y * yy]);
    of[10..TERMS].copy_from_slice(&[xx * xx, xx * xy, xx * yy, xy * yy, yy * yy]);
    of[TERMS + 2..].copy_from_slice(&[u * u, u * v, v * v]);
    of
}

/// Integrals of a polynomial of third degree times the three shape functions of the primary triangle.
#[inline(always)]
pub fn by_shapes<R: Number>(cubic: &[f64; 10], moments: &[R; TERMS]) -> [R; 3] {
    let mut sums = [R::from(0.0); 3];
    for term in 0..10 {
        sums[0] += moments[term] * cubic[term];
        sums[1] += moments[TIMES[0][term]] * cubic[term];
        sums[2] += moments[TIMES[1][term]] * cubic[term];
    }
    [sums[0] - sums[1] - sums[2], sums[1], sums[2]]
}

/// Value of a polynomial of third degree.
#[inline(always)]
pub fn cubic<T: Number>(c: &[f64; 10], [x, y]: [T; 2]) -> T {
    let constant = ((x * c[6] + c[3]) * x + c[1]) * x + c[0];
    let linear = (x * c[7] + c[4]) * x + c[2];
    ((y * c[9] + x * c[8] + c[5]) * y + linear) * y + constant
}

/// Integral of a polynomial from those of its terms.
#[inline(always)]
pub fn integral<R: Number>(polynomial: &Quartic, moments: &[R; TERMS]) -> R {
    let mut sum = moments[0] * polynomial.0[0];
    for term in 1..TERMS {
        sum += moments[term] * polynomial.0[term];
    }
    sum
}

impl Products {
    /// Integrals over a polygon with these corners.
    #[inline(always)]
    pub fn new(vertices: &[Vertex<f64>]) -> Self {
        let mut products = [[0.0; FUNCTIONS]; 3];
        for k in 1..vertices.len() - 1 {
            let corners = [&vertices[0], &vertices[k], &vertices[k + 1]];
            // In two loops, of which the second one is compiled with the wide registers.
            let (mut rows, mut parts) = ([[0.0; FUNCTIONS]; POINTS.len()], [[0.0; 3]; POINTS.len()]);
            for (point, (at, share)) in POINTS.iter().enumerate() {
                let shapes = shapes(corners, at);
                rows[point] = monomials(&shapes);
                let area = vertices[k].fan * (0.5 * share);
                parts[point] = [area * shapes[0][0], area * shapes[0][1], area * shapes[0][2]];
            }
            for (row, part) in rows.iter().zip(&parts) {
                for a in 0..3 {
                    for term in 0..FUNCTIONS {
                        products[a][term] += part[a] * row[term];
                    }
                }
            }
        }
        Products(products)
    }

    /// Integrals of secondary shape function `a` times monomials in the primary ones.
    #[inline(always)]
    pub fn other(&self, a: usize) -> [f64; TERMS] {
        let mut other = [0.0; TERMS];
        other.copy_from_slice(&self.0[a][..TERMS]);
        other
    }

    /// Integrals of secondary shape function `a` times monomials in the secondary ones.
    #[inline(always)]
    pub fn own(&self, a: usize) -> [f64; 6] {
        let row = &self.0[a];
        [row[0], row[TERMS], row[TERMS + 1], row[TERMS + 2], row[TERMS + 3], row[TERMS + 4]]
    }
}
