//! NumPy arrays over memory of Conserva, without a copy.
//!
//! NumPy takes the address of the numbers from an object with the attribute `__array_interface__` and keeps this object, which holds the
//! owner of the memory in a capsule. The memory therefore lives as long as the last view of the array, on any thread. Rust does not access
//! the memory through the address: a writable array is owned by the capsule alone, other arrays are read-only.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyCapsule, PyDict};

static ASARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static NAMESPACE: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

/// Number type with a NumPy equivalent.
pub trait Element: Send + Sync + 'static {
    /// Kind and size in NumPy's array interface.
    const CODE: &'static str;
}

impl Element for f64 {
    const CODE: &'static str = "f8";
}

impl Element for i64 {
    const CODE: &'static str = "i8";
}

impl Element for u32 {
    const CODE: &'static str = "u4";
}

/// Writable array that owns the numbers, two-dimensional with `rows` rows if given.
///
/// # Errors
/// NumPy cannot be imported.
pub fn array<T: Element>(py: Python<'_>, mut values: Vec<T>, rows: Option<usize>) -> PyResult<Bound<'_, PyAny>> {
    let (address, count) = (values.as_mut_ptr().expose_provenance(), values.len());
    over::<T>(py, PyCapsule::new_with_value(py, values, c"conserva.numbers")?, (address, count), rows, false)
}

/// Read-only array over numbers of an immutable shared value, with a number of rows.
///
/// # Errors
/// NumPy cannot be imported.
pub fn shared<'py, S: Send + Sync + 'static, T: Element>(
    py: Python<'py>,
    owner: &Arc<S>,
    choose: impl FnOnce(&S) -> &[T],
    rows: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let values = choose(owner);
    let place = (values.as_ptr().expose_provenance(), values.len());
    over::<T>(py, PyCapsule::new_with_value(py, owner.clone(), c"conserva.shared")?, place, Some(rows), true)
}

fn over<'py, T: Element>(
    py: Python<'py>,
    owner: Bound<'py, PyCapsule>,
    (address, count): (usize, usize),
    rows: Option<usize>,
    is_read_only: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let order = if cfg!(target_endian = "little") { "<" } else { ">" };
    let interface = PyDict::new(py);
    interface.set_item("version", 3)?;
    interface.set_item("typestr", format!("{order}{}", T::CODE))?;
    match rows {
        Some(rows) => interface.set_item("shape", (rows, count.checked_div(rows).unwrap_or(0)))?,
        None => interface.set_item("shape", (count,))?,
    }
    interface.set_item("data", (address, is_read_only))?;
    let attributes = PyDict::new(py);
    attributes.set_item("__array_interface__", interface)?;
    attributes.set_item("owner", owner)?;
    let namespace = NAMESPACE.get_or_try_init(py, || py.import("types")?.getattr("SimpleNamespace").map(Bound::unbind))?;
    let asarray = ASARRAY.get_or_try_init(py, || py.import("numpy")?.getattr("asarray").map(Bound::unbind))?;
    asarray.bind(py).call1((namespace.bind(py).call((), Some(&attributes))?,))
}
