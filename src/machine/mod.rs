//! Floor 0 of `ARCHITECTURE.md`: services of the machine: memory, regular files, interrupts by the user during long computations.

pub mod files;
pub mod memory;
mod watched;

pub use watched::{consulted, watched};
