//! The record of the files of a run: `.files` in its folder, one path a line, so that the next run into the same folder removes what is
//! not its own instead of leaving it beside its results.
//!
//! A path is written down before its file, and nothing is removed that is not in the record: files that others put into the folder stay.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::inputs::Inputs;
use crate::machine::files;

/// Name of the record.
pub const NAME: &str = ".files";
/// Its name until it is whole.
const PART: &str = "..files.part";

/// Paths of the files that a run has written, relative to its folder.
#[derive(Debug)]
pub struct FileRecord {
    root: PathBuf,
    known: Mutex<(BTreeSet<String>, File)>,
}

impl FileRecord {
    /// The record in a folder, which has its canonical path, to be continued.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn open(root: &Path) -> io::Result<Self> {
        let (known, place) = (read(root), root.join(NAME));
        // A new file in its place: the one that is there may have further names elsewhere, or be none.
        let hidden = root.join(PART);
        let _ = fs::remove_file(&hidden);
        let mut file = File::options().create_new(true).append(true).open(&hidden)?;
        file.write_all(known.iter().map(|name| format!("{name}\n")).collect::<String>().as_bytes())?;
        fs::rename(&hidden, &place)?;
        Ok(FileRecord { root: root.into(), known: Mutex::new((known, file)) })
    }

    /// The path of a file relative to the folder, as the record has it.
    fn name<'a>(&self, path: &'a Path) -> Option<&'a str> {
        path.strip_prefix(&self.root).ok().and_then(Path::to_str).filter(|name| !name.contains(['\n', '\r']))
    }

    /// Whether a file is in the record.
    pub fn knows(&self, path: &Path) -> bool {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        self.name(path).is_some_and(|name| known.0.contains(name))
    }

    /// Notes a file that is to be written.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn note(&self, path: &Path) -> io::Result<()> {
        let Some(name) = self.name(path) else { return Ok(()) };
        let (known, file) = &mut *self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.insert(name.to_string()) { file.write_all(format!("{name}\n").as_bytes()) } else { Ok(()) }
    }

    /// Paths of the files that are there, one a line, in the order of the alphabet: they are noted in the order in which threads come to
    /// them, and checkpoints go when they have served.
    pub fn text(&self) -> String {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.0.iter().filter(|name| self.root.join(name).is_file()).map(|name| format!("{name}\n")).collect()
    }
}

/// The paths that the record in a folder names.
fn read(root: &Path) -> BTreeSet<String> {
    let bytes = files::read(&root.join(NAME)).unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default().lines().map(String::from).collect()
}

/// Removes the files that the record in a folder names but for those that the run reads, folders that are empty then, and the record.
///
/// # Errors
/// The operating system refused to remove the file.
pub fn remove_all(root: &Path, inputs: &Inputs) -> Result<(), (PathBuf, io::Error)> {
    for name in read(root) {
        // The record may have been written by anybody.
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
