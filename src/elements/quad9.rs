//! Biquadratic quadrilateral: corners as in `quad4`, the middles of the edges 1-2, 2-3, 3-4, 4-1, the center; 3 x 3 Gauss points.
//!
//! Shape functions are products of the quadratic ones of an interval, `x (x - 1)/2`, `1 - x^2`, `x (x + 1)/2` (Hughes, The Finite Element
//! Method, 2000, section 3.6).

use super::edge::{edge_points, quadratic};
use super::reference_cell::{CellRow, CellShape, ReferenceCell, extrapolation_of_products, gradients, quadrature, shape};

pub(super) const PLACES: [[f64; 3]; 9] = [
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 0.0, 0.0],
];

pub(super) const FACETS: [&[usize]; 4] = [&[0, 1, 4], &[1, 2, 5], &[2, 3, 6], &[3, 0, 7]];

pub(super) static ROW: CellRow = CellRow {
    name: "quad9",
    summary: "biquadratic quadrilateral with 9 nodes and 3 x 3 Gauss points",
    cell_shape: CellShape::Quadrilateral,
    dimension: 2,
    nodes: 9,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 5,
    vtk_type: 28,
    xdmf: (35, "Quadrilateral_9"),
    gmsh_type: 10,
    gmsh_order: &[],
    abaqus_order: &[],
    quadrature: quadrature::<Quad9, 2, 9, 9>,
    shape: shape::<Quad9, 2, 9, 9>,
    gradients: gradients::<Quad9, 2, 9, 9>,
};

/// The biquadratic quadrilateral.
pub struct Quad9;

/// 3 x 3 Gauss points.
pub(super) fn gauss() -> [([f64; 2], f64); 9] {
    let points = edge_points();
    std::array::from_fn(|q| {
        let ((x, v), (y, w)) = (points[q % 3], points[q / 3]);
        ([x, y], v * w)
    })
}

impl ReferenceCell<2, 9, 9> for Quad9 {
    fn quadrature() -> [([f64; 2], f64); 9] {
        gauss()
    }

    fn shape(xi: [f64; 2]) -> [f64; 9] {
        std::array::from_fn(|a| quadratic(PLACES[a][0], xi[0]).0 * quadratic(PLACES[a][1], xi[1]).0)
    }

    fn gradients(xi: [f64; 2]) -> [[f64; 2]; 9] {
        std::array::from_fn(|a| {
            let ((f, df), (g, dg)) = (quadratic(PLACES[a][0], xi[0]), quadratic(PLACES[a][1], xi[1]));
            [df * g, f * dg]
        })
    }

    fn extrapolation() -> [[f64; 9]; 9] {
        extrapolation_of_products(&PLACES, gauss())
    }
}
