//! Threads of the element loop.

use std::sync::Arc;

/// A number of threads that computes batches; sums are always made in one order, so results do not depend on it.
#[derive(Clone)]
pub struct Workers {
    pool: Option<Arc<rayon::ThreadPool>>,
}

impl Workers {
    /// `threads` threads; with one, or where none can be started, everything runs on the calling thread.
    pub fn new(threads: usize) -> Self {
        let pool = (threads > 1).then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok().map(Arc::new)).flatten();
        Workers { pool }
    }

    /// The pool, if there is more than one thread.
    pub(super) fn pool(&self) -> Option<&rayon::ThreadPool> {
        self.pool.as_deref()
    }
}
