//! Checks that run a scenario several times.
//!
//! The simulations of a study are aside of the run: they write no files and stand in no summary.

use crate::script::language::function::Function;

pub mod invariance;
pub mod order;
pub mod result;

/// The functions of this topic.
pub fn functions() -> Vec<Function> {
    vec![order::expect_order(), invariance::expect_invariant(), result::result()]
}
