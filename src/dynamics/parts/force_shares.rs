//! Shares of contact forces in the balance of momentum of a step.

/// Shares of the multipliers of a step in its balance of momentum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceShares {
    /// Weight of multipliers whose forces also enter later steps, as defined by the time integrator.
    pub lagging: f64,
    /// Weight of multipliers whose forces enter only their own step (unilateral contact, friction): 1 in a motion.
    pub alone: f64,
}

impl ForceShares {
    /// Full weight of all multipliers.
    pub const WHOLE: ForceShares = ForceShares { lagging: 1.0, alone: 1.0 };
}
