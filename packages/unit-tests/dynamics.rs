//! Unit tests of models, steps and runs.

use conserva::{bodies, contact, elements, integrators, linear, machine, materials, math, mesh};

#[path = "../../src/dynamics/mod.rs"]
pub mod dynamics;
