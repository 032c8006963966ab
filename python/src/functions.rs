//! The functions of the extension module.

use std::ffi::CStr;
use std::path::PathBuf;
use std::time::Duration;

use conserva::script::Form;
use pyo3::exceptions::{PyImportError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyCFunction, PyDict, PyList, PyTuple, PyType};

use crate::convert::{number_of, numpy, set_classes, to_engine, to_python};
use crate::raise::{diagnostic_error, is_of, script_error};
use crate::script::{described, run};
use crate::state::{self, Pending};

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
    let functions: [(&'static CStr, Body); 12] = [
        (c"call", call),
        (c"reference", reference),
        (c"register", register),
        (c"release", release),
        (c"printed", printed),
        (c"shown", shown),
        (c"mesh", mesh),
        (c"positions", positions),
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

/// `call(function, values)`: calls a function by its place in the registry.
fn call<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let function: usize = arguments.get_item(0)?.extract()?;
    let values = arguments.get_item(1)?;
    let values = values.cast::<PyTuple>()?;
    let mut converted = Vec::with_capacity(values.len());
    // The object of a method decides the session.
    let live = match values.get_item(0).ok().map(|first| number_of(&first)).transpose()?.flatten() {
        Some(number) => {
            let (live, value) = state::with(|state| state.value(py, number))?;
            converted.push(value);
            live
        }
        None => state::with(|state| state.current(py))?,
    };
    if function >= live.calls.functions().len() {
        return Err(PyTypeError::new_err("there is no such function"));
    }
    for value in values.iter().skip(converted.len()) {
        converted.push(to_engine(&value)?);
    }
    let is_property = matches!(live.calls.functions()[function].form, Form::Property(_));
    state::with(|state| {
        state.begin(py, &live)?;
        state.pending.borrow_mut().push(Pending { live: live.clone(), function, values: converted, outcome: None });
        Ok::<(), PyErr>(())
    })?;
    // A property returns at once, so that giving the lock away would cost more than it gives others.
    if is_property {
        compute()
    } else {
        py.detach(compute)
    }
    let (outcome, raised) = state::with(|state| {
        state.end();
        let pending = state.pending.borrow_mut().pop();
        (pending.and_then(|pending| pending.outcome), state.raised.take())
    });
    match outcome {
        Some(Ok(value)) => match raised {
            // A handler of a signal raised after the last step: its exception is not lost.
            Some(error) if !error.is_instance_of::<pyo3::exceptions::PyException>(py) => Err(error),
            _ => to_python(py, &live, value),
        },
        Some(Err(error)) => Err(failed(py, &error, raised)),
        None => Err(script_error(py, "the call was lost", "its session ended while it ran", "call it again")),
    }
}

/// Runs the call that is pending on this thread.
fn compute() {
    let taken = state::with(|state| {
        state.pending.borrow_mut().last_mut().map(|pending| (pending.live.clone(), pending.function, std::mem::take(&mut pending.values)))
    });
    let Some((live, function, values)) = taken else { return };
    let outcome = live.calls.call(function, values);
    state::with(|state| {
        if let Some(pending) = state.pending.borrow_mut().last_mut() {
            pending.outcome = Some(outcome);
        }
    });
}

/// The exception of a call: that of a signal itself, else that of the message, caused by what a callable raised.
fn failed(py: Python, error: &conserva::script::Diagnostic, raised: Option<PyErr>) -> PyErr {
    let is_interrupt = error.class == conserva::script::Class::Interrupted;
    if is_interrupt && let Err(signal) = py.check_signals() {
        return signal;
    }
    match raised {
        Some(raised) if is_interrupt || !raised.is_instance_of::<pyo3::exceptions::PyException>(py) => raised,
        // A message of a call within a callable says more than that the callable raised.
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

/// `release(number)`: lets go of the value of an object.
fn release<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let number: u64 = arguments.get_item(0)?.extract()?;
    state::with(|state| state.release(number));
    Ok(arguments.py().None().into_bound(arguments.py()))
}

/// `printed(object)`: what `print` shows.
fn printed<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (live, value) = state::with(|state| state.value(py, arguments.get_item(0)?.extract()?))?;
    Ok(live.calls.printed(&value).into_pyobject(py)?.into_any())
}

/// `shown(object)`: what the prompt shows.
fn shown<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (live, value) = state::with(|state| state.value(py, arguments.get_item(0)?.extract()?))?;
    Ok(live.calls.shown(&value).into_pyobject(py)?.into_any())
}

/// `mesh(object)`: kind of its cells, positions, node numbers of cells, boundaries as cells and sides, parts.
fn mesh<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (live, value) = state::with(|state| state.value(py, arguments.get_item(0)?.extract()?))?;
    let Some(mesh) = live.calls.mesh(&value) else {
        return Err(script_error(py, "the object is no mesh", "positions and cells are those of a `Mesh`", "use `body.mesh`"));
    };
    let entries = PyDict::new(py);
    entries.set_item("element", mesh.kind.name())?;
    entries.set_item("dimension", mesh.dimension())?;
    let points = numpy(py, "float64", mesh.points.as_flattened().iter().map(|x| x.to_ne_bytes()), Some(mesh.points.len()))?;
    entries.set_item("positions", points)?;
    let cells = numpy(py, "uint32", mesh.connectivity.iter().map(|node| node.to_ne_bytes()), Some(mesh.cell_count()))?;
    entries.set_item("connectivity", cells)?;
    let boundaries = PyDict::new(py);
    for boundary in &mesh.boundaries {
        let facets: Vec<Vec<u32>> = boundary.facets.iter().map(|facet| mesh.facet_nodes(*facet).collect()).collect();
        boundaries.set_item(&boundary.name, facets)?;
    }
    entries.set_item("boundaries", boundaries)?;
    let parts = PyDict::new(py);
    for (name, cells) in &mesh.parts {
        parts.set_item(name, PyList::new(py, cells)?)?;
    }
    entries.set_item("parts", parts)?;
    Ok(entries.into_any())
}

/// `positions(object)`: positions of the nodes of a mesh, a row of three for each.
fn positions<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (live, value) = state::with(|state| state.value(py, arguments.get_item(0)?.extract()?))?;
    let points = live.calls.mesh(&value);
    let points = points.as_ref().map_or(&[][..], |mesh| &mesh.points);
    numpy(py, "float64", points.as_flattened().iter().map(|x| x.to_ne_bytes()), Some(points.len()))
}

/// `enter(options)`: opens a session; its number and that of the one before.
fn enter<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let options = arguments.get_item(0)?;
    let numbers = state::with(|state| state.enter(py, options.cast::<PyDict>()?))?;
    Ok(numbers.into_pyobject(py)?.into_any())
}

/// `leave(number, before)`: ends a session; its report.
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

/// `command(program, arguments)`: the command line; its exit code.
fn command<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    let (program, words): (PathBuf, Vec<std::ffi::OsString>) = arguments.extract()?;
    let code = py.detach(|| conserva::cli::main_of(program, words));
    Ok(code.into_pyobject(py)?.into_any())
}

/// `shutdown()`: ends all computations before the interpreter does, and frees what this thread has.
fn shutdown<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = arguments.py();
    py.detach(|| state::interrupt_all(LONGEST_END));
    state::with(|state| state.clear());
    Ok(py.None().into_bound(py))
}
