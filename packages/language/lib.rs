//! Floors 7 to 9 of Conserva: script language, studies, commands.
//! `src/README.md` tells what is in them.

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
#[doc(no_inline)]
pub use conserva_output::output;

#[path = "../../src/script/mod.rs"]
pub mod script;

#[path = "../../src/studies/mod.rs"]
pub mod studies;

#[cfg(feature = "command-line")]
#[path = "../../src/cli/mod.rs"]
pub mod cli;
