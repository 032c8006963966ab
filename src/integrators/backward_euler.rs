//! Backward Euler: the forces and the velocity of the end of the step. It takes energy from fast motion and never adds any in linear ones.

use super::derivative::Derivative;
use super::scheme::{Kinematics, Promises, Scheme};

/// The linear momentum exact; energy and angular momentum fade.
pub static BACKWARD_EULER: Scheme = Scheme {
    name: "backward_euler",
    summary: "backward Euler method, of first order: damps vibrations, the more the larger the step; keeps the linear momentum alone",
    derivative: Derivative::AT_END,
    weight: 1.0,
    kinematics: Kinematics { slope: 1.0 },
    promises: Promises { energy: false, momentum: true, angular_momentum: false, order: 1 },
};
