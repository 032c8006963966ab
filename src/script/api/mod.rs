//! The functions and objects that scripts use, one topic a file or folder.

use crate::script::language::function::Function;

pub mod arrays;
pub mod checks;
pub mod contacts;
pub mod examples;
pub mod files;
pub mod materials;
pub mod meshes;
pub mod models;
pub mod motion;
pub mod nested_runs;
pub mod numbers;
pub mod parameters;
pub mod remedies;
pub mod signals;
pub mod simulations;
pub mod studies;
pub mod time_functions;
pub mod units;

/// All functions of the API in the order of the reference.
pub fn functions() -> Vec<Function> {
    [
        meshes::functions(),
        materials::functions(),
        models::functions(),
        contacts::functions(),
        simulations::probes::functions(),
        time_functions::functions(),
        simulations::functions(),
        simulations::results::functions(),
        checks::functions(),
        studies::functions(),
        studies::studies(),
        parameters::functions(),
        simulations::stop_after::functions(),
        numbers::functions(),
        units::functions(),
        arrays::functions(),
        signals::functions(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
