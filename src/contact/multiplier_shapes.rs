//! Multiplier shape functions on a facet in the plane: standard and dual ones, also for bodies of revolution.

use super::pair::PerNode;

/// Multiplier shape functions of a facet as coefficients of its linear shape functions `[2 x 2]`.
pub type MultiplierFunctions = PerNode<PerNode<f64>>;

/// Linear shape functions.
pub const STANDARD: MultiplierFunctions = [[1.0, 0.0], [0.0, 1.0]];

/// Dual shape functions: `int psi_A N_B ds = delta_AB int N_B ds` (Wohlmuth, SIAM J. Numer. Anal. 38, 2000).
pub const DUAL: MultiplierFunctions = [[2.0, -1.0], [-1.0, 2.0]];

/// Ratio of the radii of a facet's nodes, smaller over larger, below which the facet counts as adjacent to the axis.
const NEXT_TO_AXIS: f64 = 0.1;

/// Dual shape functions `psi = diag(G r / r) G^-1 N` of a facet of revolution, `G = int N N^T ds`, nodal radii `r`. Each multiplier loads
/// its own node only. `sum r_A psi_A` is the radius, so that multipliers `p r_A` are a uniform pressure `p`; dual functions of the plane
/// give an error of 8 %. Facets next to the axis, where `1/r` is unbounded, have the standard functions.
pub fn dual_around_axis(r: PerNode<f64>) -> MultiplierFunctions {
    if r[0].min(r[1]) < NEXT_TO_AXIS * r[0].max(r[1]) {
        return STANDARD;
    }
    let share = |own: f64, other: f64| (2.0 * own + other) / (3.0 * own);
    let [a, b] = [share(r[0], r[1]), share(r[1], r[0])];
    [[2.0 * a, -a], [-b, 2.0 * b]]
}
