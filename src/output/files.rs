//! The output directory of a run: every file below it, replaced atomically, and errors that name the file.
//!
//! A file is written under a hidden name beside its place and then renamed, so that a reader finds the old or the new content, never a
//! part. A file, link or pipe at that place is replaced, not written through. Names come from scripts: names that lead outside the
//! directory (`..`, an absolute path, a symbolic link) are refused, and so are files that the run reads. This guards against mistakes and
//! untrusted scripts, not against another program that swaps links during a write. Only checkpoints are synced to disk: after a power
//! failure the last of the other files may be missing.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use thiserror::Error;

use super::counted::{self, Counted, CountedFile};
use super::file_record::{self, FileRecord};
use super::inputs::Inputs;
use super::summary::SUMMARY;
use crate::machine::files::read;

/// A result that could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// Name that leads outside the output directory.
    #[error("the path \"{name}\" leads outside the output directory \"{}\"", directory.display())]
    Outside {
        /// The name as given.
        name: String,
        /// The output directory.
        directory: PathBuf,
    },
    /// Name without a file, such as `""` or `"plots/"`.
    #[error("the path \"{name}\" names no file")]
    NoFileName {
        /// The name as given.
        name: String,
    },
    /// Written file that has been removed since.
    #[error("\"{}\" is gone: it was removed or replaced while the run went on", path.display())]
    Gone {
        /// Path of the removed file.
        path: PathBuf,
    },
    /// Name of a file that the run reads.
    #[error("\"{}\" is read by this run, so no result is written in its place", path.display())]
    Input {
        /// Path of the input file.
        path: PathBuf,
    },
    /// Another process writes to the directory.
    #[error(
        "a run is under way here{}: \"{}\"",
        if process.is_empty() { String::new() } else { format!(" ({process})") },
        directory.display()
    )]
    UnderWay {
        /// The output directory.
        directory: PathBuf,
        /// The other process, such as `process 4711`; empty if unknown.
        process: String,
    },
    /// The operating system refused to write.
    #[error("\"{}\" could not be written: {}", path.display(), reason(source))]
    Write {
        /// The file or directory.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}

impl OutputError {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            OutputError::Outside { .. } => "C0901",
            OutputError::NoFileName { .. } => "C0902",
            OutputError::Gone { .. } => "C0903",
            OutputError::Input { .. } => "C0904",
            OutputError::UnderWay { .. } => "C0905",
            OutputError::Write { .. } => "C0906",
        }
    }

    /// Returns a hint how to mend the error, one sentence.
    pub fn hint(&self) -> String {
        use io::ErrorKind::{
            DirectoryNotEmpty, FileTooLarge, IsADirectory, NotADirectory, PermissionDenied, QuotaExceeded, ReadOnlyFilesystem, StorageFull,
        };
        let text = match self {
            OutputError::Outside { .. } => {
                "name a file below the output directory, such as `plots/energy.svg`; choose the directory itself with `--out`"
            }
            OutputError::NoFileName { .. } => "end the path with the name of a file, such as `plots/energy.svg`",
            OutputError::Input { .. } => "choose another directory with `--out`, or another name",
            OutputError::UnderWay { .. } => "wait until it has ended, or choose another directory with `--out`",
            OutputError::Gone { .. } => "leave the output directory alone until the run has ended; run the script again for what is lost",
            OutputError::Write { source, .. } => match source.kind() {
                StorageFull | QuotaExceeded => "free some space, or choose a directory on another disk with `--out`",
                FileTooLarge => "raise the limit of the size of files (`ulimit -f`), or write less",
                PermissionDenied | ReadOnlyFilesystem => "choose a directory that you may write to with `--out`",
                IsADirectory | NotADirectory | DirectoryNotEmpty => {
                    "choose another name: a file and a directory cannot share one, or remove what is in the way"
                }
                _ => "see that the directory still exists and may be written to, or choose another one with `--out`",
            },
        };
        text.into()
    }

    pub(super) fn write(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| OutputError::Write { path, source }
    }
}

/// Returns the operating system's message without its number.
pub(super) fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    let words = text.split(" (os error").next().unwrap_or_default();
    let mut letters = words.chars();
    letters.next().map_or_else(|| "unknown reason".into(), |first| first.to_lowercase().chain(letters).collect())
}

/// The output directory of a run. Cheap to clone and free to move to another thread.
#[derive(Clone, Debug)]
pub struct RunFiles {
    directory: PathBuf,
    root: PathBuf,
    run: Option<Arc<Run>>,
}

/// Records of a run that owns its directory.
#[derive(Debug)]
struct Run {
    record: FileRecord,
    counted: Counted,
    inputs: Inputs,
}

impl RunFiles {
    /// True if a folder contains files of a run: the record, a summary, or checkpoints.
    pub fn are_in(folder: &Path) -> bool {
        [file_record::NAME, counted::FOLDER, SUMMARY].iter().any(|name| fs::symlink_metadata(folder.join(name)).is_ok())
    }

    /// Opens the output directory, which is created with its parents if missing. Its files stay until files of equal names are written.
    ///
    /// # Errors
    /// The directory cannot be created.
    pub fn create(directory: impl AsRef<Path>) -> Result<Self, OutputError> {
        let directory = directory.as_ref();
        fs::create_dir_all(directory).map_err(OutputError::write(directory))?;
        let root = directory.canonicalize().map_err(OutputError::write(directory))?;
        Ok(RunFiles { directory: directory.into(), root, run: None })
    }

    /// Opens the output directory for a run. Removes the files of an earlier run that its record (`.files`) names, except the inputs of
    /// this run, and begins a new record.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn begin(directory: impl AsRef<Path>, inputs: Inputs) -> Result<Self, OutputError> {
        let files = Self::create(directory)?;
        file_record::remove_all(&files.root, &inputs).map_err(|(path, source)| OutputError::Write { path, source })?;
        files.recorded(inputs, Vec::new())
    }

    /// Opens the output directory for a run that continues an earlier process. `counted` are the files of its checkpoints; the last list
    /// belongs to the checkpoint from which the run is resumed.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn resume(directory: impl AsRef<Path>, inputs: Inputs, counted: Vec<Vec<CountedFile>>) -> Result<Self, OutputError> {
        Self::create(directory)?.recorded(inputs, counted)
    }

    fn recorded(self, inputs: Inputs, counted: Vec<Vec<CountedFile>>) -> Result<Self, OutputError> {
        let path = self.place(file_record::NAME)?;
        let record = FileRecord::open(&self.root).map_err(OutputError::write(path))?;
        let counted = Counted::new(&self.root, counted);
        Ok(RunFiles { run: Some(Arc::new(Run { record, counted, inputs })), ..self })
    }

    /// Returns a folder below the directory, with a common record.
    ///
    /// # Errors
    /// An invalid name, or the operating system refused.
    pub fn below(&self, name: &str) -> Result<Self, OutputError> {
        let root = self.place(&format!("{name}/x"))?.with_file_name("");
        Ok(RunFiles { directory: self.directory.join(name), root, run: self.run.clone() })
    }

    /// Writes the list of files (`.files`) in alphabetical order at the end of a run.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn complete_record(&self) -> Result<(), OutputError> {
        let Some(run) = &self.run else { return Ok(()) };
        RunFiles { run: None, ..self.clone() }.write(file_record::NAME, run.record.text()).map(drop)
    }

    /// Returns the path of a file that is about to be written, and records it.
    fn noted(&self, name: &str) -> Result<PathBuf, OutputError> {
        let path = self.place(name)?;
        let Some(run) = &self.run else { return Ok(path) };
        // The run may write files again that it has itself written and read.
        if run.inputs.contains(&path) && !run.record.knows(&path) {
            return Err(OutputError::Input { path });
        }
        run.record.note(&path).map_err(OutputError::write(&path))?;
        Ok(path)
    }

    /// Returns the present files that a resumed run relies on.
    pub fn counted(&self) -> Vec<CountedFile> {
        self.run.as_ref().map_or(Vec::new(), |run| run.counted.all())
    }

    /// Keeps these files restorable until two further checkpoints are written.
    pub fn promise(&self, files: Vec<CountedFile>) {
        self.run.iter().for_each(|run| run.counted.promise(files.clone()));
    }

    /// True if the record of the run has a file of that name, which may have been removed since.
    pub fn has_written(&self, name: &str) -> bool {
        self.run.as_ref().is_some_and(|run| run.record.knows(&self.root.join(name)))
    }

    /// True if a resumed run relies on the file `name` written at `time`.
    pub fn counts_on(&self, name: &str, time: f64) -> bool {
        let path = self.root.join(name);
        self.run.as_ref().is_none_or(|run| run.counted.get(&path).is_some_and(|file| file.time == Some(time)))
    }

    /// Directory as given.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Returns the path of a file below the directory; missing folders are created.
    ///
    /// # Errors
    /// A name that leads outside or names no file; a folder that cannot be created.
    pub fn place(&self, name: &str) -> Result<PathBuf, OutputError> {
        let outside = || OutputError::Outside { name: name.into(), directory: self.directory.clone() };
        let mut parts = Vec::new();
        for component in Path::new(name).components() {
            match component {
                Component::Normal(part) => parts.push(part),
                Component::CurDir => {}
                Component::ParentDir | Component::RootDir | Component::Prefix(_) => return Err(outside()),
            }
        }
        let Some((last, folders)) = parts.split_last().filter(|_| !name.ends_with(['/', std::path::MAIN_SEPARATOR])) else {
            return Err(OutputError::NoFileName { name: name.into() });
        };
        let inside = |path: &Path| match fs::symlink_metadata(path) {
            // The target of a dangling link is unknown, so the link counts as leading outside.
            Ok(found) if found.is_symlink() => path.canonicalize().is_ok_and(|target| target.starts_with(&self.root)),
            _ => true,
        };
        let mut path = self.root.clone();
        for folder in folders {
            path.push(folder);
            if !inside(&path) {
                return Err(outside());
            }
            match fs::create_dir(&path) {
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(OutputError::Write { path, source: error }),
                _ => {}
            }
        }
        path.push(last);
        if inside(&path) { Ok(path) } else { Err(outside()) }
    }

    /// Writes a file atomically and returns its path.
    ///
    /// # Errors
    /// An invalid name, or the operating system refused; an older file of that name is then kept.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<PathBuf, OutputError> {
        self.replace(name, |file| file.write_all(bytes.as_ref()))
    }

    /// Writes a file and syncs it to disk, so that it survives a power failure.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_durably(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<PathBuf, OutputError> {
        self.replace(name, |file| file.write_all(bytes.as_ref()).and_then(|()| file.sync_all()))
    }

    /// Writes a file that a resumed run relies on, because the file shows earlier steps that are not computed again (a frame, a movie). A
    /// file that a checkpoint refers to is kept aside when it is replaced.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_counted(&self, name: &str, time: Option<f64>, bytes: impl AsRef<[u8]>) -> Result<PathBuf, OutputError> {
        let path = self.write(name, bytes.as_ref())?;
        self.run.iter().for_each(|run| run.counted.note(&path, time, bytes.as_ref()));
        Ok(path)
    }

    /// Removes a file of this run; a file that a checkpoint refers to can be restored.
    ///
    /// # Errors
    /// An invalid name, or the operating system refused.
    pub fn remove(&self, name: &str) -> Result<(), OutputError> {
        let path = self.place(name)?;
        self.set_aside(&path)?;
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(OutputError::Write { path, source: error }),
            _ => Ok(()),
        }
    }

    /// Moves a file away before it is replaced or removed, if a checkpoint refers to it.
    fn set_aside(&self, path: &Path) -> Result<(), OutputError> {
        let Some(aside) = self.run.as_ref().and_then(|run| run.counted.forget(path)) else { return Ok(()) };
        aside.take(path).map_err(OutputError::write(path))
    }

    /// Writes a temporary file by `fill` and renames it to `name`.
    fn replace(&self, name: &str, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<PathBuf, OutputError> {
        let path = self.noted(name)?;
        self.put(&path, fill).map(|_| path)
    }

    /// Writes a temporary file by `fill` and renames it to `path`; returns the open file.
    fn put(&self, path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<File, OutputError> {
        let mut hidden = OsString::from(".");
        hidden.push(path.file_name().unwrap_or_default());
        hidden.push(".part");
        let hidden = path.with_file_name(hidden);
        // The remainder of a killed run is removed first: `create_new` then never writes through a link.
        let _ = fs::remove_file(&hidden);
        let mut options = File::options();
        let mut written = options.append(true).create_new(true).open(&hidden);
        written = written.and_then(|mut file| fill(&mut file).map(|()| file));
        let put = written.map_err(OutputError::write(path)).and_then(|file| {
            self.set_aside(path)?;
            fs::rename(&hidden, path).map_err(OutputError::write(path)).map(|()| file)
        });
        if put.is_err() {
            // The first error is reported; a temporary file that cannot be removed does no harm.
            let _ = fs::remove_file(&hidden);
        }
        put
    }

    /// Opens an empty file for appending, in place of an existing one.
    ///
    /// # Errors
    /// An invalid name, or the operating system refused.
    pub fn stream(&self, name: &str) -> Result<Stream, OutputError> {
        self.filled(name, |_| Ok(()))
    }

    /// Opens a file for appending with the content written by `fill`, in place of an existing one.
    ///
    /// # Errors
    /// An invalid name, or the operating system refused.
    pub fn filled(&self, name: &str, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> Result<Stream, OutputError> {
        let path = self.noted(name)?;
        let file = self.put(&path, |file| {
            let mut buffered = BufWriter::with_capacity(BUFFER, file);
            fill(&mut buffered)?;
            buffered.flush()
        })?;
        let length = file.metadata().map_err(OutputError::write(&path))?.len();
        Ok(Stream { path, file, length })
    }

    /// Opens an existing file for appending; a file with several hard links is copied before.
    ///
    /// # Errors
    /// An invalid name, or the operating system refused.
    pub fn extend(&self, name: &str) -> Result<Stream, OutputError> {
        let path = self.place(name)?;
        let found = fs::symlink_metadata(&path).map_err(OutputError::write(&path))?;
        if !found.is_file() || has_further_names(&found) {
            let content = read(&path).map_err(OutputError::write(&path))?;
            return self.filled(name, |file| file.write_all(&content));
        }
        let file = File::options().append(true).open(&path).map_err(OutputError::write(&path))?;
        let length = file.metadata().map_err(OutputError::write(&path))?.len();
        Ok(Stream { path, file, length })
    }
}

/// Size of the write buffer `[bytes]`.
const BUFFER: usize = 1 << 16;

/// True if a file has several hard links.
#[cfg(unix)]
fn has_further_names(found: &fs::Metadata) -> bool {
    std::os::unix::fs::MetadataExt::nlink(found) > 1
}

/// Always false: the number of hard links is not available on this system.
#[cfg(not(unix))]
fn has_further_names(_: &fs::Metadata) -> bool {
    false
}

/// File to which complete pieces are appended.
#[derive(Debug)]
pub struct Stream {
    path: PathBuf,
    file: File,
    length: u64,
}

impl Stream {
    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of bytes written so far.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Appends a piece with one system call, so that the piece is in the file on return, even if the program is killed.
    ///
    /// # Errors
    /// The operating system refused; the file is then unchanged.
    pub fn append(&mut self, piece: &[u8]) -> Result<(), OutputError> {
        if let Err(error) = self.file.write_all(piece) {
            // A full disk may have written a part of the piece.
            let _ = self.file.set_len(self.length);
            return Err(OutputError::Write { path: self.path.clone(), source: error });
        }
        self.length += piece.len() as u64;
        Ok(())
    }

    /// Syncs the file to disk.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn sync(&self) -> Result<(), OutputError> {
        self.file.sync_data().map_err(OutputError::write(&self.path))
    }

    /// Checks that the file is still at its path.
    ///
    /// # Errors
    /// The file was removed or replaced.
    pub fn verify(&self) -> Result<(), OutputError> {
        let is_there = fs::metadata(&self.path).is_ok_and(|there| self.file.metadata().is_ok_and(|own| are_same(&there, &own)));
        if is_there { Ok(()) } else { Err(OutputError::Gone { path: self.path.clone() }) }
    }

    /// Truncates the file to its first `length` bytes.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn truncate(&mut self, length: u64) -> Result<(), OutputError> {
        self.file.set_len(length).map_err(OutputError::write(&self.path))?;
        self.length = length;
        Ok(())
    }
}

/// True if both metadata are of one file (device and inode agree).
#[cfg(unix)]
pub(super) fn are_same(there: &fs::Metadata, own: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (there.dev(), there.ino()) == (own.dev(), own.ino())
}

/// True if both metadata have equal length; identity of files cannot be determined on this system.
#[cfg(not(unix))]
pub(super) fn are_same(there: &fs::Metadata, own: &fs::Metadata) -> bool {
    there.len() == own.len()
}

#[cfg(test)]
mod tests {
    use super::super::samples::scratch;
    use super::*;

    #[test]
    fn a_file_is_replaced_in_one_piece_and_leaves_nothing_beside_it() {
        let (directory, files) = scratch("replace");
        assert_eq!(files.write("plots/energy.svg", "old").unwrap(), directory.canonicalize().unwrap().join("plots/energy.svg"));
        files.write("./plots/energy.svg", "new").unwrap();
        assert_eq!(fs::read_to_string(directory.join("plots/energy.svg")).unwrap(), "new");
        assert_eq!(fs::read_dir(directory.join("plots")).unwrap().count(), 1);
    }

    #[test]
    fn a_file_that_grows_knows_when_it_is_gone() {
        let (directory, files) = scratch("gone");
        let mut stream = files.stream("history.csv").unwrap();
        stream.append(b"a\n").unwrap();
        stream.verify().unwrap();
        files.write("history.csv", "another\n").unwrap();
        assert!(matches!(stream.verify(), Err(OutputError::Gone { .. })), "replaced");
        let stream = files.extend("history.csv").unwrap();
        fs::remove_dir_all(&*directory).unwrap();
        assert!(matches!(stream.verify(), Err(OutputError::Gone { .. })), "removed");
    }

    #[test]
    fn names_that_lead_outside_are_refused() {
        let (directory, files) = scratch("outside");
        for name in ["../x", "a/../../x", "/tmp/x", "a/../x"] {
            let error = files.write(name, "").unwrap_err();
            assert!(matches!(&error, OutputError::Outside { name: given, .. } if given == name), "{name}: {error}");
        }
        for name in ["", ".", "plots/", "./"] {
            assert!(matches!(files.write(name, ""), Err(OutputError::NoFileName { .. })), "{name}");
        }
        assert!(!directory.join("a").exists(), "a refused name makes no folder");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_only_while_they_stay_inside() {
        use std::os::unix::fs::symlink;
        let (directory, files) = scratch("links");
        let (elsewhere, _) = scratch("links elsewhere");
        fs::write(elsewhere.join("kept"), "theirs").unwrap();
        symlink(&*elsewhere, directory.join("away")).unwrap();
        symlink(elsewhere.join("kept"), directory.join("history.csv")).unwrap();
        symlink("nowhere", directory.join("dangling")).unwrap();
        fs::create_dir(directory.join("inside")).unwrap();
        symlink("inside", directory.join("near")).unwrap();
        for name in ["away/kept", "history.csv", "dangling", "dangling/x"] {
            assert!(matches!(files.write(name, "ours"), Err(OutputError::Outside { .. })), "{name}");
            assert!(matches!(files.stream(name), Err(OutputError::Outside { .. })), "{name}");
        }
        assert_eq!(fs::read_to_string(elsewhere.join("kept")).unwrap(), "theirs");
        files.write("near/x", "ours").unwrap();
        assert_eq!(fs::read_to_string(directory.join("inside/x")).unwrap(), "ours");
    }

    #[test]
    fn a_refusal_names_the_file_and_keeps_the_old_one() {
        let (directory, files) = scratch("refusal");
        files.write("taken", "file").unwrap();
        fs::create_dir(directory.join("folder")).unwrap();
        for name in ["taken/x", "folder"] {
            let error = files.write(name, "").unwrap_err();
            assert!(matches!(error, OutputError::Write { .. }), "{name}");
            assert!(error.to_string().contains(name), "{error}");
            assert!(!error.to_string().contains("os error"), "{error}");
            assert!(error.hint().contains("choose another name"), "{name}: {}", error.hint());
        }
        assert_eq!(fs::read_to_string(directory.join("taken")).unwrap(), "file");
        assert_eq!(fs::read_dir(&*directory).unwrap().count(), 2, "no part is left behind");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_said_in_words() {
        let mut stream = Stream { path: "history.csv".into(), file: File::options().append(true).open("/dev/full").unwrap(), length: 0 };
        let error = stream.append(b"1,2\n").unwrap_err();
        assert_eq!(error.to_string(), "\"history.csv\" could not be written: no space left on device");
        assert!(error.hint().starts_with("free some space"));
        assert_eq!(stream.length(), 0);
    }

    #[test]
    fn a_stream_grows_by_whole_pieces_and_can_be_cut_back() {
        let (directory, files) = scratch("stream");
        files.write("history.csv", "of an older run").unwrap();
        let mut stream = files.stream("history.csv").unwrap();
        for piece in ["step\n", "0\n", "1\n"] {
            stream.append(piece.as_bytes()).unwrap();
        }
        // The stream is still open: after a kill a reader finds this content.
        assert_eq!(fs::read_to_string(directory.join("history.csv")).unwrap(), "step\n0\n1\n");
        stream.truncate(7).unwrap();
        stream.append(b"2\n").unwrap();
        assert_eq!(fs::read_to_string(directory.join("history.csv")).unwrap(), "step\n0\n2\n");
    }
}
