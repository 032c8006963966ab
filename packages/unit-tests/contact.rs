//! Unit tests of contact.

use conserva::{elements, integrators, math, mesh};

#[path = "../../src/contact/mod.rs"]
pub mod contact;
