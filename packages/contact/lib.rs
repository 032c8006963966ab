//! Floor 4 of Conserva: contact between surfaces.
//!
//! The modules stand in floor order: each names only modules above it in this list (`src/README.md` tells why).

#![deny(missing_docs)]
#![forbid(unsafe_code)]

#[doc(no_inline)]
pub use conserva_base::{elements, integrators, linear, machine, materials, math, mesh};

#[path = "../../src/contact/mod.rs"]
pub mod contact;
