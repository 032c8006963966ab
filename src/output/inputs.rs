//! Input files of a run, which no result of the run may replace.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Canonical paths of the files that a run reads, its script among them. Clones share their data, so that files read later are also
/// protected.
#[derive(Clone, Debug, Default)]
pub struct Inputs(Arc<Mutex<BTreeSet<PathBuf>>>);

impl Inputs {
    /// Adds a file if it exists.
    pub fn add(&self, path: &Path) {
        if let Ok(path) = path.canonicalize() {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(path);
        }
    }

    /// True if the run reads the file at `path`, which is canonical.
    pub fn contains(&self, path: &Path) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).contains(path)
    }
}
