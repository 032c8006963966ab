//! Quadratic triangle: corners as in `tri3`, then the middles of the edges 1-2, 2-3, 3-1; three points.
//!
//! `N = L (2 L - 1)` at the corners, `4 L_a L_b` at the middles, in area coordinates (Hughes, The Finite Element Method, 2000, section
//! 3.I). Three points of degree two (Strang and Fix 1973) are exact for the stiffness of straight cells. The mass matrix has the exact
//! integrals, relative to the area: 1/30 for a corner with itself, -1/180 for two corners, -1/45 for a corner and the middle of the
//! opposite edge, 0 for a corner and the middle of an edge that ends there, 8/45 for a middle with itself, 4/45 for two middles.

use super::reference_cell::{CellRow, CellShape, ReferenceCell, gradients, quadrature, shape};

const PLACES: [[f64; 3]; 6] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.0]];

const FACETS: [&[usize]; 3] = [&[0, 1, 3], &[1, 2, 4], &[2, 0, 5]];

pub(super) static ROW: CellRow = CellRow {
    name: "tri6",
    summary: "quadratic triangle with 6 nodes and 3 points",
    cell_shape: CellShape::Triangle,
    dimension: 2,
    nodes: 6,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 2,
    vtk_type: 22,
    xdmf: (36, "Triangle_6"),
    gmsh_type: 9,
    gmsh_order: &[],
    abaqus_order: &[],
    quadrature: quadrature::<Tri6, 2, 6, 3>,
    shape: shape::<Tri6, 2, 6, 3>,
    gradients: gradients::<Tri6, 2, 6, 3>,
};

/// The quadratic triangle.
pub struct Tri6;

/// Area coordinates and their gradients.
fn area([xi, eta]: [f64; 2]) -> ([f64; 3], [[f64; 2]; 3]) {
    ([1.0 - xi - eta, xi, eta], [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
}

impl ReferenceCell<2, 6, 3> for Tri6 {
    fn quadrature() -> [([f64; 2], f64); 3] {
        let (near, far) = (1.0 / 6.0, 2.0 / 3.0);
        [[near, near], [far, near], [near, far]].map(|xi| (xi, 1.0 / 6.0))
    }

    fn shape(xi: [f64; 2]) -> [f64; 6] {
        let (l, _) = area(xi);
        std::array::from_fn(|a| if a < 3 { l[a] * (2.0 * l[a] - 1.0) } else { 4.0 * l[a - 3] * l[(a - 2) % 3] })
    }

    fn gradients(xi: [f64; 2]) -> [[f64; 2]; 6] {
        let (l, d) = area(xi);
        std::array::from_fn(|a| {
            std::array::from_fn(|i| {
                if a < 3 {
                    (4.0 * l[a] - 1.0) * d[a][i]
                } else {
                    let (b, c) = (a - 3, (a - 2) % 3);
                    4.0 * (l[b] * d[c][i] + l[c] * d[b][i])
                }
            })
        })
    }

    fn products() -> [[[f64; 6]; 6]; 3] {
        // Integrals over the cell of products of shape functions, relative to the area.
        let entry = |a: usize, b: usize| match (a.min(b), a.max(b)) {
            (corner, other) if other < 3 => {
                if corner == other {
                    1.0 / 30.0
                } else {
                    -1.0 / 180.0
                }
            }
            (corner, middle) if corner < 3 => {
                if (middle - 3 + 2) % 3 == corner {
                    -1.0 / 45.0
                } else {
                    0.0
                }
            }
            (middle, other) => {
                if middle == other {
                    8.0 / 45.0
                } else {
                    4.0 / 45.0
                }
            }
        };
        [std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b))); 3]
    }

    fn extrapolation() -> [[f64; 6]; 3] {
        // Linear function through three points, each with 2/3 as the area coordinate of its nearest corner and 1/6 of the others.
        std::array::from_fn(|q| PLACES.map(|[x, y, _]| 2.0 * area([x, y]).0[q] - 1.0 / 3.0))
    }
}
