//! Hints of the solver's refusals and findings in terms of scripts. The solver gives hints in plain words, since it is independent of
//! scripts; this folder has the hints that need terms of scripts.

mod meshes;
mod models;
mod runs;
mod words;

pub use runs::explained;
pub use words::ScriptWords;
