//! Messages of Conserva as exceptions of Python, which the package constructs from their parts.

use conserva::script::{Calls, Class, Diagnostic, Ink};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Name of a class of messages.
fn class_name(class: Class) -> &'static str {
    match class {
        Class::Check => "check",
        Class::Script => "script",
        Class::Numerics => "numerics",
        Class::Output => "output",
        Class::Interrupted => "interrupted",
        Class::ResultUsed => "result used",
        Class::Internal => "internal",
    }
}

/// The parts of a message as a dictionary.
///
/// # Errors
/// Python has no memory left.
pub fn parts<'py>(py: Python<'py>, error: &Diagnostic) -> PyResult<Bound<'py, PyDict>> {
    let parts = PyDict::new(py);
    parts.set_item("kind", class_name(error.class))?;
    parts.set_item("code", &error.code)?;
    parts.set_item("title", &error.title)?;
    parts.set_item("label", &error.label)?;
    parts.set_item("causes", &error.causes)?;
    parts.set_item("hints", &error.hints)?;
    parts.set_item("is_in_script", Calls::is_in_text(error))?;
    parts.set_item("drawn", error.render(Ink::Plain))?;
    Ok(parts)
}

/// Exception of a message.
pub fn diagnostic_error(py: Python, error: &Diagnostic) -> PyErr {
    let made = || -> PyResult<PyErr> {
        let exception = py.import("conserva._errors")?.call_method1("exception_of", (parts(py, error)?,))?;
        Ok(PyErr::from_value(exception))
    };
    made().unwrap_or_else(|_| PyRuntimeError::new_err(error.title.clone()))
}

/// True for an exception of a class of `conserva._errors`.
pub fn is_of(py: Python, error: &PyErr, class: &str) -> bool {
    let class = py.import("conserva._errors").and_then(|errors| errors.getattr(class));
    class.is_ok_and(|class| error.matches(py, class).unwrap_or(false))
}

/// Exception of a call that did not reach the engine.
pub fn script_error(py: Python, title: &str, cause: &str, hint: &str) -> PyErr {
    diagnostic_error(py, &Diagnostic::error(Class::Script, title).code("C1020").cause(cause).hint(hint))
}
