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
//! The functions of `G` are evaluated once per point for all derivatives that are requested there, and integrals of them are combined with
//! the directions `w_eta` and `w_m`. Derivatives, with `w_eta = (s, -eta, eta - 1, 0, 0)`, `w_m = (0, -m, m, 0, 1)` and
//! `J = 1 - mu p'(xi)`:
//!
//! ```text
//! dD      = p_1 e_1 + G (e_2 - e_3) + G_eta w_eta + G_m w_m
//! d2D     = (G_etaeta w_eta w_eta + G_etam (w_eta w_m + w_m w_eta) + G_mm w_m w_m)/E
//! G_eta   = (1 + mu^2) p'/J                         G_etaeta  = (1 + mu^2) p''/J^3
//! G_mu    = 2 mu p + (1 + mu^2) p p'/J              G_etamu   = 2 mu p'/J + (1 + mu^2) (p'^2/J^2 + p p''/J^3)
//!                                                   G_mumu    = 2 p + 4 mu p p'/J + (1 + mu^2) (2 p p'^2/J^2 + p^2 p''/J^3)
//! ```

use super::pair::{Invariants, Overlap, PerNode};
use super::profile::{PairProfiles, Profile};
use crate::elements::GAUSS;
use crate::math::simd::{Kernel, dispatch};

/// Slope of the primary facet and quantities that depend on it only.
struct Tilt {
    m: f64,
    /// Bounded slope `mu` and its first two derivatives with respect to `m`.
    mu: [f64; 3],
    /// `1 + mu^2`.
    even: f64,
    /// `1/E`.
    per_extent: f64,
}

/// Height `G` of the primary curve over its facet, opposite a point of the secondary facet.
struct PrimaryHeight {
    eta: f64,
    /// `(G, G_eta, G_m)`.
    first: [f64; 3],
    /// `(G_etaeta, G_etam, G_mm)/E`.
    second: [f64; 3],
}

impl PrimaryHeight {
    /// Components 1 to 3 of the gradient of `E G` at fixed `s`; component 4 is zero, component 5 is `G_m`.
    #[inline(always)]
    fn gradient(&self, s: f64, m: f64) -> [f64; 3] {
        let [g, g_eta, g_m] = self.first;
        let of_first = g - g_eta * self.eta - m * g_m;
        [g_eta * s, of_first, -of_first - g_eta]
    }
}

impl Overlap<'_> {
    /// Slope of the primary facet for [`Overlap::primary_height`].
    #[inline(always)]
    fn tilt(&self) -> Tilt {
        let m = self.slope;
        let fourth = m * m * m * m;
        let bound = 1.0 + fourth * fourth;
        let root = 1.0 / bound.sqrt().sqrt().sqrt();
        let (mu, mu_1) = (m * root, root / bound);
        Tilt { m, mu: [mu, mu_1, -9.0 * fourth * m * m * m * mu_1 / bound], even: 1.0 + mu * mu, per_extent: 1.0 / self.extent }
    }

    /// Height of the primary curve opposite the point `s` of the secondary facet.
    #[inline(always)]
    fn primary_height(&self, profile: &Profile, tilt: &Tilt, s: f64) -> PrimaryHeight {
        let (eta, [mu, mu_1, mu_2], even) = ((self.pi[0] * s - self.pi[2]) * tilt.per_extent, tilt.mu, tilt.even);
        let [p, d, dd] = profile.at_seen(eta, mu);
        let per_jacobian = 1.0 / (1.0 - mu * d);
        let (rate, bend) = (d * per_jacobian, dd * per_jacobian * per_jacobian * per_jacobian);
        let g_mu = 2.0 * mu * p + even * p * rate;
        let g_eta_mu = 2.0 * mu * rate + even * (rate * rate + p * bend);
        let g_mu_mu = 2.0 * p + 4.0 * mu * p * rate + even * (2.0 * p * rate * rate + p * p * bend);
        let second = [even * bend, mu_1 * g_eta_mu, mu_1 * mu_1 * g_mu_mu + mu_2 * g_mu];
        PrimaryHeight { eta, first: [even * p, even * rate, mu_1 * g_mu], second: second.map(|part| tilt.per_extent * part) }
    }

    /// Gauss points of the overlap and their weights `[5 x 2]`.
    #[inline(always)]
    fn points(&self) -> [[f64; 2]; 5] {
        GAUSS.map(|(place, weight)| [self.ends[0] + self.length * place, self.length * weight])
    }

    /// Adds `- int N_k D ds` to the weighted gaps.
    #[inline(always)]
    pub(super) fn add_value(&self, PairProfiles([own, other]): &PairProfiles, value: &mut PerNode<f64>) {
        let tilt = self.tilt();
        for [s, weight] in self.points() {
            let [g, ..] = self.primary_height(other, &tilt, s).first;
            let depth = weight * (self.pi[0] * own.at(s)[0] + self.extent * g);
            value[0] -= (1.0 - s) * depth;
            value[1] -= s * depth;
        }
    }

    /// Adds `- int N_k D ds` to the weighted gaps and its gradient to theirs.
    #[inline(always)]
    fn sum_value_and_gradient(
        &self,
        profiles @ PairProfiles([own, other]): &PairProfiles,
        value: &mut PerNode<f64>,
        gradient: &mut PerNode<Invariants>,
    ) {
        let tilt = self.tilt();
        let mut sums = [[0.0; 4]; 2];
        for [s, weight] in self.points() {
            let (p_1, other) = (own.at(s)[0], self.primary_height(other, &tilt, s));
            let depth = self.pi[0] * p_1 + self.extent * other.first[0];
            let of = gradient_at(p_1, &other, s, tilt.m);
            for (k, shape) in [1.0 - s, s].into_iter().enumerate() {
                value[k] -= weight * shape * depth;
                (0..4).for_each(|l| sums[k][l] += weight * shape * of[l]);
            }
        }
        subtract(&sums, gradient);
        self.add_swept(profiles, &tilt, gradient);
    }

    /// Adds the gradient of `- int N_k D ds` to those of the weighted gaps, and the Hessian of `int W D ds` to `h`; the linear weight
    /// function `W` is given by its values at the ends of the facet.
    #[inline(always)]
    fn sum_derivatives(
        &self,
        profiles @ PairProfiles([own, other]): &PairProfiles,
        weights: PerNode<f64>,
        gradient: &mut PerNode<Invariants>,
        h: &mut [Invariants; 5],
    ) {
        let (tilt, mut sums) = (self.tilt(), [[0.0; 4]; 2]);
        // Integrals of W (s^2, s eta, eta^2, s, eta, 1) G_etaeta/E, W (s, eta, 1) G_etam/E and W G_mm/E.
        let (mut ee, mut em, mut mm) = ([0.0; 6], [0.0; 3], 0.0);
        for [s, weight] in self.points() {
            let height = self.primary_height(other, &tilt, s);
            let of = gradient_at(own.at(s)[0], &height, s, tilt.m);
            for (sums, shape) in sums.iter_mut().zip([weight * (1.0 - s), weight * s]) {
                (0..4).for_each(|l| sums[l] += shape * of[l]);
            }
            let (eta, weight) = (height.eta, weight * (weights[0] * (1.0 - s) + weights[1] * s));
            let [x, y, z] = height.second.map(|part| weight * part);
            let (xs, xe) = (x * s, x * eta);
            ee.iter_mut().zip([xs * s, xs * eta, xe * eta, xs, xe, x]).for_each(|(sum, part)| *sum += part);
            em.iter_mut().zip([y * s, y * eta, y]).for_each(|(sum, part)| *sum += part);
            mm += z;
        }
        subtract(&sums, gradient);
        let m = tilt.m;
        h[0][0] += ee[0];
        h[0][1] -= ee[1] + m * em[0];
        h[0][2] += ee[1] - ee[3] + m * em[0];
        h[0][4] += em[0];
        h[1][1] += ee[2] + 2.0 * m * em[1] + m * m * mm;
        h[1][2] -= ee[2] - ee[4] + m * (2.0 * em[1] - em[2]) + m * m * mm;
        h[2][2] += ee[2] - 2.0 * ee[4] + ee[5] + 2.0 * m * (em[1] - em[2]) + m * m * mm;
        h[1][4] -= em[1] + m * mm;
        h[2][4] += em[1] - em[2] + m * mm;
        h[4][4] += mm;
        self.add_swept_derivatives(profiles, &tilt, weights, gradient, h);
    }

    /// Adds `- int N_k D ds` to the weighted gaps and its gradient to theirs.
    pub(super) fn add_value_and_gradient(&self, profiles: &PairProfiles, value: &mut PerNode<f64>, gradient: &mut PerNode<Invariants>) {
        dispatch(ValueAndGradient { overlap: self, profiles, value, gradient });
    }

    /// Adds the gradient of `- int N_k D ds` to those of the weighted gaps, and the Hessian of `int W D ds` to the upper triangle
    /// `hessian`; the linear weight function `W` is given by its values at the ends of the facet.
    pub(super) fn add_derivatives(
        &self,
        profiles: &PairProfiles,
        weights: PerNode<f64>,
        gradient: &mut PerNode<Invariants>,
        hessian: &mut [Invariants; 5],
    ) {
        dispatch(Derivatives { overlap: self, profiles, weights, gradient, hessian });
    }

    /// Adds the gradient of `- int N_k D ds` with respect to moving ends of the overlap.
    #[inline(always)]
    fn add_swept(&self, PairProfiles([own, other]): &PairProfiles, tilt: &Tilt, gradient: &mut PerNode<Invariants>) {
        let inverse = 1.0 / self.pi[0];
        for (end, sign, node) in [(0, -1.0, 2), (1, 1.0, 1)] {
            if self.moves[end] {
                let s = self.ends[end];
                let depth = self.pi[0] * own.at(s)[0] + self.extent * self.primary_height(other, tilt, s).first[0];
                sweep(s, node, sign * depth * inverse, gradient);
            }
        }
    }

    /// Adds the contributions of moving ends of the overlap to the gradient of `- int N_k D ds` and to the Hessian of `int W D ds`.
    #[inline(always)]
    fn add_swept_derivatives(
        &self,
        PairProfiles([own, other]): &PairProfiles,
        tilt: &Tilt,
        weights: PerNode<f64>,
        gradient: &mut PerNode<Invariants>,
        h: &mut [Invariants; 5],
    ) {
        let inverse = 1.0 / self.pi[0];
        for (end, sign, node) in [(0, -1.0, 2), (1, 1.0, 1)] {
            if !self.moves[end] {
                continue;
            }
            let s = self.ends[end];
            let ([p_1, rise, _], height) = (own.at(s), self.primary_height(other, tilt, s));
            let depth = self.pi[0] * p_1 + self.extent * height.first[0];
            sweep(s, node, sign * depth * inverse, gradient);
            let weight = sign * (weights[0] * (1.0 - s) + weights[1] * s);
            // Derivative of the coordinate of the end with respect to the first invariant and to that of the primary node.
            let moved = [-s * inverse, inverse];
            let square = sign * (weights[1] - weights[0]) * depth + weight * self.pi[0] * (rise + height.first[1]);
            let [first, second, third, fifth] = gradient_at(p_1, &height, s, tilt.m).map(|part| weight * part);
            let of = [first, second, third, 0.0, fifth];
            h[0][0] += square * moved[0] * moved[0] + 2.0 * of[0] * moved[0] + 2.0 * s * weight * depth * inverse * inverse;
            h[0][node] += square * moved[0] * moved[1] + of[0] * moved[1] + of[node] * moved[0] - weight * depth * inverse * inverse;
            h[0][3 - node] += of[3 - node] * moved[0];
            h[0][4] += of[4] * moved[0];
            h[node][node] += square * moved[1] * moved[1] + 2.0 * of[node] * moved[1];
            h[1][2] += of[3 - node] * moved[1];
            h[node][4] += of[4] * moved[1];
        }
    }
}

/// Adds the terms of height profiles to weighted gaps and gradients.
struct ValueAndGradient<'a> {
    overlap: &'a Overlap<'a>,
    profiles: &'a PairProfiles,
    value: &'a mut PerNode<f64>,
    gradient: &'a mut PerNode<Invariants>,
}

impl Kernel for ValueAndGradient<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        self.overlap.sum_value_and_gradient(self.profiles, self.value, self.gradient);
    }
}

/// Adds the terms of height profiles to gradients of weighted gaps, and to the upper triangle of the Hessian of `int W h ds`.
struct Derivatives<'a> {
    overlap: &'a Overlap<'a>,
    profiles: &'a PairProfiles,
    /// Linear weight function `W` at the ends of the secondary facet.
    weights: PerNode<f64>,
    gradient: &'a mut PerNode<Invariants>,
    hessian: &'a mut [Invariants; 5],
}

impl Kernel for Derivatives<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        self.overlap.sum_derivatives(self.profiles, self.weights, self.gradient, self.hessian);
    }
}

/// Components 1, 2, 3 and 5 of the gradient of the added depth `D` with respect to the invariants at fixed `s`; component 4 is zero.
#[inline(always)]
fn gradient_at(p_1: f64, height: &PrimaryHeight, s: f64, m: f64) -> [f64; 4] {
    let [first, second, third] = height.gradient(s, m);
    [p_1 + first, second, third, height.first[2]]
}

/// Subtracts sums of [`gradient_at`] from the gradients of the weighted gaps.
#[inline(always)]
fn subtract(sums: &PerNode<[f64; 4]>, gradient: &mut PerNode<Invariants>) {
    for (gradient, sums) in gradient.iter_mut().zip(sums) {
        [0, 1, 2, 4].into_iter().zip(sums).for_each(|(l, sum)| gradient[l] -= sum);
    }
}

/// Adds the gradient of `- int N_k D ds` with respect to the end `s` of the overlap, which is at the primary node of an invariant.
#[inline(always)]
fn sweep(s: f64, node: usize, depth: f64, gradient: &mut PerNode<Invariants>) {
    for (gradient, shape) in gradient.iter_mut().zip([1.0 - s, s]) {
        gradient[0] += s * shape * depth;
        gradient[node] -= shape * depth;
    }
}
