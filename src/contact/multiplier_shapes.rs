//! Shape functions of the multipliers on a facet of the plane: standard and dual ones.

use super::pair::PerNode;

/// Multiplier shape functions of a facet as combinations of its linear ones.
pub type Shape = PerNode<PerNode<f64>>;

/// Linear shape functions.
pub const STANDARD: Shape = [[1.0, 0.0], [0.0, 1.0]];

/// Biorthogonal to the linear ones: `int psi_A N_B ds = delta_AB int N_B ds` (Wohlmuth, SIAM J. Numer. Anal. 38, 2000).
pub const DUAL: Shape = [[2.0, -1.0], [-1.0, 2.0]];

/// Radius of the inner node of a facet over that of the outer one below which the facet is next to the axis.
const NEXT_TO_AXIS: f64 = 0.1;

/// Dual shape functions `psi = diag(G r / r) G^-1 N` of a facet around the axis, `G = int N N^T ds`, with the radii `r` of its nodes: each
/// multiplier presses its own node alone, and `sum r_A psi_A` is the radius, so that multipliers `p r_A` are a uniform pressure. With the
/// functions of the plane it is 8 % off. Next to the axis, where `1/r` grows without bound, facets have the standard functions.
pub fn dual_around_axis(r: PerNode<f64>) -> Shape {
    if r[0].min(r[1]) < NEXT_TO_AXIS * r[0].max(r[1]) {
        return STANDARD;
    }
    let share = |own: f64, other: f64| (2.0 * own + other) / (3.0 * own);
    let [a, b] = [share(r[0], r[1]), share(r[1], r[0])];
    [[2.0 * a, -a], [-b, 2.0 * b]]
}
