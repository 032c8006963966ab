//! Limits of a script, which the engine enforces and messages name.

/// Largest depth of nested calls.
pub const MAX_CALL_LEVELS: usize = 64;
/// Characters of a string.
pub const MAX_STRING: usize = 16_000_000;
/// Entries of an array.
pub const MAX_ARRAY: usize = 10_000_000;
/// Entries of a map.
pub const MAX_MAP: usize = 1_000_000;

/// Default of the largest number of operations of a script: about a minute of pure script.
pub const MAX_OPERATIONS: u64 = 500_000_000;
/// Stack of a thread that runs scripts: deep recursion must end with a message, not with a crash.
pub const STACK: usize = 256 << 20;
