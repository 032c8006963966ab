//! Observer of a session for Python: printed lines, warnings, checks and progress are passed to `conserva._told`; signals end the
//! computation.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use conserva::script::{Diagnostic, Observer, Progress};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::raise::parts;
use crate::state;

/// Period at which signals of Python are checked.
const BETWEEN_LOOKS: Duration = Duration::from_millis(100);

/// Observer that calls Python functions.
pub struct PythonObserver {
    interrupt: Arc<AtomicBool>,
    looked: Cell<Instant>,
}

impl PythonObserver {
    /// Observer that sets this flag if the handler of a signal raises an exception.
    pub fn new(interrupt: Arc<AtomicBool>) -> Self {
        PythonObserver { interrupt, looked: Cell::new(Instant::now()) }
    }

    /// Calls a function of `conserva._told`; an exception ends the computation.
    fn tell(&self, name: &str, arguments: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, PyTuple>>) {
        Python::attach(|py| {
            let told = || py.import("conserva._told")?.getattr(name)?.call1(arguments(py)?);
            if let Err(error) = told() {
                self.stop(error);
            }
        });
    }

    fn stop(&self, error: PyErr) {
        self.interrupt.store(true, Ordering::Relaxed);
        state::with(|state| state.raised.replace(Some(error)));
    }
}

impl Observer for PythonObserver {
    fn print(&self, line: &str) {
        self.tell("printed", |py| PyTuple::new(py, [line]));
    }

    fn passed(&self, line: &str) {
        self.tell("passed", |py| PyTuple::new(py, [line]));
    }

    fn warn(&self, warning: &Diagnostic) {
        self.tell("warned", |py| PyTuple::new(py, [parts(py, warning)?]));
    }

    fn advanced(&self, progress: &Progress) {
        if self.looked.get().elapsed() < BETWEEN_LOOKS {
            return;
        }
        self.looked.set(Instant::now());
        Python::attach(|py| {
            if let Err(error) = py.check_signals() {
                self.stop(error);
            }
        });
        let (model, time, until) = (progress.model.to_string(), progress.row.time, progress.until);
        self.tell("advanced", move |py| (model, time, until).into_pyobject(py));
    }

    fn began(&self, what: &str) {
        self.tell("began", |py| PyTuple::new(py, [what]));
    }

    fn ended(&self) {
        self.tell("ended", |py| Ok(PyTuple::empty(py)));
    }
}
