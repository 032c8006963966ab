//! Newmark's method (Newmark, J. Eng. Mech. Div. ASCE 85, 1959) with `gamma` = 0.6 and the `beta = (gamma + 1/2)^2 / 4` that damps the
//! fastest vibrations most without letting any grow.
//!
//! ```text
//! q_1 = q_0 + dt v_0 + dt^2 ((1/2 - beta) a_0 + beta a_1),    v_1 = v_0 + dt ((1 - gamma) a_0 + gamma a_1),    M a_1 + f_1 = 0
//! ```
//!
//! The three give velocity and acceleration as functions of `q_1`, and the mean of the forces with the shares `gamma` and `1 - gamma` as
//! what changes the momentum. With `gamma` = 1/2 and `beta` = 1/4 it is the trapezoidal rule.

use super::derivative::Derivative;
use super::scheme::{Affine, History, Promises, Scheme};

const GAMMA: f64 = 0.6;
const BETA: f64 = 0.25 * (GAMMA + 0.5) * (GAMMA + 0.5);

/// The linear momentum exact; fast vibrations fade.
pub static NEWMARK: Scheme = Scheme {
    name: "newmark",
    summary: "Newmark's method (beta = 0.3025, gamma = 0.6), of first order: damps fast vibrations; keeps the linear momentum alone",
    derivative: Derivative::AT_END,
    remembers: &[History::Acceleration, History::Force],
    velocity: Affine { moved: GAMMA / BETA, velocity: 1.0 - GAMMA / BETA, acceleration: 1.0 - 0.5 * GAMMA / BETA },
    acceleration: Affine { moved: 1.0 / BETA, velocity: -1.0 / BETA, acceleration: 1.0 - 0.5 / BETA },
    weight: GAMMA,
    promises: Promises { energy: false, momentum: true, angular_momentum: false, order: 1 },
};
