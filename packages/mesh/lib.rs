//! Floor 3 of Conserva: meshes, their generators, checks and files.
//! `src/README.md` tells what is in it.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

#[doc(no_inline)]
pub use conserva_base::{elements, machine, math};

#[path = "../../src/mesh/mod.rs"]
pub mod mesh;
