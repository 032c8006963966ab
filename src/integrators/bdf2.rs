//! Second-order backward differentiation formula for positions and velocities (Gear, Numerical Initial Value Problems, 1971) with variable
//! step size, and TR-BDF2 (Bank et al., IEEE Trans. Electron Devices 32, 1985), whose second stage it is.
//!
//! ```text
//! (q_1 - q_0) / dt = w v_1 + c (q_0 - q_b) / dt_b,    (v_1 - v_0) / dt = -w M^-1 f_1 + c (v_0 - v_b) / dt_b
//! w = (r + 1) / (r + 2),    c = 1 / (r + 2),    r = dt_b / dt
//! ```
//!
//! after a step of size `dt_b` from `q_b`, `v_b`. Its mean velocity enters through the history variable
//! `a_0 = 2 (v_0 - (q_0 - q_b)/dt_b)/dt_b`, the acceleration of an equivalent motion of constant acceleration, its mean acceleration
//! through the force that balances it. Without a previous step the formula is the trapezoidal rule.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use super::derivative::Derivative;
use super::scheme::{
    ConservedQuantities, Dissipation, History, LagWeights, LeadingError, Parameters, Scheme, StepKind, UpdateCoefficients,
};

const PROMISES: ConservedQuantities = ConservedQuantities { energy: false, momentum: true, angular_momentum: false, order: 2 };

/// Update coefficients of the velocity and of the history variable `a_1 = 2 (v_1 - (q_1 - q_0)/dt)/dt`, the acceleration of a motion of
/// constant acceleration with the velocity `v_1` at the end.
const fn kinematics(velocity: UpdateCoefficients) -> [UpdateCoefficients; 2] {
    let UpdateCoefficients { moved, velocity: of_velocity, acceleration } = velocity;
    [velocity, UpdateCoefficients { moved: 2.0 * (moved - 1.0), velocity: 2.0 * of_velocity, acceleration: 2.0 * acceleration }]
}

/// BDF2 after a previous step of `ratio` times the size.
const fn after(ratio: f64) -> Scheme {
    let (weight, before) = ((ratio + 1.0) / (ratio + 2.0), 1.0 / (ratio + 2.0));
    let [velocity, acceleration] =
        kinematics(UpdateCoefficients { moved: 1.0 / weight, velocity: -before / weight, acceleration: 0.5 * ratio * before / weight });
    Scheme {
        name: "bdf2",
        summary: "backward differentiation formula of second order: damps fast vibrations within a few steps, and slow ones more than \
                  `generalized_alpha`; conserves the linear momentum only",
        derivative: Derivative::AT_END,
        remembers: &[History::Acceleration, History::Force],
        velocity,
        acceleration,
        weight,
        lag: LagWeights { used: before, force: 0.0, inertia: 1.0, gamma: 1.0 },
        step: StepKind::Whole,
        dissipation: Dissipation::NONE,
        averages_stress: false,
        parameters: Parameters::NONE,
        promises: PROMISES,
        error: LeadingError { first: 0.0, second: (1.0 + ratio) / 6.0 },
    }
}

/// BDF2: conserves linear momentum exactly; vibrations faster than the steps vanish.
pub static BDF2: Scheme = Scheme { step: StepKind::ByRatio(after), ..after(1.0) };

/// First stage of TR-BDF2: the trapezoidal rule; passes on the mean of its forces.
const FIRST: Scheme = {
    let [velocity, acceleration] = kinematics(UpdateCoefficients { moved: 2.0, velocity: -1.0, acceleration: 0.0 });
    Scheme { velocity, acceleration, weight: 0.5, lag: LagWeights { used: 1.0, force: 0.0, inertia: 1.0, gamma: 1.0 }, ..LAST }
};

/// Second stage of TR-BDF2; passes on half of the force at its end.
const LAST: Scheme = {
    let row = after(SQRT_2);
    Scheme {
        name: "tr_bdf2",
        summary: "trapezoidal rule and backward differentiation in one step (Bank et al. 1985), of second order: twice the work of a step, \
                  and removes what vibrates faster than the steps at once; conserves the linear momentum only",
        lag: LagWeights { used: row.lag.used, force: 0.5, inertia: 0.0, gamma: 1.0 },
        // Error of both stages together.
        error: LeadingError { first: 0.0, second: FRAC_1_SQRT_2 - 2.0 / 3.0 },
        ..row
    }
};

/// Stages of TR-BDF2 (trapezoidal rule, then BDF2), whose matrices have equal mass factors.
static STAGES: [(f64, Scheme); 2] = [(2.0 - SQRT_2, FIRST), (SQRT_2 - 1.0, LAST)];

/// TR-BDF2: conserves linear momentum exactly; vibrations faster than the steps vanish.
pub static TR_BDF2: Scheme = Scheme { step: StepKind::Stages(&STAGES), ..LAST };
