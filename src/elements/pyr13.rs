//! Quadratic pyramid: corners as in `pyr5`, then the middles of the edges in the order of [`CellShape::edges`]; 3 x 3 x 3 Gauss points.
//!
//! In the coordinates of `pyr5`, with `t = (1 - zeta)/2`, the rational functions of G. Bedrosian (International Journal for Numerical
//! Methods in Engineering 35, 1992) span the polynomials of degree two of the pyramid with `xi eta t`, `xi^2 eta t^2` and `xi eta^2 t^2`:
//!
//! ```text
//! corners of the base   (1 + x)(1 + y) t (t (x + y) - 1)/4 with x = xi xi_a, y = eta eta_a      apex   (1 - t)(1 - 2 t)
//! middles of the base   (1 - xi^2)(1 + y) t^2/2 etc.                               of rising edges   (1 + x)(1 + y) t (1 - t)
//! ```

use super::hex27::gauss;
use super::reference_cell::{CellRow, CellShape, ReferenceCell, extrapolation_of_products, gradients, quadrature, shape};

const PLACES: [[f64; 3]; 13] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [0.0, 0.0, 1.0],
    [0.0, -1.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, -1.0],
    [-1.0, 0.0, -1.0],
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
];

const FACETS: [&[usize]; 5] =
    [&[0, 3, 2, 1, 8, 7, 6, 5], &[0, 1, 4, 5, 10, 9], &[1, 2, 4, 6, 11, 10], &[2, 3, 4, 7, 12, 11], &[3, 0, 4, 8, 9, 12]];

pub(super) static ROW: CellRow = CellRow {
    name: "pyr13",
    summary: "quadratic pyramid with 13 nodes and 3 x 3 x 3 Gauss points",
    cell_shape: CellShape::Pyramid,
    dimension: 3,
    nodes: 13,
    node_places: &PLACES,
    facets: &FACETS,
    exact_power: 5,
    vtk_type: 27,
    xdmf: (0x27, "Pyramid_13"),
    gmsh_type: 19,
    gmsh_order: &[0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12],
    abaqus_order: &[],
    quadrature: quadrature::<Pyr13, 3, 13, 27>,
    shape: shape::<Pyr13, 3, 13, 27>,
    gradients: gradients::<Pyr13, 3, 13, 27>,
};

/// The quadratic pyramid.
pub struct Pyr13;

/// Value and gradient of a function with respect to `xi`, `eta` and `t`.
type Function = (f64, [f64; 3]);

/// Product of functions of `xi`, `eta` and `t`, each given with its derivative.
fn product((x, dx): (f64, f64), (y, dy): (f64, f64), (t, dt): (f64, f64)) -> Function {
    (x * y * t, [dx * y * t, x * dy * t, x * y * dt])
}

/// The shape function of a node at `xi`, `eta`, `t`.
fn function(node: usize, [xi, eta, t]: [f64; 3]) -> Function {
    let [a, b, _] = PLACES[node];
    let side = |x: f64, at: f64| if at == 0.0 { (1.0 - x * x, -2.0 * x) } else { (1.0 + x * at, at) };
    let (x, y) = (side(xi, a), side(eta, b));
    match node {
        0..4 => {
            let (value, slopes) = product(x, y, (t, 1.0));
            let last = 0.25 * (t * (xi * a + eta * b) - 1.0);
            let of_last = [0.25 * t * a, 0.25 * t * b, 0.25 * (xi * a + eta * b)];
            (value * last, [0, 1, 2].map(|i| slopes[i] * last + value * of_last[i]))
        }
        4 => ((1.0 - t) * (1.0 - 2.0 * t), [0.0, 0.0, 4.0 * t - 3.0]),
        5..9 => product(x, y, (0.5 * t * t, t)),
        _ => product(x, y, (t * (1.0 - t), 1.0 - 2.0 * t)),
    }
}

impl ReferenceCell<3, 13, 27> for Pyr13 {
    fn quadrature() -> [([f64; 3], f64); 27] {
        gauss()
    }

    fn shape([xi, eta, zeta]: [f64; 3]) -> [f64; 13] {
        std::array::from_fn(|node| function(node, [xi, eta, 0.5 * (1.0 - zeta)]).0)
    }

    fn gradients([xi, eta, zeta]: [f64; 3]) -> [[f64; 3]; 13] {
        std::array::from_fn(|node| {
            let (_, [x, y, t]) = function(node, [xi, eta, 0.5 * (1.0 - zeta)]);
            [x, y, -0.5 * t]
        })
    }

    fn extrapolation() -> [[f64; 13]; 27] {
        extrapolation_of_products(&PLACES, gauss())
    }
}
