//! Bilinear quadrilateral on the square [-1, 1]^2, nodes counter-clockwise from (-1, -1), 2 x 2 Gauss points.
//!
//! Shape functions `N_a = (1 + xi xi_a)(1 + eta eta_a) / 4` (Hughes, The Finite Element Method, 2000, section 3.2).

use super::reference_cell::{CellRow, CellShape, ReferenceCell, extrapolation_of_products, gradients, quadrature, shape};

const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

const PLACES: [[f64; 3]; 4] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];

const FACETS: [&[usize]; 4] = [&[0, 1], &[1, 2], &[2, 3], &[3, 0]];

pub(super) static ROW: CellRow = CellRow {
    name: "quad4",
    summary: "bilinear quadrilateral with 4 nodes and 2 x 2 Gauss points",
    cell_shape: CellShape::Quadrilateral,
    dimension: 2,
    nodes: 4,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 3,
    vtk_type: 9,
    xdmf: (5, "Quadrilateral"),
    gmsh_type: 3,
    gmsh_order: &[],
    abaqus_order: &[],
    quadrature: quadrature::<Quad4, 2, 4, 4>,
    shape: shape::<Quad4, 2, 4, 4>,
    gradients: gradients::<Quad4, 2, 4, 4>,
};

/// The bilinear quadrilateral.
pub struct Quad4;

impl ReferenceCell<2, 4, 4> for Quad4 {
    fn quadrature() -> [([f64; 2], f64); 4] {
        CORNERS.map(|corner| (corner.map(|c| c / 3f64.sqrt()), 1.0))
    }

    fn shape(xi: [f64; 2]) -> [f64; 4] {
        CORNERS.map(|c| 0.25 * (1.0 + xi[0] * c[0]) * (1.0 + xi[1] * c[1]))
    }

    fn gradients(xi: [f64; 2]) -> [[f64; 2]; 4] {
        CORNERS.map(|c| [0.25 * c[0] * (1.0 + xi[1] * c[1]), 0.25 * c[1] * (1.0 + xi[0] * c[0])])
    }

    fn extrapolation() -> [[f64; 4]; 4] {
        extrapolation_of_products(&PLACES, Self::quadrature())
    }
}
