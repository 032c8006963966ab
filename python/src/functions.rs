//! The functions of the extension module.

use std::ffi::CStr;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Duration;

use conserva::script::Form;
use pyo3::exceptions::{PyImportError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCFunction, PyDict, PyTuple, PyType};
use rhai::Dynamic;

use crate::convert::{number_of, set_classes, to_engine, to_python};
use crate::meshes;
use crate::raise::{diagnostic_error, is_of, script_error};
use crate::script::{described, run};
use crate::state::{self, Live, Outcome, Pending, Work};

/// Longest wait for computations of other threads when the interpreter ends.
const LONGEST_END: Duration = Duration::from_secs(10);

/// Body of a function of the module.
type Body = for<'py> fn(&Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>>;

/// Adds the functions to the module.
///
/// # Errors
/// Python has no memory left.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    if !conserva::math::simd::is_supported() {
        let title = "this processor has no AVX2 and FMA, for which the module was compiled; compile it with the feature `portable`";
        return Err(PyImportError::new_err(title));
    }
    let functions: [(&'static CStr, Body); 17] = [
        (c"call", call),
        (c"file", file),
        (c"text", text),
        (c"reference", reference),
        (c"register", register),
        (c"release", release),
        (c"printed", printed),
        (c"shown", shown),
        (c"mesh", meshes::mesh),
        (c"make_mesh", meshes::make_mesh),
        (c"positions", meshes::positions),
        (c"state_bytes", state_bytes),
        (c"state_object", state_object),
        (c"enter", enter),
        (c"leave", leave),
        (c"run", run_script),
        (c"command", command),
    ];
    for (name, body) in functions {
        add_function(module, name, body)?;
    }
    add_function(module, c"shutdown", shutdown)
}

fn add_function(module: &Bound<'_, PyModule>, name: &'static CStr, body: Body) -> PyResult<()> {
    let function = PyCFunction::new_closure(module.py(), Some(name), None, move |arguments, _| body(arguments).map(Bound::unbind))?;
    module.add(name.to_string_lossy().as_ref(), function)
}

/// `call(function, values)`: calls a function by its index in the registry.
fn call<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    function(arguments, Work::Function)
}

/// `file(function, values)`: returns the bytes of the file that a function would write.
fn file<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    function(arguments, Work::File)
}

fn function<'py>(arguments: &Bound<'py, PyTuple>, work: impl FnOnce(usize, Vec<Dynamic>) -> Work) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let function: usize = arguments.get_item(0)?.extract()?;
    let values = arguments.get_item(1)?;
    let values = values.cast::<PyTuple>()?;
    let mut converted = Vec::with_capacity(values.len());
    // The object of a method determines the session.
    let live = match values.get_item(0).ok().map(|first| number_of(&first)).transpose()?.flatten() {
        Some(number) => {
            let (live, value) = state::with(|state| state.value(py, number))?;
            converted.push(value);
            live
        }
        None => state::with(|state| state.current(py))?,
    };
    let Some(description) = live.calls.functions().get(function) else {
        return Err(PyTypeError::new_err("there is no such function"));
    };
    for value in values.iter().skip(converted.len()) {
        converted.push(to_engine(&value)?);
    }
    // Releasing the lock for a property would cost more than it gains.
    let is_quick = matches!(description.form, Form::Property(_));
    run_call(py, &live, work(function, converted), is_quick)
}

/// `text(text, variables)`: runs a text of the script language; returns its variables, and its value under an empty name.
fn text<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (text, given): (String, Bound<PyDict>) = arguments.extract()?;
    let variables = given.iter().map(|(name, value)| Ok((name.extract()?, to_engine(&value)?))).collect::<PyResult<Vec<_>>>()?;
    let live = state::with(|state| state.current(py))?;
    run_call(py, &live, Work::Text(text, variables), false)
}

/// Runs a call, without Python's lock unless it is quick.
fn run_call<'py>(py: Python<'py>, live: &Rc<Live>, work: Work, is_quick: bool) -> PyResult<Bound<'py, PyAny>> {
    state::with(|state| {
        state.begin(py, live)?;
        state.pending.borrow_mut().push(Pending { live: live.clone(), work: Some(work), outcome: None });
        Ok::<(), PyErr>(())
    })?;
    if is_quick {
        compute()
    } else {
        py.detach(compute)
    }
    let (outcome, raised) = state::with(|state| {
        state.end();
        let pending = state.pending.borrow_mut().pop();
        (pending.and_then(|pending| pending.outcome), state.raised.take())
    });
    match (outcome, raised) {
        // The exception of a signal handler raised after the last step is not lost.
        (Some(Ok(_)), Some(error)) if !error.is_instance_of::<pyo3::exceptions::PyException>(py) => Err(error),
        (Some(Ok(Outcome::Value(value))), _) => to_python(py, live, value),
        (Some(Ok(Outcome::File(bytes))), _) => Ok(bytes.map(|bytes| PyBytes::new(py, &bytes)).into_pyobject(py)?.into_any()),
        (Some(Err(error)), raised) => Err(failed(py, &error, raised)),
        (None, _) => Err(script_error(py, "the call was lost", "its session ended while it ran", "call it again")),
    }
}

/// Runs the pending call of this thread.
fn compute() {
    let taken = state::with(|state| state.pending.borrow_mut().last_mut().map(|pending| (pending.live.clone(), pending.work.take())));
    let Some((live, Some(work))) = taken else { return };
    let outcome = work.run(&live.calls);
    state::with(|state| {
        if let Some(pending) = state.pending.borrow_mut().last_mut() {
            pending.outcome = Some(outcome);
        }
    });
}

/// Exception of a call: that of a signal handler, otherwise that of the message, with the exception of a callable as its cause.
fn failed(py: Python, error: &conserva::script::Diagnostic, raised: Option<PyErr>) -> PyErr {
    let is_interrupt = error.class == conserva::script::Class::Interrupted;
    if is_interrupt && let Err(signal) = py.check_signals() {
        return signal;
    }
    match raised {
        Some(raised) if is_interrupt || !raised.is_instance_of::<pyo3::exceptions::PyException>(py) => raised,
        // The message of a nested call within a callable is more specific than the fact that the callable raised.
        Some(raised) if is_of(py, &raised, "ConservaError") && error.title.starts_with("the callable raised") => raised,
        Some(raised) if error.title.starts_with("the callable raised") => {
            let cause = format!("a function that was passed to Conserva raised {raised}");
            let hint = "the traceback above is that of the function; check it by calling it with numbers";
            let exception = diagnostic_error(py, &error.clone().cause(cause).hint(hint));
            exception.set_cause(py, Some(raised));
            exception
        }
        raised => {
            let exception = diagnostic_error(py, error);
            exception.set_cause(py, raised);
            exception
        }
    }
}

/// `reference()`: the registry as JSON.
fn reference<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let live = state::with(|state| state.current(py))?;
    Ok((live.calls.reference(), live.calls.type_names().to_vec()).into_pyobject(py)?.into_any())
}

/// `register(object, classes)`: sets the classes of objects.
fn register<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let (object, classes): (Bound<PyType>, Bound<PyDict>) = arguments.extract()?;
    set_classes(object, classes);
    Ok(arguments.py().None().into_bound(arguments.py()))
}

/// `release(number)`: drops the value of an object.
fn release<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let number: u64 = arguments.get_item(0)?.extract()?;
    state::with(|state| state.release(number));
    Ok(arguments.py().None().into_bound(arguments.py()))
}

/// `printed(object)`: returns the text of `print`.
fn printed<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (live, value) = state::with(|state| state.value(py, arguments.get_item(0)?.extract()?))?;
    Ok(live.calls.printed(&value).into_pyobject(py)?.into_any())
}

/// `shown(object)`: returns the text at the prompt.
fn shown<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (live, value) = state::with(|state| state.value(py, arguments.get_item(0)?.extract()?))?;
    Ok(live.calls.shown(&value).into_pyobject(py)?.into_any())
}

/// `state_bytes(object)`: a state and the rows of its history as bytes.
fn state_bytes<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (live, value) = state::with(|state| state.value(py, arguments.get_item(0)?.extract()?))?;
    let bytes = live.calls.state_bytes(&value);
    let bytes = bytes.ok_or_else(|| script_error(py, "the object is no state", "`sim.save()` returns a `State`", "pass a `State`"))?;
    Ok((PyBytes::new(py, &bytes.0), PyBytes::new(py, &bytes.1)).into_pyobject(py)?.into_any())
}

/// `state_object(state, rows)`: a state from its bytes.
fn state_object<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (bytes, rows): (Vec<u8>, Vec<u8>) = arguments.extract()?;
    let live = state::with(|state| state.current(py))?;
    let object = live.calls.state_object(&bytes, &rows).map_err(|error| diagnostic_error(py, &error))?;
    to_python(py, &live, object)
}

/// `enter(options)`: opens a session; returns its number and that of the previous session.
fn enter<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let options = arguments.get_item(0)?;
    let numbers = state::with(|state| state.enter(py, options.cast::<PyDict>()?))?;
    Ok(numbers.into_pyobject(py)?.into_any())
}

/// `leave(number, before)`: ends a session; returns its report.
fn leave<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (number, before): (u64, u64) = arguments.extract()?;
    let report = state::with(|state| state.leave(py, number, before))?;
    Ok(described(py, &report)?.into_any())
}

/// `run(path, output, overrides, threads)`: runs a script file.
fn run_script<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    type Given = (PathBuf, Option<PathBuf>, Vec<(String, String)>, usize);
    let (path, output, overrides, threads): Given = arguments.extract()?;
    Ok(run(arguments.py(), path, output, overrides, threads)?.into_any())
}

/// `command(program, arguments)`: runs the command line; returns its exit code.
fn command<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (program, words): (PathBuf, Vec<std::ffi::OsString>) = arguments.extract()?;
    let code = py.detach(|| conserva::cli::main_of(program, words));
    Ok(code.into_pyobject(py)?.into_any())
}

/// `shutdown()`: ends all computations before the end of the interpreter, and frees the values of this thread.
fn shutdown<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    py.detach(|| state::interrupt_all(LONGEST_END));
    state::with(|state| state.clear());
    Ok(py.None().into_bound(py))
}
