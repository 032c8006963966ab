//! What a process of this program has: the stack of the threads that run scripts, and its exit codes.

use crate::script::Class;
pub use crate::script::STACK;

/// The exit code of a run without an error that should not be trusted.
pub const DOUBTFUL: u8 = 4;

/// The exit code of an error.
pub fn exit_code(class: Class) -> u8 {
    match class {
        Class::Check => 1,
        Class::Script => 2,
        Class::Numerics | Class::Output | Class::Internal => 3,
        Class::Interrupted => 130,
        Class::ResultUsed => 0,
    }
}
