//! Trilinear hexahedron on the cube [-1, 1]^3, nodes counter-clockwise at zeta = -1, then at zeta = 1, 2 x 2 x 2 Gauss points.
//!
//! Shape functions `N_a = (1 + xi xi_a)(1 + eta eta_a)(1 + zeta zeta_a) / 8` (Hughes, The Finite Element Method, 2000, section 3.5).

use super::hex27;
use super::reference_cell::{CellRow, CellShape, ReferenceCell, extrapolation_of_products, gradients, quadrature, shape};

const CORNERS: [[f64; 3]; 8] = *hex27::PLACES.first_chunk().expect("8 of 27");

const FACETS: [&[usize]; 6] = [&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];

pub(super) static ROW: CellRow = CellRow {
    name: "hex8",
    summary: "trilinear hexahedron with 8 nodes and 2 x 2 x 2 Gauss points",
    cell_shape: CellShape::Hexahedron,
    dimension: 3,
    nodes: 8,
    node_places: &CORNERS,
    facets: &FACETS,
    exact_power: 3,
    vtk_type: 12,
    xdmf: (9, "Hexahedron"),
    gmsh_type: 5,
    gmsh_order: &[],
    abaqus_order: &[],
    quadrature: quadrature::<Hex8, 3, 8, 8>,
    shape: shape::<Hex8, 3, 8, 8>,
    gradients: gradients::<Hex8, 3, 8, 8>,
};

/// The trilinear hexahedron.
pub struct Hex8;

impl ReferenceCell<3, 8, 8> for Hex8 {
    fn quadrature() -> [([f64; 3], f64); 8] {
        CORNERS.map(|corner| (corner.map(|c| c / 3f64.sqrt()), 1.0))
    }

    fn shape(xi: [f64; 3]) -> [f64; 8] {
        CORNERS.map(|c| 0.125 * (1.0 + xi[0] * c[0]) * (1.0 + xi[1] * c[1]) * (1.0 + xi[2] * c[2]))
    }

    fn gradients(xi: [f64; 3]) -> [[f64; 3]; 8] {
        CORNERS.map(|c| {
            let factor = [0, 1, 2].map(|i| 1.0 + xi[i] * c[i]);
            [0.125 * c[0] * factor[1] * factor[2], 0.125 * c[1] * factor[0] * factor[2], 0.125 * c[2] * factor[0] * factor[1]]
        })
    }

    fn extrapolation() -> [[f64; 8]; 8] {
        extrapolation_of_products(&CORNERS, Self::quadrature())
    }
}
