//! Standard output and standard error of a command: what the script prints, checks, warnings, and progress.
//!
//! Progress goes to standard error: a bar on a terminal, occasional lines elsewhere. Failed writes never end the run. When the reader of
//! standard output has closed its pipe, the remaining output is dropped. Other failures, such as a full disk, are reported once, and the
//! exit code reports the loss.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::process::{DOUBTFUL, exit_code};
use crate::script::{Class, Diagnostic, Ink, Observer, Progress};

/// Least time between two plain lines of progress.
const BETWEEN_LINES: Duration = Duration::from_secs(2);
/// Time after which a plain line is written even if less than a percent has been done.
const LONGEST_SILENCE: Duration = Duration::from_secs(60);
/// Number of positions of the bar.
const BAR: u64 = 10_000;

/// Writes to standard error.
///
/// # Errors
/// The text cannot be written.
pub fn write_error(text: &str) -> std::io::Result<()> {
    std::io::stderr().lock().write_all(text.as_bytes())
}

/// Writes to standard error; failures are ignored.
pub fn complain(text: &str) {
    let _ = write_error(text);
}

/// Returns `Colored` if standard error is a terminal and `NO_COLOR` is not set.
pub fn ink() -> Ink {
    let wanted = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    if wanted && std::io::stderr().is_terminal() { Ink::Colored } else { Ink::Plain }
}

/// True if nothing more is written, because the reader of standard output has closed its pipe.
static CLOSED: AtomicBool = AtomicBool::new(false);
/// True if output was lost, so that the exit code must report the loss.
static LOST: AtomicBool = AtomicBool::new(false);

/// Writes a text to standard output.
pub fn write_out(text: &str) {
    if CLOSED.load(Ordering::Relaxed) {
        return;
    }
    let mut out = std::io::stdout().lock();
    judge(out.write_all(text.as_bytes()).and_then(|()| out.flush()));
}

/// Records the result of a write to standard output.
pub fn judge(written: std::io::Result<()>) {
    let Err(error) = written else { return };
    CLOSED.store(true, Ordering::Relaxed);
    if error.kind() != ErrorKind::BrokenPipe && !LOST.swap(true, Ordering::Relaxed) {
        let message = Diagnostic::error(Class::Output, "standard output cannot be written").cause(error.to_string());
        complain(&message.hint("what is printed is missing from here on; files are written all the same").render(ink()));
    }
}

/// Returns the exit code `code`, or that of lost output unless `code` reports an error.
pub fn with_loss(code: u8) -> u8 {
    let tells_of_loss = [0, exit_code(Class::Check), DOUBTFUL].contains(&code);
    if tells_of_loss && LOST.load(Ordering::Relaxed) { exit_code(Class::Output) } else { code }
}

/// The observer of the command line.
pub struct Console {
    quiet: bool,
    bar: RefCell<Option<ProgressBar>>,
    terminal: bool,
    begun: Cell<Instant>,
    last: Cell<(Instant, f64)>,
    status: RefCell<Option<Status>>,
    factorization: Arc<AtomicU32>,
}

impl Console {
    /// Returns a console that shows progress unless `quiet`.
    pub fn new(quiet: bool) -> Self {
        let now = Instant::now();
        Console {
            quiet,
            bar: RefCell::default(),
            terminal: std::io::stderr().is_terminal(),
            begun: Cell::new(now),
            last: Cell::new((now, 0.0)),
            status: RefCell::default(),
            factorization: Arc::default(),
        }
    }

    /// True if no progress is shown.
    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Progress of a long factorization, which the linear solver sets and the bar shows.
    pub fn factorization(&self) -> Arc<AtomicU32> {
        self.factorization.clone()
    }

    /// Writes a line to standard output, above the progress bar.
    pub fn say(&self, line: &str) {
        let write = || write_out(&format!("{line}\n"));
        match self.bar.borrow().as_ref() {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }

    /// Shows a message on standard error.
    pub fn report(&self, diagnostic: &Diagnostic) {
        let text = diagnostic.render(ink());
        match self.bar.borrow().as_ref() {
            Some(bar) => bar.suspend(|| complain(&text)),
            None => complain(&text),
        }
    }

    /// Writes a note to standard error, unless quiet.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            complain(&format!("{text}\n"));
        }
    }

    fn bar(&self, until: Option<f64>) -> ProgressBar {
        let mut slot = self.bar.borrow_mut();
        let fresh = || {
            let bar = ProgressBar::with_draw_target(until.map(|_| BAR), ProgressDrawTarget::stderr_with_hz(10));
            // On a narrow terminal, the message is shortened.
            let template = match until {
                Some(_) => "{bar:16} {percent:>3} %, {eta} left  {factorization}{wide_msg}",
                None => "{spinner} {factorization}{wide_msg}",
            };
            if let Ok(style) = ProgressStyle::with_template(template) {
                let factorization = self.factorization();
                let tell = move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
                    let done = factorization.load(Ordering::Relaxed);
                    if done > 0 {
                        let _ = write!(out, "factorization {} %  ", done / 10);
                    }
                };
                bar.set_style(style.with_key("factorization", tell));
            }
            bar.enable_steady_tick(Duration::from_millis(250));
            bar
        };
        slot.get_or_insert_with(fresh).clone()
    }
}

/// Status after a step, formatted only where it is shown: a resumed run passes a million steps in a second.
#[derive(Default)]
struct Status {
    model: String,
    time: f64,
    until: Option<f64>,
    step: usize,
    /// Energy defect relative to the largest energy.
    defect: f64,
    iterations: usize,
    halvings: usize,
}

impl Status {
    fn set(&mut self, progress: &Progress) {
        let row = progress.row;
        if self.model != progress.model {
            self.model = progress.model.into();
        }
        (self.time, self.until, self.step) = (row.time, progress.until, row.step);
        self.defect = if progress.scale > 0.0 { row.energy_defect / progress.scale } else { 0.0 };
        (self.iterations, self.halvings) = (row.newton_iterations, row.halvings);
    }
}

impl fmt::Display for Status {
    /// Writes `t = 0.5 of 2, step 100, energy defect 1.2e-15, 4 iterations`.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: t = {:.6}", self.model, self.time)?;
        self.until.map_or(Ok(()), |until| write!(out, " of {until}"))?;
        let plural = if self.iterations == 1 { "" } else { "s" };
        write!(out, ", step {}, energy defect {:.1e}, {} Newton iteration{plural}", self.step, self.defect, self.iterations)?;
        if self.halvings > 0 { write!(out, ", halved {} times", self.halvings) } else { Ok(()) }
    }
}

impl Observer for Console {
    fn print(&self, line: &str) {
        self.say(line);
    }

    fn passed(&self, line: &str) {
        self.say(line);
    }

    fn warn(&self, warning: &Diagnostic) {
        self.report(warning);
    }

    fn advanced(&self, progress: &Progress) {
        if self.quiet {
            return;
        }
        let done = progress.until.map(|until| ((progress.row.time - progress.from) / (until - progress.from)).clamp(0.0, 1.0));
        if self.terminal {
            let bar = self.bar(progress.until);
            if let Some(done) = done {
                bar.set_position((done * BAR as f64) as u64);
            } else {
                bar.tick();
            }
            let mut status = Status::default();
            status.set(progress);
            bar.set_message(status.to_string());
            return;
        }
        let mut status = self.status.borrow_mut();
        if status.is_none() {
            self.begun.set(Instant::now());
            self.last.set((Instant::now(), 0.0));
        }
        let status = status.get_or_insert_default();
        status.set(progress);
        let (at, before) = self.last.get();
        let silence = at.elapsed();
        let moved = done.is_none_or(|done| done - before >= 0.01);
        if (silence >= BETWEEN_LINES && moved) || silence >= LONGEST_SILENCE {
            let left = done.filter(|done| *done > 0.0).map(|done| self.begun.get().elapsed().mul_f64((1.0 - done) / done));
            let left = left.map(|left| format!(", about {:.0} s left", left.as_secs_f64())).unwrap_or_default();
            complain(&format!("{status}{left}\n"));
            self.last.set((Instant::now(), done.unwrap_or(0.0)));
        }
    }

    fn began(&self, what: &str) {
        if !self.quiet && self.terminal {
            let bar = self.bar(None);
            bar.set_message(what.to_string());
            bar.enable_steady_tick(Duration::from_millis(100));
        }
    }

    fn ink(&self) -> Ink {
        if ink() == Ink::Colored && std::io::stdout().is_terminal() { Ink::Colored } else { Ink::Plain }
    }

    fn ended(&self) {
        if let Some(bar) = self.bar.borrow_mut().take() {
            bar.finish_and_clear();
        }
        if let Some(status) = self.status.take().filter(|_| self.begun.get().elapsed() >= BETWEEN_LINES) {
            complain(&format!("{status}, {:.1} s\n", self.begun.get().elapsed().as_secs_f64()));
        }
    }
}
