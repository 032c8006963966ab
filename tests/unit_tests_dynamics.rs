//! Unit tests of models, steps and runs, compiled without optimization as `unit_tests.rs` tells.

use conserva::{bodies, contact, elements, integrators, linear, machine, materials, math, mesh};

#[path = "../src/dynamics/mod.rs"]
pub mod dynamics;
