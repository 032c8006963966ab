//! One step of a model: its equations, their linearization at an iterate as a value, Newton's method, contact conditions, prediction.

pub mod acceleration;
pub mod active_set;
pub mod assembly;
pub mod attempts;
pub mod conditions;
pub mod constraint_rows;
pub mod constraints;
pub mod contact_set;
pub mod convergence;
pub mod counters;
pub mod failure;
pub mod foresight;
pub mod frozen;
pub mod impulse_response;
pub mod iterate;
pub mod large_motion;
pub mod making;
pub mod matrix;
pub mod newton;
pub mod predictor;
pub mod redundancy;
pub mod scheme_memory;
pub mod search_history;
pub mod start;
pub mod system;
pub mod vibrations;
