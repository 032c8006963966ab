//! A callable of Python as a function pointer of the script engine.

#![allow(deprecated)] // rhai marks native function pointers as deprecated because their interface may change

use std::sync::atomic::{AtomicU64, Ordering};

use conserva::script::Calls;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rhai::{Dynamic, EvalAltResult, FnPtr, Position};

use crate::convert::{to_engine, to_python};
use crate::raise::{is_of, script_error};
use crate::state;

/// Number of the next callable, part of its name: the engine may take functions of one name for one function.
static NEXT: AtomicU64 = AtomicU64::new(1);

/// The function pointer of a callable.
///
/// # Errors
/// The engine refuses its name.
pub fn function_of(callable: Bound<'_, PyAny>) -> PyResult<Dynamic> {
    let py = callable.py();
    let callable = callable.unbind();
    let name = format!("python_{}", NEXT.fetch_add(1, Ordering::Relaxed));
    let function = FnPtr::from_dyn_fn(name, Box::new(move |_, values| Python::attach(|py| call(py, callable.bind(py), values))));
    let refused = |error: Box<EvalAltResult>| script_error(py, "the callable cannot be passed", &error.to_string(), "use another function");
    function.map(Dynamic::from).map_err(refused)
}

fn call(py: Python, callable: &Bound<'_, PyAny>, values: &mut [&mut Dynamic]) -> Result<Dynamic, Box<EvalAltResult>> {
    let result = || -> PyResult<Dynamic> {
        let live = state::with(|state| state.current_call(py))?;
        let values = values.iter().map(|value| to_python(py, &live, value.flatten_clone())).collect::<PyResult<Vec<_>>>()?;
        to_engine(&callable.call1(PyTuple::new(py, values)?)?)
    };
    result().map_err(|error| {
        let title =
            format!("the callable raised {}", error.value(py).repr().map_or_else(|_| "an exception".into(), |text| text.to_string()));
        // The computation of a nested call was ended by Conserva.
        if is_of(py, &error, "Interrupted") {
            return Calls::interrupted();
        }
        let is_interrupt = error.is_instance_of::<PyKeyboardInterrupt>(py);
        state::with(|state| {
            if is_interrupt {
                state.interrupt();
            }
            state.raised.replace(Some(error));
        });
        if is_interrupt { Calls::interrupted() } else { Box::new(EvalAltResult::ErrorRuntime(title.into(), Position::NONE)) }
    })
}
