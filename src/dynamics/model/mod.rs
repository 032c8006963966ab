//! Definition of a problem, before any number is computed.

pub mod amplitude;
pub mod boundaries;
pub mod bounds;
pub mod builder;
mod codes;
pub mod coupling_checks;
pub mod couplings;
pub mod definitions;
pub mod depths;
pub mod error;
pub mod findings;
pub mod growth;
pub mod held;
pub mod hulls;
pub mod integrator_limits;
pub mod interactions;
pub mod joint_checks;
pub mod joints;
pub mod locking;
pub mod overlaps;
pub mod part;
pub mod prescription;
pub mod remedy;
pub mod repeated;
pub mod step_error;
pub mod unpaired;
pub mod update_rules;
