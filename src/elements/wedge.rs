//! Functions that linear and quadratic wedges share: nodes, points of a triangle by points along the axis, extrapolation.

/// Node positions of `wedge15` in reference coordinates; those of `wedge6` are the first six.
pub(super) const PLACES: [[f64; 3]; 15] = [
    [0.0, 0.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, -1.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [0.5, 0.0, -1.0],
    [0.5, 0.5, -1.0],
    [0.0, 0.5, -1.0],
    [0.5, 0.0, 1.0],
    [0.5, 0.5, 1.0],
    [0.0, 0.5, 1.0],
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
];

/// Area coordinates of the triangle and their gradients.
pub(super) fn area([xi, eta, _]: [f64; 3]) -> ([f64; 3], [[f64; 2]; 3]) {
    ([1.0 - xi - eta, xi, eta], [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
}

/// `(1 + z z_a)/2` along the axis, and its slope.
pub(super) fn linear(at: f64, z: f64) -> (f64, f64) {
    (0.5 * (1.0 + z * at), 0.5 * at)
}

/// Three points of degree two in the triangle for each point along the axis.
pub(super) fn points<const N: usize>(along: [(f64, f64); N]) -> Vec<([f64; 3], f64)> {
    let (near, far) = (1.0 / 6.0, 2.0 / 3.0);
    let triangle = [[near, near], [far, near], [near, far]];
    along.into_iter().flat_map(|(z, weight)| triangle.map(|[xi, eta]| ([xi, eta, z], weight / 6.0))).collect()
}

/// Extrapolation from [`points`]: linear in the triangle, by Legendre's polynomials along the axis (`extrapolation_of_products`).
pub(super) fn extrapolation<const A: usize, const Q: usize>(places: &[[f64; 3]; A], points: [([f64; 3], f64); Q]) -> [[f64; A]; Q] {
    let legendre = |x: f64| [1.0, x, 0.5 * (3.0 * x * x - 1.0)];
    std::array::from_fn(|q| {
        let (at, weight) = points[q];
        places.map(|place| {
            let (own, z) = (2.0 * area(place).0[q % 3] - 1.0 / 3.0, [legendre(place[2]), legendre(at[2])]);
            let along: f64 = (0..Q / 3).map(|k| (k as f64 + 0.5) * z[0][k] * z[1][k]).sum();
            own * along * 6.0 * weight
        })
    })
}
