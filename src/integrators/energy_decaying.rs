//! Energy-decaying, momentum-conserving scheme: the energy-momentum scheme with a dissipation of its own, after Armero and Romero (Comput.
//! Methods Appl. Mech. Engrg. 190, 2001, 2603-2649).
//!
//! Beside the stress of the discrete gradient acts `chi/2 C (E_1 - E_0)`, whose work is never negative; at the end of the step velocities
//! become `v - k (I - F)^2 v`, `F = (M + dt^2/4 K)^-1 M`, whose eigenvalues are in (0, 1]. `K` is the stiffness of the moduli `C` at the
//! end of the step, which resists no rigid velocity. A small vibration, `Omega = omega dt`, has with `F = 1/(1 + Omega^2/4)`
//!
//! ```text
//! dv + Omega^2 ((q_0 + q_1)/2 + chi/2 (q_1 - q_0)) = 0,    q_1 - q_0 = (v_0 + v)/2,    v_1 = (1 - k (1 - F)^2) v
//! ```
//!
//! (velocities times `dt`), and for `Omega` to infinity the eigenvalues `-(1 - chi)/(1 + chi)` and `-(1 - k)`, both `-rho`. Velocities
//! lose by the fourth power of `Omega` where vibrations are slow, strains by the second: that makes it a scheme of first order, and no
//! stress that follows from the strains of the step alone does better. Armero and Romero filter velocities node by node, which keeps
//! momenta with lumped masses alone, and changes the equations of the step.

use super::energy_momentum::ROW;
use super::family::Family;
use super::scheme::{Dissipation, LeadingError, Parameters, Promises, Scheme};
use crate::math::catalogue::{Interval, Parameter};

/// The scheme for a spectral radius from 0 to 1 in steps without end.
pub const fn energy_decaying(spectral_radius: f64) -> Scheme {
    let dissipation = Dissipation::to_radius(spectral_radius);
    let chi = dissipation.strain;
    Scheme {
        name: "energy_decaying",
        summary: "energy-momentum scheme that damps fast vibrations of bodies (after Armero and Romero 2001), of first order: both momenta \
                  exact, rigid motions undamped, and the energy never grows, for every step size",
        dissipation,
        parameters: Parameters { names: &["spectral_radius"], values: [spectral_radius, 0.0] },
        promises: Promises { order: if chi > 0.0 { 1 } else { 2 }, ..ROW.promises },
        error: LeadingError { first: 0.25 * chi, second: 1.0 / 12.0 + chi * chi / 32.0 },
        ..ROW
    }
}

/// Energy-decaying scheme with spectral radius 0.8: fast vibrations lose a fifth of their amplitude in a long step.
pub static ENERGY_DECAYING: Scheme = energy_decaying(0.8);

/// Energy-decaying schemes of all spectral radii.
pub static FAMILY: Family = Family {
    default: &ENERGY_DECAYING,
    parameters: &[Parameter {
        name: "spectral_radius",
        summary: "what is left of the amplitude of a vibration much faster than a step after each: 1 does not damp, 0 removes it at once",
        dimension: "1",
        range: Interval::Closed(0.0, 1.0),
        default: Some(0.8),
    }],
    make: |[spectral_radius, _]| energy_decaying(spectral_radius),
};
