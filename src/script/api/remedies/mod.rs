//! Hints of the kernels' refusals and findings in terms of scripts. Kernels give hints in plain words, since they are independent of
//! scripts; this folder has the hints that need terms of scripts.

mod meshes;
mod models;
mod runs;
mod words;

pub use runs::explained;
pub use words::ScriptWords;
