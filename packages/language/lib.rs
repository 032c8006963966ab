//! Floors 7 to 9 of Conserva: script language, studies, commands.
//! `src/README.md` tells what is in them.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

#[doc(no_inline)]
pub use conserva_output::{bodies, contact, dynamics, elements, integrators, linear, machine, materials, math, mesh, output};

#[path = "../../src/script/mod.rs"]
pub mod script;

#[path = "../../src/studies/mod.rs"]
pub mod studies;

#[cfg(feature = "command-line")]
#[path = "../../src/cli/mod.rs"]
pub mod cli;
