//! `history.csv`: one row per accepted step, on the disk as soon as the step is accepted.
//!
//! Every row is written by one system call, so the file is complete up to the last accepted step however the program ends. One exception
//! remains: Linux may stop a write between two pages of the file when the process is killed at that moment, which leaves an incomplete last
//! line (2 of 200 kills of a program that only wrote rows, 4 microseconds each). Numbers have the fewest digits that read back as the same
//! value. A value that does not exist yet, such as that of a probe added later, is an empty field.

use std::fmt::Write as _;
use std::io::{self, BufRead, BufReader, Read as _, Seek, SeekFrom, Write as _};
use std::path::Path;

use crc32fast::Hasher;

use super::csv_text::line;
use super::files::{OutputError, RunFiles, Stream};
use super::table::is_count;
use crate::dynamics::{LedgerRow, Quantity, Rows};
use crate::machine::files;

/// Returns the header for a space dimension, with further columns at its end.
fn header(dimension: usize, extra: &[String]) -> Vec<u8> {
    let names = Quantity::names(&LedgerRow::columns(dimension));
    line(&names.into_iter().map(String::from).chain(extra.iter().cloned()).collect::<Vec<_>>())
}

/// Returns a row with the values of the further columns; NaN or missing ones become empty fields.
fn record(dimension: usize, row: &LedgerRow, extra: &[f64], extra_columns: usize) -> Vec<u8> {
    // Numbers need no quotes, so a row is written directly, without a string for each field.
    let mut text = String::with_capacity(20 * (20 + extra_columns));
    let own = Quantity::names(&LedgerRow::columns(dimension)).into_iter().map(|name| (row.column(name), is_count(name)));
    let further = (0..extra_columns).map(|index| (extra.get(index).copied().filter(|value| !value.is_nan()), false));
    for (value, is_count) in own.chain(further) {
        // Writing to memory does not fail.
        let _ = match value {
            Some(value) if is_count => write!(text, "{value},"),
            Some(value) => write!(text, "{value:?},"),
            None => write!(text, ","),
        };
    }
    text.pop();
    text.push('\n');
    text.into_bytes()
}

/// Name of the file.
const NAME: &str = "history.csv";

/// Number of rows between recorded positions in the file.
const MARKED: usize = 256;
/// Number of bytes read at once.
const PIECE: usize = 1 << 16;

/// File `history.csv`, to which rows are appended during the run.
#[derive(Debug)]
pub struct HistoryCsv {
    files: RunFiles,
    dimension: usize,
    extra: Vec<String>,
    /// Open file; `None` while the rows are those of an earlier process, whose file is unchanged until then.
    stream: Option<Stream>,
    rows: usize,
    /// Row numbers with the length of the file up to these, ascending; the header first.
    marks: Vec<(usize, u64)>,
    /// CRC-32 of the file; `None` after rows were dropped.
    sum: Option<Hasher>,
}

impl HistoryCsv {
    /// Starts the file with its header: the columns of [`LedgerRow::columns`], then `extra`.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn create(files: &RunFiles, dimension: usize, extra: Vec<String>) -> Result<Self, OutputError> {
        let mut history = HistoryCsv::recalled(files, dimension, extra);
        history.begin::<[LedgerRow]>(&[], |_| Vec::new())?;
        Ok(history)
    }

    /// Counts the rows of an earlier process; no row is written before [`Self::begin`].
    pub fn recalled(files: &RunFiles, dimension: usize, extra: Vec<String>) -> Self {
        HistoryCsv { files: files.clone(), dimension, extra, stream: None, rows: 0, marks: vec![(0, 0)], sum: None }
    }

    /// Replaces the file by one with the given rows and their further values, atomically.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn begin<R: Rows + ?Sized>(&mut self, rows: &R, further: impl Fn(&LedgerRow) -> Vec<f64>) -> Result<(), OutputError> {
        let header = header(self.dimension, &self.extra);
        let (mut count, mut marks, mut sum) = (0, vec![(0, header.len() as u64)], Hasher::new());
        let stream = self.files.filled(NAME, |file| {
            file.write_all(&header)?;
            sum.update(&header);
            let (mut length, mut written) = (header.len() as u64, Ok(()));
            rows.visit(0, &mut |row| {
                let line = record(self.dimension, row, &further(row), self.extra.len());
                written = std::mem::replace(&mut written, Ok(())).and_then(|()| file.write_all(&line));
                sum.update(&line);
                length += line.len() as u64;
                count += 1;
                mark(&mut marks, count, length);
            });
            written
        })?;
        (self.stream, self.rows, self.marks, self.sum) = (Some(stream), count, marks, Some(sum));
        Ok(())
    }

    /// Continues the file of an earlier process up to the length and checksum of a checkpoint. Returns false if its columns or its last row
    /// differ.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn take_over(&mut self, (length, checksum): (u64, u32), last: &LedgerRow, further: &[f64]) -> Result<bool, OutputError> {
        let place = self.files.directory().join(NAME);
        let (header, last) = (header(self.dimension, &self.extra), record(self.dimension, last, further, self.extra.len()));
        let is_same = |from: u64, bytes: &[u8]| piece(&place, from, bytes.len()).is_ok_and(|found| found == bytes);
        let is_ours = super::counted::checksum(&place, length).is_ok_and(|(sum, found)| found == length && sum == checksum)
            && is_same(0, &header)
            && length.checked_sub(last.len() as u64).is_some_and(|from| is_same(from, &last));
        if !is_ours {
            return Ok(false);
        }
        let mut stream = self.files.extend(NAME)?;
        stream.truncate(length)?;
        (self.stream, self.marks) = (Some(stream), vec![(0, header.len() as u64)]);
        self.sum = Some(Hasher::new_with_initial_len(checksum, length));
        Ok(true)
    }

    /// Length and CRC-32 of the file; `None` while its rows are those of an earlier process.
    pub fn digest(&mut self) -> Option<(u64, u32)> {
        let stream = self.stream.as_ref()?;
        if self.sum.is_none() {
            let (sum, length) = super::counted::checksum(stream.path(), stream.length()).ok()?;
            self.sum = (length == stream.length()).then(|| Hasher::new_with_initial_len(sum, length));
        }
        Some((stream.length(), self.sum.clone()?.finalize()))
    }

    /// True while no row is written because the file still holds the rows of an interrupted program.
    pub fn is_recalled(&self) -> bool {
        self.stream.is_none()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Appends the row of an accepted step and the values of the further columns; missing ones and NaN become empty fields.
    ///
    /// # Errors
    /// The operating system refused; the file then ends with the row before.
    pub fn append(&mut self, row: &LedgerRow, extra: &[f64]) -> Result<(), OutputError> {
        if let Some(stream) = &mut self.stream {
            let line = record(self.dimension, row, extra, self.extra.len());
            stream.append(&line)?;
            self.sum.iter_mut().for_each(|sum| sum.update(&line));
            mark(&mut self.marks, self.rows + 1, stream.length());
        }
        self.rows += 1;
        Ok(())
    }

    /// Checks that the file is still at its path.
    ///
    /// # Errors
    /// The file was removed or replaced.
    pub fn verify(&self) -> Result<(), OutputError> {
        self.stream.as_ref().map_or(Ok(()), Stream::verify)
    }

    /// Drops all rows behind the first `rows`, when a simulation goes back.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn keep(&mut self, rows: usize) -> Result<(), OutputError> {
        if rows >= self.rows {
            return Ok(());
        }
        self.marks.truncate(self.marks.partition_point(|(marked, _)| *marked <= rows));
        if let Some(stream) = &mut self.stream {
            let path = stream.path().to_path_buf();
            let end = end_of(&path, &mut self.marks, rows).map_err(|source| OutputError::Write { path, source })?;
            stream.truncate(end)?;
            self.sum = None;
        }
        self.rows = rows;
        Ok(())
    }

    /// Adds columns, with empty fields in existing rows. The file is rewritten.
    ///
    /// # Errors
    /// The file cannot be read back, or the operating system refused.
    pub fn add_columns(&mut self, names: &[String]) -> Result<(), OutputError> {
        let extra: Vec<String> = self.extra.iter().chain(names).cloned().collect();
        let Some(stream) = &self.stream else {
            self.extra = extra;
            return Ok(());
        };
        let path = stream.path().to_path_buf();
        let failed = |source| OutputError::Write { path: path.clone(), source };
        let mut old = BufReader::with_capacity(PIECE, files::open(&path).map_err(failed)?.0);
        old.seek(SeekFrom::Start(self.marks[0].1)).map_err(failed)?;
        let header = header(self.dimension, &extra);
        let (mut length, mut marks) = (header.len() as u64, vec![(0, header.len() as u64)]);
        // A quoted name in the header may contain a line end, rows never do.
        let stream = self.files.filled(NAME, |file| {
            file.write_all(&header)?;
            let mut line = Vec::new();
            for row in 1..=self.rows {
                line.clear();
                old.read_until(b'\n', &mut line)?;
                line.pop();
                line.extend(names.iter().map(|_| b','));
                line.push(b'\n');
                file.write_all(&line)?;
                length += line.len() as u64;
                mark(&mut marks, row, length);
            }
            Ok(())
        })?;
        (self.stream, self.extra, self.marks, self.sum) = (Some(stream), extra, marks, None);
        Ok(())
    }
}

/// Records the length of the file up to some of the rows.
fn mark(marks: &mut Vec<(usize, u64)>, rows: usize, length: u64) {
    if rows.is_multiple_of(MARKED) {
        marks.push((rows, length));
    }
}

/// Reads `count` bytes of a file.
fn piece(path: &Path, from: u64, count: usize) -> io::Result<Vec<u8>> {
    let mut file = files::open(path)?.0;
    file.seek(SeekFrom::Start(from))?;
    let mut bytes = vec![0; count];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Returns the length of a file up to a row, counted from the last recorded position.
fn end_of(path: &Path, marks: &mut Vec<(usize, u64)>, rows: usize) -> io::Result<u64> {
    let (mut count, mut end) = marks.last().copied().unwrap_or_default();
    if count == rows {
        return Ok(end);
    }
    let mut file = BufReader::with_capacity(PIECE, files::open(path)?.0);
    file.seek(SeekFrom::Start(end))?;
    let mut line = Vec::new();
    while count < rows {
        line.clear();
        if file.read_until(b'\n', &mut line)? == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        end += line.len() as u64;
        count += 1;
        mark(marks, count, end);
    }
    Ok(end)
}

#[cfg(test)]
mod tests {
    use super::super::samples::{rows, scratch};
    use super::*;

    fn read(path: &std::path::Path) -> (Vec<String>, Vec<Vec<String>>) {
        let mut reader = csv::Reader::from_path(path).unwrap();
        let text = |record: &csv::StringRecord| record.iter().map(String::from).collect::<Vec<_>>();
        (text(reader.headers().unwrap()), reader.records().map(|record| text(&record.unwrap())).collect())
    }

    #[test]
    fn header_has_the_columns_of_the_language() {
        let expected = "step,time,dt,kinetic,strain,potential,total,load_work,contact_work,energy_defect,momentum_x,momentum_y,\
                        angular_momentum,momentum_defect,angular_momentum_defect,newton_iterations,halvings,active,max_penetration,reserve,\
                        dissipation,factorizations,friction_work,tip.ux,\"a, \"\"b\"\"\"\n";
        assert_eq!(String::from_utf8(header(2, &["tip.ux".into(), "a, \"b\"".into()])).unwrap(), expected);
    }

    #[test]
    fn every_number_reads_back_as_itself() {
        let (directory, files) = scratch("csv numbers");
        let odd = [0.1 + 0.2, 1.0 / 3.0, -0.0, 5e-324, f64::MAX, 1e-7, 123456789.125, 1e22, f64::INFINITY];
        let mut history = HistoryCsv::create(&files, 3, vec!["tip.ux".into()]).unwrap();
        for (step, &value) in odd.iter().enumerate() {
            let row = LedgerRow { step, kinetic: value, momentum: [value; 3], newton_iterations: 5, ..LedgerRow::default() };
            history.append(&row, &[-value]).unwrap();
        }
        let (names, records) = read(&directory.join("history.csv"));
        assert_eq!(records.len(), odd.len());
        for (record, &value) in records.iter().zip(&odd) {
            let field = |name: &str| &record[names.iter().position(|other| other == name).unwrap()];
            for (name, expected) in [("kinetic", value), ("momentum_z", value), ("tip.ux", -value)] {
                assert_eq!(field(name).parse::<f64>().unwrap().to_bits(), expected.to_bits(), "{name}");
            }
            assert_eq!(field("newton_iterations"), "5");
        }
    }

    #[test]
    fn the_file_is_whole_after_every_row_without_being_closed() {
        let (directory, files) = scratch("csv open");
        let mut history = HistoryCsv::create(&files, 2, vec![]).unwrap();
        for row in rows() {
            history.append(&row, &[]).unwrap();
            let text = std::fs::read_to_string(directory.join("history.csv")).unwrap();
            assert!(text.ends_with('\n') && text.lines().count() == row.step + 2);
        }
        std::mem::forget(history);
        assert_eq!(read(&directory.join("history.csv")).1.len(), 401);
    }

    #[test]
    fn columns_can_be_added_and_rows_dropped() {
        let (directory, files) = scratch("csv columns");
        let mut history = HistoryCsv::create(&files, 2, vec!["two\nlines".into()]).unwrap();
        for row in &rows()[..5] {
            history.append(row, &[1.5]).unwrap();
        }
        history.keep(3).unwrap();
        history.add_columns(&["late".into(), "later".into()]).unwrap();
        history.append(&rows()[3], &[1.5, 2.5]).unwrap();
        history.append(&rows()[4], &[f64::NAN, 2.5, 3.5]).unwrap();
        history.keep(9).unwrap();
        let (names, records) = read(&directory.join("history.csv"));
        assert_eq!(names[names.len() - 3..], ["two\nlines", "late", "later"]);
        let ends: Vec<_> = records.iter().map(|record| record[record.len() - 3..].join("|")).collect();
        assert_eq!(ends, ["1.5||", "1.5||", "1.5||", "1.5|2.5|", "|2.5|3.5"]);
        assert_eq!(records.iter().map(|record| record[0].as_str()).collect::<Vec<_>>(), ["0", "1", "2", "3", "4"]);
        assert_eq!(history.rows(), 5);
    }

    #[test]
    fn a_file_is_taken_over_up_to_where_a_checkpoint_was() {
        let (directory, files) = scratch("csv taken over");
        let all = rows();
        let mut history = HistoryCsv::create(&files, 2, vec!["two\nlines".into()]).unwrap();
        all[..300].iter().for_each(|row| history.append(row, &[1.5]).unwrap());
        let digest = history.digest().unwrap();
        history.keep(257).unwrap();
        all[257..300].iter().for_each(|row| history.append(row, &[1.5]).unwrap());
        assert_eq!(history.digest().unwrap(), digest, "counted again after rows were dropped");
        all[300..].iter().for_each(|row| history.append(row, &[1.5]).unwrap());
        let again = |extra: &str| {
            let mut again = HistoryCsv::recalled(&files, 2, vec![extra.into()]);
            all[..300].iter().for_each(|row| again.append(row, &[]).unwrap());
            again
        };
        assert!(!again("other").take_over(digest, &all[299], &[1.5]).unwrap());
        assert!(!again("two\nlines").take_over(digest, &all[298], &[1.5]).unwrap());
        assert!(!again("two\nlines").take_over((digest.0, 7), &all[299], &[1.5]).unwrap());
        let mut again = again("two\nlines");
        assert!(again.take_over(digest, &all[299], &[1.5]).unwrap());
        again.keep(299).unwrap();
        again.append(&all[299], &[1.5]).unwrap();
        assert_eq!((again.digest().unwrap(), again.rows()), (digest, 300));
        assert_eq!(read(&directory.join("history.csv")).1.len(), 300);
    }
}
