//! What mends a step that failed: data, so that a language on top of the kernels can say it in its own words.

use std::fmt;

/// What mends a step that failed; `Display` says it in one sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Guide a body that contact alone does not hold.
    Guide,
    /// Hold every body against its loads, before rest is looked for.
    HoldBeforeRest,
    /// Hold every body against its loads: a rigid motion under a load has no equilibrium.
    HoldAgainstLoads,
    /// Hold every body against rigid motion, and define nothing twice.
    HoldOnce,
    /// Ask for less at a time, and what to do besides or instead, as it follows in the sentence.
    Ease(Ease, &'static str),
    /// Look at what was defined again, or go on by the length of the path, which passes a limit point of the load.
    FollowPath,
    /// Apply a load more slowly, or ask for less at a time.
    LoadSlowly(Ease),
}

/// How less is asked for at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ease {
    /// By steps below this size `[time]`, or by more halvings of them.
    SmallerStep(f64),
    /// By other means than steps below this size `[time]`, as the residuals grew from halving to halving.
    LargerStep(f64),
    /// Rest has no steps in time; what was defined is looked at again.
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

impl fmt::Display for Ease {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ease::SmallerStep(dt) => write!(out, "use a smaller step than dt = {dt}, or allow more halvings"),
            Ease::LargerStep(dt) => write!(
                out,
                "halving the step down to {dt} came no nearer to a solution: try a larger step, or penalties in place of multipliers in \
                 contacts"
            ),
            Ease::SupportsAndLoads => write!(out, "check supports and loads"),
        }
    }
}
