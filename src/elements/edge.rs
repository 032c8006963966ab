//! Edges with two or three nodes, and the Gauss points on them.

/// Three Gauss points of an edge, `s` from -1 to 1, and their weights.
pub fn edge_points() -> [(f64, f64); 3] {
    [(-0.6f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6f64.sqrt(), 5.0 / 9.0)]
}

/// Shape functions of an edge and their slopes at `s`: its ends, then its middle node if it has one.
pub fn edge_shapes(nodes: usize, s: f64) -> ([f64; 3], [f64; 3]) {
    if nodes == 2 {
        ([0.5 * (1.0 - s), 0.5 * (1.0 + s), 0.0], [-0.5, 0.5, 0.0])
    } else {
        ([0.5 * s * (s - 1.0), 0.5 * s * (s + 1.0), 1.0 - s * s], [s - 0.5, s + 0.5, -2.0 * s])
    }
}

/// Quadratic shape function on the interval [-1, 1] that is 1 at its node `at` and 0 at the other two, and its derivative.
pub(super) fn quadratic(at: f64, x: f64) -> (f64, f64) {
    if at == 0.0 { (1.0 - x * x, -2.0 * x) } else { (0.5 * x * (x + at), x + 0.5 * at) }
}
