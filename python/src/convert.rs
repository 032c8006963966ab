//! Values between Python and the script engine.

use std::rc::Rc;

use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBool, PyBytes, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple, PyType};
use rhai::{Array, Dynamic, Map};

use crate::arrays::array;
use crate::callable::function_of;
use crate::raise::script_error;
use crate::state::{self, Live};

/// Largest depth of nested lists and dictionaries.
const DEEPEST: usize = 64;

/// Class of all objects, and classes of the types of the language by name.
static OBJECT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static CLASSES: PyOnceLock<Py<PyDict>> = PyOnceLock::new();

/// Sets the classes of values of the language; a second call has no effect.
///
/// # Errors
/// They are set already.
pub fn set_classes(object: Bound<'_, PyType>, classes: Bound<'_, PyDict>) {
    let py = object.py();
    // A second import of the package keeps the classes of the first.
    let _ = OBJECT.set(py, object.unbind());
    let _ = CLASSES.set(py, classes.unbind());
}

/// Number of an object of the language; `None` for any other value.
pub fn number_of(value: &Bound<'_, PyAny>) -> PyResult<Option<u64>> {
    let py = value.py();
    let Some(object) = OBJECT.get(py) else { return Ok(None) };
    if !value.is_instance(object.bind(py))? {
        return Ok(None);
    }
    value.getattr(pyo3::intern!(py, "_number"))?.extract().map(Some)
}

/// Converts a value of Python for the engine.
///
/// # Errors
/// The language has no such value.
pub fn to_engine(value: &Bound<'_, PyAny>) -> PyResult<Dynamic> {
    at_depth(value, 0)
}

fn at_depth(value: &Bound<'_, PyAny>, depth: usize) -> PyResult<Dynamic> {
    let py = value.py();
    if depth > DEEPEST {
        let cause = format!("lists and dictionaries may be nested {DEEPEST} levels deep");
        return Err(script_error(py, "the value is nested too deeply", &cause, "pass flat lists; a list must not contain itself"));
    }
    if value.is_none() {
        return Ok(Dynamic::UNIT);
    }
    if let Ok(number) = value.cast_exact::<PyFloat>() {
        return Ok(number.value().into());
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(flag.is_true().into());
    }
    if value.is_instance_of::<PyInt>() {
        return match value.extract::<i64>() {
            Ok(whole) => Ok(whole.into()),
            Err(error) if error.is_instance_of::<PyOverflowError>(py) => {
                let cause = "whole numbers have 64 bits";
                Err(script_error(py, "the whole number is too large", cause, "write it as a number with a decimal point"))
            }
            Err(error) => Err(error),
        };
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(value.extract::<f64>()?.into());
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(text.to_cow()?.as_ref().into());
    }
    if let Some(number) = number_of(value)? {
        return state::with(|state| state.value(py, number)).map(|(_, value)| value);
    }
    if let Ok(list) = value.cast::<PyList>() {
        return list.iter().map(|entry| at_depth(&entry, depth + 1)).collect::<PyResult<Array>>().map(Dynamic::from_array);
    }
    if let Ok(tuple) = value.cast::<PyTuple>() {
        return tuple.iter().map(|entry| at_depth(&entry, depth + 1)).collect::<PyResult<Array>>().map(Dynamic::from_array);
    }
    if let Ok(entries) = value.cast::<PyDict>() {
        return map_of(entries, depth);
    }
    if value.hasattr(pyo3::intern!(py, "tolist"))? {
        return at_depth(&value.call_method0(pyo3::intern!(py, "tolist"))?, depth + 1);
    }
    if value.hasattr(pyo3::intern!(py, "__fspath__"))? {
        return at_depth(&value.call_method0(pyo3::intern!(py, "__fspath__"))?, depth + 1);
    }
    if value.is_callable() && !value.is_instance_of::<PyType>() {
        return function_of(value.clone());
    }
    if value.hasattr("__len__")? && value.hasattr("__getitem__")? && !value.hasattr("keys")? && !value.is_instance_of::<PyBytes>() {
        return at_depth(PyList::new(py, value.try_iter()?.collect::<PyResult<Vec<_>>>()?)?.as_any(), depth + 1);
    }
    let kind = value.get_type().name()?.to_string();
    let cause = "values are numbers, truth values, texts, lists and arrays, dictionaries, callables, and objects of Conserva";
    let hint = if kind == "generator" || kind == "set" { "pass a list: `list(…)`" } else { "convert it to one of these first" };
    Err(script_error(py, &format!("a value of the type `{kind}` cannot be passed to Conserva"), cause, hint))
}

fn map_of(entries: &Bound<'_, PyDict>, depth: usize) -> PyResult<Dynamic> {
    let mut map = Map::new();
    for (key, value) in entries {
        let Ok(key) = key.cast::<PyString>() else {
            let title = format!("the key {} of a dictionary is not a text", key.repr()?);
            return Err(script_error(entries.py(), &title, "keys of options are texts", "write the key in quotes"));
        };
        map.insert(key.to_cow()?.as_ref().into(), at_depth(&value, depth + 1)?);
    }
    Ok(Dynamic::from_map(map))
}

/// Converts a value of the engine for Python.
///
/// # Errors
/// Python has no memory left, or NumPy cannot be imported.
pub fn to_python<'py>(py: Python<'py>, live: &Rc<Live>, value: Dynamic) -> PyResult<Bound<'py, PyAny>> {
    if value.is_unit() {
        return Ok(py.None().into_bound(py));
    }
    if let Ok(number) = value.as_float() {
        return Ok(PyFloat::new(py, number).into_any());
    }
    if let Ok(whole) = value.as_int() {
        return Ok(whole.into_pyobject(py)?.into_any());
    }
    if let Ok(flag) = value.as_bool() {
        return Ok(PyBool::new(py, flag).to_owned().into_any());
    }
    if value.is_string() || value.is_char() {
        return Ok(PyString::new(py, &value.to_string()).into_any());
    }
    if let Some(array) = value.read_lock::<Array>() {
        if let Some(numbers) = Numbers::of(&array) {
            return numbers.array(py);
        }
        let entries = array.iter().map(|entry| to_python(py, live, entry.clone())).collect::<PyResult<Vec<_>>>()?;
        return Ok(PyList::new(py, entries)?.into_any());
    }
    if let Some(map) = value.read_lock::<Map>() {
        let entries = PyDict::new(py);
        for (key, value) in map.iter() {
            entries.set_item(key.as_str(), to_python(py, live, value.clone())?)?;
        }
        // Maps of results have a class of their own, constructed from a dictionary.
        return match class_of(py, "Map")? {
            Some(class) => class.call1((entries,)),
            None => Ok(entries.into_any()),
        };
    }
    let name = live.calls.type_name(&value).unwrap_or("Closure");
    let class = class_of(py, name)?;
    let class = class
        .ok_or_else(|| script_error(py, &format!("the type `{name}` has no class"), "the package is incomplete", "install it anew"))?;
    let number = state::with(|state| state.keep(live, value));
    class.call1((number,)).inspect_err(|_| state::with(|state| state.release(number)))
}

/// The class of a type of the language.
fn class_of<'py>(py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    CLASSES.get(py).map_or(Ok(None), |classes| classes.bind(py).get_item(name))
}

/// An array of numbers, of one or two dimensions.
struct Numbers {
    values: Values,
    rows: Option<usize>,
}

enum Values {
    Whole(Vec<i64>),
    Real(Vec<f64>),
}

impl Numbers {
    fn of(array: &Array) -> Option<Self> {
        let width = array.first()?.read_lock::<Array>().map(|row| row.len());
        let mut reals = Vec::new();
        let mut wholes = Vec::new();
        let mut add = |entry: &Dynamic| {
            if let Ok(whole) = entry.as_int() {
                wholes.push(whole);
                reals.push(whole as f64);
                true
            } else {
                entry.as_float().map(|real| reals.push(real)).is_ok()
            }
        };
        let is_all = match width {
            None => array.iter().all(&mut add),
            Some(width) => {
                array.iter().all(|row| row.read_lock::<Array>().is_some_and(|row| row.len() == width && row.iter().all(&mut add)))
            }
        };
        let values = if wholes.len() == reals.len() { Values::Whole(wholes) } else { Values::Real(reals) };
        is_all.then_some(Numbers { values, rows: width.map(|_| array.len()) })
    }

    fn array(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        match self.values {
            Values::Whole(values) => array(py, values, self.rows),
            Values::Real(values) => array(py, values, self.rows),
        }
    }
}
