//! Floors 0 to 2 of Conserva: numbers, reference cells, the linear solver, time integrators.
//!
//! The modules stand in floor order: each names only modules above it in this list (`src/README.md` tells why).

#![deny(missing_docs)]
#![forbid(unsafe_code)]

#[path = "../../src/machine/mod.rs"]
pub mod machine;
#[path = "../../src/math/mod.rs"]
pub mod math;

#[path = "../../src/elements/mod.rs"]
pub mod elements;
#[path = "../../src/linear/mod.rs"]
pub mod linear;

#[path = "../../src/integrators/mod.rs"]
pub mod integrators;
