//! Progress of a study: a bar on a terminal, occasional lines elsewhere, and a line for each point that is not completed.

use std::cell::{Cell, RefCell};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::console::complain;
use crate::studies::{Plan, Record};

/// Least time between two plain lines.
const BETWEEN_LINES: Duration = Duration::from_secs(5);

/// Largest number of characters of a cause in a line; the table has the complete text.
pub const LONGEST: usize = 160;

/// Progress of a study.
pub struct StudyProgress {
    bar: Option<ProgressBar>,
    quiet: bool,
    count: usize,
    done: Cell<usize>,
    told: RefCell<Vec<usize>>,
    begun: Instant,
    last: Cell<Instant>,
}

impl StudyProgress {
    /// Returns the progress of a study of `count` points.
    pub fn new(count: usize, quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(count as u64), ProgressDrawTarget::stderr_with_hz(10));
            if let Ok(style) = ProgressStyle::with_template("{bar:24} {pos} of {len} points{msg}, {eta} left") {
                bar.set_style(style);
            }
            bar.enable_steady_tick(Duration::from_millis(500));
            bar
        });
        let now = Instant::now();
        StudyProgress { bar, quiet, count, done: Cell::new(0), told: RefCell::default(), begun: now, last: Cell::new(now) }
    }

    /// Reports a computed point.
    pub fn done(&self, plan: &Plan, index: usize, record: &Record) {
        self.done.set(self.done.get() + 1);
        if !record.outcome.is_completed() {
            self.told.borrow_mut().push(index);
            let cause: String = record.cause.as_deref().unwrap_or_default().chars().take(LONGEST).collect();
            let line = format!("point {index} ({}) {}: {cause}\n", plan.points[index].id, record.outcome.word());
            match &self.bar {
                Some(bar) => bar.suspend(|| complain(&line)),
                None => complain(&line),
            }
        }
        if let Some(bar) = &self.bar {
            if !self.told.borrow().is_empty() {
                bar.set_message(format!(", {} failed", self.told.borrow().len()));
            }
            bar.set_position(self.done.get() as u64);
        } else if !self.quiet && self.last.get().elapsed() >= BETWEEN_LINES {
            self.last.set(Instant::now());
            let left = self.begun.elapsed().mul_f64((self.count - self.done.get()) as f64 / self.done.get() as f64);
            let failed = if !self.told.borrow().is_empty() { format!(", {} failed", self.told.borrow().len()) } else { String::new() };
            complain(&format!("{} of {} points{failed}, about {:.0} s left\n", self.done.get(), self.count, left.as_secs_f64()));
        }
    }

    /// Returns the indices of failed points that were reported.
    pub fn told(&self) -> Vec<usize> {
        self.told.borrow().clone()
    }

    /// Ends the progress display.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
