//! Runs of random scripts that are killed and resumed: every file and every printed line must equal those of an uninterrupted run.

pub mod course;
pub mod generator;
pub mod scenes;
