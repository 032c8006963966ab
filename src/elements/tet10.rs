//! Quadratic tetrahedron: corners as in `tet4`, then the middles of the edges in the order of [`CellShape::edges`]; four points.
//!
//! `N = L (2 L - 1)` at the corners, `4 L_a L_b` at the middles, in volume coordinates (Hughes, The Finite Element Method, 2000, section
//! 3.I). Four points of degree two (Hammer and Stroud 1956) are exact for the stiffness of straight cells. The mass matrix has the exact
//! integrals, in 420ths of the volume: 6 for a corner with itself, 1 for two corners; -4 for a corner and the middle of an edge that ends
//! there, -6 of another edge; 32 for a middle with itself, 16 for middles of edges with a common corner, 8 of opposite edges.

use super::reference_cell::{CellRow, CellShape, ReferenceCell, gradients, quadrature, shape};

const PLACES: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
    [0.0, 0.0, 0.5],
    [0.5, 0.0, 0.5],
    [0.0, 0.5, 0.5],
];

const FACETS: [&[usize]; 4] = [&[0, 2, 1, 6, 5, 4], &[0, 1, 3, 4, 8, 7], &[1, 2, 3, 5, 9, 8], &[2, 0, 3, 6, 7, 9]];

pub(super) static ROW: CellRow = CellRow {
    name: "tet10",
    summary: "quadratic tetrahedron with 10 nodes and 4 points: for meshes of any shape",
    cell_shape: CellShape::Tetrahedron,
    dimension: 3,
    nodes: 10,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 2,
    vtk_type: 24,
    xdmf: (0x26, "Tetrahedron_10"),
    gmsh_type: 11,
    gmsh_order: &[0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
    abaqus_order: &[],
    quadrature: quadrature::<Tet10, 3, 10, 4>,
    shape: shape::<Tet10, 3, 10, 4>,
    gradients: gradients::<Tet10, 3, 10, 4>,
};

/// The quadratic tetrahedron.
pub struct Tet10;

/// Volume coordinates and their gradients.
fn volume([x, y, z]: [f64; 3]) -> ([f64; 4], [[f64; 3]; 4]) {
    ([1.0 - x - y - z, x, y, z], [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

/// Corners at the ends of the edge whose middle a node is; for a corner node, this corner twice.
fn ends(node: usize) -> [usize; 2] {
    if node < 4 { [node; 2] } else { CellShape::Tetrahedron.edges()[node - 4] }
}

/// Volume coordinates of a quadrature point: `NEAR` of the nearest corner, `FAR` of the other three.
const NEAR: f64 = 0.585_410_196_624_968_5;
const FAR: f64 = 0.138_196_601_125_010_5;

impl ReferenceCell<3, 10, 4> for Tet10 {
    fn quadrature() -> [([f64; 3], f64); 4] {
        [[FAR; 3], [NEAR, FAR, FAR], [FAR, NEAR, FAR], [FAR, FAR, NEAR]].map(|xi| (xi, 1.0 / 24.0))
    }

    fn shape(xi: [f64; 3]) -> [f64; 10] {
        let (l, _) = volume(xi);
        std::array::from_fn(|node| {
            let [a, b] = ends(node);
            if a == b { l[a] * (2.0 * l[a] - 1.0) } else { 4.0 * l[a] * l[b] }
        })
    }

    fn gradients(xi: [f64; 3]) -> [[f64; 3]; 10] {
        let (l, d) = volume(xi);
        std::array::from_fn(|node| {
            let [a, b] = ends(node);
            std::array::from_fn(|i| if a == b { (4.0 * l[a] - 1.0) * d[a][i] } else { 4.0 * (l[a] * d[b][i] + l[b] * d[a][i]) })
        })
    }

    fn products() -> [[[f64; 10]; 10]; 4] {
        let entry = |one: usize, other: usize| {
            let (a, b) = (ends(one), ends(other));
            let common = a.iter().filter(|end| b.contains(end)).count();
            let in_420ths = match (one < 4, other < 4) {
                (true, true) => {
                    if one == other {
                        6.0
                    } else {
                        1.0
                    }
                }
                (false, false) => [8.0, 16.0, 32.0][common],
                _ => {
                    if common > 0 {
                        -4.0
                    } else {
                        -6.0
                    }
                }
            };
            in_420ths / 420.0
        };
        [std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b))); 4]
    }

    fn extrapolation() -> [[f64; 10]; 4] {
        // The values at the four points determine a linear function, which is extrapolated to the nodes.
        std::array::from_fn(|q| PLACES.map(|place| (volume(place).0[q] - FAR) / (NEAR - FAR)))
    }
}
