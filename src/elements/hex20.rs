//! Quadratic serendipity hexahedron: corners as in `hex8`, then the middles of the edges in the order of [`CellShape::edges`]; 3 x 3 x 3
//! Gauss points.
//!
//! `N = (1 + xi xi_a)(1 + eta eta_a)(1 + zeta zeta_a)(xi xi_a + eta eta_a + zeta zeta_a - 2)/8` at the corners, `(1 - xi^2)(1 + eta
//! eta_a)(1 + zeta zeta_a)/4` and corresponding functions at the middles (Hughes, The Finite Element Method, 2000, section 3.7).

use super::hex27::{self, gauss};
use super::reference_cell::{CellRow, CellShape, ReferenceCell, extrapolation_of_products, gradients, quadrature, shape};

/// Node positions in reference coordinates: those of `hex27` without the face centers and the cell center.
const PLACES: [[f64; 3]; 20] = *hex27::PLACES.first_chunk().expect("20 of 27");

const FACETS: [&[usize]; 6] = [
    &[0, 3, 2, 1, 11, 10, 9, 8],
    &[4, 5, 6, 7, 12, 13, 14, 15],
    &[0, 1, 5, 4, 8, 17, 12, 16],
    &[1, 2, 6, 5, 9, 18, 13, 17],
    &[2, 3, 7, 6, 10, 19, 14, 18],
    &[3, 0, 4, 7, 11, 16, 15, 19],
];

pub(super) static ROW: CellRow = CellRow {
    name: "hex20",
    summary: "quadratic hexahedron with 20 nodes and 3 x 3 x 3 Gauss points",
    cell_shape: CellShape::Hexahedron,
    dimension: 3,
    nodes: 20,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 5,
    vtk_type: 25,
    xdmf: (0x30, "Hexahedron_20"),
    gmsh_type: 17,
    gmsh_order: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
    abaqus_order: &[],
    quadrature: quadrature::<Hex20, 3, 20, 27>,
    shape: shape::<Hex20, 3, 20, 27>,
    gradients: gradients::<Hex20, 3, 20, 27>,
};

/// The quadratic serendipity hexahedron.
pub struct Hex20;

/// Direction of the edge whose midpoint has the reference coordinates `place`; `None` for a corner.
fn along(place: [f64; 3]) -> Option<usize> {
    place.iter().position(|&x| x == 0.0)
}

/// Linear shape function `(1 + x x_a)/2` of one direction, and its derivative.
fn linear(at: f64, x: f64) -> (f64, f64) {
    (0.5 * (1.0 + x * at), 0.5 * at)
}

impl ReferenceCell<3, 20, 27> for Hex20 {
    fn quadrature() -> [([f64; 3], f64); 27] {
        gauss()
    }

    fn shape(xi: [f64; 3]) -> [f64; 20] {
        PLACES.map(|place| {
            let factor = |i: usize| if along(place) == Some(i) { 1.0 - xi[i] * xi[i] } else { linear(place[i], xi[i]).0 };
            let product: f64 = (0..3).map(factor).product();
            if along(place).is_some() { product } else { product * ((0..3).map(|i| xi[i] * place[i]).sum::<f64>() - 2.0) }
        })
    }

    fn gradients(xi: [f64; 3]) -> [[f64; 3]; 20] {
        PLACES.map(|place| {
            let factor = [0, 1, 2].map(|i| match along(place) == Some(i) {
                true => (1.0 - xi[i] * xi[i], -2.0 * xi[i]),
                false => linear(place[i], xi[i]),
            });
            let slope = |i: usize| (0..3).map(|k| if k == i { factor[k].1 } else { factor[k].0 }).product::<f64>();
            if along(place).is_some() {
                return [0, 1, 2].map(slope);
            }
            let last = (0..3).map(|i| xi[i] * place[i]).sum::<f64>() - 2.0;
            let product = factor[0].0 * factor[1].0 * factor[2].0;
            [0, 1, 2].map(|i| slope(i) * last + product * place[i])
        })
    }

    fn extrapolation() -> [[f64; 20]; 27] {
        extrapolation_of_products(&PLACES, gauss())
    }
}
