//! Unit tests of output, script language, studies and commands.

// Tests reach only a part of the files in which they stand.
#![allow(dead_code)]

use conserva::{bodies, contact, dynamics, elements, integrators, linear, machine, materials, math, mesh};

#[path = "../../src/output/mod.rs"]
pub mod output;

#[path = "../../src/script/mod.rs"]
pub mod script;

#[path = "../../src/studies/mod.rs"]
pub mod studies;

#[path = "../../src/cli/mod.rs"]
pub mod cli;
