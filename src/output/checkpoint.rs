//! Checkpoints: states from which a run is resumed with byte-identical results.
//!
//! A resumed run executes the script again from its start and reads the results of completed computations from the [journal]. A checkpoint
//! refers to a moment of the journal: its length and checksum, the simulations at that moment, and the files on disk that belong to it. The
//! size of a checkpoint does not depend on the number of steps.
//!
//! File format: 12 bytes of identification, the format version, length and CRC-32 of the content (little endian), the content encoded by
//! `postcard`. A checkpoint is written to a temporary file, synced to disk, and renamed.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::counted::{ASIDE, CountedFile, FOLDER, FileCondition, KEPT};
use super::files::{OutputError, RunFiles};
use super::history::ROWS;
use super::journal::{self, Mark};
use super::recording::Recording;
use crate::dynamics::{State, Tally};
use crate::machine::files::read;
use crate::math::simd::instructions;

/// First bytes of a checkpoint.
pub const MAGIC: &[u8; 12] = b"conserva\0ckp";
/// Version of the format.
pub const FORMAT: u32 = 15;
/// Bytes before the content.
const HEADER: usize = MAGIC.len() + 4 + 8 + 4;
/// Extension of the files beside checkpoints that keep results of studies' points ([`PointLog`](super::PointLog)).
pub const POINTS: &str = "points";

/// All data on which results of a run depend.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of the program.
    pub program: String,
    /// Instruction set of the processor, which affects the last bits.
    pub instructions: String,
    /// Folder in which the program was started; paths are relative to it.
    pub folder: PathBuf,
    /// Path of the script as given.
    pub script: String,
    /// Names and texts of the script and its modules.
    pub sources: Vec<(String, String)>,
    /// Other files that the script has read, with length and CRC-32.
    pub files: Vec<(PathBuf, u64, u32)>,
    /// Values given for parameters with `--set`.
    pub overrides: Vec<(String, String)>,
    /// Folders that the script may read.
    pub allow_read: Vec<PathBuf>,
    /// Number of operations after which the script counts as endless.
    pub max_operations: u64,
}

impl Origin {
    /// Returns the current origin of a run with the arguments of `then`: program version, instruction set, scripts and input files as they
    /// are now.
    pub fn now(then: &Origin) -> Origin {
        let source = |(name, _): &(String, String)| {
            let text = read(Path::new(name)).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
            (name.clone(), text.unwrap_or_default())
        };
        let file = |(path, ..): &(PathBuf, u64, u32)| {
            let (length, checksum) = read(path).map_or((0, 0), |content| Origin::digest(&content));
            (path.clone(), length, checksum)
        };
        Origin {
            program: env!("CARGO_PKG_VERSION").into(),
            instructions: instructions(),
            sources: then.sources.iter().map(source).collect(),
            files: then.files.iter().map(file).collect(),
            ..then.clone()
        }
    }

    /// Returns the differences from another origin: those that change results, and those that change the last digits at most.
    pub fn differences(&self, other: &Origin) -> (Vec<String>, Vec<String>) {
        let mut changed = Vec::new();
        for ((name, then), (_, now)) in self.sources.iter().zip(&other.sources) {
            let mut lines = then.lines().zip(now.lines().map(Some).chain(std::iter::repeat(None))).enumerate();
            if then == now {
                continue;
            }
            changed.push(match lines.find(|(_, (then, now))| Some(*then) != *now) {
                _ if now.is_empty() => format!("the script {name} is gone"),
                Some((line, (_, Some(_)))) => format!("the script {name} has another line {}", line + 1),
                _ => format!("the script {name} has another end"),
            });
        }
        for ((path, length, then), (_, now_length, now)) in self.files.iter().zip(&other.files) {
            if (length, then) != (now_length, now) {
                changed.push(format!("the file {} has another content", path.display()));
            }
        }
        let versions = [("program", &self.program, &other.program), ("processor's instructions", &self.instructions, &other.instructions)];
        let differing = versions.into_iter().filter(|(_, then, now)| then != now);
        (changed, differing.map(|(what, then, now)| format!("the {what} were {then} and are {now}")).collect())
    }

    /// Length and CRC-32 of a file's content.
    pub fn digest(content: &[u8]) -> (u64, u32) {
        (content.len() as u64, crc32fast::hash(content))
    }
}

/// Saved data of a simulation that is not in the journal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SavedSimulation {
    /// Name of the simulation.
    pub name: String,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Steps and time reached.
    pub reached: (usize, f64),
    /// Counters of the simulation.
    pub tally: Tally,
    /// State of the simulation.
    pub state: Option<Arc<State>>,
    /// States before the last steps, the newest last; kept if the script goes back by steps.
    pub past: Vec<Arc<State>>,
    /// Recorded stills (animation frames).
    pub recording: Option<Recording>,
    /// Length and CRC-32 of `history.csv`.
    pub rows: Option<(u64, u32)>,
}

/// A checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Scripts, input files, arguments and program version on which the run depends.
    pub origin: Origin,
    /// Simulations of the run.
    pub simulations: Vec<SavedSimulation>,
    /// Position in the journal that belongs to the checkpoint.
    pub journal: Mark,
    /// Files of the run that belong to the checkpoint.
    pub files: Vec<CountedFile>,
}

/// Error of a file from which a run cannot be resumed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The operating system refused to read the file.
    #[error("it cannot be read: {0}")]
    Read(String),
    /// The file is not a checkpoint.
    #[error("it is not a checkpoint of Conserva")]
    Foreign,
    /// The checkpoint was written by a later version of the program.
    #[error("its format {found} is newer than the format {FORMAT} of this program")]
    Future {
        /// Format version of the file.
        found: u32,
    },
    /// The end of the file is missing.
    #[error("it is cut off: {found} of {announced} bytes are there")]
    Truncated {
        /// Number of bytes of the content.
        found: u64,
        /// Number of bytes that the header announces.
        announced: u64,
    },
    /// The content does not match the checksum.
    #[error("it is damaged: its content does not agree with its checksum")]
    Damaged,
    /// The checkpoint was written by an earlier version of the program.
    #[error("its format {found} is older than the format {FORMAT} of this program")]
    Past {
        /// Format version of the file.
        found: u32,
    },
    /// The folder belongs to another run, or its files have changed.
    #[error("{0}")]
    Stranger(String),
}

impl CheckpointError {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            CheckpointError::Read(..) => "C0911",
            CheckpointError::Foreign => "C0912",
            CheckpointError::Future { .. } => "C0913",
            CheckpointError::Truncated { .. } => "C0914",
            CheckpointError::Damaged => "C0915",
            CheckpointError::Past { .. } => "C0916",
            CheckpointError::Stranger(..) => "C0917",
        }
    }
}

impl Checkpoint {
    /// Describes steps and times reached by the simulations, as the end of a sentence.
    pub fn reached(&self) -> String {
        let one = |saved: &SavedSimulation| format!("\"{}\" at t = {} (step {})", saved.name, saved.reached.1, saved.reached.0);
        let all: Vec<String> = self.simulations.iter().map(one).collect();
        if all.is_empty() { String::new() } else { format!(" {}", all.join(", ")) }
    }

    /// Encodes the checkpoint as the bytes of a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; HEADER];
        // Writing to memory does not fail, and all of these types can be encoded.
        bytes = postcard::to_extend(self, bytes).unwrap_or_default();
        let content = bytes.len().saturating_sub(HEADER) as u64;
        let checksum = crc32fast::hash(bytes.get(HEADER..).unwrap_or_default());
        let header = MAGIC.iter().copied().chain(FORMAT.to_le_bytes()).chain(content.to_le_bytes()).chain(checksum.to_le_bytes());
        bytes.iter_mut().zip(header).for_each(|(byte, known)| *byte = known);
        bytes
    }

    /// Decodes a checkpoint from the bytes of a file.
    ///
    /// # Errors
    /// The bytes are no checkpoint, of another format version, truncated or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, CheckpointError> {
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            let is_begun = !bytes.is_empty() && MAGIC.starts_with(bytes);
            return Err(if is_begun {
                CheckpointError::Truncated { found: 0, announced: HEADER as u64 }
            } else {
                CheckpointError::Foreign
            });
        };
        let cut_off = CheckpointError::Truncated { found: 0, announced: HEADER as u64 };
        let Some((format, rest)) = rest.split_first_chunk() else { return Err(cut_off) };
        let found = u32::from_le_bytes(*format);
        if found > FORMAT {
            return Err(CheckpointError::Future { found });
        }
        if found < FORMAT {
            return Err(CheckpointError::Past { found });
        }
        let Some((length, rest)) = rest.split_first_chunk() else { return Err(cut_off) };
        let Some((checksum, content)) = rest.split_first_chunk() else { return Err(cut_off) };
        let (announced, found) = (u64::from_le_bytes(*length), content.len() as u64);
        if found < announced {
            return Err(CheckpointError::Truncated { found, announced });
        }
        if found > announced || crc32fast::hash(content) != u32::from_le_bytes(*checksum) {
            return Err(CheckpointError::Damaged);
        }
        postcard::from_bytes(content).map_err(|_| CheckpointError::Damaged)
    }

    /// Reads a checkpoint file.
    ///
    /// # Errors
    /// The file cannot be read, or its content is no valid checkpoint.
    pub fn read(path: &Path) -> Result<Self, CheckpointError> {
        let bytes = read(path).map_err(|error| CheckpointError::Read(super::files::reason(&error)))?;
        Checkpoint::from_bytes(&bytes)
    }

    /// Checks that `run` is the folder to which this checkpoint belongs: its journal and its files are there. Returns the files that the
    /// run has replaced since the checkpoint, which must be restored before the run is resumed.
    ///
    /// # Errors
    /// The journal or a file is missing or has another content.
    pub fn belongs_to(&self, run: &Path) -> Result<Vec<CountedFile>, CheckpointError> {
        if let Some(complaint) = self.journal.complaint(run) {
            return Err(CheckpointError::Stranger(complaint.into()));
        }
        let mut aside = Vec::new();
        for file in &self.files {
            let what = match file.time {
                Some(time) => format!("the frame of the fields at t = {time} ({})", file.name),
                None => file.name.clone(),
            };
            let complaint = match file.standing(run) {
                FileCondition::There => continue,
                FileCondition::Aside => {
                    aside.push(file.clone());
                    continue;
                }
                FileCondition::Gone => format!("{what} is gone: the run had written it, and does not compute it again"),
                FileCondition::Replaced => format!("{what} has another content than the run had written"),
            };
            return Err(CheckpointError::Stranger(complaint));
        }
        Ok(aside)
    }

    /// Returns the files of all checkpoints in the folder of a run, those of this checkpoint last.
    pub fn promises(&self, run: &Path) -> Vec<Vec<CountedFile>> {
        let others = places(run).into_iter().filter_map(|place| Checkpoint::read(&place).ok()).filter(|other| other != self);
        others.map(|other| other.files).chain([self.files.clone()]).collect()
    }

    /// Writes the checkpoint into the folder of a run, and removes the oldest checkpoints there.
    ///
    /// # Errors
    /// The operating system refused; earlier checkpoints are kept.
    pub fn write(&self, files: &RunFiles) -> Result<(), OutputError> {
        let newest = places(files.directory()).last().and_then(|path| number(path)).unwrap_or(0);
        files.write_durably(&format!("{FOLDER}/{:06}.checkpoint", newest + 1), self.to_bytes())?;
        let all = places(files.directory());
        for old in &all[..all.len().saturating_sub(KEPT)] {
            // A file that cannot be removed does no harm.
            let _ = std::fs::remove_file(old);
        }
        Ok(())
    }
}

/// Restores files of a run that it has replaced since a checkpoint.
///
/// # Errors
/// The operating system refused.
pub fn restore_files(run: &Path, aside: &[CountedFile]) -> Result<(), OutputError> {
    aside.iter().try_for_each(|file| file.restore(run).map_err(OutputError::write(run.join(&file.name))))
}

/// Returns the number in the name of a checkpoint.
fn number(path: &Path) -> Option<u64> {
    if path.extension()? != "checkpoint" { None } else { path.file_stem()?.to_str()?.parse().ok() }
}

/// Returns the paths of the checkpoints in the folder of a run, the newest last.
pub fn places(run: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(run.join(FOLDER)).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut found: Vec<PathBuf> = entries.filter(|path| number(path).is_some()).collect();
    found.sort_by_key(|path| number(path));
    found
}

/// Removes the checkpoints in the folder of a run, and the kept results of studies' points: the run is complete, or begins anew.
///
/// # Errors
/// The operating system refused.
pub fn remove_all(run: &Path) -> Result<(), OutputError> {
    let entries = std::fs::read_dir(run.join(FOLDER)).into_iter().flatten().flatten().map(|entry| entry.path());
    // On systems that cannot unlink an open file, the file of rows is removed here.
    let is_rows = |name: &std::ffi::OsStr| name.to_string_lossy().starts_with(&format!("{ROWS}-"));
    // Incomplete files of a killed process are removed, too.
    let is_ours = |ending: &std::ffi::OsStr| [POINTS, ASIDE, "part"].iter().any(|known| *known == ending);
    let logs = entries.filter(|path| {
        path.extension().is_some_and(is_ours) || path.file_name().is_some_and(|name| name == journal::NAME || is_rows(name))
    });
    for path in places(run).into_iter().chain(logs) {
        std::fs::remove_file(&path).map_err(|source| OutputError::Write { path, source })?;
    }
    // A folder with other files is not removed.
    let _ = std::fs::remove_dir(run.join(FOLDER));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkpoint() -> Checkpoint {
        let file = CountedFile { name: "fields/fields_000000.vtu".into(), time: Some(0.0), length: 5, checksum: 7 };
        let saved = SavedSimulation { name: "drop".into(), unknowns: 12, reached: (3, 0.3), ..SavedSimulation::default() };
        Checkpoint { simulations: vec![saved; 2], files: vec![file; 3], ..Checkpoint::default() }
    }

    #[test]
    fn a_checkpoint_comes_back_as_it_was() {
        let bytes = checkpoint().to_bytes();
        assert_eq!(Checkpoint::from_bytes(&bytes).unwrap(), checkpoint());
    }

    #[test]
    fn whatever_happened_to_a_file_is_told() {
        let bytes = checkpoint().to_bytes();
        for length in 0..bytes.len() {
            let error = Checkpoint::from_bytes(&bytes[..length]).unwrap_err();
            let is_told = matches!(error, CheckpointError::Truncated { .. }) || length == 0 && matches!(error, CheckpointError::Foreign);
            assert!(is_told, "{length}: {error}");
        }
        for place in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 0x10;
            assert!(Checkpoint::from_bytes(&damaged).is_err(), "byte {place}");
        }
        let mut longer = bytes.clone();
        longer.push(0);
        assert!(matches!(Checkpoint::from_bytes(&longer), Err(CheckpointError::Damaged)));
        let mut future = bytes;
        future[MAGIC.len()] = FORMAT as u8 + 1;
        assert!(matches!(Checkpoint::from_bytes(&future), Err(CheckpointError::Future { found }) if found == FORMAT + 1));
        assert!(matches!(Checkpoint::from_bytes(b"step,time\n"), Err(CheckpointError::Foreign)));
    }
}
