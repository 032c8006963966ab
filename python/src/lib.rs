//! Conserva as a Python module: sessions of the script engine, one or more per thread, behind functions with plain arguments.
//!
//! The package `conserva` beside this crate makes classes, functions and documentation from the registry of the language. PyO3 is used
//! without its macros: they would enable features of `syn` that the program does not need, so that all crates with derives, and with them
//! the whole program, would be compiled a second time.

#![deny(missing_docs)]
#![deny(unsafe_code)]

mod arrays;
mod callable;
mod convert;
mod functions;
mod meshes;
#[allow(unsafe_code)] // the entry point that Python looks up by its name
mod module;
mod observer;
mod raise;
mod script;
mod state;
