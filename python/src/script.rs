//! Whole scripts and the command line, each on a thread with a stack for deep recursion.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use conserva::script::{Class, Diagnostic, Report, STACK, Session, Settings, home};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::observer::PythonObserver;
use crate::raise::{diagnostic_error, parts};

/// Period at which signals of Python are checked.
const BETWEEN_LOOKS: Duration = Duration::from_millis(50);

/// Runs a script file; returns its report.
///
/// # Errors
/// The exception of a signal's handler, after the run has ended at a whole step.
pub fn run<'py>(
    py: Python<'py>,
    path: PathBuf,
    output: Option<PathBuf>,
    overrides: Vec<(String, String)>,
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let interrupt = Arc::new(AtomicBool::new(false));
    let settings = Settings { overrides, output, threads, interrupt: interrupt.clone(), ..Settings::default() };
    let (sender, receiver) = channel();
    let work = move || {
        let observer = Rc::new(PythonObserver::new(settings.interrupt.clone()));
        let folder: PathBuf = home(&path).to_path_buf();
        let report = match Session::new(settings, Path::new(&folder), observer) {
            Ok(mut session) => session.run_file(&path),
            Err(error) => Report::failed(*error),
        };
        // There is no receiver if the interpreter has ended.
        let _ = sender.send(report);
    };
    let thread = std::thread::Builder::new().name("script".into()).stack_size(STACK).spawn(work)?;
    let receiver = std::sync::Mutex::new(receiver);
    let mut raised = None;
    let report = loop {
        let received =
            py.detach(|| receiver.lock().map_or(Err(RecvTimeoutError::Disconnected), |receiver| receiver.recv_timeout(BETWEEN_LOOKS)));
        match received {
            Ok(report) => break report,
            Err(RecvTimeoutError::Timeout) => {
                if let Err(error) = py.check_signals() {
                    interrupt.store(true, Ordering::Relaxed);
                    raised = Some(error);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                break Report::failed(Diagnostic::error(Class::Internal, "the thread of the script has ended"));
            }
        }
    };
    // The thread has sent its last message; freeing its values needs no lock of Python.
    let _ = py.detach(|| thread.join());
    match (raised, &report.error) {
        (Some(error), _) => Err(error),
        (None, Some(error)) if error.class != Class::Check => Err(diagnostic_error(py, error)),
        _ => described(py, &report),
    }
}

/// A report as a dictionary.
///
/// # Errors
/// Python has no memory left.
pub fn described<'py>(py: Python<'py>, report: &Report) -> PyResult<Bound<'py, PyDict>> {
    let entries = PyDict::new(py);
    entries.set_item("error", report.error.as_ref().map(|error| parts(py, error)).transpose()?)?;
    entries.set_item("findings", &report.findings)?;
    entries.set_item("checks", report.checks)?;
    entries.set_item("energy", &report.energy)?;
    entries.set_item("is_conserving", report.is_conserving)?;
    entries.set_item("is_doubtful", report.is_doubtful)?;
    Ok(entries)
}
