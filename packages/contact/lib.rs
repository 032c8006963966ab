//! Floor 4 of Conserva: contact between surfaces.
//! `src/README.md` tells what is in it.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

#[doc(no_inline)]
pub use conserva_base::{elements, integrators, linear, machine, math};
#[doc(no_inline)]
pub use conserva_mesh::mesh;

#[path = "../../src/contact/mod.rs"]
pub mod contact;
