//! Height profiles of curved facets in the weighted gaps of a facet pair in the plane (`pair.rs`): added depth, gradient, Hessian.
//!
//! With the height profiles `p_1` of the secondary facet and `p` of the primary facet (from its second node on), the depth `h(s)` of
//! straight facets becomes `h(s) + D(s)`,
//!
//! ```text
//! D = pi_1 p_1(s) + E G(eta, m),    E = pi_2 - pi_3,    eta = (pi_1 s - pi_3)/E,    m = pi_5/E
//! G = (1 + mu^2) p(xi),             xi = eta + mu p(xi),             mu = m (1 + m^8)^(-1/8)
//! ```
//!
//! With `mu = m` this is exact: the projection along the secondary normal maps the point `xi` of the primary curve to `eta = xi - m p(xi)`,
//! and its height over the facet is `E (1 + m^2) p(xi)`. The depth is then continuous at nodes between primary facets. A bound of `m` of
//! lower order, such as `m/(1 + m^2/2)`, leaves jumps that hold edges of second order in place. The bounded `mu` keeps steep pairs regular.
//! `D` depends on the invariants only and is homogeneous of first degree like `h`: discrete gradient, momenta and objectivity carry over.
//! Five Gauss points on the overlap are exact to ninth degree in `s`; `N_k D` is of fifth degree plus terms of higher order in `mu p`.
//!
//! Derivatives, with `w_eta = (s, -eta, eta - 1, 0, 0)`, `w_m = (0, -m, m, 0, 1)` and `J = 1 - mu p'(xi)`:
//!
//! ```text
//! dD      = p_1 e_1 + G (e_2 - e_3) + G_eta w_eta + G_m w_m
//! d2D     = (G_etaeta w_eta w_eta + G_etam (w_eta w_m + w_m w_eta) + G_mm w_m w_m)/E
//! G_eta   = (1 + mu^2) p'/J                         G_etaeta  = (1 + mu^2) p''/J^3
//! G_mu    = 2 mu p + (1 + mu^2) p p'/J              G_etamu   = 2 mu p'/J + (1 + mu^2) (p'^2/J^2 + p p''/J^3)
//!                                                   G_mumu    = 2 p + 4 mu p p'/J + (1 + mu^2) (2 p p'^2/J^2 + p^2 p''/J^3)
//! ```

#![allow(clippy::needless_range_loop)] // indices are those of the formulas

use super::pair::{Invariants, Overlap, PerNode};
use super::profile::PairProfiles;
use crate::elements::GAUSS;

/// Added depth `D` at a point of the secondary facet, with derivatives.
struct AddedDepth {
    depth: f64,
    /// Derivative with respect to `s`.
    along: f64,
    /// Gradient with respect to the invariants at fixed `s`.
    gradient: Invariants,
    /// Directions `w_eta` and `w_m`.
    directions: [Invariants; 2],
    /// Second derivatives of `G` over `E`, `(G_etaeta, G_etam, G_mm)/E`.
    curvature: [f64; 3],
}

impl Overlap<'_> {
    /// Added depth `D` at `s`.
    #[inline(always)]
    fn added_depth(&self, PairProfiles([own, other]): &PairProfiles, s: f64) -> AddedDepth {
        let [p_1, rise, _] = own.at(s);
        let eta = (self.pi[0] * s - self.pi[2]) / self.extent;
        let m = self.slope;
        let fourth = m * m * m * m;
        let bound = 1.0 + fourth * fourth;
        let root = 1.0 / bound.sqrt().sqrt().sqrt();
        let (mu, mu_1) = (m * root, root / bound);
        let mu_2 = -9.0 * fourth * m * m * m * mu_1 / bound;
        let [p, d, dd] = other.at(other.seen_at(eta, mu));
        let per_jacobian = 1.0 / (1.0 - mu * d);
        let (even, rate, bend) = (1.0 + mu * mu, d * per_jacobian, dd * per_jacobian * per_jacobian * per_jacobian);
        let g = even * p;
        let g_eta = even * rate;
        let g_mu = 2.0 * mu * p + even * p * rate;
        let g_eta_mu = 2.0 * mu * rate + even * (rate * rate + p * bend);
        let g_mu_mu = 2.0 * p + 4.0 * mu * p * rate + even * (2.0 * p * rate * rate + p * p * bend);
        let g_m = mu_1 * g_mu;
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
            curvature: [inverse * even * bend, inverse * mu_1 * g_eta_mu, inverse * (mu_1 * mu_1 * g_mu_mu + mu_2 * g_mu)],
        }
    }

    /// Gauss points of the overlap and their weights `[5 x 2]`.
    #[inline(always)]
    fn points(&self) -> [[f64; 2]; 5] {
        GAUSS.map(|(place, weight)| [self.ends[0] + self.length * place, self.length * weight])
    }

    /// Adds `- int N_k D ds` to the weighted gaps.
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

    /// Adds the Hessian of `int W D ds`; the linear weight function `W` is given by its values at the ends of the facet.
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
            // Derivative of the coordinate of a moving end with respect to the invariants.
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
