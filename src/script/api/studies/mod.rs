//! Studies: many runs from one script.
//!
//! Checks that run a scenario several times, closures for many points (`sweep`), minimization (`minimize`), and comparison of curves
//! (`compare`). The simulations of a study write no files and are not in the summary.

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

/// Functions of studies, apart from the checks.
pub fn studies() -> Vec<Function> {
    let mut all = vec![sweep::sweep(), minimize::minimize(), compare::compare(), integrators::compare_integrators(), measured::read_csv()];
    all.extend(tables::functions());
    all
}
