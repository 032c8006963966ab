//! Runs of random scripts that are killed and resumed: every file and every printed line must be as if nobody had disturbed them.

pub mod course;
pub mod generator;
pub mod scenes;
