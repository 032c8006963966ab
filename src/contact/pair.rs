//! Weighted gaps of one facet pair in the plane as closed functions of five quadratic invariants, with gradient and Hessian (`mortar.rs`).
//!
//! Secondary facet `(x_1, x_2)`, primary facet `(y_1, y_2)`, both with their body on the left. With `t = x_2 - x_1`, `d_i = y_i - x_1` and
//! the plane cross product `a x b` (Hesch and Betsch 2007, equations 7 to 10)
//!
//! ```text
//! pi = ( t.t,  t.d_1,  t.d_2,  t x (d_1 + d_2),  t x (d_1 - d_2) )
//! ```
//!
//! The projection along the secondary normal maps the primary nodes to `s_1 = pi_2/pi_1` and `s_2 = pi_3/pi_1` in the secondary coordinate
//! `s` in `[0, 1]`; `s_2 < s_1` if the facets face each other. The overlap is `[a, b] = [max(s_2, 0), min(s_1, 1)]`. The depth `h(s)` is
//! linear with `h(s_1) = (pi_4 + pi_5)/2` and `h(s_2) = (pi_4 - pi_5)/2`:
//!
//! ```text
//! Phi_1 = - int_a^b (1 - s) h(s) ds,    Phi_2 = - int_a^b s h(s) ds          [length^2], > 0 when open
//! ```
//!
//! Both are zero without overlap. Integrals are taken about the middle of the overlap, which avoids differences of powers of `a` and `b`,
//! and all terms are linear in `pi_4, pi_5`: small gaps keep the relative accuracy of the invariants. Height profiles of curved facets add
//! to the depth (`pair_profiles.rs`). At a limit of overlap (a node opposite a node) the gradients jump by the depth there.

#![allow(clippy::needless_range_loop)] // indices are those of the formulas

use super::numbers::Number;
use super::profile::PairProfiles;
use crate::math::tolerances::{ALIGNED, FACING};

/// Five invariants, or a gradient with respect to them.
pub type Invariants = [f64; 5];

/// Vectors `t`, `d_1`, `d_2`, concatenated.
pub type Offsets = [f64; 6];

/// Vectors `t`, `d_1`, `d_2` of four node positions.
#[inline(always)]
pub fn offsets(x_1: [f64; 2], x_2: [f64; 2], y_1: [f64; 2], y_2: [f64; 2]) -> Offsets {
    [x_2[0] - x_1[0], x_2[1] - x_1[1], y_1[0] - x_1[0], y_1[1] - x_1[1], y_2[0] - x_1[0], y_2[1] - x_1[1]]
}

/// Invariants of the vectors `t`, `d_1`, `d_2`.
#[inline(always)]
pub fn invariants(z: &Offsets) -> Invariants {
    let &[t_x, t_y, d_x, d_y, e_x, e_y] = z;
    [
        t_x * t_x + t_y * t_y,
        t_x * d_x + t_y * d_y,
        t_x * e_x + t_y * e_y,
        t_x * (d_y + e_y) - t_y * (d_x + e_x),
        t_x * (d_y - e_y) - t_y * (d_x - e_x),
    ]
}

/// True if the facets face each other and overlap, so that the weighted gaps can differ from zero.
#[inline(always)]
pub fn overlaps(pi: &Invariants) -> bool {
    pi[1] - pi[2] > FACING * pi[0] && pi[1] > 0.0 && pi[2] < pi[0]
}

/// One value for each of the two secondary nodes.
pub type PerNode<T> = [T; 2];

/// Overlap of a facet pair, with quantities that values and derivatives share.
#[derive(Clone, Copy, Debug)]
pub struct Overlap<'a> {
    pub(super) pi: Invariants,
    /// Ends `a`, `b` of the overlap in the secondary coordinate.
    pub(super) ends: [f64; 2],
    /// True for each end of the overlap that is at a primary node.
    pub(super) moves: [bool; 2],
    /// Length `b - a` of the overlap.
    pub(super) length: f64,
    /// Shape functions at the middle of the overlap.
    middle: PerNode<f64>,
    /// Distance of the middle of the overlap from that of the projected primary facet, in units of `s`.
    shift: f64,
    /// Projected length `pi_2 - pi_3` of the primary facet.
    pub(super) extent: f64,
    /// Slope `pi_5 / (pi_2 - pi_3)` of the primary facet relative to the secondary one.
    pub(super) slope: f64,
    /// Height profiles of both facets; `None` where both are straight.
    profiles: Option<&'a PairProfiles>,
}

/// Derivatives of the shape functions `N_1 = 1 - s`, `N_2 = s`.
const RISE: PerNode<f64> = [-1.0, 1.0];

impl<'a> Overlap<'a> {
    /// Overlap at `pi`; `None` where the functions vanish.
    #[inline(always)]
    pub fn new(pi: &Invariants, profiles: Option<&'a PairProfiles>) -> Option<Self> {
        overlaps(pi).then(|| Overlap::between(pi, [pi[2] > 0.0, pi[1] < pi[0]], profiles))
    }

    /// Overlap at `pi` whose ends are at primary nodes as given by `moves`, instead of the nearer nodes: a smooth continuation of the
    /// functions while one node passes another. `None` where the functions vanish.
    #[inline(always)]
    pub fn with_ends(pi: &Invariants, moves: [bool; 2], profiles: Option<&'a PairProfiles>) -> Option<Self> {
        overlaps(pi).then(|| Overlap::between(pi, moves, profiles))
    }

    /// True for each end of the overlap at a primary node that is farther than [`ALIGNED`] from every secondary node.
    pub fn clearly_moving_ends(&self) -> [bool; 2] {
        [self.moves[0] && self.ends[0] > ALIGNED, self.moves[1] && self.ends[1] < 1.0 - ALIGNED]
    }

    #[inline(always)]
    fn between(pi: &Invariants, moves: [bool; 2], profiles: Option<&'a PairProfiles>) -> Self {
        let inverse = 1.0 / pi[0];
        let (s_1, s_2) = (pi[1] * inverse, pi[2] * inverse);
        let (a, b) = (if moves[0] { s_2 } else { 0.0 }, if moves[1] { s_1 } else { 1.0 });
        let middle = 0.5 * (a + b);
        let extent = pi[1] - pi[2];
        Overlap {
            pi: *pi,
            ends: [a, b],
            moves,
            length: b - a,
            middle: [1.0 - middle, middle],
            // This form is exactly zero if both ends are primary nodes.
            shift: 0.5 * ((a - s_2) + (b - s_1)),
            extent,
            slope: pi[4] / extent,
            profiles,
        }
    }

    /// `int N_k ds` over the overlap; 1/2 each if the facet is fully covered.
    #[inline(always)]
    pub fn coverage(&self) -> PerNode<f64> {
        self.middle.map(|n| self.length * n)
    }

    /// Weighted gaps `Phi_1, Phi_2`.
    #[inline(always)]
    pub fn value(&self) -> PerNode<f64> {
        let mut value = self.value_of_facets();
        if let Some(profiles) = self.profiles {
            self.add_value(profiles, &mut value);
        }
        value
    }

    /// Weighted gaps between straight facets.
    #[inline(always)]
    fn value_of_facets(&self) -> PerNode<f64> {
        let rate = self.slope * self.pi[0];
        let depth = 0.5 * self.pi[3] + rate * self.shift;
        let spread = rate * self.length * self.length * (1.0 / 12.0);
        [0, 1].map(|k| -self.length * (self.middle[k] * depth + RISE[k] * spread))
    }

    /// Weighted gaps `Phi_1, Phi_2` and their gradients with respect to the invariants.
    #[inline(always)]
    pub fn value_and_gradient(&self) -> (PerNode<f64>, PerNode<Invariants>) {
        let (mut value, mut gradient) = (self.value_of_facets(), self.gradient_of_facets());
        if let Some(profiles) = self.profiles {
            self.add_value_and_gradient(profiles, &mut value, &mut gradient);
        }
        (value, gradient)
    }

    /// Gradients of `Phi_1, Phi_2` with respect to the invariants, and the Hessian of `weights[0] Phi_1 + weights[1] Phi_2`.
    #[inline(always)]
    pub fn derivatives(&self, weights: PerNode<f64>) -> (PerNode<Invariants>, [Invariants; 5]) {
        // Weight function W = weights . N, with the sign of Phi = - int W h ds.
        let weights = weights.map(|weight| -weight);
        let (mut gradient, mut h) = (self.gradient_of_facets(), self.hessian_of_facets(weights));
        if let Some(profiles) = self.profiles {
            self.add_derivatives(profiles, weights, &mut gradient, &mut h);
        }
        for row in 1..5 {
            for column in 0..row {
                h[row][column] = h[column][row];
            }
        }
        (gradient, h)
    }

    /// Gradients of `Phi_1, Phi_2` between straight facets.
    #[inline(always)]
    fn gradient_of_facets(&self) -> PerNode<Invariants> {
        let [a, b] = self.ends;
        let inverse = 1.0 / self.pi[0];
        // A moving end contributes the depth there: d b = (-b, 1, 0, 0, 0)/pi_1, d a = (-a, 0, 1, 0, 0)/pi_1.
        let sweep_a = if self.moves[0] { -0.5 * (self.pi[3] - self.pi[4]) * inverse } else { 0.0 };
        let sweep_b = if self.moves[1] { 0.5 * (self.pi[3] + self.pi[4]) * inverse } else { 0.0 };
        let (at_a, at_b) = ([1.0 - a, a], [1.0 - b, b]);
        let steepness = self.slope / self.extent;
        [0, 1].map(|k| {
            let integrals = self.integrals(self.middle[k], RISE[k]);
            let (end_a, end_b) = (at_a[k] * sweep_a, at_b[k] * sweep_b);
            let turn = steepness * integrals.lever;
            let sink = 0.5 * self.slope * integrals.one;
            [
                a * end_a + b * end_b - self.slope * integrals.position,
                turn + sink - end_b,
                sink - turn - end_a,
                -0.5 * integrals.one,
                -integrals.lever / self.extent,
            ]
        })
    }

    /// Upper triangle of the Hessian of `int W h ds` between straight facets; the linear weight function `W` is given by its values at the
    /// ends of the secondary facet.
    #[inline(always)]
    fn hessian_of_facets(&self, weights: PerNode<f64>) -> [Invariants; 5] {
        let rise = weights[1] - weights[0];
        let integrals = self.integrals(weights[0] * self.middle[0] + weights[1] * self.middle[1], rise);
        let inverse = 1.0 / self.pi[0];
        let per_extent = 1.0 / self.extent;

        // int W d2h ds with h = pi_4/2 + slope u, u(s) = pi_1 s - (pi_2 + pi_3)/2: slope' (x) u' twice, u slope''.
        let slope_1 = [-self.slope * per_extent, self.slope * per_extent, per_extent]; // with respect to pi_2, pi_3, pi_5
        let u_1 = [integrals.position, -0.5 * integrals.one, -0.5 * integrals.one]; // with respect to pi_1, pi_2, pi_3
        let bend = 2.0 * integrals.lever * self.slope * per_extent * per_extent;
        let twist = integrals.lever * per_extent * per_extent;
        let mut h = [[0.0; 5]; 5];
        h[0][1] = u_1[0] * slope_1[0];
        h[0][2] = u_1[0] * slope_1[1];
        h[0][4] = u_1[0] * slope_1[2];
        h[1][1] = 2.0 * u_1[1] * slope_1[0] + bend;
        h[1][2] = u_1[1] * slope_1[1] + u_1[2] * slope_1[0] - bend;
        h[2][2] = 2.0 * u_1[2] * slope_1[1] + bend;
        h[1][4] = u_1[1] * slope_1[2] - twist;
        h[2][4] = u_1[2] * slope_1[2] + twist;

        // Ends: [W (H (x) s' + s' (x) H) + (W' depth - W depth') s' (x) s' + W depth s''], H = d depth(end) = (0, 0, 0, 1/2, +-1/2).
        for (end, sign, node, half) in [(0, -1.0, 2, -0.5), (1, 1.0, 1, 0.5)] {
            if !self.moves[end] {
                continue;
            }
            let s = self.ends[end];
            let weight = sign * (weights[0] * (1.0 - s) + weights[1] * s);
            let depth = 0.5 * self.pi[3] + half * self.pi[4];
            let s_1 = [-s * inverse, inverse]; // with respect to pi_1 and the primary node's invariant
            let square = sign * rise * depth - weight * self.slope * self.pi[0];
            let curve = weight * depth * inverse * inverse;
            h[0][0] += square * s_1[0] * s_1[0] + 2.0 * s * curve;
            h[0][node] += square * s_1[0] * s_1[1] - curve;
            h[node][node] += square * s_1[1] * s_1[1];
            h[0][3] += 0.5 * weight * s_1[0];
            h[0][4] += half * weight * s_1[0];
            h[node][3] += 0.5 * weight * s_1[1];
            h[node][4] += half * weight * s_1[1];
        }
        h
    }

    /// Integrals over the overlap of a linear weight function, given by its value at the middle and its slope.
    #[inline(always)]
    fn integrals(&self, middle: f64, rise: f64) -> Integrals {
        let one = self.length * middle;
        let spread = rise * self.length * self.length * self.length * (1.0 / 12.0);
        Integrals { one, position: one * self.middle[1] + spread, lever: self.pi[0] * (one * self.shift + spread) }
    }
}

/// `int W ds`, `int W s ds` and `int W u ds`, `u = pi_1 (s - (s_1 + s_2)/2)`.
struct Integrals {
    one: f64,
    position: f64,
    lever: f64,
}

/// Gradient `Dpi(z)^T g` with respect to the four nodes `(x_1, x_2, y_1, y_2)`.
///
/// The first node gets minus the sum of the others, so that the forces sum to zero up to the rounding of that sum.
#[inline(always)]
pub fn pull_back(z: &Offsets, g: &Invariants) -> [f64; 8] {
    let [a, b, c, d, e, f] = pull_back_offsets(z, g);
    [-(a + c + e), -(b + d + f), a, b, c, d, e, f]
}

/// Gradient `Dpi(z)^T g` with respect to the vectors `t`, `d_1`, `d_2`.
#[inline(always)]
fn pull_back_offsets(z: &Offsets, g: &Invariants) -> Offsets {
    let &[t_x, t_y, d_x, d_y, e_x, e_y] = z;
    // Coefficients of t . d_i and t x d_i.
    let (cross_1, cross_2) = (g[3] + g[4], g[3] - g[4]);
    [
        2.0 * g[0] * t_x + g[1] * d_x + g[2] * e_x + cross_1 * d_y + cross_2 * e_y,
        2.0 * g[0] * t_y + g[1] * d_y + g[2] * e_y - cross_1 * d_x - cross_2 * e_x,
        g[1] * t_x - cross_1 * t_y,
        g[1] * t_y + cross_1 * t_x,
        g[2] * t_x - cross_2 * t_y,
        g[2] * t_y + cross_2 * t_x,
    ]
}

/// Tangent `share sum_k g_k A_k + Dpi(test)^T T Dpi(trial)`, 8 x 8 row-major over `(x_1, x_2, y_1, y_2)`; `A_k` are the second derivatives
/// of the invariants.
#[inline(always)]
pub fn tangent_into(test: &Offsets, trial: &Offsets, share: f64, g: &Invariants, t: &[Invariants; 5], out: &mut [f64; 64]) {
    // First the 6 x 6 matrix in t, d_1, d_2: rows T Dpi(trial), then columns Dpi(test)^T (...).
    let half: [Offsets; 5] = std::array::from_fn(|k| pull_back_offsets(trial, &t[k]));
    let mut block = [[0.0; 6]; 6];
    for column in 0..6 {
        let pulled = pull_back_offsets(test, &std::array::from_fn(|k| half[k][column]));
        for row in 0..6 {
            block[row][column] = pulled[row];
        }
    }
    let (along, dot_1, dot_2) = (2.0 * share * g[0], share * g[1], share * g[2]);
    let (cross_1, cross_2) = (share * (g[3] + g[4]), share * (g[3] - g[4]));
    for axis in 0..2 {
        block[axis][axis] += along;
        block[axis][axis + 2] += dot_1;
        block[axis + 2][axis] += dot_1;
        block[axis][axis + 4] += dot_2;
        block[axis + 4][axis] += dot_2;
    }
    for (node, cross) in [(2, cross_1), (4, cross_2)] {
        block[0][node + 1] += cross;
        block[node + 1][0] += cross;
        block[1][node] -= cross;
        block[node][1] -= cross;
    }
    for (row, entries) in block.iter().enumerate() {
        let line = &mut out[8 * (row + 2)..8 * (row + 3)];
        line[2..].copy_from_slice(entries);
        line[0] = -(entries[0] + entries[2] + entries[4]);
        line[1] = -(entries[1] + entries[3] + entries[5]);
    }
    for column in 0..8 {
        out[column] = -(out[16 + column] + out[32 + column] + out[48 + column]);
        out[8 + column] = -(out[24 + column] + out[40 + column] + out[56 + column]);
    }
}

/// Overlap of a facet pair in coordinates of the secondary facet; `T` may carry derivatives with respect to the node positions.
pub struct SlipOverlap<T> {
    /// Secondary facet vector.
    pub t: [T; 2],
    /// Coordinates of the projected primary nodes.
    pub projections: [T; 2],
    /// Ends of the overlap.
    pub ends: [T; 2],
}

/// Overlap of a pair with the node positions `(x_1, x_2, y_1, y_2)`; `None` where the facets do not face each other or do not overlap.
pub fn slip_overlap<T: Number>(z: &[T]) -> Option<SlipOverlap<T>> {
    let from = |k: usize| [z[2 * k] - z[0], z[2 * k + 1] - z[1]];
    let [t, d_1, d_2] = [1, 2, 3].map(from);
    let square = t[0] * t[0] + t[1] * t[1];
    let [s_1, s_2] = [d_1, d_2].map(|d| (t[0] * d[0] + t[1] * d[1]) / square);
    if (s_1 - s_2).re() <= FACING || s_1.re() <= 0.0 || s_2.re() >= 1.0 {
        return None;
    }
    let a = if s_2.re() > 0.0 { s_2 } else { T::from(0.0) };
    let b = if s_1.re() < 1.0 { s_1 } else { T::from(1.0) };
    Some(SlipOverlap { t, projections: [s_1, s_2], ends: [a, b] })
}

/// Weights `int N_A N_B ds / |t|` of the four nodes `(x_1, x_2, y_1, y_2)` in the slips of a pair, those of the primary nodes with negative
/// sign, and the secondary facet vector `t`. `None` without overlap.
pub fn slip_weights<T: Number>(z: &[T]) -> Option<(PerNode<[T; 4]>, [T; 2])> {
    let SlipOverlap { t, projections: [s_1, s_2], ends: [a, b] } = slip_overlap(z)?;
    let extent = s_1 - s_2;
    let (middle, half) = ((a + b) * 0.5, (b - a) * 0.5);
    // Two Gauss points are exact.
    let mut standard = [[T::from(0.0); 4]; 2];
    for place in [-1.0, 1.0].map(|sign: f64| sign / 3f64.sqrt()) {
        let s = middle + half * place;
        let opposite = (s_1 - s) / extent;
        let shares = [-s + 1.0, s, opposite - 1.0, -opposite];
        for (weights, shape) in standard.iter_mut().zip([-s + 1.0, s]) {
            weights.iter_mut().zip(shares).for_each(|(weight, share)| *weight += half * shape * share);
        }
    }
    Some((standard, t))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::super::profile::Profile;
    use super::*;

    const CURVED: PairProfiles = PairProfiles([Profile([0.01, 0.2, -0.15, -0.08, 0.02]), Profile([-0.02, 0.1, 0.2, -0.3, 0.05])]);

    /// Node positions of facets that roughly face each other, with all kinds of overlap.
    fn nodes() -> impl Strategy<Value = [[f64; 2]; 4]> {
        (prop::array::uniform8(-0.4..0.4), -1.0..1.0).prop_map(|(noise, slide)| {
            let base = [0.0, 0.0, 1.0, 0.0, 1.0 + slide, 0.0, slide, 0.0];
            let at = |i: usize| [base[2 * i] + noise[2 * i], base[2 * i + 1] + noise[2 * i + 1]];
            [at(0), at(1), at(2), at(3)]
        })
    }

    fn of([x_1, x_2, y_1, y_2]: [[f64; 2]; 4]) -> Invariants {
        invariants(&offsets(x_1, x_2, y_1, y_2))
    }

    fn value(pi: &Invariants, profiles: Option<&PairProfiles>) -> PerNode<f64> {
        Overlap::new(pi, profiles).map_or([0.0; 2], |overlap| overlap.value())
    }

    /// True if difference quotients of width `step` would cross a limit of overlap.
    fn near_limit(pi: &Invariants, step: f64) -> bool {
        let near = |x: f64, limit: f64| (x - limit).abs() < 10.0 * step;
        near(pi[1], 0.0) || near(pi[2], 0.0) || near(pi[1], pi[0]) || near(pi[2], pi[0]) || pi[1] - pi[2] < 0.1 || pi[0] < 0.1
    }

    /// True for pairs tilted by more than 15 degrees, where the quadrature error of the profile terms exceeds 1e-6.
    fn is_steep(pi: &Invariants) -> bool {
        (pi[4] / (pi[1] - pi[2])).abs() > 0.27
    }

    /// Fourth-order central difference of `f` in direction `k`.
    fn difference<const N: usize>(f: impl Fn(&Invariants) -> [f64; N], pi: &Invariants, k: usize, step: f64) -> [f64; N] {
        let at = |shift: f64| {
            let mut moved = *pi;
            moved[k] += shift;
            f(&moved)
        };
        let (a, b, c, d) = (at(-2.0 * step), at(-step), at(step), at(2.0 * step));
        std::array::from_fn(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * step))
    }

    const STEP: f64 = 2e-4;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        /// Oracle: the integral computed from the geometry by two-point Gauss quadrature on the segment, exact for the quadratic integrand.
        #[test]
        fn values_are_the_integrals_over_the_overlap(x in nodes()) {
            let [x_1, x_2, y_1, y_2] = x;
            let t = [x_2[0] - x_1[0], x_2[1] - x_1[1]];
            let square = t[0] * t[0] + t[1] * t[1];
            let coordinate = |y: [f64; 2]| (t[0] * (y[0] - x_1[0]) + t[1] * (y[1] - x_1[1])) / square;
            let depth = |y: [f64; 2]| t[0] * (y[1] - x_1[1]) - t[1] * (y[0] - x_1[0]);
            let (s_1, s_2) = (coordinate(y_1), coordinate(y_2));
            let (a, b) = (s_2.clamp(0.0, 1.0), s_1.clamp(0.0, 1.0));
            let mut expected = [0.0; 2];
            if s_1 > s_2 {
                for sign in [-1.0, 1.0] {
                    let s = 0.5 * (a + b) + sign * 0.5 * (b - a) / 3f64.sqrt();
                    let h = depth(y_2) + (depth(y_1) - depth(y_2)) * (s - s_2) / (s_1 - s_2);
                    expected[0] -= 0.5 * (b - a) * (1.0 - s) * h;
                    expected[1] -= 0.5 * (b - a) * s * h;
                }
            }
            let ours = value(&of(x), None);
            // Round-off grows as the projected primary facet becomes short, that is steep relative to the secondary facet.
            let tolerance = 1e-14 * (1.0 + 1.0 / (s_1 - s_2).abs());
            prop_assert!((0..2).all(|k| (ours[k] - expected[k]).abs() < tolerance), "{ours:?} against {expected:?}");
        }

        #[test]
        fn gradients_agree_with_differences(x in nodes(), is_curved: bool) {
            let (pi, profiles) = (of(x), is_curved.then_some(&CURVED));
            prop_assume!(!(near_limit(&pi, STEP) || is_curved && is_steep(&pi)));
            if let Some(overlap) = Overlap::new(&pi, profiles) {
                let (_, gradient) = overlap.value_and_gradient();
                for k in 0..5 {
                    let expected = difference(|pi| value(pi, profiles), &pi, k, STEP);
                    for n in 0..2 {
                        // Gauss points are exact for straight facets; with profiles, terms of tenth degree remain.
                        let tolerance = if is_curved { 1e-6 } else { 1e-8 };
                        prop_assert!((gradient[n][k] - expected[n]).abs() < tolerance, "{} {} of {}", gradient[n][k], expected[n], k);
                    }
                }
            }
        }

        #[test]
        fn hessian_agrees_with_differences_of_the_gradient(x in nodes(), w_1 in -1.0..2.0, w_2 in -1.0..2.0, is_curved: bool) {
            let (pi, profiles) = (of(x), is_curved.then_some(&CURVED));
            prop_assume!(!(near_limit(&pi, STEP) || is_curved && is_steep(&pi)));
            if let Some(overlap) = Overlap::new(&pi, profiles) {
                let (same, hessian) = overlap.derivatives([w_1, w_2]);
                prop_assert_eq!(same, overlap.value_and_gradient().1);
                let gradient = |pi: &Invariants| {
                    let (_, g) = Overlap::new(pi, profiles).unwrap().value_and_gradient();
                    std::array::from_fn(|k| w_1 * g[0][k] + w_2 * g[1][k])
                };
                for k in 0..5 {
                    let expected: [f64; 5] = difference(gradient, &pi, k, STEP);
                    for l in 0..5 {
                        let tolerance = 1e-6 * (1.0 + expected[l].abs());
                        prop_assert!((hessian[k][l] - expected[l]).abs() < tolerance, "{k} {l}: {} {}", hessian[k][l], expected[l]);
                    }
                }
            }
        }
    }

    /// Closed form: facet [0, 1] at height 0, primary facet from (1/2, -2e-12) to (-1, -5e-12).
    #[test]
    fn a_tiny_gap_keeps_its_relative_accuracy() {
        let pi = of([[0.0, 0.0], [1.0, 0.0], [0.5, -2e-12], [-1.0, -5e-12]]);
        // Gap 3e-12 - 2e-12 s on [0, 1/2], integrated with the weights 1 - s and s.
        let exact = [0.5 * 3e-12 - 5.0 * 1e-12 / 8.0 + 2e-12 / 24.0, 3e-12 / 8.0 - 2e-12 / 24.0];
        for (ours, exact) in value(&pi, None).into_iter().zip(exact) {
            assert!((ours / exact - 1.0).abs() < 1e-15, "{ours:e} {exact:e}");
        }
    }

    #[test]
    fn facets_apart_or_looking_the_same_way_give_zero() {
        for y in [[[3.0, -0.1], [2.0, -0.1]], [[0.0, -0.1], [1.0, -0.1]], [[0.5, -0.1], [0.5, -0.2]], [[f64::NAN, 0.0], [0.0, 0.0]]] {
            assert!(Overlap::new(&of([[0.0, 0.0], [1.0, 0.0], y[0], y[1]]), None).is_none());
        }
        // A secondary facet of zero length.
        assert!(Overlap::new(&of([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]), None).is_none());
    }

    /// Closed form: for fully covered facets at distance 0.1 the gradients along the normal are the mortar integrals of the unit facet.
    #[test]
    fn matching_facets_give_the_mass_integrals() {
        let z = offsets([0.0, 0.0], [1.0, 0.0], [1.0, -0.1], [0.0, -0.1]);
        let overlap = Overlap::new(&invariants(&z), None).unwrap();
        for (ours, exact) in overlap.value().into_iter().zip([0.05, 0.05]) {
            assert!((ours - exact).abs() < 1e-16);
        }
        assert_eq!(overlap.coverage(), [0.5, 0.5]);
    }
}
