//! Linear tetrahedron on the corners (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), one point.
//!
//! Shape functions are the volume coordinates (Hughes, The Finite Element Method, 2000, section 3.I). The strain is constant, so one point
//! is exact; the mass is that of the exact integrals `(1 + delta_ab)/20`.

use super::reference_cell::{CellRow, CellShape, ReferenceCell, gradients, quadrature, shape};

const PLACES: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

const FACETS: [&[usize]; 4] = [&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];

pub(super) static ROW: CellRow = CellRow {
    name: "tet4",
    summary: "linear tetrahedron with 4 nodes and 1 point: stiff, for given meshes of this kind",
    cell_shape: CellShape::Tetrahedron,
    dimension: 3,
    nodes: 4,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 1,
    vtk_type: 10,
    xdmf: (6, "Tetrahedron"),
    gmsh_type: 4,
    gmsh_order: &[],
    abaqus_order: &[],
    quadrature: quadrature::<Tet4, 3, 4, 1>,
    shape: shape::<Tet4, 3, 4, 1>,
    gradients: gradients::<Tet4, 3, 4, 1>,
};

/// The linear tetrahedron.
pub struct Tet4;

impl ReferenceCell<3, 4, 1> for Tet4 {
    fn quadrature() -> [([f64; 3], f64); 1] {
        [([0.25; 3], 1.0 / 6.0)]
    }

    fn shape([xi, eta, zeta]: [f64; 3]) -> [f64; 4] {
        [1.0 - xi - eta - zeta, xi, eta, zeta]
    }

    fn gradients(_: [f64; 3]) -> [[f64; 3]; 4] {
        [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    }

    fn products() -> [[[f64; 4]; 4]; 1] {
        [std::array::from_fn(|a| std::array::from_fn(|b| if a == b { 0.1 } else { 0.05 }))]
    }

    fn extrapolation() -> [[f64; 4]; 1] {
        [[1.0; 4]]
    }
}
