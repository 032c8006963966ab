//! Environment of the program: signals, streams that cannot be written, files of all kinds, names, memory.

#[path = "../common/program.rs"]
mod program;

mod files;
mod memory;
mod output;
mod signals;
