//! Progress and interruption of a running factorisation.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Number of operations above which a factorization reports its progress: a few tenths of a second.
const LONG: f64 = 5e9;

/// Interrupt flag and progress counter of a factorization; both may be shared with other threads.
#[derive(Clone, Debug, Default)]
pub struct InterruptWatch {
    /// Ends the factorisation when it becomes true.
    pub interrupt: Option<Arc<AtomicBool>>,
    /// Completed thousandths of a long factorization; 0 while none runs.
    pub progress: Option<Arc<AtomicU32>>,
}

impl InterruptWatch {
    /// True if the factorisation is to end.
    pub(super) fn is_interrupted(&self) -> bool {
        self.interrupt.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Stores the progress: `done` of `all` operations.
    pub(super) fn progressed(&self, done: u64, all: f64) {
        if let Some(progress) = self.progress.as_ref().filter(|_| all > LONG) {
            progress.store((1e3 * done as f64 / all) as u32, Ordering::Relaxed);
        }
    }

    /// Resets the progress when no factorization runs.
    pub(super) fn ended(&self) {
        if let Some(progress) = &self.progress {
            progress.store(0, Ordering::Relaxed);
        }
    }
}
