//! Unit tests of materials and meshes.

use conserva::{elements, machine, math};

#[path = "../../src/materials/mod.rs"]
pub mod materials;

#[path = "../../src/mesh/mod.rs"]
pub mod mesh;
