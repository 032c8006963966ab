//! Files that cannot be read back, as messages of the command line.

use super::console::{complain, ink};
use super::process::exit_code;
use crate::output::ReadError;
use crate::script::{Class, Diagnostic};

/// Shows what is wrong with a file; the exit code.
pub fn refuse(error: &ReadError) -> u8 {
    let message = Diagnostic::error(Class::Script, error.to_string()).code(error.code());
    let message = error.cause.iter().fold(message, Diagnostic::cause);
    complain(&message.hint(&error.hint).render(ink()));
    exit_code(Class::Script)
}
