//! Energy-decaying, momentum-conserving scheme: the energy-momentum scheme with algorithmic dissipation, after Armero and Romero (Comput.
//! Methods Appl. Mech. Engrg. 190, 2001, 2603-2649).
//!
//! The stress `chi/2 C (E_1 - E_0)`, whose work is never negative, is added to that of the discrete gradient; at the end of the step
//! velocities become `v - k (I - F)^2 v`, `F = (M + dt^2/4 K)^-1 M` with eigenvalues in (0, 1]. `K` is the stiffness by the moduli `C` at
//! the end of the step, zero for rigid velocities. For a small vibration, `Omega = omega dt`, `F = 1/(1 + Omega^2/4)` gives
//!
//! ```text
//! dv + Omega^2 ((q_0 + q_1)/2 + chi/2 (q_1 - q_0)) = 0,    q_1 - q_0 = (v_0 + v)/2,    v_1 = (1 - k (1 - F)^2) v
//! ```
//!
//! (velocities times `dt`). As `Omega` tends to infinity the eigenvalues tend to `-(1 - chi)/(1 + chi)` and `-(1 - k)`, both `-rho`. For
//! slow vibrations the loss is of order `Omega^4` by the velocities and `Omega^2` by the strains: the scheme is of first order, as with any
//! stress that depends on the strains of the step only. (Armero and Romero filter velocities node by node, which conserves momenta with
//! lumped masses only and changes the equations of the step.)

use super::energy_momentum::ROW;
use super::family::Family;
use super::scheme::{ConservedQuantities, Dissipation, LeadingError, Parameters, Scheme};
use crate::math::catalogue::{Interval, Parameter};

/// Energy-decaying scheme with a spectral radius from 0 to 1 in the limit of long steps.
pub const fn energy_decaying(spectral_radius: f64) -> Scheme {
    let dissipation = Dissipation::to_radius(spectral_radius);
    let chi = dissipation.strain;
    Scheme {
        name: "energy_decaying",
        summary: "energy-momentum scheme that damps fast vibrations of bodies (after Armero and Romero 2001), of first order: linear and \
                  angular momentum are exact, rigid motions undamped, and the energy never grows, for every step size",
        dissipation,
        parameters: Parameters { names: &["spectral_radius"], values: [spectral_radius, 0.0] },
        promises: ConservedQuantities { order: if chi > 0.0 { 1 } else { 2 }, ..ROW.promises },
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
        summary: "the factor by which a step reduces the amplitude of a vibration much faster than the steps: 1 does not damp, 0 removes \
                  it at once",
        dimension: "1",
        range: Interval::Closed(0.0, 1.0),
        default: Some(0.8),
    }],
    make: |[spectral_radius, _]| energy_decaying(spectral_radius),
};
