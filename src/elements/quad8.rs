//! Quadratic serendipity quadrilateral: corners as in `quad4`, then the middles of the edges 1-2, 2-3, 3-4, 4-1; 3 x 3 Gauss points.
//!
//! `N = (1 + xi xi_a)(1 + eta eta_a)(xi xi_a + eta eta_a - 1)/4` at the corners, `(1 - xi^2)(1 + eta eta_a)/2` and corresponding functions
//! at the middles (Hughes, The Finite Element Method, 2000, section 3.7).

use super::quad9::{self, FACETS, gauss};
use super::reference_cell::{CellRow, CellShape, ReferenceCell, extrapolation_of_products, gradients, quadrature, shape};

/// Node positions in reference coordinates: those of `quad9` without the cell center.
const PLACES: [[f64; 3]; 8] = *quad9::PLACES.first_chunk().expect("eight of nine");

pub(super) static ROW: CellRow = CellRow {
    name: "quad8",
    summary: "quadratic quadrilateral with 8 nodes and 3 x 3 Gauss points",
    cell_shape: CellShape::Quadrilateral,
    dimension: 2,
    nodes: 8,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 5,
    vtk_type: 23,
    xdmf: (37, "Quadrilateral_8"),
    gmsh_type: 16,
    gmsh_order: &[],
    abaqus_order: &[],
    quadrature: quadrature::<Quad8, 2, 8, 9>,
    shape: shape::<Quad8, 2, 8, 9>,
    gradients: gradients::<Quad8, 2, 8, 9>,
};

/// The quadratic serendipity quadrilateral.
pub struct Quad8;

impl ReferenceCell<2, 8, 9> for Quad8 {
    fn quadrature() -> [([f64; 2], f64); 9] {
        gauss()
    }

    fn shape([x, y]: [f64; 2]) -> [f64; 8] {
        PLACES.map(|[a, b, _]| match (a == 0.0, b == 0.0) {
            (true, _) => 0.5 * (1.0 - x * x) * (1.0 + y * b),
            (_, true) => 0.5 * (1.0 + x * a) * (1.0 - y * y),
            _ => 0.25 * (1.0 + x * a) * (1.0 + y * b) * (x * a + y * b - 1.0),
        })
    }

    fn gradients([x, y]: [f64; 2]) -> [[f64; 2]; 8] {
        PLACES.map(|[a, b, _]| match (a == 0.0, b == 0.0) {
            (true, _) => [-x * (1.0 + y * b), 0.5 * (1.0 - x * x) * b],
            (_, true) => [0.5 * a * (1.0 - y * y), -y * (1.0 + x * a)],
            _ => [0.25 * a * (1.0 + y * b) * (2.0 * x * a + y * b), 0.25 * b * (1.0 + x * a) * (x * a + 2.0 * y * b)],
        })
    }

    fn extrapolation() -> [[f64; 8]; 9] {
        extrapolation_of_products(&PLACES, gauss())
    }
}
