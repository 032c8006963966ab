//! Quadratic wedge: corners as in `wedge6`, then the middles of the edges in the order of [`CellShape::edges`]; 3 x 3 points.
//!
//! `N = L ((2 L - 1)(1 + zeta zeta_a) - (1 - zeta^2))/2` at the corners, `2 L_a L_b (1 + zeta zeta_a)` at the middles of the triangles'
//! edges, `L (1 - zeta^2)` at those along the axis (O. C. Zienkiewicz, R. L. Taylor, The Finite Element Method, volume 1, 2000, section
//! 8.12). The points are exact for the stiffness of straight cells, as those of `tri6` are; the mass is that of the exact integrals.

use super::edge::edge_points;
use super::reference_cell::{CellRow, CellShape, ReferenceCell, gradients, quadrature, shape};
use super::wedge::{self, PLACES, area, linear};

const FACETS: [&[usize]; 5] =
    [&[0, 2, 1, 8, 7, 6], &[3, 4, 5, 9, 10, 11], &[0, 1, 4, 3, 6, 13, 9, 12], &[1, 2, 5, 4, 7, 14, 10, 13], &[2, 0, 3, 5, 8, 12, 11, 14]];

pub(super) static ROW: CellRow = CellRow {
    name: "wedge15",
    summary: "quadratic wedge (prism over a triangle) with 15 nodes and 3 x 3 points",
    cell_shape: CellShape::Wedge,
    dimension: 3,
    nodes: 15,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 2,
    vtk_type: 26,
    xdmf: (0x28, "Wedge_15"),
    gmsh_type: 18,
    gmsh_order: &[0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11],
    abaqus_order: &[],
    quadrature: quadrature::<Wedge15, 3, 15, 9>,
    shape: shape::<Wedge15, 3, 15, 9>,
    gradients: gradients::<Wedge15, 3, 15, 9>,
};

/// The quadratic wedge.
pub struct Wedge15;

/// Corners at the ends of the triangle edge whose middle is node `6 + number`.
fn ends(number: usize) -> [usize; 2] {
    [number % 3, (number + 1) % 3]
}

impl ReferenceCell<3, 15, 9> for Wedge15 {
    fn quadrature() -> [([f64; 3], f64); 9] {
        wedge::points(edge_points()).try_into().expect("3 x 3 points")
    }

    fn shape(xi: [f64; 3]) -> [f64; 15] {
        let ((l, _), z) = (area(xi), xi[2]);
        std::array::from_fn(|a| {
            let (along, _) = linear(PLACES[a][2], z);
            match a {
                0..6 => l[a % 3] * ((2.0 * l[a % 3] - 1.0) * along - 0.5 * (1.0 - z * z)),
                6..12 => {
                    let [b, c] = ends(a - 6);
                    4.0 * l[b] * l[c] * along
                }
                _ => l[a - 12] * (1.0 - z * z),
            }
        })
    }

    fn gradients(xi: [f64; 3]) -> [[f64; 3]; 15] {
        let ((l, d), z) = (area(xi), xi[2]);
        std::array::from_fn(|a| {
            let (along, slope) = linear(PLACES[a][2], z);
            match a {
                0..6 => {
                    let (l, d) = (l[a % 3], d[a % 3]);
                    let of_l = (4.0 * l - 1.0) * along - 0.5 * (1.0 - z * z);
                    [of_l * d[0], of_l * d[1], l * ((2.0 * l - 1.0) * slope + z)]
                }
                6..12 => {
                    let [b, c] = ends(a - 6);
                    let of_plane = |i: usize| 4.0 * (l[b] * d[c][i] + l[c] * d[b][i]) * along;
                    [of_plane(0), of_plane(1), 4.0 * l[b] * l[c] * slope]
                }
                _ => {
                    let (l, d, across) = (l[a - 12], d[a - 12], 1.0 - z * z);
                    [d[0] * across, d[1] * across, -2.0 * l * z]
                }
            }
        })
    }

    fn products() -> [[[f64; 15]; 15]; 9] {
        let mut mass = [[0.0; 15]; 15];
        for (xi, weight) in CellShape::Wedge.mass_points() {
            let shapes = Self::shape(xi);
            for (row, a) in mass.iter_mut().zip(shapes) {
                row.iter_mut().zip(shapes).for_each(|(sum, b)| *sum += weight * a * b);
            }
        }
        // The reference cell has the volume 1: products are summed to the mass of a unit volume.
        [mass; 9]
    }

    fn extrapolation() -> [[f64; 15]; 9] {
        wedge::extrapolation(&PLACES, Self::quadrature())
    }
}
