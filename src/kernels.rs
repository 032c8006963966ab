//! The kernels of Conserva: finite elements, contact and time integration that conserve energy and both momenta, without the language and
//! without files of a run. Use them by the names of the package `conserva`, which has them all.
//!
//! The modules stand in floor order: each names only modules above it in this list (`src/README.md` tells why).

#![deny(missing_docs)]
#![forbid(unsafe_code)]

pub mod machine;
pub mod math;

pub mod elements;
pub mod linear;
pub mod materials;

pub mod mesh;

pub mod integrators;

pub mod bodies;
pub mod contact;

pub mod dynamics;
