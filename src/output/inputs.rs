//! Files that are read: never anything but files, and no result of a run takes the place of what it reads.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Canonical paths of the files that a run reads, its script among them. Clones share them, so that what is read later counts for files
/// that are written later.
#[derive(Clone, Debug, Default)]
pub struct Inputs(Arc<Mutex<BTreeSet<PathBuf>>>);

impl Inputs {
    /// Adds a file, if it is there.
    pub fn add(&self, path: &Path) {
        if let Ok(path) = path.canonicalize() {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(path);
        }
    }

    /// Whether the run reads this file, whose path is canonical.
    pub fn contains(&self, path: &Path) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).contains(path)
    }
}

/// The content of a regular file. Anything else, such as a pipe, is refused without waiting for it.
///
/// # Errors
/// The operating system refused, or it is no file.
pub fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    refuse_others(path).and_then(|()| std::fs::read(path))
}

/// Refuses what is no regular file, such as a pipe, for which a program would wait.
///
/// # Errors
/// The operating system refused, or it is no file.
pub fn refuse_others(path: &Path) -> io::Result<()> {
    if std::fs::metadata(path)?.is_file() { Ok(()) } else { Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file")) }
}
