//! How a session runs its scripts: the values that the command line or a test decides on.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32};
use std::time::Duration;

use super::limits::MAX_OPERATIONS;
use crate::output::LiveReport;

/// What a session does with a script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Runs it.
    Run,
    /// Builds its models and reports what it would do; takes no step.
    Check,
}

/// How often a run writes a checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checkpoints {
    /// Never, not even when it is interrupted.
    Never,
    /// After so many steps and equilibria.
    Steps(usize),
    /// After so much time, or thirty times what the last one took, whichever is longer.
    Time(Duration),
}

/// How a session runs a script.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Run or check.
    pub mode: Mode,
    /// Values for `param`, as given with `--set`.
    pub overrides: Vec<(String, String)>,
    /// Folders that a script may read besides its own.
    pub allow_read: Vec<PathBuf>,
    /// Folder of the results; none are written without it.
    pub output: Option<PathBuf>,
    /// Threads of the element loop.
    pub threads: usize,
    /// Points of a study that are computed at a time, each on a thread, where the script does not say.
    pub workers: usize,
    /// Operations after which a script counts as endless; time spent in native functions does not count.
    pub max_operations: u64,
    /// Ends the run at the last accepted step when it becomes true.
    pub interrupt: Arc<AtomicBool>,
    /// Tells how far a long factorization is, in thousandths; 0 while none runs.
    pub factorization: Arc<AtomicU32>,
    /// How often it writes a checkpoint.
    pub checkpoints: Checkpoints,
    /// Time at which simulations stop, as if interrupted.
    pub until: Option<f64>,
    /// Those who follow the run while it goes on.
    pub live: Option<Arc<LiveReport>>,
    /// Whether somebody sits at a prompt, who can ask further.
    pub interactive: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            mode: Mode::Run,
            overrides: Vec::new(),
            allow_read: Vec::new(),
            output: None,
            threads: 1,
            workers: processors(),
            max_operations: MAX_OPERATIONS,
            interrupt: Arc::default(),
            factorization: Arc::default(),
            checkpoints: Checkpoints::Time(Duration::from_secs(60)),
            until: None,
            live: None,
            interactive: false,
        }
    }
}

/// Threads that are worth their stacks and their engines where so many were asked for: more than a few for each processor gain nothing.
pub fn worthwhile(threads: usize) -> usize {
    threads.min((4 * processors()).max(16))
}

/// Processors of this machine that the program may use.
pub fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
