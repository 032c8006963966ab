//! Studies: from one run to many.
//!
//! Checks that run a scenario several times, closures for many points (`sweep`), searches for the best one (`minimize`), and what curves
//! have in common (`compare`). The simulations of a study are aside of the run: they write no files and stand in no summary.

use crate::script::api::files::results;
use crate::script::language::function::Function;

pub mod compare;
pub mod integrators;
pub mod invariance;
pub mod measured;
pub mod minimize;
pub mod order;
pub mod record;
pub mod sweep;
pub mod tables;
pub mod vary;
pub mod worker_pool;

/// The checks of this topic.
pub fn functions() -> Vec<Function> {
    vec![order::expect_order(), invariance::expect_invariant(), results::result()]
}

/// Its other functions.
pub fn studies() -> Vec<Function> {
    let mut all = vec![sweep::sweep(), minimize::minimize(), compare::compare(), integrators::compare_integrators(), measured::read_csv()];
    all.extend(tables::functions());
    all
}
