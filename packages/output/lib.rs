//! Floor 6 of Conserva: results as files.
//! `src/README.md` tells what is in it.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

#[doc(no_inline)]
pub use conserva_base::{elements, integrators, linear, machine, math};
#[doc(no_inline)]
pub use conserva_bodies::bodies;
#[doc(no_inline)]
pub use conserva_contact::contact;
#[doc(no_inline)]
pub use conserva_dynamics::dynamics;
#[doc(no_inline)]
pub use conserva_materials::materials;
#[doc(no_inline)]
pub use conserva_mesh::mesh;

#[path = "../../src/output/mod.rs"]
pub mod output;
