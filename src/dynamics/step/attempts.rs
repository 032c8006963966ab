//! Strategies of Newton's method for a step, and their order.

use serde::{Deserialize, Serialize};

use crate::contact::Correction;

/// Strategy of Newton's method.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Strategy {
    /// The active set is completed on the frozen linearization; increments are limited.
    InnerLoop,
    /// One active set update per iteration, backtracking on the residual: used if [`Self::InnerLoop`] fails.
    Backtracking,
}

impl Strategy {
    /// Usual number of iterations.
    pub fn iterations(self) -> usize {
        match self {
            Strategy::InnerLoop => 25,
            Strategy::Backtracking => 40,
        }
    }
}

/// Solution attempts for a step, in their order: strategy of Newton's method and discrete gradient of the contacts.
pub const ATTEMPTS: [(Strategy, Correction); 5] = [
    (Strategy::InnerLoop, Correction::PerPatch),
    (Strategy::InnerLoop, Correction::SteadyEnds),
    (Strategy::InnerLoop, Correction::PerNode),
    (Strategy::Backtracking, Correction::PerPatch),
    (Strategy::Backtracking, Correction::PerNode),
];

/// Order of the attempts, by their indices in [`ATTEMPTS`].
pub type AttemptOrder = [usize; ATTEMPTS.len()];

/// Usual order of the attempts. Nodes exactly opposite nodes in the plane, and edges of both sides that coincide on a length in space
/// (blocks or rings with equal layers), are kinks of all their contact elements. The correction of one element depends on the direction of
/// its motion `p` without rigid motions, and its derivative on `1/|p|`. In the sum over the elements of a node the kinks of inner edges
/// cancel (`tests/scripts/contacts.rhai`).
const USUAL: AttemptOrder = [0, PER_NODE, 1, 3, 4];

/// Order of the attempts in space with friction. Surfaces that stick move by 1e-9 of a facet relative to each other. With corrections of
/// elements the tangent has entries of 2000 times the stiffness of the nodes (`tests/scripts/flush_friction.rhai`), and no set of sticking
/// and slipping constraints is a solution.
const IN_SPACE_WITH_FRICTION: AttemptOrder = [PER_NODE, 0, 1, 3, 4];

/// Index in [`ATTEMPTS`] of one correction per node.
pub const PER_NODE: usize = 2;

/// Order of the attempts for models in `dimension` dimensions.
pub fn usual_order(dimension: usize, has_friction: bool) -> AttemptOrder {
    if dimension == 3 && has_friction { IN_SPACE_WITH_FRICTION } else { USUAL }
}

/// Number of steps after which the usual attempt is the first one again.
const PREFERRED_STEPS: u8 = 8;

/// Attempt that succeeded after the usual first one failed; the next steps try it first, because causes of failure persist for some steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PreferredAttempt {
    /// Index into `ATTEMPTS`.
    attempt: u8,
    /// Number of successive steps solved by this attempt.
    steps: u8,
}

impl PreferredAttempt {
    /// True if the index is in the list of attempts; a state read from a file may contain any index.
    pub fn is_sound(self) -> bool {
        usize::from(self.attempt) < ATTEMPTS.len()
    }

    /// Indices of the attempts in the order of trial.
    pub fn order(self, usual: AttemptOrder) -> impl Iterator<Item = usize> {
        let is_usual = self.steps == 0 || self.steps >= PREFERRED_STEPS;
        let first = if is_usual { usual[0] } else { usize::from(self.attempt) };
        std::iter::once(first).chain(usual.into_iter().filter(move |&attempt| attempt != first))
    }

    /// Preference after a step solved by the attempt with this index.
    pub fn after(self, attempt: usize, usual: AttemptOrder) -> PreferredAttempt {
        let is_usual = attempt == usual[0];
        let attempt = attempt as u8;
        match attempt {
            _ if is_usual => PreferredAttempt::default(),
            _ if attempt == self.attempt && self.steps < PREFERRED_STEPS => PreferredAttempt { attempt, steps: self.steps + 1 },
            _ => PreferredAttempt { attempt, steps: 1 },
        }
    }
}
