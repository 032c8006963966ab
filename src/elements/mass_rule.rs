//! A quadrature that integrates the mass matrix of every cell kind exactly, also for curved and for axisymmetric cells.
//!
//! `N_a N_b det J` of a cell of order `p` in `D` dimensions has the degree `2 p + D p - 1` in each coordinate of a product cell, at most 8
//! (`hex20`, `hex27`, `pyr13`), and the total degree `2 p + D (p - 1)` of a simplex, at most 7 (`tet10`), 8 in the triangle of `wedge15`;
//! the radius of a body of revolution adds `p`. Five Gauss points along each axis are exact to degree 9. A simplex is a collapsed square or
//! cube (A. H. Stroud, Approximate Calculation of Multiple Integrals, 1971), whose factors `(1 - u)` and `(1 - u)^2` add one and two
//! degrees.

use super::CellShape;

/// Five Gauss points of the unit interval and their weights.
pub const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668_004, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

impl CellShape {
    /// Points and weights of a quadrature that integrates products of two shape functions over a cell exactly; components beyond the
    /// dimension are zero.
    pub fn mass_points(self) -> Vec<([f64; 3], f64)> {
        let plane = || GAUSS.into_iter().flat_map(|(u, a)| GAUSS.into_iter().map(move |(v, b)| ([u, v], a * b)));
        let space = || plane().flat_map(|([u, v], a)| GAUSS.into_iter().map(move |(w, b)| ([u, v, w], a * b)));
        match self {
            CellShape::Triangle => plane().map(|([u, v], weight)| ([u, v * (1.0 - u), 0.0], weight * (1.0 - u))).collect(),
            CellShape::Quadrilateral => plane().map(|([u, v], weight)| ([2.0 * u - 1.0, 2.0 * v - 1.0, 0.0], 4.0 * weight)).collect(),
            CellShape::Tetrahedron => {
                let collapsed = |([u, v, w], weight): ([f64; 3], f64)| {
                    let (first, second) = (1.0 - u, 1.0 - v);
                    ([u, v * first, w * first * second], weight * first * first * second)
                };
                space().map(collapsed).collect()
            }
            CellShape::Wedge => {
                let collapsed = |([u, v, w], weight): ([f64; 3], f64)| ([u, v * (1.0 - u), 2.0 * w - 1.0], 2.0 * weight * (1.0 - u));
                space().map(collapsed).collect()
            }
            CellShape::Hexahedron | CellShape::Pyramid => space().map(|(at, weight)| (at.map(|x| 2.0 * x - 1.0), 8.0 * weight)).collect(),
        }
    }
}
