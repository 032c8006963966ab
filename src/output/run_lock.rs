//! The lock on the folder of a run: one process at a time writes there.
//!
//! During a run, `.lock` in its folder is locked (`flock`, also across machines on a shared file system). The file names the process
//! and is removed with the end of the run. Locks end with their process, so the file of a killed process has no effect.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::files::{OutputError, are_same};
use crate::machine::files::read;

/// Name of the file.
const NAME: &str = ".lock";
/// Number of attempts to take a lock: a process that only inspects the lock holds it for a moment.
const ATTEMPTS: usize = 4;
/// Time between two attempts to take a lock.
const MOMENT: Duration = Duration::from_millis(10);

/// Right to write into the folder of a run, until dropped.
#[derive(Debug)]
pub struct RunLock {
    path: PathBuf,
    /// File that is locked as long as it is open.
    _file: File,
}

impl RunLock {
    /// Takes the lock on an existing folder.
    ///
    /// # Errors
    /// Another process holds the lock, or the operating system refused.
    pub fn take(folder: &Path) -> Result<Self, OutputError> {
        let path = folder.join(NAME);
        let outcome = loop {
            match attempt(&path) {
                Ok(Attempt::Again) => {}
                outcome => break outcome,
            }
        };
        match outcome {
            Ok(Attempt::Taken(file)) => Ok(RunLock { path, _file: file }),
            Ok(_) => Err(OutputError::UnderWay { directory: folder.into(), process: process(folder) }),
            Err(source) => Err(OutputError::Write { path, source }),
        }
    }

    /// Refuses a folder in which a run is under way, without changing it.
    ///
    /// # Errors
    /// A run is under way in the folder.
    pub fn refuse_if_taken(folder: &Path) -> Result<(), OutputError> {
        let path = folder.join(NAME);
        if !fs::symlink_metadata(&path).is_ok_and(|found| found.is_file()) {
            return Ok(());
        }
        let Ok(file) = File::open(&path) else { return Ok(()) };
        match file.try_lock_shared() {
            Err(TryLockError::WouldBlock) => Err(OutputError::UnderWay { directory: folder.into(), process: process(folder) }),
            _ => Ok(()),
        }
    }
}

impl Drop for RunLock {
    fn drop(&mut self) {
        // The file is still locked here, so that no other process takes the lock.
        let _ = fs::remove_file(&self.path);
    }
}

/// Result of an attempt to take the lock.
enum Attempt {
    Taken(File),
    /// Another process holds the lock.
    Lost,
    /// The lock file was replaced meanwhile.
    Again,
}

fn attempt(path: &Path) -> io::Result<Attempt> {
    match File::options().read(true).write(true).create_new(true).open(path) {
        Ok(mut file) => {
            if !locked(&file)? {
                return Ok(Attempt::Lost);
            }
            // The process number is information only, so that a full disk may refuse the write.
            let _ = file.write_all(format!("process {}\n", std::process::id()).as_bytes());
            Ok(if is_at(&file, path) { Attempt::Taken(file) } else { Attempt::Again })
        }
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            match fs::symlink_metadata(path) {
                Ok(found) if !found.is_file() => return Err(io::Error::new(io::ErrorKind::InvalidInput, "something else stands there")),
                Ok(_) => {}
                Err(_) => return Ok(Attempt::Again),
            }
            let file = match File::options().read(true).write(true).open(path) {
                Ok(file) => file,
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Attempt::Again),
                Err(error) => return Err(error),
            };
            if !locked(&file)? {
                return Ok(Attempt::Lost);
            }
            // A lock file of a killed process is replaced.
            if is_at(&file, path) {
                fs::remove_file(path)?;
            }
            Ok(Attempt::Again)
        }
        Err(error) => Err(error),
    }
}

/// Locks a file; returns false if another process holds the lock.
fn locked(file: &File) -> io::Result<bool> {
    for attempt in 1.. {
        match file.try_lock() {
            Ok(()) => break,
            Err(TryLockError::WouldBlock) if attempt < ATTEMPTS => std::thread::sleep(MOMENT),
            Err(TryLockError::WouldBlock) => return Ok(false),
            // Without file locks of the file system, the run continues unprotected.
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => break,
            Err(TryLockError::Error(error)) => return Err(error),
        }
    }
    Ok(true)
}

fn is_at(file: &File, path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|there| file.metadata().is_ok_and(|own| are_same(&there, &own)))
}

/// Returns the process that holds the lock, as written in the file.
fn process(folder: &Path) -> String {
    let text = read(&folder.join(NAME)).ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default();
    text.lines()
        .next()
        .filter(|line| line.strip_prefix("process ").is_some_and(|number| number.parse::<u32>().is_ok()))
        .unwrap_or_default()
        .into()
}

#[cfg(test)]
mod tests {
    use super::super::samples::scratch;
    use super::*;

    #[test]
    fn one_at_a_time_and_nothing_is_left() {
        let (directory, _) = scratch("lock");
        RunLock::refuse_if_taken(&directory).unwrap();
        let lock = RunLock::take(&directory).unwrap();
        let error = RunLock::take(&directory).unwrap_err();
        assert!(error.to_string().contains(&format!("a run is under way here (process {})", std::process::id())), "{error}");
        assert!(RunLock::refuse_if_taken(&directory).is_err());
        drop(lock);
        assert_eq!(fs::read_dir(&*directory).unwrap().count(), 0);
        // Lock file of a killed process.
        fs::write(directory.join(NAME), "process 1\n").unwrap();
        RunLock::refuse_if_taken(&directory).unwrap();
        drop(RunLock::take(&directory).unwrap());
        assert!(!directory.join(NAME).exists());
    }

    #[test]
    fn of_many_threads_one_has_it() {
        let (directory, _) = scratch("lock threads");
        fs::write(directory.join(NAME), "process 1\n").unwrap();
        let taken: Vec<RunLock> = std::thread::scope(|scope| {
            let all: Vec<_> = (0..16).map(|_| scope.spawn(|| RunLock::take(&directory))).collect();
            all.into_iter().filter_map(|thread| thread.join().unwrap().ok()).collect()
        });
        assert_eq!(taken.len(), 1);
    }
}
