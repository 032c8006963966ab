//! Files that a run which is resumed counts on.
//!
//! A run is resumed by computing again from a checkpoint on, and what shows the steps before it, such as the frames of the fields, is taken
//! as it stands on the disk. So a checkpoint names these files with length and checksum. A run goes on after a checkpoint and may go back
//! ([`FieldSeries::cut`](super::FieldSeries::cut)) and write other frames under the same names: then the file that a checkpoint counts on
//! is moved beside the checkpoints, under a name that its content gives, and a run that is resumed takes it from there.

use std::collections::{BTreeMap, VecDeque};
use std::fs;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use crate::machine::files;

/// Checkpoints that are kept, and whose files can be had back.
pub const KEPT: usize = 2;
/// Folder of the checkpoints of a run, and of files that were moved away for them.
pub const FOLDER: &str = "checkpoints";
/// Ending of the files that were moved away.
pub const ASIDE: &str = "kept";
/// Bytes that are read at once.
const PIECE: usize = 1 << 16;

/// A file that a run which is resumed counts on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CountedFile {
    /// Its path relative to the folder of the run.
    pub name: String,
    /// The time that it shows, if it is a frame of a series.
    pub time: Option<f64>,
    /// Its length.
    pub length: u64,
    /// CRC-32 of its content.
    pub checksum: u32,
}

/// What became of a file that a run counts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// It is there.
    There,
    /// It was moved away by the run itself.
    Aside,
    /// It is not there.
    Gone,
    /// It has another content.
    Replaced,
}

impl CountedFile {
    fn is_same(&self, other: &CountedFile) -> bool {
        (self.length, self.checksum) == (other.length, other.checksum)
    }

    /// Its place beside the checkpoints of a run.
    fn aside(&self, run: &Path) -> PathBuf {
        run.join(FOLDER).join(format!("{:08x}-{}.{ASIDE}", self.checksum, self.length))
    }

    /// Its place in the folder of a run, unless the name leads out of it.
    fn place(&self, run: &Path) -> Option<PathBuf> {
        let is_inside = Path::new(&self.name).components().all(|part| matches!(part, Component::Normal(_)));
        is_inside.then(|| run.join(&self.name))
    }

    /// How it stands with the file in the folder of a run.
    pub fn standing(&self, run: &Path) -> Standing {
        let Some(place) = self.place(run) else { return Standing::Gone };
        if self.agrees(&place) {
            Standing::There
        } else if self.agrees(&self.aside(run)) {
            Standing::Aside
        } else if place.exists() {
            Standing::Replaced
        } else {
            Standing::Gone
        }
    }

    /// Whether a file has its content.
    fn agrees(&self, path: &Path) -> bool {
        let Ok(found) = fs::symlink_metadata(path) else { return false };
        found.is_file() && found.len() == self.length && checksum(path, self.length).is_ok_and(|(sum, _)| sum == self.checksum)
    }

    /// Puts the file back that was moved away.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn bring_back(&self, run: &Path) -> io::Result<()> {
        let Some(place) = self.place(run) else { return Ok(()) };
        let part = place.with_extension("part");
        let _ = fs::remove_file(&part);
        place.parent().map_or(Ok(()), fs::create_dir_all)?;
        fs::copy(self.aside(run), &part)?;
        fs::rename(&part, &place)
    }
}

/// CRC-32 of the first bytes of a regular file, and how many there are.
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

/// The place to which a file is moved.
#[derive(Debug)]
pub struct Aside(PathBuf);

impl Aside {
    /// Moves the file there.
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

/// The files that a run counts on.
#[derive(Debug)]
pub struct Counted {
    root: PathBuf,
    known: Mutex<Known>,
}

#[derive(Debug, Default)]
struct Known {
    /// As they are now.
    present: BTreeMap<String, CountedFile>,
    /// As the checkpoints name them that are kept, the newest last.
    promised: VecDeque<Vec<CountedFile>>,
}

impl Counted {
    /// Those of a run in a folder, as the checkpoints of an earlier program name them; the last one is that from which the run goes on.
    pub fn new(root: &Path, promised: Vec<Vec<CountedFile>>) -> Self {
        let present = promised.last().into_iter().flatten().map(|file| (file.name.clone(), file.clone())).collect();
        Counted { root: root.into(), known: Mutex::new(Known { present, promised: promised.into() }) }
    }

    fn name(&self, path: &Path) -> Option<String> {
        path.strip_prefix(&self.root).ok().and_then(Path::to_str).map(String::from)
    }

    /// Notes a file that was written.
    pub fn note(&self, path: &Path, time: Option<f64>, content: &[u8]) {
        let Some(name) = self.name(path) else { return };
        let file = CountedFile { name: name.clone(), time, length: content.len() as u64, checksum: crc32fast::hash(content) };
        self.known.lock().unwrap_or_else(PoisonError::into_inner).present.insert(name, file);
    }

    /// Forgets a file that is to be replaced or removed. Where it must be moved to, if a checkpoint counts on it.
    pub fn forget(&self, path: &Path) -> Option<Aside> {
        let name = self.name(path)?;
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let file = known.present.remove(&name)?;
        let is_promised = known.promised.iter().flatten().any(|promised| promised.name == name && promised.is_same(&file));
        is_promised.then(|| Aside(file.aside(&self.root)))
    }

    /// A file, if it is one of them.
    pub fn get(&self, path: &Path) -> Option<CountedFile> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.present.get(&self.name(path)?).cloned()
    }

    /// All of them as they are now, in the order of their names.
    pub fn all(&self) -> Vec<CountedFile> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).present.values().cloned().collect()
    }

    /// A checkpoint names these files. What no checkpoint that is kept counts on any more goes.
    pub fn promise(&self, files: Vec<CountedFile>) {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.promised.push_back(files);
        let mut old = Vec::new();
        while known.promised.len() > KEPT {
            old.extend(known.promised.pop_front().unwrap_or_default());
        }
        old.retain(|file| !known.promised.iter().flatten().any(|promised| promised.is_same(file)));
        for file in old {
            // One too many does no harm.
            let _ = fs::remove_file(file.aside(&self.root));
        }
    }
}
