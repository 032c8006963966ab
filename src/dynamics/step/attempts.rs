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
    pub fn order(self) -> impl Iterator<Item = usize> {
        let first = if self.steps < PREFERRED_STEPS { usize::from(self.attempt) } else { 0 };
        std::iter::once(first).chain((0..ATTEMPTS.len()).filter(move |&attempt| attempt != first))
    }

    /// Preference after a step solved by the attempt with this index.
    pub fn after(self, attempt: usize) -> PreferredAttempt {
        let attempt = attempt as u8;
        match attempt {
            0 => PreferredAttempt::default(),
            _ if attempt == self.attempt && self.steps < PREFERRED_STEPS => PreferredAttempt { attempt, steps: self.steps + 1 },
            _ => PreferredAttempt { attempt, steps: 1 },
        }
    }
}
