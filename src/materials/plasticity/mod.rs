//! Plasticity of metals: von Mises' yield condition on the logarithmic strain in a multiplicative frame, with a stress whose work in a
//! step is exactly what is stored and what becomes heat.
//!
//! A point keeps `P = F_p^-1`, back strains `a_k` and the equivalent plastic strain `alpha`. In a step from `C_0` to `C_1`, with `P` of
//! its start and `Ch = P^T C P`, the logarithmic strain `eps = ln(Ch)/2` is split additively:
//!
//! ```text
//! stress        T = K tr(eps) I + 2 mu dev(eps - dep)                    Hencky's law
//! yielding      |xi| <= sqrt(2/3) k(alpha),  xi = dev T - sum_k c_k a_k
//! flow          dep = g N,  alpha_1 = alpha_0 + sqrt(2/3) g              N: flow.rs
//! of the step   S = P sym(Q_1 [ln[c_1i, c_0j] (Q_1^T T_bar Q_0)_ij] Q_0^T) P^T,  T_bar = (s T_0 + T_s + (1 - s) T_1)/2
//! ```
//!
//! `s` is the elastic share of the step, `ln[a, b] = (ln a - ln b)/(a - b)`, `c` and `Q` principal values and directions of `Ch`. The
//! formula for `S` is the discrete derivative of the logarithm (Daletskii and Krein 1956): `S : (C_1 - C_0)/2 = T_bar : (eps_1 - eps_0)`
//! holds identically, without a division by the size of the step. After the step `P_1 = P G` with the symmetric `G` of
//! `G Ch_1 G = exp(2 (eps_1 - dep))`, so that the next step starts from the elastic strain at which this one ends.
//!
//! Sources: Simo, Computer Methods in Applied Mechanics and Engineering 99, 1992 (multiplicative frame, exponential map); Ortiz and Popov,
//! International Journal for Numerical Methods in Engineering 21, 1985 (generalized trapezoidal rule); Armstrong and Frederick, CEGB report
//! RD/B/N731, 1966; Perzyna, Quarterly of Applied Mathematics 20, 1963; Johnson and Cook, 7th International Symposium on Ballistics, 1983.

mod constants;
mod flow;
mod frame;
mod hardening;
mod law;
mod logarithm;
#[cfg(test)]
mod tests;

pub use constants::{BackStress, ElasticPlastic, Hardening, PlasticityError, RateDependence};
pub(super) use law::PlasticLaw;
