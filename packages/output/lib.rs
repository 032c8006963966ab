//! Floor 6 of Conserva: results as files.
//! `src/README.md` tells what is in it.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

#[doc(no_inline)]
pub use conserva_dynamics::{bodies, contact, dynamics, elements, integrators, linear, machine, materials, math, mesh};

#[path = "../../src/output/mod.rs"]
pub mod output;
