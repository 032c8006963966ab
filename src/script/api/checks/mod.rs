//! Checks: expectations of a script on its results. A check that holds reports what it measured; one that fails ends the script.
//!
//! Checks that run a scenario several times are in `studies/`.

use crate::script::language::function::Function;

pub mod conserved;
pub mod touched;
pub mod values;
pub mod verdicts;

/// Script functions of this topic.
pub fn functions() -> Vec<Function> {
    vec![values::expect(), values::expect_close(), conserved::expect_conserved(), touched::expect_contact(), values::expect_error()]
}
