//! Unit tests of output, script language, studies and commands.
//!
//! They stand in the files that they test, and reach what is private there. Here these files are compiled once more, without optimization,
//! which takes a fifth of the time that a unit test of their packages takes.

// Of the files, tests reach a part.
#![allow(dead_code)]

use conserva::{bodies, contact, dynamics, elements, integrators, linear, machine, materials, math, mesh};

#[path = "../src/output/mod.rs"]
pub mod output;

#[path = "../src/script/mod.rs"]
pub mod script;

#[path = "../src/studies/mod.rs"]
pub mod studies;

#[path = "../src/cli/mod.rs"]
pub mod cli;
