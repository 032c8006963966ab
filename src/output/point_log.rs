//! Results of a study's points, kept beside the checkpoints of a run, so that a resumed run does not compute them again.
//!
//! An append-only file of records: length and CRC-32 (little endian), then the content. An incomplete record of a killed process is
//! removed.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::checkpoint::POINTS;
use super::counted::FOLDER;
use super::files::{OutputError, RunFiles, Stream};

/// Size of the header of a record `[bytes]`.
const HEADER: usize = 8;

/// Append-only file of records.
#[derive(Debug)]
pub struct PointLog(Stream);

impl PointLog {
    /// Creates an empty file, in place of an older one.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn create(files: &RunFiles, study: &str) -> Result<Self, OutputError> {
        files.stream(&path(study)).map(PointLog)
    }

    /// Opens the file of an earlier process and returns its records; creates a new file if there is none.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn reopen<T: DeserializeOwned>(files: &RunFiles, study: &str) -> Result<(Self, Vec<T>), OutputError> {
        let place = files.place(&path(study))?;
        let Ok(bytes) = std::fs::read(&place) else { return Ok((PointLog::create(files, study)?, Vec::new())) };
        let (mut records, mut whole) = (Vec::new(), 0);
        while let Some(record) = record(&bytes[whole..]) {
            // A record of another program version is computed again.
            records.extend(postcard::from_bytes(record).ok());
            whole += HEADER + record.len();
        }
        let mut stream = files.extend(&path(study))?;
        stream.truncate(whole as u64)?;
        Ok((PointLog(stream), records))
    }

    /// Adds a record.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn append(&mut self, record: &impl Serialize) -> Result<(), OutputError> {
        let content = encoded(record);
        let length = u32::try_from(content.len()).unwrap_or(u32::MAX);
        let header = length.to_le_bytes().into_iter().chain(crc32fast::hash(&content).to_le_bytes());
        self.0.append(&header.chain(content).collect::<Vec<u8>>())
    }
}

/// Encodes a value; bitwise equal values give equal bytes.
pub fn encoded(value: &(impl Serialize + ?Sized)) -> Vec<u8> {
    // Writing to memory does not fail, and only values of known length are encoded.
    postcard::to_allocvec(value).unwrap_or_default()
}

/// Decodes bytes written by [`encoded`]; `None` for other bytes.
pub fn decoded<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}

fn path(study: &str) -> String {
    format!("{FOLDER}/{study}.{POINTS}")
}

/// Returns the first record of some bytes if complete.
fn record(bytes: &[u8]) -> Option<&[u8]> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    let (checksum, rest) = rest.split_first_chunk::<4>()?;
    let content = rest.get(..u32::from_le_bytes(*length) as usize)?;
    (crc32fast::hash(content) == u32::from_le_bytes(*checksum)).then_some(content)
}

#[cfg(test)]
mod tests {
    use super::super::samples::scratch;
    use super::*;

    #[test]
    fn whole_records_come_back_whatever_was_left_behind_them() {
        let (directory, files) = scratch("points");
        let mut log = PointLog::create(&files, "sweep").unwrap();
        for text in ["first", "", "third"] {
            log.append(&text).unwrap();
        }
        let place = directory.join("checkpoints/sweep.points");
        let bytes = std::fs::read(&place).unwrap();
        // A text is encoded as its length and its letters.
        let ends = [14, 23, 37];
        assert_eq!(bytes.len(), ends[2]);
        for cut in 0..=bytes.len() {
            std::fs::write(&place, &bytes[..cut]).unwrap();
            let (mut log, records) = PointLog::reopen::<String>(&files, "sweep").unwrap();
            let count = ends.iter().filter(|&&end| end <= cut).count();
            assert_eq!(records, ["first", "", "third"][..count], "cut at {cut}");
            log.append(&"next").unwrap();
            assert_eq!(PointLog::reopen::<String>(&files, "sweep").unwrap().1.len(), count + 1);
        }
        let mut damaged = bytes.clone();
        damaged[ends[1] + HEADER + 2] ^= 1;
        std::fs::write(&place, damaged).unwrap();
        assert_eq!(PointLog::reopen::<String>(&files, "sweep").unwrap().1.len(), 2);
        assert!(PointLog::reopen::<String>(&files, "another").unwrap().1.is_empty());
    }
}
