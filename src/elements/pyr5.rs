//! Linear pyramid: nodes of the base counter-clockwise as seen from the apex, then the apex; 2 x 2 x 2 Gauss points.
//!
//! Reference coordinates are those of the cube [-1, 1]^3 whose face zeta = 1 is collapsed into the apex: a point of the cube corresponds to
//! the place `(xi (1 - zeta)/2, eta (1 - zeta)/2, zeta)` of the pyramid. In these the rational shape functions of G. Bedrosian
//! (International Journal for Numerical Methods in Engineering 35, 1992) are polynomials, `N = (1 + xi xi_a)(1 + eta eta_a)(1 - zeta)/8` at
//! the base and `(1 + zeta)/2` at the apex, so that Gauss points integrate them as exactly as those of a hexahedron.

use super::reference_cell::{CellRow, CellShape, ReferenceCell, extrapolation_of_products, gradients, quadrature, shape};

const PLACES: [[f64; 3]; 5] = [[-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [-1.0, 1.0, -1.0], [0.0, 0.0, 1.0]];

const FACETS: [&[usize]; 5] = [&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]];

pub(super) static ROW: CellRow = CellRow {
    name: "pyr5",
    summary: "linear pyramid with 5 nodes and 2 x 2 x 2 Gauss points",
    cell_shape: CellShape::Pyramid,
    dimension: 3,
    nodes: 5,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 3,
    vtk_type: 14,
    xdmf: (7, "Pyramid"),
    gmsh_type: 7,
    gmsh_order: &[],
    abaqus_order: &[],
    quadrature: quadrature::<Pyr5, 3, 5, 8>,
    shape: shape::<Pyr5, 3, 5, 8>,
    gradients: gradients::<Pyr5, 3, 5, 8>,
};

/// The linear pyramid.
pub struct Pyr5;

impl ReferenceCell<3, 5, 8> for Pyr5 {
    fn quadrature() -> [([f64; 3], f64); 8] {
        let x = 1.0 / 3f64.sqrt();
        std::array::from_fn(|q| ([0, 1, 2].map(|i| if q >> i & 1 == 0 { -x } else { x }), 1.0))
    }

    fn shape(xi: [f64; 3]) -> [f64; 5] {
        let base = |at: [f64; 3]| 0.125 * (1.0 + xi[0] * at[0]) * (1.0 + xi[1] * at[1]) * (1.0 - xi[2]);
        std::array::from_fn(|a| if a < 4 { base(PLACES[a]) } else { 0.5 * (1.0 + xi[2]) })
    }

    fn gradients(xi: [f64; 3]) -> [[f64; 3]; 5] {
        let base = |at: [f64; 3]| {
            let (x, y, z) = (1.0 + xi[0] * at[0], 1.0 + xi[1] * at[1], 1.0 - xi[2]);
            [0.125 * at[0] * y * z, 0.125 * at[1] * x * z, -0.125 * x * y]
        };
        std::array::from_fn(|a| if a < 4 { base(PLACES[a]) } else { [0.0, 0.0, 0.5] })
    }

    fn extrapolation() -> [[f64; 5]; 8] {
        extrapolation_of_products(&PLACES, Self::quadrature())
    }
}
