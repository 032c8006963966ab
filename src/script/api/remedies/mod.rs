//! How to mend what the kernels refuse or find, as a script does it. Kernels say it in plain words, for they know of no script; here stand
//! the sentences that a script has other words for.

mod meshes;
mod models;
mod runs;
mod words;

pub use runs::explained;
pub use words::ScriptWords;
