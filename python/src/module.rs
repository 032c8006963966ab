//! Entry point of the extension module, which Python finds by its name.

use std::ffi::c_int;
use std::ptr;

use pyo3::ffi;
use pyo3::prelude::*;

use crate::functions;

/// Definition of the module; Python keeps its address.
struct Definition(std::cell::UnsafeCell<ffi::PyModuleDef>);

// SAFETY: only Python writes to the definition, while it holds its global lock.
unsafe impl Sync for Definition {}

static DEFINITION: Definition = Definition(std::cell::UnsafeCell::new(ffi::PyModuleDef {
    m_base: ffi::PyModuleDef_HEAD_INIT,
    m_name: c"conserva._core".as_ptr(),
    m_doc: c"The script engine of Conserva; the package `conserva` is its face.".as_ptr(),
    m_size: -1,
    m_methods: ptr::null_mut(),
    m_slots: ptr::null_mut(),
    m_traverse: None,
    m_clear: None,
    m_free: None,
}));

/// Makes the module.
#[unsafe(no_mangle)]
pub extern "C" fn PyInit__core() -> *mut ffi::PyObject {
    // SAFETY: Python calls this function with its lock held.
    let py = unsafe { Python::assume_attached() };
    let made = || -> PyResult<Bound<'_, PyModule>> {
        // SAFETY: the definition is complete and lives as long as the process; a null pointer comes with an error that is set.
        let module = unsafe { Bound::from_owned_ptr_or_err(py, ffi::PyModule_Create(DEFINITION.0.get()))? };
        let module = module.cast_into::<PyModule>()?;
        functions::add(&module)?;
        Ok(module)
    };
    match made() {
        Ok(module) => module.into_ptr(),
        Err(error) => {
            error.restore(py);
            ptr::null_mut()
        }
    }
}

/// Version of the module layout for which this file is written.
const _: c_int = ffi::PYTHON_API_VERSION;
