//! Why a step failed: what a user can look at after the error.

use crate::dynamics::model::remedy::{Ease, Remedy};
use crate::math::digits::three_digits;

/// What made a step fail.
#[derive(Clone, Debug, PartialEq)]
pub enum FailureCause {
    /// The contact state of some nodes changed at least every second time in the last iterations.
    CyclingContact {
        /// Name of the contact pair.
        contact: String,
        /// The nodes that changed.
        cycling: Vec<CyclingNode>,
        /// Secondary nodes of the pair.
        nodes: usize,
        /// Whether they kept touching, and changed between stick and slip only.
        is_slip: bool,
    },
    /// A load or a prescribed motion moves nodes too far in one step.
    LoadTooFast {
        /// What it is, such as `the load on "block.top"`.
        load: String,
        /// Body of the node that it moves farthest.
        body: String,
        /// That node in the body's mesh.
        node: usize,
        /// By how many cells the load alone moves it in the last try.
        cells: f64,
        /// What that led to.
        outcome: Box<FailureCause>,
    },
    /// Newton's method came nearer from halving to halving, or was still converging when its iterations were over.
    StepLimit {
        /// Residual over target at the end of each try.
        ratios: Vec<f64>,
    },
    /// `settle` found no equilibrium.
    NoEquilibrium {
        /// Damped steps taken.
        steps: usize,
        /// Unbalanced force on the body over the forces on it.
        unbalanced: f64,
        /// The body that moves most.
        body: String,
        /// How it moves, such as `move along (1.00, 0.00)`.
        how: String,
        /// What it lacks, where that is known.
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
        /// Smallest determinant of the deformation gradient in it.
        determinant: f64,
        /// Center of the cell in the undeformed body `[length]`.
        center: [f64; 3],
        /// Space dimension.
        dimension: usize,
    },
    /// The linear system could not be solved.
    SingularSystem {
        /// Which body can still move how, or which constraints depend on one another.
        reason: String,
    },
    /// Bodies moved farther in the step than the search for contact reaches.
    TooFast {
        /// Name of the contact pair.
        contact: String,
    },
}

/// What a body lacks to be at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Missing {
    /// It touches nothing.
    Support,
    /// It touches something that does not hold it: contact has no friction.
    Guidance,
    /// The same although contacts have friction.
    Friction,
}

/// A node whose contact state kept changing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CyclingNode {
    /// Its body.
    pub body: String,
    /// Its number in the body's mesh.
    pub node: usize,
    /// Its number among the secondary nodes of the contact; `None` for a corner of the primary side.
    pub index: Option<usize>,
}

/// One try of the step that failed.
#[derive(Clone, Debug, PartialEq)]
pub struct TryReport {
    /// Size of the step `[time]`.
    pub dt: f64,
    /// Iterations looked at.
    pub iterations: usize,
    /// Residual of the last one `[force]`.
    pub residual: f64,
    /// Force below which it would have been small enough.
    pub target: f64,
    /// How it ended, in two words.
    pub outcome: &'static str,
}

/// One Newton iteration of the step that failed.
#[derive(Clone, Debug, PartialEq)]
pub struct IterationReport {
    /// Largest component of the residual `[force]`.
    pub residual: f64,
    /// Force below which it would have been small enough.
    pub target: f64,
    /// Energy that the residual can still move, over what the tolerance allows.
    pub energy: f64,
    /// Largest violation of the contact conditions over what is tolerated.
    pub gap_violation: f64,
    /// Contact nodes that changed their state.
    pub changes: usize,
    /// Active contact nodes.
    pub active: usize,
    /// Body with the largest residual.
    pub body: String,
    /// Node of that body's mesh.
    pub node: usize,
    /// Contact pair with the largest violation.
    pub contact: Option<String>,
    /// Whether what is violated there is the law of friction.
    pub is_slip: bool,
}

/// The report on a step that failed for good.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureReport {
    /// Time at its beginning `[time]`.
    pub time: f64,
    /// Its number.
    pub step: usize,
    /// Size of the last try `[time]`; 0 in `settle`.
    pub dt: f64,
    /// How often it had been halved.
    pub halvings: usize,
    /// What made it fail.
    pub cause: FailureCause,
    /// The iterations of the last try.
    pub iterations: Vec<IterationReport>,
    /// In `settle`: a body without support on which the loads do not balance, so that only contact can hold it.
    pub unheld: Option<String>,
    /// All tries, from the nominal step to the last halving; empty in `settle`.
    pub tries: Vec<TryReport>,
}

impl FailureReport {
    /// The cause with its numbers, one sentence.
    pub fn explanation(&self) -> String {
        let cause = self.cause_text();
        match &self.unheld {
            // Which body lacks what is said already.
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
            FailureCause::SingularSystem { reason } => format!("{reason} in the tangent of the step"),
            FailureCause::TooFast { contact } => {
                format!("the bodies of contact \"{contact}\" moved farther in one step than the search for contact reaches")
            }
        }
    }

    /// How to mend it; `ease` says how less is asked for at a time.
    pub(super) fn remedy(&self, ease: Ease) -> Remedy {
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

/// Halvings from which on the residuals of the tries say whether smaller steps help.
const HALVINGS_TO_JUDGE: usize = 3;

/// Growth of the residual over its target, from the nominal step to the last halving, from which on smaller steps are no remedy.
const WORSE: f64 = 10.0;

/// What helps friction besides.
const FRICTION: &str = ", or, where the coefficient falls with the speed, a larger transition speed";

impl IterationReport {
    /// Whether the forces balance and the law of friction is what is missing.
    fn fails_by_slip(&self) -> bool {
        self.is_slip && self.residual <= self.target && self.gap_violation > 1.0
    }

    /// What is still wrong after `count` iterations, to follow another clause.
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

/// Nodes that an explanation names at most.
const NAMED: usize = 4;

/// `nodes 3, 4 and 7 of body "block"`.
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
