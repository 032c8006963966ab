//! Conserva as a module of Python: sessions of the script engine, one or more for each thread, behind functions of plain arguments.
//!
//! The package `conserva` beside this crate makes classes, functions and documentation of them, from the registry of the language. PyO3 is
//! used without its macros: they would turn on features of `syn` that the program does not have, so that every crate that is derived with
//! `syn`, and with it the whole program, would be compiled a second time.

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
