//! Conserva: a scripting engine for contact dynamics that conserves energy and both momenta.
//!
//! The modules stand in floor order: each names only modules above it in this list (`src/README.md` tells why).
//! The method is that of C. Hesch and P. Betsch, "Energy-momentum schemes for large deformation contact problems", PAMM 2007.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

pub mod math;

pub mod elements;
pub mod linear;
pub mod materials;

pub mod mesh;

pub mod integrators;

pub mod bodies;
pub mod contact;

pub mod dynamics;

pub mod output;

pub mod script;

pub mod cli;
