//! What is wrong with a file that is read back: where, and how to mend it.

use std::io;
use std::path::{Path, PathBuf};

use super::super::files::reason;
use crate::machine::files;

/// A file that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{}\" {what}", path.display())]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong, behind its name: `cannot be read`, `is damaged in line 3`.
    pub what: String,
    /// The reason in words, where there is more to say.
    pub cause: Option<String>,
    /// How to mend it.
    pub hint: String,
}

impl ReadError {
    /// Its stable code, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        "C0921"
    }

    /// A file with a defect.
    pub fn new(path: &Path, what: impl Into<String>, hint: impl Into<String>) -> Self {
        ReadError { path: path.into(), what: what.into(), cause: None, hint: hint.into() }
    }

    /// A file whose bytes do not agree with themselves.
    pub fn damaged(path: &Path, what: impl AsRef<str>) -> Self {
        ReadError::new(path, format!("is damaged: {}", what.as_ref()), "run the script again, or take the file from a copy")
    }

    /// What the operating system refuses.
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
