//! Threads that share a loop. Loop items must be computed independently; results then do not depend on the number of threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::Yield;
use rayon::prelude::*;

/// A pool of threads.
#[derive(Clone, Debug, Default)]
pub struct Workers {
    pool: Option<Arc<rayon::ThreadPool>>,
}

impl Workers {
    /// Pool of `threads` threads; with one thread, or if none can be started, all work runs on the calling thread.
    pub fn new(threads: usize) -> Self {
        let pool = (threads > 1).then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok().map(Arc::new)).flatten();
        Workers { pool }
    }

    /// True if there is more than one thread.
    pub fn are_many(&self) -> bool {
        self.pool.is_some()
    }

    /// Number of threads.
    pub fn count(&self) -> usize {
        self.pool.as_ref().map_or(1, |pool| pool.current_num_threads())
    }

    /// Runs work with many short loops, keeping all threads awake until it ends: waking a thread takes as long as a short loop.
    pub fn together<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        let Some(pool) = &self.pool else { return work() };
        let (work, result, done) = (Mutex::new(Some(work)), Mutex::new(None), AtomicBool::new(false));
        pool.broadcast(|thread| {
            if thread.index() == 0 {
                let ended = Ended(&done);
                let work = work.lock().unwrap_or_else(PoisonError::into_inner).take();
                *result.lock().unwrap_or_else(PoisonError::into_inner) = work.map(|work| work());
                drop(ended);
                return;
            }
            let mut idle = 0;
            while !done.load(Ordering::Acquire) {
                idle = if rayon::yield_now() == Some(Yield::Executed) { 0 } else { idle + 1 };
                // An idle thread yields the processor to other programs from time to time.
                if idle % 64 == 63 { std::thread::yield_now() } else { std::hint::spin_loop() }
            }
        });
        result.into_inner().unwrap_or_else(PoisonError::into_inner).expect("one thread has the number 0")
    }

    /// Calls `work` for every item with its index, in any order; a thread takes `together` consecutive items at a time.
    pub fn for_each<T: Send>(&self, items: &mut [T], together: usize, work: impl Fn(usize, &mut T) + Sync + Send) {
        match &self.pool {
            Some(pool) if items.len() > together => pool.install(|| {
                let items = items.par_iter_mut().with_min_len(together).with_max_len(together.max(1));
                items.enumerate().for_each(|(k, item)| work(k, item));
            }),
            _ => items.iter_mut().enumerate().for_each(|(k, item)| work(k, item)),
        }
    }

    /// Calls `work` for every `length` numbers of `data` (the last may be fewer) with the number of the part, in any order.
    pub(crate) fn for_each_part(&self, data: &mut [f64], length: usize, work: impl Fn(usize, &mut [f64]) + Sync + Send) {
        match &self.pool {
            Some(pool) => pool.install(|| data.par_chunks_mut(length).with_max_len(1).enumerate().for_each(|(k, part)| work(k, part))),
            None => data.chunks_mut(length).enumerate().for_each(|(k, part)| work(k, part)),
        }
    }
}

/// Guard that sets a flag when dropped, also after a panic.
struct Ended<'a>(&'a AtomicBool);

impl Drop for Ended<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}
