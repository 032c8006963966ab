//! Record of the files of a run: `.files` in its folder, one path per line, so that the next run into the folder removes the files of the
//! earlier run.
//!
//! A path is recorded before its file is written, and only recorded files are removed: foreign files in the folder stay.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::inputs::Inputs;
use crate::machine::files;

/// Name of the record.
pub const NAME: &str = ".files";
/// Name of the temporary file that is renamed to the record when complete.
const PART: &str = "..files.part";

/// Paths of the files that a run has written, relative to its folder.
#[derive(Debug)]
pub struct FileRecord {
    root: PathBuf,
    known: Mutex<(BTreeSet<String>, File)>,
}

impl FileRecord {
    /// Opens the record in a folder (canonical path) to append to it.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn open(root: &Path) -> io::Result<Self> {
        let (known, place) = (read(root), root.join(NAME));
        // A new file replaces an existing one, which may be linked elsewhere, or be no regular file.
        let hidden = root.join(PART);
        let _ = fs::remove_file(&hidden);
        let mut file = File::options().create_new(true).append(true).open(&hidden)?;
        file.write_all(known.iter().map(|name| format!("{name}\n")).collect::<String>().as_bytes())?;
        fs::rename(&hidden, &place)?;
        Ok(FileRecord { root: root.into(), known: Mutex::new((known, file)) })
    }

    /// Returns the path of a file relative to the folder.
    fn name<'a>(&self, path: &'a Path) -> Option<&'a str> {
        path.strip_prefix(&self.root).ok().and_then(Path::to_str).filter(|name| !name.contains(['\n', '\r']))
    }

    /// True if a file is in the record.
    pub fn knows(&self, path: &Path) -> bool {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        self.name(path).is_some_and(|name| known.0.contains(name))
    }

    /// Records a file before it is written.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn note(&self, path: &Path) -> io::Result<()> {
        let Some(name) = self.name(path) else { return Ok(()) };
        let (known, file) = &mut *self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.insert(name.to_string()) { file.write_all(format!("{name}\n").as_bytes()) } else { Ok(()) }
    }

    /// Returns the paths of existing files, one per line, in alphabetical order: they were recorded in the order of threads, and
    /// checkpoints are removed in between.
    pub fn text(&self) -> String {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.0.iter().filter(|name| self.root.join(name).is_file()).map(|name| format!("{name}\n")).collect()
    }
}

/// Reads the paths of the record in a folder.
fn read(root: &Path) -> BTreeSet<String> {
    let bytes = files::read(&root.join(NAME)).unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default().lines().map(String::from).collect()
}

/// Removes the files that the record in a folder names except those that the run reads, folders that are then empty, and the record.
///
/// # Errors
/// The operating system refused to remove the file.
pub fn remove_all(root: &Path, inputs: &Inputs) -> Result<(), (PathBuf, io::Error)> {
    for name in read(root) {
        // The record is untrusted input.
        if !Path::new(&name).components().all(|part| matches!(part, Component::Normal(_))) {
            continue;
        }
        let path = root.join(&name);
        if !path.parent().and_then(|folder| folder.canonicalize().ok()).is_some_and(|folder| folder.starts_with(root)) {
            continue;
        }
        if path.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
            continue;
        }
        match fs::remove_file(&path) {
            Err(error) if !matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::IsADirectory | io::ErrorKind::NotADirectory) => {
                return Err((path, error));
            }
            _ => {}
        }
        // Only empty folders can be removed.
        for folder in path.ancestors().skip(1).take_while(|folder| *folder != root) {
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
    let record = root.join(NAME);
    match fs::remove_file(&record) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err((record, error)),
        _ => Ok(()),
    }
}
