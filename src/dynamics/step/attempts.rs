//! The ways in which Newton's method tries to solve a step, and which of them it tries first.

use serde::{Deserialize, Serialize};

use crate::contact::Correction;

/// How Newton's method proceeds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Strategy {
    /// Set finished on the frozen linearisation, increments limited.
    InnerLoop,
    /// One set update per iteration, backtracking on the residual: for what the first did not solve.
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

/// The ways in which a step is tried until one converges: how Newton's method proceeds, and with which discrete gradient of the contacts.
pub const ATTEMPTS: [(Strategy, Correction); 5] = [
    (Strategy::InnerLoop, Correction::PerPatch),
    (Strategy::InnerLoop, Correction::SteadyEnds),
    (Strategy::InnerLoop, Correction::PerNode),
    (Strategy::Backtracking, Correction::PerPatch),
    (Strategy::Backtracking, Correction::PerNode),
];

/// Steps after which the usual attempt goes first again.
const PREFERRED_STEPS: u8 = 8;

/// The attempt that succeeded where the usual first one failed: the steps that follow try it first, because what made the usual one fail
/// lasts for some steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Preferred {
    /// Its place in the list of attempts.
    attempt: u8,
    /// Steps in a row that it has solved.
    steps: u8,
}

impl Preferred {
    /// Whether it is one of the list, whatever file it comes from.
    pub fn is_sound(self) -> bool {
        usize::from(self.attempt) < ATTEMPTS.len()
    }

    /// The attempts in the order in which they are tried.
    pub fn order(self) -> impl Iterator<Item = usize> {
        let first = if self.steps < PREFERRED_STEPS { usize::from(self.attempt) } else { 0 };
        std::iter::once(first).chain((0..ATTEMPTS.len()).filter(move |&attempt| attempt != first))
    }

    /// After a step that an attempt has solved.
    pub fn after(self, attempt: usize) -> Preferred {
        let attempt = attempt as u8;
        match attempt {
            0 => Preferred::default(),
            _ if attempt == self.attempt && self.steps < PREFERRED_STEPS => Preferred { attempt, steps: self.steps + 1 },
            _ => Preferred { attempt, steps: 1 },
        }
    }
}
