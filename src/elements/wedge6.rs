//! Linear wedge: the triangle of `tri3` at zeta = -1, counter-clockwise as seen from the other one at zeta = 1; 3 x 2 points.
//!
//! Shape functions `N = L_a (1 + zeta zeta_a)/2` with area coordinates `L` (Hughes, The Finite Element Method, 2000, section 3.I). Three
//! points of the triangle by two along the axis: with one of the triangle the torsion of a cell about its axis would have no energy.

use super::reference_cell::{CellRow, CellShape, ReferenceCell, gradients, quadrature, shape};
use super::wedge::{self, area, linear};

const PLACES: [[f64; 3]; 6] = *wedge::PLACES.first_chunk().expect("6 of 15");

const FACETS: [&[usize]; 5] = [&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]];

pub(super) static ROW: CellRow = CellRow {
    name: "wedge6",
    summary: "linear wedge (prism over a triangle) with 6 nodes and 3 x 2 points",
    cell_shape: CellShape::Wedge,
    dimension: 3,
    nodes: 6,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 2,
    vtk_type: 13,
    xdmf: (8, "Wedge"),
    gmsh_type: 6,
    gmsh_order: &[],
    abaqus_order: &[],
    quadrature: quadrature::<Wedge6, 3, 6, 6>,
    shape: shape::<Wedge6, 3, 6, 6>,
    gradients: gradients::<Wedge6, 3, 6, 6>,
};

/// The linear wedge.
pub struct Wedge6;

impl ReferenceCell<3, 6, 6> for Wedge6 {
    fn quadrature() -> [([f64; 3], f64); 6] {
        let z = 1.0 / 3f64.sqrt();
        wedge::points([(-z, 1.0), (z, 1.0)]).try_into().expect("3 x 2 points")
    }

    fn shape(xi: [f64; 3]) -> [f64; 6] {
        let (l, _) = area(xi);
        std::array::from_fn(|a| l[a % 3] * linear(PLACES[a][2], xi[2]).0)
    }

    fn gradients(xi: [f64; 3]) -> [[f64; 3]; 6] {
        let (l, d) = area(xi);
        std::array::from_fn(|a| {
            let (value, slope) = linear(PLACES[a][2], xi[2]);
            [d[a % 3][0] * value, d[a % 3][1] * value, l[a % 3] * slope]
        })
    }

    fn extrapolation() -> [[f64; 6]; 6] {
        wedge::extrapolation(&PLACES, Self::quadrature())
    }
}
