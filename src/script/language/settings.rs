//! Settings of a session, from the command line or a test.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32};
use std::time::Duration;

use super::limits::MAX_OPERATIONS;
use crate::linear::SolverChoice;
use crate::output::LiveReport;

/// Mode of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The script is run.
    Run,
    /// Models are built and described; no steps are taken.
    Check,
}

/// Interval between checkpoints of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checkpoints {
    /// Never, not even on an interrupt.
    Never,
    /// After this number of steps and equilibria.
    Steps(usize),
    /// After this time, or thirty times the time spent on the last checkpoint, whichever is longer.
    Time(Duration),
}

/// Settings of a session.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Run or check.
    pub mode: Mode,
    /// Values for `param`, as given with `--set`.
    pub overrides: Vec<(String, String)>,
    /// Folders that a script may read besides its own.
    pub allow_read: Vec<PathBuf>,
    /// Folder of the results; without it, no results are written.
    pub output: Option<PathBuf>,
    /// Threads of the element loop.
    pub threads: usize,
    /// Linear solver in place of the one that the script chooses.
    pub solver: Option<SolverChoice>,
    /// Default number of points of a study that are computed simultaneously, each on a thread.
    pub workers: usize,
    /// Operations after which a script counts as endless; time spent in native functions does not count.
    pub max_operations: u64,
    /// Flag that ends the run at the last accepted step.
    pub interrupt: Arc<AtomicBool>,
    /// Progress of a long factorization in thousandths; 0 while none runs.
    pub factorization: Arc<AtomicU32>,
    /// Interval between checkpoints.
    pub checkpoints: Checkpoints,
    /// Time at which simulations stop, as if interrupted.
    pub until: Option<f64>,
    /// Live report of the run, for browsers that follow it.
    pub live: Option<Arc<LiveReport>>,
    /// True at a prompt, where the user can enter further statements.
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
            solver: None,
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

/// Limits a requested number of threads to a few per processor: more gain nothing and cost stacks and engines.
pub fn worthwhile(threads: usize) -> usize {
    threads.min((4 * processors()).max(16))
}

/// Processors of this machine that the program may use.
pub fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
