//! Linear triangle on the corners (0, 0), (1, 0), (0, 1), nodes counter-clockwise, one point.
//!
//! Shape functions are the area coordinates `L_1 = 1 - xi - eta`, `L_2 = xi`, `L_3 = eta` (Hughes, The Finite Element Method, 2000,
//! section 3.I). The strain is constant, so one point is exact; the mass is that of the exact integrals `(1 + delta_ab)/12`.

use super::reference_cell::{CellRow, CellShape, ReferenceCell, gradients, quadrature, shape};

const PLACES: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

const FACETS: [&[usize]; 3] = [&[0, 1], &[1, 2], &[2, 0]];

pub(super) static ROW: CellRow = CellRow {
    name: "tri3",
    summary: "linear triangle with 3 nodes and 1 point: stiff, for given meshes of this kind",
    cell_shape: CellShape::Triangle,
    dimension: 2,
    nodes: 3,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 1,
    vtk_type: 5,
    xdmf: (4, "Triangle"),
    gmsh_type: 2,
    gmsh_order: &[],
    abaqus_order: &[],
    quadrature: quadrature::<Tri3, 2, 3, 1>,
    shape: shape::<Tri3, 2, 3, 1>,
    gradients: gradients::<Tri3, 2, 3, 1>,
};

/// The linear triangle.
pub struct Tri3;

impl ReferenceCell<2, 3, 1> for Tri3 {
    fn quadrature() -> [([f64; 2], f64); 1] {
        [([1.0 / 3.0; 2], 0.5)]
    }

    fn shape([xi, eta]: [f64; 2]) -> [f64; 3] {
        [1.0 - xi - eta, xi, eta]
    }

    fn gradients(_: [f64; 2]) -> [[f64; 2]; 3] {
        [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]
    }

    fn products() -> [[[f64; 3]; 3]; 1] {
        [std::array::from_fn(|a| std::array::from_fn(|b| if a == b { 1.0 / 6.0 } else { 1.0 / 12.0 }))]
    }

    fn extrapolation() -> [[f64; 3]; 1] {
        [[1.0; 3]]
    }
}
