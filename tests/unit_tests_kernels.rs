//! Unit tests of materials and meshes, compiled without optimization as `unit_tests.rs` tells: they take less to run than to optimize.

use conserva::{elements, machine, math};

#[path = "../src/materials/mod.rs"]
pub mod materials;

#[path = "../src/mesh/mod.rs"]
pub mod mesh;
