//! Messages on files that cannot be read back.

use super::console::{complain, ink};
use super::process::exit_code;
use crate::output::ReadError;
use crate::script::{Class, Diagnostic};

/// Reports the error of a file; returns the exit code.
pub fn refuse(error: &ReadError) -> u8 {
    let message = Diagnostic::error(Class::Script, error.to_string()).code(error.code());
    let message = error.cause.iter().fold(message, Diagnostic::cause);
    complain(&message.hint(&error.hint).render(ink()));
    exit_code(Class::Script)
}
