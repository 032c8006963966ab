//! Checks: what a script expects of its results. One that holds says what it measured; one that does not ends the script.
//!
//! Checks that run a scenario several times stand in `studies/`.

use crate::script::language::function::Function;

pub mod conserved;
pub mod touched;
pub mod values;
pub mod verdicts;

/// The functions of this topic.
pub fn functions() -> Vec<Function> {
    vec![values::expect(), values::expect_close(), conserved::expect_conserved(), touched::expect_contact(), values::expect_error()]
}
