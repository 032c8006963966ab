//! Causes of a failed step.

use super::large_motion::LargeMotion;
use crate::bodies::Inverted;
use crate::dynamics::model::part::Refusal;
use crate::dynamics::model::step_error::StepError;
use crate::linear::LinearError;

/// Cause of a failed step.
pub enum Failure {
    /// Too many iterations.
    Iterations,
    /// A cell turned inside out.
    Inverted {
        /// Name of the body.
        body: String,
        /// The inverted cell.
        inverted: Inverted,
    },
    /// The linear system could not be solved.
    Linear(LinearError),
    /// The iterate left the range of numbers.
    Diverged,
    /// Bodies moved farther than the candidate pairs reach.
    BeyondSearch {
        /// Name of the contact.
        pair: String,
    },
    /// A contact that was not admitted to the step, because no closing was expected, overlaps at its end.
    Overlooked {
        /// Name of the contact.
        pair: String,
    },
    /// The predicted motion is too large: the step was not tried.
    Foreseen(LargeMotion),
    /// The step has converged, but its time discretization error is too large.
    Inexact {
        /// The size to try instead `[time]`.
        size: f64,
    },
    /// Failure with a cause other than convergence: no further attempt.
    Fatal(StepError),
}

impl Failure {
    /// Short name of the failure.
    pub fn name(&self) -> &'static str {
        Failure::NAMES[match self {
            Failure::Iterations => 0,
            Failure::Inverted { .. } => 1,
            Failure::Linear(_) => 2,
            Failure::Diverged => 3,
            Failure::Foreseen(_) | Failure::BeyondSearch { .. } | Failure::Overlooked { .. } => 4,
            Failure::Fatal(_) => 5,
            Failure::Inexact { .. } => 6,
        }]
    }

    /// Names of all kinds of failures.
    pub const NAMES: &'static [&'static str] =
        &["iterations used up", "inverted cell", "singular system", "divergence", "motion too fast", "given up", Failure::INEXACT];

    /// Name of a failure by a too large time discretization error.
    pub const INEXACT: &'static str = "error too large";

    /// Converts an interrupted factorization, lack of memory, or a lost rank to a fatal failure; other failures are returned unchanged.
    pub fn or_end(self, time: f64) -> Self {
        match self {
            Failure::Linear(LinearError::Interrupted) => Failure::Fatal(StepError::Interrupted { time }),
            Failure::Linear(LinearError::Ranks(source)) => Failure::Fatal(StepError::Ranks { time, source }),
            Failure::Linear(LinearError::OutOfMemory { unknowns, needed }) => {
                Failure::Fatal(StepError::OutOfMemory { time, unknowns, needed })
            }
            failure => failure,
        }
    }
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Inverted { body, inverted } => Failure::Inverted { body, inverted },
            Refusal::Load(error) => Failure::Fatal(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lack_of_memory_ends_the_run_and_does_not_speak_of_supports() {
        let failure = Failure::Linear(LinearError::OutOfMemory { unknowns: 900_000, needed: 4_100_000_000 }).or_end(0.5);
        let Failure::Fatal(error) = failure else { panic!("smaller steps need no less memory") };
        assert_eq!(error.to_string(), "the memory is used up at t = 0.5: the factorization of 900000 unknowns takes at least 4.1 GB");
        assert!(error.hint().contains("coarser mesh") && !error.hint().contains("fix"), "{}", error.hint());
    }
}
