//! Triquadratic hexahedron: corners as in `hex8`, the middles of the edges in the order of [`CellShape::edges`], those of the faces
//! xi = -1, xi = 1, eta = -1, eta = 1, zeta = -1, zeta = 1, the center; 3 x 3 x 3 Gauss points.
//!
//! Shape functions are products of the quadratic ones of an interval, as in `quad9` (Hughes, The Finite Element Method, 2000, section 3.6).

use super::edge::{edge_points, quadratic};
use super::reference_cell::{CellRow, CellShape, ReferenceCell, extrapolation_of_products, gradients, quadrature, shape};

pub(super) const PLACES: [[f64; 3]; 27] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [0.0, -1.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, -1.0],
    [-1.0, 0.0, -1.0],
    [0.0, -1.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [-1.0, 0.0, 1.0],
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [-1.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, -1.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, 0.0],
];

const FACETS: [&[usize]; 6] = [
    &[0, 3, 2, 1, 11, 10, 9, 8, 24],
    &[4, 5, 6, 7, 12, 13, 14, 15, 25],
    &[0, 1, 5, 4, 8, 17, 12, 16, 22],
    &[1, 2, 6, 5, 9, 18, 13, 17, 21],
    &[2, 3, 7, 6, 10, 19, 14, 18, 23],
    &[3, 0, 4, 7, 11, 16, 15, 19, 20],
];

pub(super) static ROW: CellRow = CellRow {
    name: "hex27",
    summary: "triquadratic hexahedron with 27 nodes and 3 x 3 x 3 Gauss points: the most accurate and most expensive",
    cell_shape: CellShape::Hexahedron,
    dimension: 3,
    nodes: 27,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 5,
    vtk_type: 29,
    xdmf: (0x32, "Hexahedron_27"),
    gmsh_type: 12,
    gmsh_order: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26],
    // Abaqus numbers the center, then the faces in the order of the sides.
    abaqus_order: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 26, 24, 23, 25, 21, 22, 20],
    quadrature: quadrature::<Hex27, 3, 27, 27>,
    shape: shape::<Hex27, 3, 27, 27>,
    gradients: gradients::<Hex27, 3, 27, 27>,
};

/// The triquadratic hexahedron.
pub struct Hex27;

/// 3 x 3 x 3 Gauss points.
pub(super) fn gauss() -> [([f64; 3], f64); 27] {
    let points = edge_points();
    std::array::from_fn(|q| {
        let ((x, u), (y, v), (z, w)) = (points[q % 3], points[q / 3 % 3], points[q / 9]);
        ([x, y, z], u * v * w)
    })
}

impl ReferenceCell<3, 27, 27> for Hex27 {
    fn quadrature() -> [([f64; 3], f64); 27] {
        gauss()
    }

    fn shape(xi: [f64; 3]) -> [f64; 27] {
        PLACES.map(|place| (0..3).map(|i| quadratic(place[i], xi[i]).0).product())
    }

    fn gradients(xi: [f64; 3]) -> [[f64; 3]; 27] {
        PLACES.map(|place| {
            let [(f, df), (g, dg), (h, dh)] = [0, 1, 2].map(|i| quadratic(place[i], xi[i]));
            [df * g * h, f * dg * h, f * g * dh]
        })
    }

    fn extrapolation() -> [[f64; 27]; 27] {
        extrapolation_of_products(&PLACES, gauss())
    }
}
