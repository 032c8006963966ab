//! Shares of contact forces in the balance of momentum of a step.

/// Shares of the multipliers of a step in its balance of momentum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceShares {
    /// Share of those whose forces act in later steps, too, as the time integrator says.
    pub lagging: f64,
    /// Share of those of contacts with friction, which act in their own step alone: 1 in a motion.
    pub alone: f64,
}

impl ForceShares {
    /// All forces as a whole.
    pub const WHOLE: ForceShares = ForceShares { lagging: 1.0, alone: 1.0 };
}
