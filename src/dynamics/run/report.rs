//! Report of a failed step for the user.

use crate::dynamics::model::remedy::{Remedy, SmallerIncrements};
use crate::math::digits::three_digits;

/// Cause of a failed step.
#[derive(Clone, Debug, PartialEq)]
pub enum FailureCause {
    /// The contact state of some nodes changed at least every second time in the last iterations.
    CyclingContact {
        /// Name of the contact pair.
        contact: String,
        /// Nodes whose contact state cycled.
        cycling: Vec<CyclingNode>,
        /// Secondary nodes of the pair.
        nodes: usize,
        /// True if the nodes stayed in contact and changed between stick and slip only.
        is_slip: bool,
    },
    /// A load or a prescribed motion moves nodes too far in one step.
    LoadTooFast {
        /// Name of the load or prescribed motion, such as `the load on "block.top"`.
        load: String,
        /// Body of the node with the largest displacement by the load.
        body: String,
        /// Number of the node in the body's mesh.
        node: usize,
        /// Displacement of the node by the load alone in the last attempt, in cells.
        cells: f64,
        /// Failure by which the last attempt ended.
        outcome: Box<FailureCause>,
    },
    /// Newton's method improved from halving to halving, or was still converging at its iteration limit.
    StepLimit {
        /// Residual over target at the end of each attempt.
        ratios: Vec<f64>,
    },
    /// `settle` found no equilibrium.
    NoEquilibrium {
        /// Damped steps taken.
        steps: usize,
        /// Unbalanced force on the body relative to the forces on it.
        unbalanced: f64,
        /// Body with the largest motion.
        body: String,
        /// Motion of the body, such as `move along (1.00, 0.00)`.
        how: String,
        /// Missing support of the body, if known.
        missing: Option<Missing>,
    },
    /// The residual fell too slowly or not at all.
    SlowConvergence,
    /// The iterates grew without bound.
    Divergence,
    /// A cell turned inside out.
    InvertedCell {
        /// Name of the body.
        body: String,
        /// Cell number in its mesh.
        cell: usize,
        /// Smallest determinant of the deformation gradient in the cell.
        determinant: f64,
        /// Center of the cell in the undeformed body `[length]`.
        center: [f64; 3],
        /// Space dimension.
        dimension: usize,
    },
    /// The linear system could not be solved.
    SingularSystem {
        /// Possible rigid motion of a body, or dependent constraints.
        reason: String,
        /// Number of the constraint that depends on others, if elimination stopped at one.
        constraint: Option<usize>,
    },
    /// Bodies moved farther in the step than the search for contact reaches.
    TooFast {
        /// Name of the contact pair.
        contact: String,
    },
}

/// Kind of support that a body needs for equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Missing {
    /// The body touches nothing.
    Support,
    /// The body is only in frictionless contact, which does not prevent sliding.
    Guidance,
    /// The body is in contact with friction that is insufficient to hold it.
    Friction,
}

/// A node whose contact state kept changing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CyclingNode {
    /// Name of the body.
    pub body: String,
    /// Number of the node in the body's mesh.
    pub node: usize,
    /// Index among the secondary nodes of the contact; `None` for a corner of the primary side.
    pub index: Option<usize>,
}

/// One attempt at the failed step.
#[derive(Clone, Debug, PartialEq)]
pub struct TryReport {
    /// Size of the step `[time]`.
    pub dt: f64,
    /// Number of iterations.
    pub iterations: usize,
    /// Residual of the last iteration `[force]`.
    pub residual: f64,
    /// Force tolerance of the residual `[force]`.
    pub target: f64,
    /// Outcome in two words.
    pub outcome: &'static str,
}

/// One Newton iteration of the failed step.
#[derive(Clone, Debug, PartialEq)]
pub struct IterationReport {
    /// Largest component of the residual `[force]`.
    pub residual: f64,
    /// Force tolerance of the residual `[force]`.
    pub target: f64,
    /// Energy error of the iterate, the work of the residual along the displacement in the step, relative to the tolerance.
    pub energy: f64,
    /// Largest violation of the contact conditions, relative to the tolerance.
    pub gap_violation: f64,
    /// Number of contact nodes whose state changed.
    pub changes: usize,
    /// Active contact nodes.
    pub active: usize,
    /// Body with the largest residual.
    pub body: String,
    /// Node in that body's mesh.
    pub node: usize,
    /// Contact pair with the largest violation.
    pub contact: Option<String>,
    /// True if the largest violation is that of the friction law.
    pub is_slip: bool,
}

/// Report of a step that failed in all attempts.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureReport {
    /// Time at the beginning of the step `[time]`.
    pub time: f64,
    /// Number of the step.
    pub step: usize,
    /// Size of the last attempt `[time]`; 0 in `settle`.
    pub dt: f64,
    /// Number of halvings.
    pub halvings: usize,
    /// Cause of the failure.
    pub cause: FailureCause,
    /// Iterations of the last attempt.
    pub iterations: Vec<IterationReport>,
    /// Body without support whose loads are unbalanced, so that only contact can hold it; set in `settle`.
    pub unheld: Option<String>,
    /// All attempts, from the nominal step to the last halving; empty in `settle`.
    pub tries: Vec<TryReport>,
}

impl FailureReport {
    /// One sentence on the cause with its numbers.
    pub fn explanation(&self) -> String {
        let cause = self.cause_text();
        match &self.unheld {
            // The cause already names the body.
            _ if matches!(self.cause, FailureCause::NoEquilibrium { .. }) => cause,
            Some(body) => format!("{cause}; body \"{body}\" has no support, and the loads on it do not balance"),
            None => cause,
        }
    }

    /// True if the residuals, relative to their targets, grew from the nominal step to the last halving.
    pub(super) fn is_worse_when_smaller(&self) -> bool {
        let ratio = |attempt: &TryReport| attempt.residual / attempt.target;
        let [first, .., last] = &self.tries[..] else { return false };
        self.tries.len() > HALVINGS_TO_JUDGE && ratio(last) > WORSE * ratio(first)
    }

    fn cause_text(&self) -> String {
        let residual = self.iterations.last().map_or(String::new(), |last| last.shortfall(self.iterations.len() - 1));
        match &self.cause {
            FailureCause::CyclingContact { contact, cycling, nodes, is_slip } => {
                let (count, between) = (cycling.len(), if *is_slip { " between stick and slip" } else { "" });
                let named = named(cycling);
                format!("the contact state of {count} of {nodes} nodes of contact \"{contact}\" kept changing{between} ({named}){residual}")
            }
            FailureCause::SlowConvergence => format!("the iterations did not come nearer to a solution{residual}"),
            FailureCause::Divergence => format!("the iterates left the range of numbers or grew without bound{residual}"),
            FailureCause::StepLimit { ratios } if ratios.len() > 1 => {
                let ratios: Vec<String> = ratios.iter().map(|ratio| format!("{ratio:.0e}")).collect();
                format!("each halving came nearer (residual over target {}), but the limit of halvings was reached", ratios.join(", "))
            }
            FailureCause::StepLimit { .. } => format!("Newton's method still came nearer when its iterations were used up{residual}"),
            FailureCause::LoadTooFast { load, body, node, cells, outcome } => {
                let outcome = FailureReport { cause: (**outcome).clone(), ..self.clone() };
                let size = if *cells < 100.0 { format!("{cells:.1}") } else { format!("{cells:.0e}") };
                format!("{load} alone moves node {node} of body \"{body}\" by {size} cells in the step; {}", outcome.cause_text())
            }
            FailureCause::NoEquilibrium { steps, unbalanced, body, how, missing } => {
                let why = match missing {
                    Some(Missing::Support) => ": it touches nothing, and no support holds it there",
                    Some(Missing::Guidance) => ": what it touches does not hold it there, for contact has no friction",
                    Some(Missing::Friction) => ": what it touches does not hold it there, and friction is too small for it",
                    None => "",
                };
                let part = if *unbalanced < 0.01 { format!("{unbalanced:.0e}") } else { format!("{unbalanced:.2}") };
                format!("after {steps} damped steps body \"{body}\" can still {how}, and {part} of the forces on it is not balanced{why}")
            }
            FailureCause::InvertedCell { body, cell, determinant, center, dimension } => {
                let center: Vec<String> = center[..*dimension].iter().map(|x| format!("{x:.4}")).collect();
                format!(
                    "cell {cell} of body \"{body}\", at ({}) when undeformed, turned inside out (det F = {})",
                    center.join(", "),
                    three_digits(*determinant)
                )
            }
            FailureCause::SingularSystem { reason, .. } => format!("{reason} in the tangent of the step"),
            FailureCause::TooFast { contact } => {
                format!("the bodies of contact \"{contact}\" moved farther in one step than the search for contact reaches")
            }
        }
    }

    /// Suggested remedy; `ease` is the kind of smaller increments.
    pub(super) fn remedy(&self, ease: SmallerIncrements) -> Remedy {
        match &self.cause {
            FailureCause::NoEquilibrium { missing: Some(Missing::Guidance | Missing::Friction), .. } => Remedy::Guide,
            _ if self.unheld.is_some() => Remedy::HoldBeforeRest,
            FailureCause::CyclingContact { is_slip: true, .. } => Remedy::Ease(ease, FRICTION),
            FailureCause::SlowConvergence | FailureCause::Divergence if self.iterations.last().is_some_and(|last| last.fails_by_slip()) => {
                Remedy::Ease(ease, FRICTION)
            }
            FailureCause::CyclingContact { .. } => Remedy::Ease(ease, "; surfaces should slide by less than a facet per step"),
            FailureCause::InvertedCell { .. } => Remedy::Ease(ease, ", a finer mesh there, or a smaller load"),
            FailureCause::SingularSystem { .. } => Remedy::HoldOnce,
            FailureCause::NoEquilibrium { missing: Some(Missing::Support), .. } => Remedy::HoldAgainstLoads,
            FailureCause::LoadTooFast { .. } => Remedy::LoadSlowly(ease),
            FailureCause::Divergence => Remedy::Ease(ease, ", or apply the load more slowly"),
            FailureCause::NoEquilibrium { missing: None, .. }
            | FailureCause::SlowConvergence
            | FailureCause::TooFast { .. }
            | FailureCause::StepLimit { .. } => Remedy::Ease(ease, ""),
        }
    }
}

/// Number of halvings from which the residuals of the attempts indicate whether smaller steps help.
const HALVINGS_TO_JUDGE: usize = 3;

/// Growth of the residual relative to its target, from the nominal step to the last halving, above which smaller steps are no remedy.
const WORSE: f64 = 10.0;

/// Additional remedy for friction.
const FRICTION: &str = ", or, where the coefficient falls with the speed, a larger transition speed";

impl IterationReport {
    /// True if forces balance and the friction law alone is violated.
    fn fails_by_slip(&self) -> bool {
        self.is_slip && self.residual <= self.target && self.gap_violation > 1.0
    }

    /// Remaining error after `count` iterations, as a clause to append.
    fn shortfall(&self, count: usize) -> String {
        let what = if self.residual > self.target {
            format!(
                "the largest residual is {:.1e} at node {} of body \"{}\" (target {:.1e})",
                self.residual, self.node, self.body, self.target
            )
        } else if self.gap_violation > 1.0 {
            let contact = self.contact.as_deref().unwrap_or("");
            let condition = if self.is_slip { "friction law" } else { "gap condition" };
            format!("the {condition} of contact \"{contact}\" is violated by {:.1e} times what is tolerated", self.gap_violation)
        } else {
            format!("the residual can still move {:.1e} times the energy that `tolerance` allows", self.energy)
        };
        format!("; after {count} iterations {what}")
    }
}

/// Largest number of nodes named in an explanation.
const NAMED: usize = 4;

/// Lists the nodes in words, such as `nodes 3, 4 and 7 of body "block"`.
fn named(cycling: &[CyclingNode]) -> String {
    let numbers: Vec<String> = cycling.iter().take(NAMED).map(|node| node.node.to_string()).collect();
    let (body, plural) = (cycling.first().map_or("", |node| &node.body), if cycling.len() == 1 { "" } else { "s" });
    let numbers = match numbers.as_slice() {
        [first @ .., last] if !first.is_empty() && cycling.len() <= NAMED => format!("{} and {last}", first.join(", ")),
        _ if cycling.len() > NAMED => format!("{}, …", numbers.join(", ")),
        _ => numbers.concat(),
    };
    format!("node{plural} {numbers} of body \"{body}\"")
}
