//! Newmark's method (Newmark, J. Eng. Mech. Div. ASCE 85, 1959).
//!
//! ```text
//! q_1 = q_0 + dt v_0 + dt^2 ((1/2 - beta) a_0 + beta a_1),    v_1 = v_0 + dt ((1 - gamma) a_0 + gamma a_1),    M a_1 + f_1 = 0
//! ```
//!
//! These equations give velocity and acceleration as functions of `q_1`; momentum changes by the forces with weights `gamma` and
//! `1 - gamma`. `gamma` = 1/2 and `beta` = 1/4 is the trapezoidal rule. By default `gamma` is 0.6 and `beta = (gamma + 1/2)^2 / 4`, which
//! damps the fastest vibrations most without letting any grow.

use super::derivative::Derivative;
use super::family::Family;
use super::scheme::{
    ConservedQuantities, Dissipation, History, LagWeights, LeadingError, Parameters, Scheme, StepKind, UpdateCoefficients,
};
use crate::math::catalogue::{Interval, Parameter};

const GAMMA: f64 = 0.6;
const BETA: f64 = 0.25 * (GAMMA + 0.5) * (GAMMA + 0.5);

/// Velocity and acceleration at the end of a step, as functions of the motion in it.
pub(super) const fn kinematics(beta: f64, gamma: f64) -> [UpdateCoefficients; 2] {
    [
        UpdateCoefficients { moved: gamma / beta, velocity: 1.0 - gamma / beta, acceleration: 1.0 - 0.5 * gamma / beta },
        UpdateCoefficients { moved: 1.0 / beta, velocity: -1.0 / beta, acceleration: 1.0 - 0.5 / beta },
    ]
}

/// Newmark's method for `beta > 0` and `gamma` in (0, 1].
pub const fn newmark(beta: f64, gamma: f64) -> Scheme {
    let [velocity, acceleration] = kinematics(beta, gamma);
    Scheme {
        name: "newmark",
        summary: "Newmark's method, of second order for `gamma` = 0.5 and of first order beyond, where it damps fast vibrations; no \
                  vibration grows, whatever the step, for 2 `beta` >= `gamma` >= 0.5; conserves the linear momentum only",
        derivative: Derivative::AT_END,
        remembers: if gamma < 1.0 { &[History::Acceleration, History::Force] } else { &[History::Acceleration] },
        velocity,
        acceleration,
        weight: gamma,
        lag: LagWeights::once(gamma),
        step: StepKind::Whole,
        dissipation: Dissipation::NONE,
        averages_stress: false,
        parameters: Parameters { names: &["beta", "gamma"], values: [beta, gamma] },
        promises: ConservedQuantities { energy: false, momentum: true, angular_momentum: false, order: if gamma == 0.5 { 2 } else { 1 } },
        error: {
            let beyond = gamma - 0.5;
            let second = 0.5 * (beta - 0.5 * beyond - 1.0 / 12.0) + 0.125 * beyond * beyond;
            LeadingError { first: 0.5 * beyond, second: second.abs() }
        },
    }
}

/// Newmark's method with numerical damping: conserves linear momentum exactly; fast vibrations decay.
pub static NEWMARK: Scheme = newmark(BETA, GAMMA);

/// Newmark methods with all values of the parameters.
pub static FAMILY: Family = Family {
    default: &NEWMARK,
    parameters: &[
        Parameter {
            name: "beta",
            summary: "how much of the acceleration at the end is in the motion; below `gamma`/2 fast vibrations grow where steps are long",
            dimension: "1",
            range: Interval::Open(0.0, 2.0),
            default: Some(BETA),
        },
        Parameter {
            name: "gamma",
            summary: "share of the acceleration at the end in the change of the velocity; 0.5 does not damp",
            dimension: "1",
            range: Interval::Closed(0.5, 1.0),
            default: Some(GAMMA),
        },
    ],
    make: |[beta, gamma]| newmark(beta, gamma),
};
