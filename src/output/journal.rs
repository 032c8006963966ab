//! The journal of a run: results of all computations of its simulations, in the order of the script's calls, in one append-only file.
//!
//! A checkpoint refers to a position in the journal ([`Mark`]), so that the checkpoint itself holds only the current state of the
//! simulations. Entries behind the mark of the checkpoint from which a run is resumed are removed.
//!
//! File format: consecutive entries, each of its length (4 bytes, little endian) and its content encoded by `postcard`.

use std::fs::File;
use std::io::{self, BufReader, Read, Take};
use std::path::Path;
use std::sync::Arc;

use crc32fast::Hasher;
use serde::{Deserialize, Serialize};

use super::counted::{FOLDER, checksum};
use super::files::{OutputError, RunFiles, Stream};
use crate::dynamics::{LedgerRow, SettleReport, State, Tally};
use crate::machine::files;

/// Name of the file in the folder of the checkpoints.
pub const NAME: &str = "journal";
/// Number of buffered bytes beyond which the buffer is written.
const PIECE: usize = 1 << 20;
/// Number of bytes that are read at once; small enough for the processor's cache.
const BUFFER: usize = 1 << 16;
/// Largest number of buffered bytes if the file cannot be written.
const MOST_WAITING: usize = 1 << 26;

/// Request for a computation of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Computation {
    /// A nominal step, shortened to end at the given time.
    Step(Option<f64>),
    /// Equilibrium at a time; true with friction.
    Settle(f64, bool),
}

/// Outcome of a computation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    /// The step was taken, in substeps with these rows of the history.
    Stepped(#[serde(with = "packed_rows")] Vec<LedgerRow>),
    /// Equilibrium was found.
    Settled(SettleReport),
    /// The computation failed, and the script went on; the resumed run repeats the failure.
    Failed,
}

/// Encoding of rows in an entry by [`LedgerRow::pack`].
mod packed_rows {
    use serde::de::{Deserialize, Deserializer, Error};
    use serde::{Serialize, Serializer};

    use super::LedgerRow;

    pub(super) fn serialize<S: Serializer>(rows: &[LedgerRow], to: S) -> Result<S::Ok, S::Error> {
        let mut bytes = Vec::new();
        rows.iter().for_each(|row| row.pack(&mut bytes));
        (rows.len(), Bytes(&bytes)).serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<LedgerRow>, D::Error> {
        let (count, mut bytes) = <(usize, &[u8])>::deserialize(from)?;
        let mut rows = Vec::new();
        for _ in 0..count {
            let mut row = LedgerRow::default();
            bytes = row.unpack(bytes).ok_or_else(|| D::Error::custom("a row is cut off"))?;
            rows.push(row);
        }
        Ok(rows)
    }

    /// Bytes that are serialized at once, not one by one.
    struct Bytes<'a>(&'a [u8]);

    impl Serialize for Bytes<'_> {
        fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
            to.serialize_bytes(self.0)
        }
    }
}

/// An entry of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Entry {
    /// Identification of the run, the first entry: script, folder in which the program was started, values given for parameters.
    Run(String, String, Vec<(String, String)>),
    /// Computation of a simulation.
    Computed {
        /// Index of the simulation in the script.
        simulation: usize,
        /// Computation that was requested.
        computation: Computation,
        /// Outcome of the computation.
        outcome: Outcome,
        /// Counters of the simulation after the computation.
        tally: Box<Tally>,
    },
    /// Return of a simulation to a kept state, or back by steps.
    WentBack {
        /// Index of the simulation in the script.
        simulation: usize,
    },
    /// State that does not follow from the entries before it without computation.
    State {
        /// Index of the simulation in the script.
        simulation: usize,
        /// State of the simulation.
        state: Arc<State>,
    },
}

/// Position in a journal to which a checkpoint refers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mark {
    /// Length of the journal `[bytes]`.
    pub length: u64,
    /// CRC-32 of these bytes.
    pub checksum: u32,
    /// Number of entries that are computations or returns to a stored state.
    pub events: u64,
}

impl Mark {
    /// Returns the fault of the journal in the folder of a run; `None` if the journal agrees with the mark.
    pub fn complaint(&self, run: &Path) -> Option<&'static str> {
        match checksum(&run.join(FOLDER).join(NAME), self.length) {
            Ok((sum, found)) if found == self.length && sum == self.checksum => None,
            Ok((_, found)) if found < self.length => Some("its steps (`checkpoints/journal`) are cut off, or those of another run"),
            Ok(_) => Some("its steps (`checkpoints/journal`) are damaged, or those of another run"),
            Err(_) => Some("its steps (`checkpoints/journal`) are not there: it is of another run, or they were removed"),
        }
    }
}

/// Writes a journal.
#[derive(Debug)]
pub struct JournalWriter {
    files: RunFiles,
    stream: Option<Stream>,
    sum: Hasher,
    /// Position reached in the file.
    mark: Mark,
    /// Buffered entries.
    waiting: Vec<u8>,
    /// Number of events among the buffered entries.
    events: u64,
}

impl JournalWriter {
    /// Returns the writer of a run's journal, from the beginning or from the mark of a checkpoint.
    pub fn new(files: &RunFiles, mark: Mark) -> Self {
        let sum = Hasher::new_with_initial_len(mark.checksum, mark.length);
        JournalWriter { files: files.clone(), stream: None, sum, mark, waiting: Vec::new(), events: 0 }
    }

    /// True if the journal has no entry.
    pub fn is_empty(&self) -> bool {
        self.mark.length == 0 && self.waiting.is_empty()
    }

    /// Adds an entry; returns its size in bytes.
    ///
    /// # Errors
    /// Buffered entries cannot be written, and exceed the size of the buffer.
    pub fn add(&mut self, entry: &Entry) -> Result<usize, OutputError> {
        let before = self.waiting.len();
        self.waiting.extend([0; 4]);
        // Writing to memory does not fail, and all of these types can be encoded.
        self.waiting = postcard::to_extend(entry, std::mem::take(&mut self.waiting)).unwrap_or_default();
        let size = self.waiting.len().saturating_sub(before);
        let length = u32::try_from(size.saturating_sub(4)).unwrap_or(u32::MAX);
        self.waiting.iter_mut().skip(before).zip(length.to_le_bytes()).for_each(|(byte, known)| *byte = known);
        self.events += u64::from(matches!(entry, Entry::Computed { .. } | Entry::WentBack { .. }));
        if self.waiting.len() < PIECE {
            return Ok(size);
        }
        match self.flush() {
            Err(error) if self.waiting.len() > MOST_WAITING => Err(error),
            // The next checkpoint reports the error if it persists.
            _ => Ok(size),
        }
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        let name = format!("{FOLDER}/{NAME}");
        let stream = match &mut self.stream {
            Some(stream) => stream,
            None if self.mark.length == 0 => self.stream.insert(self.files.stream(&name)?),
            None => {
                let mut stream = self.files.extend(&name)?;
                stream.truncate(self.mark.length)?;
                self.stream.insert(stream)
            }
        };
        stream.append(&self.waiting)?;
        self.sum.update(&self.waiting);
        self.mark.length += self.waiting.len() as u64;
        self.mark.checksum = self.sum.clone().finalize();
        self.mark.events += std::mem::take(&mut self.events);
        self.waiting.clear();
        Ok(())
    }

    /// Syncs all entries to disk; returns the position reached.
    ///
    /// # Errors
    /// The operating system refused; the entries stay buffered.
    pub fn secure(&mut self) -> Result<Mark, OutputError> {
        if !self.waiting.is_empty() {
            self.flush()?;
        }
        self.stream.as_ref().map_or(Ok(()), Stream::sync)?;
        Ok(self.mark)
    }
}

/// Reads a journal up to the mark of a checkpoint.
#[derive(Debug)]
pub struct JournalReader {
    file: BufReader<Take<File>>,
    next: Option<Entry>,
    /// Bytes of the last entry.
    content: Vec<u8>,
}

impl JournalReader {
    /// Opens the journal in the folder of a run.
    ///
    /// # Errors
    /// The operating system refused, or the file is no journal.
    pub fn open(run: &Path, mark: &Mark) -> io::Result<Self> {
        let path = run.join(FOLDER).join(NAME);
        let file = BufReader::with_capacity(BUFFER, files::open(&path)?.0.take(mark.length));
        let mut reader = JournalReader { file, next: None, content: Vec::new() };
        reader.advance()?;
        Ok(reader)
    }

    /// Next entry.
    pub fn peek(&self) -> Option<&Entry> {
        self.next.as_ref()
    }

    /// Takes the next entry.
    ///
    /// # Errors
    /// The bytes behind the entry are not a valid entry.
    pub fn take(&mut self) -> io::Result<Option<Entry>> {
        let entry = self.next.take();
        self.advance()?;
        Ok(entry)
    }

    fn advance(&mut self) -> io::Result<()> {
        let mut length = [0; 4];
        match self.file.read_exact(&mut length) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(()),
            outcome => outcome?,
        }
        let damaged = || io::Error::new(io::ErrorKind::InvalidData, "it is damaged");
        let length = u32::from_le_bytes(length) as usize;
        // A damaged length must not lead to an allocation beyond the size of the file.
        if length as u64 > self.file.get_ref().limit() + self.file.buffer().len() as u64 {
            return Err(damaged());
        }
        self.content.resize(length, 0);
        self.file.read_exact(&mut self.content)?;
        self.next = Some(postcard::from_bytes(&self.content).map_err(|_| damaged())?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::scratch;
    use super::*;

    fn computed(step: usize) -> Entry {
        let rows = vec![LedgerRow { step, time: 0.1, ..LedgerRow::default() }];
        Entry::Computed { simulation: 0, computation: Computation::Step(Some(2.0)), outcome: Outcome::Stepped(rows), tally: Box::default() }
    }

    fn read(run: &Path, mark: &Mark) -> Vec<Entry> {
        let mut reader = JournalReader::open(run, mark).unwrap();
        std::iter::from_fn(|| reader.take().unwrap()).collect()
    }

    #[test]
    fn entries_come_back_up_to_the_mark_and_what_is_behind_it_is_cut_off() {
        let (directory, files) = scratch("journal");
        let mut writer = JournalWriter::new(&files, Mark::default());
        for step in 0..3 {
            writer.add(&computed(step)).unwrap();
        }
        let mark = writer.secure().unwrap();
        assert_eq!(mark.events, 3);
        for step in 3..9 {
            writer.add(&computed(step)).unwrap();
        }
        let further = writer.secure().unwrap();
        assert_eq!((read(&directory, &mark), read(&directory, &further).len()), ((0..3).map(computed).collect(), 9));
        let mut again = JournalWriter::new(&files, mark);
        again.add(&computed(77)).unwrap();
        let other = again.secure().unwrap();
        assert_eq!(read(&directory, &other), [computed(0), computed(1), computed(2), computed(77)]);
        assert_eq!([mark, other].map(|mark| mark.complaint(&directory)), [None; 2]);
        assert!(further.complaint(&directory).unwrap().contains("cut off"));
        let place = directory.join(FOLDER).join(NAME);
        let mut bytes = std::fs::read(&place).unwrap();
        bytes[9] ^= 1;
        std::fs::write(&place, bytes).unwrap();
        assert!(mark.complaint(&directory).unwrap().contains("damaged"));
        std::fs::remove_file(&place).unwrap();
        assert!(mark.complaint(&directory).unwrap().contains("not there"));
    }
}
