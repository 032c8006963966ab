//! Height profiles in the weighted gap of a facet pair in the plane.
//!
//! With the height profiles `p_1` of the secondary facet and `p` of the primary facet (from its second node on), the depth `h(s)` of
//! straight facets (`pair.rs`) becomes `h(s) + D(s)`,
//!
//! ```text
//! D = pi_1 p_1(s) + E G(eta, m),    E = pi_2 - pi_3,    eta = (pi_1 s - pi_3)/E,    m = pi_5/E
//! G = (1 + mu^2) p(eta) + mu p(eta) p'(eta),            mu = m/(1 + m^2/2)
//! ```
//!
//! A point `xi` of the primary curve lies at `eta = xi - m p(xi)` as seen along the secondary normal, and higher than its facet by
//! `E p(xi)/cos alpha`, `m = tan alpha`. `G` is the expansion to fourth order in `m` and `p`, with the bounded `mu` in place of `m` for steep
//! pairs. `D` is a function of the invariants alone and homogeneous of first degree in them, as `h` is, so that discrete gradient, momenta
//! and objectivity need nothing else. Four Gauss points on the overlap integrate `N_k D`, of sixth degree in `s`, exactly.
//!
//! Derivatives, with `w_eta = (s, -eta, eta - 1, 0, 0)` and `w_m = (0, -m, m, 0, 1)`:
//!
//! ```text
//! dD   = p_1 e_1 + G (e_2 - e_3) + G_eta w_eta + G_m w_m
//! d2D  = (G_etaeta w_eta w_eta + G_etam (w_eta w_m + w_m w_eta) + G_mm w_m w_m)/E
//! ```

#![allow(clippy::needless_range_loop)] // indices are those of the formulas

use super::pair::{Invariants, Overlap, PerNode};
use super::profile::PairProfiles;

/// Abscissas and weights of four Gauss points on [-1/2, 1/2].
const GAUSS: [[f64; 2]; 4] = [
    [-0.430_568_155_797_026_3, 0.173_927_422_568_726_93],
    [-0.169_990_521_792_428_13, 0.326_072_577_431_273_07],
    [0.169_990_521_792_428_13, 0.326_072_577_431_273_07],
    [0.430_568_155_797_026_3, 0.173_927_422_568_726_93],
];

/// Depth `D` that height profiles add at a point of the secondary facet, with derivatives.
struct AddedDepth {
    depth: f64,
    /// Derivative with respect to `s`.
    along: f64,
    /// Gradient with respect to the invariants at fixed `s`.
    gradient: Invariants,
    /// `w_eta` and `w_m`.
    directions: [Invariants; 2],
    /// `(G_etaeta, G_etam, G_mm)/E`.
    curvature: [f64; 3],
}

impl Overlap<'_> {
    /// Added depth at `s`.
    #[inline(always)]
    fn added_depth(&self, PairProfiles([own, other]): &PairProfiles, s: f64) -> AddedDepth {
        let [p_1, rise, ..] = own.at(s);
        let eta = (self.pi[0] * s - self.pi[2]) / self.extent;
        let [p, d, dd, ddd] = other.at(eta);
        let m = self.slope;
        let per = 1.0 / (1.0 + 0.5 * m * m);
        let mu = m * per;
        let mu_1 = (1.0 - 0.5 * m * m) * per * per;
        let mu_2 = -m * (3.0 - 0.5 * m * m) * per * per * per;
        let (even, skew) = (1.0 + mu * mu, d * d + p * dd);
        let g = even * p + mu * p * d;
        let g_eta = even * d + mu * skew;
        let g_m = mu_1 * (2.0 * mu * p + p * d);
        let directions = [[s, -eta, eta - 1.0, 0.0, 0.0], [0.0, -m, m, 0.0, 1.0]];
        let mut gradient: Invariants = std::array::from_fn(|k| g_eta * directions[0][k] + g_m * directions[1][k]);
        gradient[0] += p_1;
        gradient[1] += g;
        gradient[2] -= g;
        let inverse = 1.0 / self.extent;
        AddedDepth {
            depth: self.pi[0] * p_1 + self.extent * g,
            along: self.pi[0] * (rise + g_eta),
            gradient,
            directions,
            curvature: [
                inverse * (even * dd + mu * (3.0 * d * dd + p * ddd)),
                inverse * mu_1 * (2.0 * mu * d + skew),
                inverse * (2.0 * (mu_1 * mu_1 + mu * mu_2) * p + mu_2 * p * d),
            ],
        }
    }

    /// Gauss points of the overlap with their weights.
    #[inline(always)]
    fn points(&self) -> [[f64; 2]; 4] {
        GAUSS.map(|[place, weight]| [self.middle[1] + self.length * place, self.length * weight])
    }

    /// Adds `- int N_k D ds`.
    #[inline(always)]
    pub(super) fn add_value(&self, profiles: &PairProfiles, value: &mut PerNode<f64>) {
        for [s, weight] in self.points() {
            let depth = weight * self.added_depth(profiles, s).depth;
            value[0] -= (1.0 - s) * depth;
            value[1] -= s * depth;
        }
    }

    /// Adds the gradient of `- int N_k D ds`.
    #[inline(always)]
    pub(super) fn add_gradient(&self, profiles: &PairProfiles, gradient: &mut PerNode<Invariants>) {
        for [s, weight] in self.points() {
            let of = self.added_depth(profiles, s).gradient;
            for (gradient, shape) in gradient.iter_mut().zip([1.0 - s, s]) {
                (0..5).for_each(|k| gradient[k] -= weight * shape * of[k]);
            }
        }
        let inverse = 1.0 / self.pi[0];
        for (end, sign, node) in [(0, -1.0, 2), (1, 1.0, 1)] {
            if self.moves[end] {
                let s = self.ends[end];
                let sweep = sign * self.added_depth(profiles, s).depth * inverse;
                for (gradient, shape) in gradient.iter_mut().zip([1.0 - s, s]) {
                    gradient[0] += s * shape * sweep;
                    gradient[node] -= shape * sweep;
                }
            }
        }
    }

    /// Adds the Hessian of `int W D ds`, the weight function `W` given by its values at the ends of the facet.
    #[inline(always)]
    pub(super) fn add_hessian(&self, profiles: &PairProfiles, weights: PerNode<f64>, h: &mut [Invariants; 5]) {
        let at = |s: f64| weights[0] * (1.0 - s) + weights[1] * s;
        for [s, weight] in self.points() {
            let AddedDepth { directions: [e, m], curvature: [ee, em, mm], .. } = self.added_depth(profiles, s);
            let weight = weight * at(s);
            for row in 0..5 {
                for column in row..5 {
                    h[row][column] +=
                        weight * (ee * e[row] * e[column] + em * (e[row] * m[column] + m[row] * e[column]) + mm * m[row] * m[column]);
                }
            }
        }
        let inverse = 1.0 / self.pi[0];
        for (end, sign, node) in [(0, -1.0, 2), (1, 1.0, 1)] {
            if !self.moves[end] {
                continue;
            }
            let s = self.ends[end];
            let AddedDepth { depth, along, gradient, .. } = self.added_depth(profiles, s);
            let weight = sign * at(s);
            // Derivative of the moving end with respect to the invariants.
            let mut moved = [0.0; 5];
            (moved[0], moved[node]) = (-s * inverse, inverse);
            let square = sign * (weights[1] - weights[0]) * depth + weight * along;
            for row in 0..5 {
                for column in row..5 {
                    h[row][column] +=
                        square * moved[row] * moved[column] + weight * (gradient[row] * moved[column] + moved[row] * gradient[column]);
                }
            }
            h[0][0] += 2.0 * s * weight * depth * inverse * inverse;
            h[0][node] -= weight * depth * inverse * inverse;
        }
    }
}
