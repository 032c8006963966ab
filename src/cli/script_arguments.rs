//! Arguments of every command that runs a script.

use std::path::PathBuf;

use clap::Args;

use super::memory::MemoryArguments;
use crate::script::MAX_OPERATIONS;

/// Common arguments of all commands that run a script.
#[derive(Args)]
pub struct ScriptArguments {
    /// The script
    pub script: PathBuf,
    /// Value of a parameter of the script (`param(name, default)`)
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    pub overrides: Vec<(String, String)>,
    /// Let the script read files below this folder, too (it may read those below its own)
    #[arg(long, value_name = "DIR")]
    pub allow_read: Vec<PathBuf>,
    /// Operations after which a script counts as endless (time spent in the solver does not count)
    #[arg(long, value_name = "N", default_value_t = MAX_OPERATIONS)]
    pub max_operations: u64,
    #[command(flatten)]
    pub memory: MemoryArguments,
}

/// Largest number of threads, or of simultaneous points or tests.
const MOST_THREADS: u16 = 1024;

/// Parses a number of threads.
///
/// # Errors
/// The text is not of the expected form; the message describes the form.
pub fn threads(text: &str) -> Result<u16, String> {
    match text.trim().parse::<u64>() {
        Ok(0) => Err("write at least 1".into()),
        Ok(count) => {
            u16::try_from(count).ok().filter(|count| *count <= MOST_THREADS).ok_or_else(|| format!("write at most {MOST_THREADS}"))
        }
        Err(_) => Err(format!("write a whole number from 1 to {MOST_THREADS}")),
    }
}

/// Parses `NAME=VALUE`.
///
/// # Errors
/// The text is not of the expected form; the message describes the form.
pub fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => Ok((name.trim().to_string(), value.to_string())),
        _ => Err("write it as NAME=VALUE, such as --set dt=0.01".into()),
    }
}
