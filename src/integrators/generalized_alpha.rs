//! Newmark's method with inertia and forces between the ends of a step: generalized alpha (Chung and Hulbert, J. Appl. Mech. 60, 1993), and
//! its special cases by Hilber, Hughes and Taylor (Earthquake Eng. Struct. Dyn. 5, 1977; inertia at the end) and by Wood, Bossak and
//! Zienkiewicz (IJNME 15, 1980; forces at the end).
//!
//! ```text
//! M ((1 - alpha_m) a_1 + alpha_m a_0) + (1 - alpha_f) f_1 + alpha_f f_0 = 0
//! ```
//!
//! with Newmark's `q_1` and `v_1`. Second order and unconditionally stable with `gamma = 1/2 - alpha_m + alpha_f`,
//! `beta = (1 - alpha_m + alpha_f)^2 / 4`. The force `phi = -M a`, which balances inertia at unsupported nodes, lags behind the static
//! forces: its mean over a step, `gamma phi_1 + (1 - gamma) phi_0`, is
//!
//! ```text
//! gamma (1 - alpha_f) / (1 - alpha_m) f_1 + gamma alpha_f / (1 - alpha_m) f_0 + (1 - gamma / (1 - alpha_m)) phi_0
//! ```
//!
//! so that only forces change momenta: each force acts in full, partly in later steps.

use super::derivative::Derivative;
use super::family::Family;
use super::newmark::kinematics;
use super::scheme::{ConservedQuantities, Dissipation, History, LagWeights, LeadingError, Parameters, Scheme, StepKind};
use crate::math::catalogue::{Interval, Parameter};

const fn family(name: &'static str, summary: &'static str, parameters: Parameters, alpha_m: f64, alpha_f: f64) -> Scheme {
    let (gamma, root) = (0.5 - alpha_m + alpha_f, 1.0 - alpha_m + alpha_f);
    let [velocity, acceleration] = kinematics(0.25 * root * root, gamma);
    let of_forces = gamma / (1.0 - alpha_m);
    Scheme {
        name,
        summary,
        derivative: Derivative::AT_END,
        remembers: &[History::Acceleration, History::Force, History::Answered],
        velocity,
        acceleration,
        weight: of_forces * (1.0 - alpha_f),
        lag: LagWeights { used: 1.0, force: of_forces * alpha_f, inertia: 1.0 - of_forces, gamma },
        step: StepKind::Whole,
        dissipation: Dissipation::NONE,
        averages_stress: false,
        parameters,
        promises: ConservedQuantities { energy: false, momentum: true, angular_momentum: false, order: 2 },
        error: {
            let (beta, lead) = (0.25 * root * root, alpha_m - alpha_f);
            LeadingError { first: 0.0, second: 0.5 * (beta - lead * lead + lead * alpha_m - 1.0 / 12.0).abs() }
        },
    }
}

/// Method of Hilber, Hughes and Taylor for an `alpha` from -1/3 to 0.
pub const fn hht(alpha: f64) -> Scheme {
    let summary = "method of Hilber, Hughes and Taylor (1977), of second order: Newmark's, with forces shortly before the end of the step; \
                   damps fast vibrations, slow ones hardly; conserves the linear momentum only";
    family("hht", summary, Parameters { names: &["alpha"], values: [alpha, 0.0] }, 0.0, -alpha)
}

/// Method of Wood, Bossak and Zienkiewicz for an `alpha` from -1 to 0.
pub const fn wbz(alpha: f64) -> Scheme {
    let summary = "method of Wood, Bossak and Zienkiewicz (1980), of second order: Newmark's, with inertia shortly after the end of the \
                   step; damps fast vibrations, slow ones hardly; conserves the linear momentum only";
    family("wbz", summary, Parameters { names: &["alpha"], values: [alpha, 0.0] }, alpha, 0.0)
}

/// Generalized-alpha method for a spectral radius from 0 to 1 in the limit of long steps.
pub const fn generalized_alpha(spectral_radius: f64) -> Scheme {
    let summary = "generalized-alpha method (Chung and Hulbert 1993), of second order: of all with the same damping of the fastest \
                   vibrations the one that damps slow ones least; conserves the linear momentum only";
    let (rho, sum) = (spectral_radius, spectral_radius + 1.0);
    let parameters = Parameters { names: &["spectral_radius"], values: [rho, 0.0] };
    family("generalized_alpha", summary, parameters, (2.0 * rho - 1.0) / sum, rho / sum)
}

/// HHT method: fast vibrations lose a fifth of their amplitude in a long step.
pub static HHT: Scheme = hht(-0.1);
/// WBZ method: fast vibrations lose a fifth of their amplitude in a long step.
pub static WBZ: Scheme = wbz(-0.1);
/// Generalized alpha with a spectral radius of 0.8 and the least damping of slow vibrations.
pub static GENERALIZED_ALPHA: Scheme = generalized_alpha(0.8);

/// HHT schemes with all values of the parameter.
pub static HHT_FAMILY: Family = Family {
    default: &HHT,
    parameters: &[Parameter {
        name: "alpha",
        summary: "how long before the end forces act, in steps; vibrations much faster than a step fall to (1 + `alpha`)/(1 - `alpha`) of \
                  their amplitude in each, 0 does not damp",
        dimension: "1",
        range: Interval::Closed(-1.0 / 3.0, 0.0),
        default: Some(-0.1),
    }],
    make: |[alpha, _]| hht(alpha),
};

/// WBZ schemes with all values of the parameter.
pub static WBZ_FAMILY: Family = Family {
    default: &WBZ,
    parameters: &[Parameter {
        name: "alpha",
        summary: "how long after the end inertia acts, in steps; vibrations much faster than a step fall to (1 + `alpha`)/(1 - `alpha`) of \
                  their amplitude in each, 0 does not damp",
        dimension: "1",
        range: Interval::Closed(-1.0, 0.0),
        default: Some(-0.1),
    }],
    make: |[alpha, _]| wbz(alpha),
};

/// Generalized-alpha schemes with all spectral radii.
pub static GENERALIZED_ALPHA_FAMILY: Family = Family {
    default: &GENERALIZED_ALPHA,
    parameters: &[Parameter {
        name: "spectral_radius",
        summary: "the factor by which a step reduces the amplitude of a vibration much faster than the steps: 1 does not damp, 0 removes \
                  it at once",
        dimension: "1",
        range: Interval::Closed(0.0, 1.0),
        default: Some(0.8),
    }],
    make: |[spectral_radius, _]| generalized_alpha(spectral_radius),
};
