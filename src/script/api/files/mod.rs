//! The files of a run: its output folder, files at paths given by a script, and results for its summary.

pub mod failures;
pub mod results;
pub mod run_folder;
pub mod shown;
pub mod writing;
