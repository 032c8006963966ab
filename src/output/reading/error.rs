//! Errors of reading files: place and hint.

use std::io;
use std::path::{Path, PathBuf};

use super::super::files::reason;
use crate::machine::files;

/// A file that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{}\" {what}", path.display())]
pub struct ReadError {
    /// Path of the file that cannot be read.
    pub path: PathBuf,
    /// Description of the fault, appended to the file name: `cannot be read`, `is damaged in line 3`.
    pub what: String,
    /// Further reason in words.
    pub cause: Option<String>,
    /// Hint how to mend the fault.
    pub hint: String,
}

impl ReadError {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        "C0921"
    }

    /// A file with a defect.
    pub fn new(path: &Path, what: impl Into<String>, hint: impl Into<String>) -> Self {
        ReadError { path: path.into(), what: what.into(), cause: None, hint: hint.into() }
    }

    /// Returns the error of a file whose bytes are inconsistent.
    pub fn damaged(path: &Path, what: impl AsRef<str>) -> Self {
        ReadError::new(path, format!("is damaged: {}", what.as_ref()), "run the script again, or take the file from a copy")
    }

    /// Returns the error for a refusal by the operating system.
    pub fn io(path: &Path, error: &io::Error) -> Self {
        let missing = error.kind() == io::ErrorKind::NotFound;
        let what = if missing { "does not exist" } else { "cannot be read" };
        let hint = if missing { "check the path" } else { "see that it is a file that you may read" };
        ReadError { cause: (!missing).then(|| reason(error)), ..ReadError::new(path, what, hint) }
    }
}

/// The bytes of a file.
///
/// # Errors
/// The operating system refused.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>, ReadError> {
    files::read(path).map_err(|error| ReadError::io(path, &error))
}
