//! The files of a run: its output folder, files at paths that a script gives, and what the script yields for its summary.

pub mod failures;
pub mod results;
pub mod run_folder;
pub mod writing;
