//! Files that a resumed run relies on.
//!
//! A resumed run computes again from a checkpoint on; files that show earlier steps, such as the frames of the fields, are taken from the
//! disk. A checkpoint therefore lists these files with length and checksum. After a checkpoint, a run may go back
//! ([`FieldSeries::cut`](super::FieldSeries::cut)) and write other frames under the same names. The file that a checkpoint refers to is
//! then moved beside the checkpoints, under a name derived from its content, and restored from there by a resumed run.

use std::collections::{BTreeMap, VecDeque};
use std::fs;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use crate::machine::files;

/// Number of checkpoints that are kept, and whose files can be restored.
pub const KEPT: usize = 2;
/// Folder of a run's checkpoints, and of files kept for them.
pub const FOLDER: &str = "checkpoints";
/// Extension of files that were moved to the folder of the checkpoints.
pub const ASIDE: &str = "kept";
/// Number of bytes read at once.
const PIECE: usize = 1 << 16;

/// File that a resumed run relies on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CountedFile {
    /// Path relative to the folder of the run.
    pub name: String,
    /// Time of the frame, if the file is a frame of a series.
    pub time: Option<f64>,
    /// Length of the file `[bytes]`.
    pub length: u64,
    /// CRC-32 of the content.
    pub checksum: u32,
}

/// Condition of a file that a resumed run relies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileCondition {
    /// The file is in place.
    There,
    /// The run has moved the file beside the checkpoints.
    Aside,
    /// The file is missing.
    Gone,
    /// The file at the path has other content.
    Replaced,
}

impl CountedFile {
    fn is_same(&self, other: &CountedFile) -> bool {
        (self.length, self.checksum) == (other.length, other.checksum)
    }

    /// Path of the file when it has been moved beside the checkpoints of a run.
    fn aside(&self, run: &Path) -> PathBuf {
        run.join(FOLDER).join(format!("{:08x}-{}.{ASIDE}", self.checksum, self.length))
    }

    /// Path in the folder of a run; `None` if the name leads outside of the folder.
    fn place(&self, run: &Path) -> Option<PathBuf> {
        let is_inside = Path::new(&self.name).components().all(|part| matches!(part, Component::Normal(_)));
        is_inside.then(|| run.join(&self.name))
    }

    /// Returns the condition of the file in the folder of a run.
    pub fn standing(&self, run: &Path) -> FileCondition {
        let Some(place) = self.place(run) else { return FileCondition::Gone };
        if self.agrees(&place) {
            FileCondition::There
        } else if self.agrees(&self.aside(run)) {
            FileCondition::Aside
        } else if place.exists() {
            FileCondition::Replaced
        } else {
            FileCondition::Gone
        }
    }

    /// True if the file at `path` has the recorded length and checksum.
    fn agrees(&self, path: &Path) -> bool {
        let Ok(found) = fs::symlink_metadata(path) else { return false };
        found.is_file() && found.len() == self.length && checksum(path, self.length).is_ok_and(|(sum, _)| sum == self.checksum)
    }

    /// Restores the file from the folder of the checkpoints.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn restore(&self, run: &Path) -> io::Result<()> {
        let Some(place) = self.place(run) else { return Ok(()) };
        let part = place.with_extension("part");
        let _ = fs::remove_file(&part);
        place.parent().map_or(Ok(()), fs::create_dir_all)?;
        fs::copy(self.aside(run), &part)?;
        fs::rename(&part, &place)
    }
}

/// Returns the CRC-32 of the first `length` bytes of a regular file, and the number of bytes read.
///
/// # Errors
/// The operating system refused.
pub fn checksum(path: &Path, length: u64) -> io::Result<(u32, u64)> {
    let (mut file, mut sum, mut piece, mut found) = (files::open(path)?.0.take(length), crc32fast::Hasher::new(), vec![0; PIECE], 0);
    loop {
        match file.read(&mut piece)? {
            0 => return Ok((sum.finalize(), found)),
            count => {
                sum.update(&piece[..count]);
                found += count as u64;
            }
        }
    }
}

/// Path to which a file is moved.
#[derive(Debug)]
pub struct Aside(PathBuf);

impl Aside {
    /// Moves the file at `path` to this path.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn take(&self, path: &Path) -> io::Result<()> {
        match fs::rename(path, &self.0) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

/// Files that a run relies on when it is resumed.
#[derive(Debug)]
pub struct Counted {
    root: PathBuf,
    known: Mutex<Known>,
}

#[derive(Debug, Default)]
struct Known {
    /// Files in the folder of the run, by name.
    present: BTreeMap<String, CountedFile>,
    /// Files named by the kept checkpoints, the newest checkpoint last.
    promised: VecDeque<Vec<CountedFile>>,
}

impl Counted {
    /// Returns the files of a run in the folder `root`. `promised` are the lists of its checkpoints; the last list belongs to the
    /// checkpoint from which the run is resumed.
    pub fn new(root: &Path, promised: Vec<Vec<CountedFile>>) -> Self {
        let present = promised.last().into_iter().flatten().map(|file| (file.name.clone(), file.clone())).collect();
        Counted { root: root.into(), known: Mutex::new(Known { present, promised: promised.into() }) }
    }

    fn name(&self, path: &Path) -> Option<String> {
        path.strip_prefix(&self.root).ok().and_then(Path::to_str).map(String::from)
    }

    /// Records a file that was written.
    pub fn note(&self, path: &Path, time: Option<f64>, content: &[u8]) {
        let Some(name) = self.name(path) else { return };
        let file = CountedFile { name: name.clone(), time, length: content.len() as u64, checksum: crc32fast::hash(content) };
        self.known.lock().unwrap_or_else(PoisonError::into_inner).present.insert(name, file);
    }

    /// Removes a file from the present ones before it is replaced or deleted. Returns the path to which it must be moved if a checkpoint
    /// refers to it.
    pub fn forget(&self, path: &Path) -> Option<Aside> {
        let name = self.name(path)?;
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let file = known.present.remove(&name)?;
        let is_promised = known.promised.iter().flatten().any(|promised| promised.name == name && promised.is_same(&file));
        is_promised.then(|| Aside(file.aside(&self.root)))
    }

    /// Returns the record of a file.
    pub fn get(&self, path: &Path) -> Option<CountedFile> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.present.get(&self.name(path)?).cloned()
    }

    /// Returns all present files in the order of their names.
    pub fn all(&self) -> Vec<CountedFile> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).present.values().cloned().collect()
    }

    /// Records the files of a new checkpoint, and deletes files that no kept checkpoint refers to.
    pub fn promise(&self, files: Vec<CountedFile>) {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.promised.push_back(files);
        let mut old = Vec::new();
        while known.promised.len() > KEPT {
            old.extend(known.promised.pop_front().unwrap_or_default());
        }
        old.retain(|file| !known.promised.iter().flatten().any(|promised| promised.is_same(file)));
        for file in old {
            // A file that cannot be removed does no harm.
            let _ = fs::remove_file(file.aside(&self.root));
        }
    }
}
