//! Signals: those that end a run do so with its checkpoint, summary and report. `docs/files.md` has the table.

use std::io::Result;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGUSR1, SIGXCPU, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::process::exit_code;
use crate::script::Class;

/// Period at which a thread checks for the first interrupt key.
const LOOK: Duration = Duration::from_millis(100);
/// Time after the first interrupt key within which further ones count as one: `timeout -s INT` signals the process and then its group, and
/// so does a shell script that is interrupted as a whole.
const MOMENT: Duration = Duration::from_millis(700);

/// Returns a flag that becomes true at the first signal that ends a run.
///
/// Only a second interrupt key, after `MOMENT`, ends the process at once: other signals are repeated automatically, such as that of
/// `timeout`, of a shell whose terminal closes, or of a limit of processor time, every second.
///
/// # Errors
/// A signal that cannot be watched.
pub fn interrupt() -> Result<Arc<AtomicBool>> {
    let interrupt = Arc::new(AtomicBool::new(false));
    watch_impatience()?;
    for signal in [SIGINT, SIGTERM] {
        flag::register(signal, interrupt.clone())?;
    }
    #[cfg(unix)]
    {
        for signal in [SIGXCPU, SIGUSR1] {
            flag::register(signal, interrupt.clone())?;
        }
        watch_hangup(&interrupt)?;
        // A write beyond the size limit of files then fails with an error.
        flag::register(SIGXFSZ, Arc::default())?;
    }
    Ok(interrupt)
}

/// Ends the process at an interrupt key more than `MOMENT` after the first one.
fn watch_impatience() -> Result<()> {
    let (is_first, is_impatient) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
    flag::register_conditional_shutdown(SIGINT, i32::from(exit_code(Class::Interrupted)), is_impatient.clone())?;
    flag::register(SIGINT, is_first.clone())?;
    std::thread::Builder::new().name("interrupts".into()).spawn(move || {
        while !is_first.load(Ordering::Relaxed) {
            std::thread::sleep(LOOK);
        }
        std::thread::sleep(MOMENT);
        is_impatient.store(true, Ordering::Relaxed);
    })?;
    Ok(())
}

/// Returns two flags of a prompt: that of the interrupt key, which is raised repeatedly, and that of the closing terminal or a request to
/// end. While the prompt waits (`waiting`), a request to end has its default effect, the end of the process.
///
/// # Errors
/// A signal that cannot be watched.
pub fn prompt(waiting: &Arc<AtomicBool>) -> Result<(Arc<AtomicBool>, Arc<AtomicBool>)> {
    let (interrupt, over) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
    flag::register_conditional_default(SIGTERM, waiting.clone())?;
    for signal in [SIGINT, SIGTERM] {
        flag::register(signal, interrupt.clone())?;
    }
    flag::register(SIGTERM, over.clone())?;
    #[cfg(unix)]
    for flag in [&interrupt, &over] {
        watch_hangup(flag)?;
    }
    Ok((interrupt, over))
}

/// Raises a flag when the terminal closes, unless the process was started with `nohup`.
#[cfg(unix)]
fn watch_hangup(flag: &Arc<AtomicBool>) -> Result<()> {
    if !ignores_hangup() {
        flag::register(SIGHUP, flag.clone())?;
    }
    Ok(())
}

/// True if this process was started with `SIGHUP` ignored (known on Linux only; false elsewhere).
#[cfg(unix)]
fn ignores_hangup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (SIGHUP - 1) & 1 == 1)
}
