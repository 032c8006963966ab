//! Algorithmic gradients: forces of a potential in a step.
//!
//! For a potential `f(pi(q))` of quadratic invariants `pi_k = q.A_k q / 2` every choice has the same form,
//!
//! ```text
//! force    Dpi(q_test)^T g
//! tangent  share sum_k g_k A_k + Dpi(q_test)^T T Dpi(q_trial)        derivative with respect to q_1
//! ```
//!
//! and differs in the configurations ([`Placement`]) and in `g`, `T`. A material or a contact method supplies values, gradients and
//! Hessians of `f` for a given `Derivative`, and is independent of the scheme.

/// A configuration of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Configuration {
    /// Middle of the step, `(q_0 + q_1) / 2`.
    Middle,
    /// End of the step, `q_1`.
    End,
}

impl Configuration {
    /// Derivative of the configuration with respect to `q_1`, equal to the elapsed fraction of the step.
    #[inline(always)]
    pub fn share(self) -> f64 {
        match self {
            Configuration::Middle => 0.5,
            Configuration::End => 1.0,
        }
    }

    /// Writes the positions of the configuration to `out`.
    pub fn positions_into(self, q_0: &[f64], q_1: &[f64], out: &mut Vec<f64>) {
        out.clear();
        match self {
            Configuration::Middle => out.extend(q_0.iter().zip(q_1).map(|(a, b)| 0.5 * (a + b))),
            Configuration::End => out.extend_from_slice(q_1),
        }
    }
}

/// Algorithmic gradient: evaluation of the force of a potential across a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivative {
    /// Discrete gradient: the work of the force equals the change of the potential.
    DiscreteGradient,
    /// Gradient at one configuration.
    Gradient(Configuration),
}

/// Configurations at which the gradients of the invariants are evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Configuration of the left factor `Dpi(q_test)`, which carries the force.
    pub test: Configuration,
    /// Configuration of the right factor `Dpi(q_trial)` in the tangent.
    pub trial: Configuration,
    /// Derivative `d q_test / d q_1` of the test configuration.
    pub share: f64,
}

impl Derivative {
    /// The gradient at the end of the step.
    pub const AT_END: Derivative = Derivative::Gradient(Configuration::End);

    /// All algorithmic gradients.
    pub const ALL: [Derivative; 3] = [Derivative::DiscreteGradient, Derivative::Gradient(Configuration::Middle), Derivative::AT_END];

    /// Configurations of the evaluation.
    #[inline(always)]
    pub fn placement(self) -> Placement {
        let (test, trial) = match self {
            Derivative::DiscreteGradient => (Configuration::Middle, Configuration::End),
            Derivative::Gradient(at) => (at, at),
        };
        Placement { test, trial, share: test.share() }
    }
}
