//! Laws of materials, of floor 3 of Conserva.
//! `src/README.md` tells what is in it.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

#[doc(no_inline)]
pub use conserva_base::math;

#[path = "../../src/materials/mod.rs"]
pub mod materials;
