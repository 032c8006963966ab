//! Floor 0: what the machine has and asks for: memory, regular files, an ear for the user while something long is computed.

pub mod files;
pub mod memory;
mod watched;

pub use watched::{consulted, watched};
