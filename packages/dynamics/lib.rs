//! Floor 5 of Conserva: models, steps and runs.
//! `src/README.md` tells what is in it.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

#[doc(no_inline)]
pub use conserva_bodies::{bodies, elements, integrators, linear, machine, materials, math, mesh};
#[doc(no_inline)]
pub use conserva_contact::contact;

#[path = "../../src/dynamics/mod.rs"]
pub mod dynamics;
