//! The process: its executable, the stack of the threads that run scripts, and its exit codes.

use std::path::PathBuf;
use std::sync::OnceLock;

use crate::script::Class;
pub use crate::script::STACK;

/// Program that replaces this process's executable, if set.
static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// Sets the program that studies start for their points; by default this process's executable.
pub fn set_program(program: PathBuf) {
    // Only the first call has an effect: a process has one program.
    let _ = PROGRAM.set(program);
}

/// Returns the program that studies start for their points.
///
/// # Errors
/// The operating system does not name this process's executable.
pub fn program() -> std::io::Result<PathBuf> {
    PROGRAM.get().cloned().map_or_else(std::env::current_exe, Ok)
}

/// Exit code of a run without an error whose results should not be trusted.
pub const DOUBTFUL: u8 = 4;

/// Returns the exit code of an error.
pub fn exit_code(class: Class) -> u8 {
    match class {
        Class::Check => 1,
        Class::Script => 2,
        Class::Numerics | Class::Output | Class::Internal => 3,
        Class::Interrupted => 130,
        Class::ResultUsed => 0,
    }
}
