//! Remedies for a failed step, as data, so that a language on top of the solver can word them.

use std::fmt;

/// Remedy for a failed step; `Display` writes it as one sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Support a body that only contact could hold.
    Guide,
    /// Support every body against its loads before `settle`.
    HoldBeforeRest,
    /// Support every body against its loads: a rigid motion under a load has no equilibrium.
    HoldAgainstLoads,
    /// Support every body against rigid motion, without redundant definitions.
    HoldOnce,
    /// Use smaller increments; the text names additions or alternatives and is appended.
    Ease(SmallerIncrements, &'static str),
    /// Suggests to check the definitions, or to follow the path by arc length, which passes a limit point of the load.
    FollowPath,
    /// Suggests a slower load, or smaller increments.
    LoadSlowly(SmallerIncrements),
}

/// Kind of smaller increments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SmallerIncrements {
    /// Time steps below this size `[time]`, or more halvings.
    SmallerStep(f64),
    /// Means other than steps below this size `[time]`, since the residuals grew from halving to halving.
    LargerStep(f64),
    /// Review of supports and loads: a computation at rest has no time steps.
    SupportsAndLoads,
}

impl fmt::Display for Remedy {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Remedy::Guide => write!(out, "guide the body by supports, in one direction each, or let contacts hold it from all sides"),
            Remedy::HoldBeforeRest => write!(out, "hold every body by supports or by contact against the loads on it"),
            Remedy::HoldAgainstLoads => {
                write!(out, "hold every body by supports or by contact against the loads on it; ")?;
                write!(out, "rigid motion under a load has no equilibrium")
            }
            Remedy::HoldOnce => {
                write!(out, "hold every body by supports against rigid motion, and name each contact pair and each support only once")
            }
            Remedy::Ease(ease, besides) => write!(out, "{ease}{besides}"),
            Remedy::FollowPath => {
                write!(out, "check supports and loads; past a limit point of the load equilibria are followed by the length of the path")
            }
            Remedy::LoadSlowly(ease) => write!(out, "apply the load more slowly, or {ease}"),
        }
    }
}

impl fmt::Display for SmallerIncrements {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SmallerIncrements::SmallerStep(dt) => write!(out, "use a smaller step than dt = {dt}, or allow more halvings"),
            SmallerIncrements::LargerStep(dt) => write!(
                out,
                "halving the step down to {dt} came no nearer to a solution: try a larger step, or penalties in place of multipliers in \
                 contacts"
            ),
            SmallerIncrements::SupportsAndLoads => write!(out, "check supports and loads"),
        }
    }
}
