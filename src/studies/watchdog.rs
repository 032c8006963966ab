//! Ends a point when the process is interrupted or the time limit of the point is exceeded.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Period at which the watchdog checks.
const PERIOD: Duration = Duration::from_millis(20);

/// Flag, deadline and action of the point that is watched.
struct WatchedPoint {
    stop: Arc<AtomicBool>,
    deadline: Option<Instant>,
    /// Records the point as given up if it does not stop.
    give_up: Box<dyn Fn() + Send>,
}

/// Thread that watches the points of a process, one after the other.
#[derive(Clone)]
pub struct Watchdog {
    interrupt: Arc<AtomicBool>,
    watched: Arc<Mutex<Option<WatchedPoint>>>,
}

/// Time in which a point must stop after its deadline.
const GRACE: Duration = Duration::from_secs(10);

impl Watchdog {
    /// Starts a watchdog that passes an interrupt on, and calls `end` when a point does not stop after its deadline: the thread of the
    /// point cannot be ended, so the process must be.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn new(interrupt: Arc<AtomicBool>, end: fn()) -> std::io::Result<Self> {
        let watchdog = Watchdog { interrupt, watched: Arc::default() };
        let (interrupt, watched) = (watchdog.interrupt.clone(), Arc::downgrade(&watchdog.watched));
        std::thread::Builder::new().name("watchdog".into()).spawn(move || {
            while let Some(watched) = watched.upgrade() {
                if look(&interrupt, &watched) {
                    end();
                }
                drop(watched);
                std::thread::sleep(PERIOD);
            }
        })?;
        Ok(watchdog)
    }

    /// True if the process was interrupted.
    pub fn is_interrupted(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
    }

    /// Begins to watch a point; returns the flag that requests its stop. `give_up` is called if it does not stop in time.
    pub fn begin(&self, seconds: Option<f64>, give_up: impl Fn() + Send + 'static) -> Arc<AtomicBool> {
        let stop = Arc::new(AtomicBool::new(false));
        let deadline = seconds.and_then(|seconds| Instant::now().checked_add(Duration::try_from_secs_f64(seconds).ok()?));
        if let Ok(mut watched) = self.watched.lock() {
            *watched = Some(WatchedPoint { stop: stop.clone(), deadline, give_up: Box::new(give_up) });
        }
        stop
    }

    /// Ends watching; returns true if the point was stopped at its deadline.
    pub fn end(&self) -> bool {
        let watched = self.watched.lock().ok().and_then(|mut watched| watched.take());
        let is_late = |watched: WatchedPoint| {
            watched.deadline.is_some_and(|deadline| Instant::now() >= deadline) && watched.stop.load(Ordering::Relaxed)
        };
        watched.is_some_and(is_late)
    }
}

/// Requests the stop of the watched point on an interrupt or at its deadline. Returns true if the point was given up because it did not
/// stop.
fn look(interrupt: &AtomicBool, watched: &Mutex<Option<WatchedPoint>>) -> bool {
    let Ok(watched) = watched.lock() else { return false };
    let Some(watched) = watched.as_ref() else { return false };
    let is_late = |grace: Duration| watched.deadline.is_some_and(|deadline| Instant::now() >= deadline + grace);
    if interrupt.load(Ordering::Relaxed) || is_late(Duration::ZERO) {
        watched.stop.store(true, Ordering::Relaxed);
    }
    let is_given_up = is_late(GRACE);
    if is_given_up {
        (watched.give_up)();
    }
    is_given_up
}
