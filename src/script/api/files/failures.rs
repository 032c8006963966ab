//! Files that cannot be written.

use crate::output::OutputError;
use crate::script::language::failure::{Class, Failure};

/// Failure of a file that could not be written.
pub fn output_failure(error: &OutputError) -> Failure {
    Failure::new(output_class(error), error.to_string()).code(error.code()).hint(error.hint())
}

/// Class of a failed write: an invalid name is an error of the script, a full disk is not.
pub fn output_class(error: &OutputError) -> Class {
    if matches!(error, OutputError::Write { .. } | OutputError::Gone { .. }) { Class::Output } else { Class::Script }
}
