//! Floor 3: how a potential is differentiated across a step; one file per scheme.
//!
//! For a potential `f(pi(q))` of quadratic invariants `pi_k = q.A_k q / 2` every scheme has the same form,
//!
//! ```text
//! force    w Dpi(q_test)^T g
//! tangent  w [ share sum_k g_k A_k + Dpi(q_test)^T T Dpi(q_trial) ]        derivative with respect to q_1
//! ```
//!
//! and differs in where (`Placement`) and with what `g`, `T` (the scheme's own file). A material or a contact method supplies values,
//! gradients and Hessians of `f`; it never asks which scheme runs.
//!
//! Functions of the positions of a patch without such invariants have a discrete gradient of their own ([`Projection`]).

mod energy_momentum;
mod projected;

pub use energy_momentum::discrete_gradient;
pub use projected::{PatchFunction, Projection};

/// A configuration of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Configuration {
    /// `(q_0 + q_1) / 2`.
    Middle,
    /// `q_1`.
    End,
}

/// Where a scheme evaluates the gradients of the invariants, and its weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Configuration of the left factor `Dpi(q_test)`, which carries the force.
    pub test: Configuration,
    /// Configuration of the right factor `Dpi(q_trial)` in the tangent.
    pub trial: Configuration,
    /// `d q_test / d q_1`: 1/2 in the middle, 1 at the end.
    pub share: f64,
    /// Weight of the step's force: 1, or 1/2 where the other half was the end of the step before (trapezoidal rule).
    pub weight: f64,
}

/// A time integrator as a user chooses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Integrator {
    /// Discrete gradients: energy and both momenta exact.
    EnergyMomentum,
    /// Implicit midpoint rule.
    Midpoint,
    /// Newmark's method with beta = 1/4, gamma = 1/2.
    Trapezoidal,
}

impl Integrator {
    /// All integrators, in the order of the reference.
    pub const ALL: &'static [Integrator] = &[Integrator::EnergyMomentum, Integrator::Midpoint, Integrator::Trapezoidal];

    /// Name as written in a script.
    pub fn name(self) -> &'static str {
        match self {
            Integrator::EnergyMomentum => "energy_momentum",
            Integrator::Midpoint => "midpoint",
            Integrator::Trapezoidal => "trapezoidal",
        }
    }

    /// Where the scheme evaluates.
    pub fn placement(self) -> Placement {
        use Configuration::{End, Middle};
        match self {
            Integrator::EnergyMomentum => Placement { test: Middle, trial: End, share: 0.5, weight: 1.0 },
            Integrator::Midpoint => Placement { test: Middle, trial: Middle, share: 0.5, weight: 1.0 },
            Integrator::Trapezoidal => Placement { test: End, trial: End, share: 1.0, weight: 0.5 },
        }
    }

    /// One sentence for the reference.
    pub fn summary(self) -> &'static str {
        match self {
            Integrator::EnergyMomentum => {
                "energy-momentum scheme: discrete gradients keep the energy and both momenta exactly, for every step size"
            }
            Integrator::Midpoint => "implicit midpoint rule: keeps both momenta, but not the energy",
            Integrator::Trapezoidal => {
                "trapezoidal rule (Newmark, beta = 1/4, gamma = 1/2): keeps neither the energy nor the angular momentum in large motions"
            }
        }
    }
}
