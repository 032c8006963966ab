//! Errors of a step.

use thiserror::Error;

use super::remedy::{Remedy, SmallerIncrements};
use crate::linear::RanksError;
use crate::machine::memory::written;
use crate::math::digits::three_digits;
use crate::math::tolerances::EIGHTH_TURN;

/// Reason why a step or equilibrium failed.
#[derive(Debug, Error)]
pub enum StepError {
    /// A time function failed.
    #[error("the amplitude of the load on \"{boundary}\" failed at t = {time}")]
    Amplitude {
        /// `body.boundary` on which the load acts.
        boundary: String,
        /// Time of the evaluation.
        time: f64,
        /// Error of the function.
        source: super::amplitude::TimeFunctionError,
    },
    /// Prescribed rotation of a boundary beyond the limit of one step.
    #[error("\"{boundary}\" turns by {} rad in a step of {} at t = {time}", three_digits(*angle), three_digits(*dt))]
    TurnsFar {
        /// `body.boundary` that rotates.
        boundary: String,
        /// Time at the beginning of the step.
        time: f64,
        /// Time step size.
        dt: f64,
        /// Prescribed rotation in the step `[rad]`.
        angle: f64,
    },
    /// Equations of a coupling, a tie or a joint that contradict those of other couplings, ties, joints or supports.
    #[error(
        "\"{coupling}\" contradicts supports and other couplings or joints at t = {time}: its equations are violated by {}",
        three_digits(*gap)
    )]
    Contradiction {
        /// Name of the coupling, tie or joint.
        coupling: String,
        /// Time at the end of the step.
        time: f64,
        /// Residual of the violated equation `[length]`.
        gap: f64,
    },
    /// Stop or taut cable that supports, drives and other joints force beyond its limit.
    #[error("joint \"{joint}\" has come to its stop at t = {time}, and what is held, prescribed or driven moves it beyond")]
    Blocked {
        /// Name of the joint.
        joint: String,
        /// Time of the last step.
        time: f64,
    },
    /// Contact between sides that supports, drives and joints move wholly.
    #[error("contact \"{contact}\" cannot hold at t = {time}: what is held, prescribed or driven moves both sides, and none can give way")]
    Unyielding {
        /// Name of the contact.
        contact: String,
        /// Time of the last step.
        time: f64,
    },
    /// A node that friction locks: held in one direction, it neither sticks to the other side nor slides off it.
    #[error("friction of contact \"{contact}\" locks node {node} of body \"{body}\", which is held in one direction, at t = {time}")]
    Jammed {
        /// Name of the contact.
        contact: String,
        /// Name of the body.
        body: String,
        /// Number of the node in the body's mesh.
        node: usize,
        /// Time of the last step.
        time: f64,
        /// Coefficient of friction above which the node is locked.
        limit: f64,
    },
    /// A coefficient of friction failed.
    #[error("the friction of contact \"{contact}\" failed at t = {time}")]
    Friction {
        /// Name of the contact.
        contact: String,
        /// Time of the evaluation.
        time: f64,
        /// Error of the function.
        source: super::amplitude::TimeFunctionError,
    },
    /// Newton's method failed in spite of all halvings.
    #[error("Newton's method did not converge at t = {time} (step {step}, dt = {dt}, after {halvings} halvings): {cause}")]
    NotConverged {
        /// Time at the beginning of the step.
        time: f64,
        /// Number of the failed step.
        step: usize,
        /// Step size of the last attempt.
        dt: f64,
        /// Number of halvings.
        halvings: usize,
        /// Cause as found in the last iterations.
        cause: String,
        /// Suggested remedy.
        remedy: Remedy,
    },
    /// Explicit steps are longer than the fastest vibration admits.
    #[error(
        "explicit steps of {} are longer than the stable step at t = {time}, {}: the fastest vibration has the angular frequency {}",
        three_digits(*dt),
        three_digits(*stable),
        three_digits(*frequency)
    )]
    TooLong {
        /// Time of the state.
        time: f64,
        /// Size of the steps.
        dt: f64,
        /// Stable time step size.
        stable: f64,
        /// Angular frequency of the fastest vibration.
        frequency: f64,
        /// The body with the fastest cell.
        body: String,
        /// Number of the fastest cell in its body's mesh.
        cell: usize,
        /// Share of contact penalties in the squared frequency.
        penalty_share: f64,
    },
    /// Energy of explicit steps grew without cause, or a cell was inverted.
    #[error("explicit steps of {} came to an end at t = {time}: {cause}", three_digits(*dt))]
    RanAway {
        /// Time of the last accepted step.
        time: f64,
        /// Size of the steps.
        dt: f64,
        /// Observed cause.
        cause: String,
        /// Stable step size at the last accepted state; `None` if not found.
        stable: Option<f64>,
    },
    /// Sides of a contact penetrate each other without contact forces.
    #[error("the sides of contact \"{contact}\" overlap at t = {time} without contact forces")]
    StillOverlaps {
        /// Name of the contact.
        contact: String,
        /// Time of the state.
        time: f64,
        /// Penetration `[length]`.
        depth: f64,
        /// Penetration relative to the longest facet length at that point.
        facets: f64,
        /// Place of the deepest penetration `[length]`.
        at: Vec<f64>,
    },
    /// The user interrupted the run.
    #[error("interrupted at t = {time}")]
    Interrupted {
        /// Time of the last accepted step.
        time: f64,
    },
    /// The MPI processes (ranks) of the distributed solver have ended during the step.
    #[error("{source} at t = {time}")]
    Ranks {
        /// Time of the last accepted step.
        time: f64,
        /// Failure of the MPI processes (ranks).
        source: RanksError,
    },
    /// Shortage of memory, which a smaller step does not cure.
    #[error("the memory is used up at t = {time}: the factorization of {unknowns} unknowns takes at least {}", written(*needed))]
    OutOfMemory {
        /// Time of the last accepted step.
        time: f64,
        /// Number of unknowns.
        unknowns: usize,
        /// Least number of bytes needed.
        needed: u64,
    },
}

impl StepError {
    /// True if the run can only go on after a resume: the user interrupted it, or the distributed solver was lost.
    pub(in crate::dynamics) fn is_interrupt(&self) -> bool {
        matches!(self, StepError::Interrupted { .. } | StepError::Ranks { .. })
    }

    /// Returns the error with the time up to which equilibria were followed appended to the cause.
    pub(in crate::dynamics) fn after_equilibria_until(mut self, reached: f64) -> Self {
        if let StepError::NotConverged { cause, remedy, .. } = &mut self {
            if *remedy == Remedy::Ease(SmallerIncrements::SupportsAndLoads, "") {
                *remedy = Remedy::FollowPath;
            }
            cause.push_str(&format!("; equilibria were followed up to t = {reached:.4}"));
        }
        self
    }

    /// Suggested remedy in one sentence.
    pub fn hint(&self) -> String {
        match self {
            StepError::Amplitude { .. } => "let the time function return a finite number for every time".into(),
            StepError::TurnsFar { dt, angle, .. } => {
                format!("take steps of {} or less, for an eighth of a turn at most", three_digits(dt * EIGHTH_TURN / angle))
            }
            StepError::Contradiction { .. } => {
                "let nodes that are held or moved follow what the cell or the joint does, or leave them free: supports hold both sides of \
                 a pair alike, and a mechanism does not start at a dead center"
                    .into()
            }
            StepError::Blocked { .. } => {
                "let the motion end before the stop, or leave the joint more room; a force in place of a prescribed motion lets the stop \
                 hold"
                    .into()
            }
            StepError::Unyielding { .. } => {
                "let the motion end before the surfaces meet, or leave one side free; a force in place of a prescribed motion lets the \
                 contact hold"
                    .into()
            }
            StepError::Jammed { limit, .. } => format!(
                "it could only slide with a coefficient of friction below {}: lower the friction, or leave the node free",
                three_digits(*limit)
            ),
            StepError::Friction { .. } => "let the coefficient be a finite number, 0 or more, everywhere and at every time".into(),
            StepError::NotConverged { remedy, .. } => remedy.to_string(),
            StepError::TooLong { stable, .. } => format!("take steps of {} or less", three_digits(0.9 * stable)),
            StepError::RanAway { dt, stable, .. } => match stable {
                Some(stable) if *stable < *dt => format!(
                    "the stable step has shrunk to {} since the start, as cells were compressed: take a shorter step",
                    three_digits(*stable)
                ),
                _ => "take a shorter step; look at the motion before: what moves by a good part of a cell in a step is not resolved".into(),
            },
            StepError::StillOverlaps { .. } => {
                "see that the boundaries of the contact face each other where the bodies overlap; start with a smaller overlap, or let it \
                 grow over several equilibria; in motion, try a smaller step"
                    .into()
            }
            StepError::Interrupted { .. } => "everything up to this time is kept".into(),
            StepError::Ranks { source, .. } => format!("everything up to this time is kept; {}", source.hint()),
            StepError::OutOfMemory { .. } => "use a coarser mesh, end other programs, or run it on a machine with more memory".into(),
        }
    }
}
