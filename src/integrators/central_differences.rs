//! Central differences (leapfrog, velocity Verlet) with a lumped mass: the one scheme whose steps solve no equations.
//!
//! ```text
//! v_h = v_0 - dt/2 m^-1 f_0,    q_1 = q_0 + dt v_h,    f_1 = f(q_1),    v_1 = v_h - dt/2 m^-1 f_1
//! ```
//!
//! Equivalent to Newmark's method with `beta` = 0, `gamma` = 1/2 (Hughes, The Finite Element Method, 1987, section 9.1): second order,
//! stable for `omega dt <= 2` of the fastest vibration (Courant, Friedrichs and Lewy, Math. Ann. 100, 1928), and symplectic: energy errors
//! stay bounded by the square of the step. Forces act at the positions, so that linear and angular momentum are conserved. Dampers use the
//! velocities in the middle of the step that led to the positions, which reduces the order to one.

use super::derivative::Derivative;
use super::scheme::{
    ConservedQuantities, Dissipation, History, LagWeights, LeadingError, Lumping, Parameters, Scheme, StepKind, UpdateCoefficients,
};

/// Central differences with a lumping of the mass.
pub const fn central_differences(lumping: Lumping) -> Scheme {
    Scheme {
        name: "central_differences",
        summary: "central differences (leapfrog), explicit, of second order: no equations are solved, so steps cost little and must be \
                  shorter than 2 over the fastest angular frequency; mass at the nodes; conserves linear and angular momentum, and the \
                  energy within a bound",
        derivative: Derivative::AT_END,
        remembers: &[History::Force],
        // Velocity at which velocity-dependent forces are evaluated.
        velocity: UpdateCoefficients { moved: 1.0, velocity: 0.0, acceleration: 0.0 },
        acceleration: UpdateCoefficients::NONE,
        weight: 0.5,
        lag: LagWeights::once(0.5),
        step: StepKind::Explicit(lumping),
        dissipation: Dissipation::NONE,
        averages_stress: false,
        parameters: Parameters::NONE,
        promises: ConservedQuantities { energy: false, momentum: true, angular_momentum: true, order: 2 },
        error: LeadingError { first: 0.0, second: 1.0 / 24.0 },
    }
}

/// Central differences with the lumping suitable for each cell.
pub static CENTRAL_DIFFERENCES: Scheme = central_differences(Lumping::Suitable);
