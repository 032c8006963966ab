//! Files that are read: no result of a run takes the place of what it reads.

use std::collections::BTreeSet;
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
