//! Floor 4 of Conserva: the element loop over the cells of a body.
//! `src/README.md` tells what is in it.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

#[doc(no_inline)]
pub use conserva_base::{elements, integrators, linear, machine, math};
#[doc(no_inline)]
pub use conserva_materials::materials;
#[doc(no_inline)]
pub use conserva_mesh::mesh;

#[path = "../../src/bodies/mod.rs"]
pub mod bodies;
