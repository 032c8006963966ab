//! `history.csv`: one row per accepted step, on the disk as soon as the step is accepted.
//!
//! Every row is one call to the operating system, so the file is whole up to the last accepted step however the program ends. One
//! exception cannot be closed from here: Linux may stop a write between two pages of the file when the process is killed in that very
//! microsecond, which leaves a last line without its end (2 of 200 kills of a program that did nothing but write rows, at 4 microseconds
//! each). Numbers have the fewest digits that read back as the same value. A value that does not exist yet, such as
//! that of a probe added later, is an empty field.

use std::fmt::Write as _;
use std::io::Write as _;

use super::csv_text::line;
use super::files::{OutputError, RunFiles, Stream};
use super::table::is_count;
use crate::dynamics::LedgerRow;
use crate::machine::files::read;

/// The header for a space dimension with further columns at its end.
fn header(dimension: usize, extra: &[String]) -> Vec<u8> {
    let names = LedgerRow::columns(dimension);
    line(&names.into_iter().map(String::from).chain(extra.iter().cloned()).collect::<Vec<_>>())
}

/// A row with the values of the further columns; NaN there, and what is missing, becomes an empty field.
fn record(dimension: usize, row: &LedgerRow, extra: &[f64], extra_columns: usize) -> Vec<u8> {
    // Numbers need no quotes, so a row is written without a writer of records and a string for each field.
    let mut text = String::with_capacity(20 * (20 + extra_columns));
    let own = LedgerRow::columns(dimension).into_iter().map(|name| (row.column(name), is_count(name)));
    let further = (0..extra_columns).map(|index| (extra.get(index).copied().filter(|value| !value.is_nan()), false));
    for (value, is_count) in own.chain(further) {
        // Memory takes everything.
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

/// Its name.
const NAME: &str = "history.csv";

/// The growing file.
#[derive(Debug)]
pub struct HistoryCsv {
    files: RunFiles,
    dimension: usize,
    extra: Vec<String>,
    /// None while its rows are those of an earlier program: the file that this one has left stays as it is until then.
    stream: Option<Stream>,
    /// Length of the file after the header and after each row.
    ends: Vec<u64>,
}

impl HistoryCsv {
    /// Starts the file with its header: the columns of [`LedgerRow::columns`], then `extra`.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn create(files: &RunFiles, dimension: usize, extra: Vec<String>) -> Result<Self, OutputError> {
        let mut history = HistoryCsv::recalled(files, dimension, extra);
        history.begin([])?;
        Ok(history)
    }

    /// Counts the rows of an earlier program; nothing is written before [`Self::begin`].
    pub(crate) fn recalled(files: &RunFiles, dimension: usize, extra: Vec<String>) -> Self {
        HistoryCsv { files: files.clone(), dimension, extra, stream: None, ends: vec![0] }
    }

    /// Puts a file with these rows and their further values in the place of the one that is there, in one piece.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn begin<'a>(&mut self, rows: impl IntoIterator<Item = (&'a LedgerRow, Vec<f64>)>) -> Result<(), OutputError> {
        let (header, mut ends) = (header(self.dimension, &self.extra), Vec::new());
        let stream = self.files.filled(NAME, |file| {
            file.write_all(&header)?;
            ends.push(header.len() as u64);
            let mut length = header.len() as u64;
            for (row, further) in rows {
                let line = record(self.dimension, row, &further, self.extra.len());
                file.write_all(&line)?;
                length += line.len() as u64;
                ends.push(length);
            }
            Ok(())
        })?;
        (self.stream, self.ends) = (Some(stream), ends);
        Ok(())
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.ends.len() - 1
    }

    /// Appends the row of an accepted step and the values of the further columns; missing ones and NaN become empty fields.
    ///
    /// # Errors
    /// The operating system refused; the file then ends with the row before.
    pub fn append(&mut self, row: &LedgerRow, extra: &[f64]) -> Result<(), OutputError> {
        if let Some(stream) = &mut self.stream {
            stream.append(&record(self.dimension, row, extra, self.extra.len()))?;
        }
        self.ends.push(self.stream.as_ref().map_or(0, Stream::length));
        Ok(())
    }

    /// Makes sure that the file is still at its place.
    ///
    /// # Errors
    /// It was removed or replaced.
    pub fn verify(&self) -> Result<(), OutputError> {
        self.stream.as_ref().map_or(Ok(()), Stream::verify)
    }

    /// Drops all but the first `rows` rows, when a simulation goes back.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn keep(&mut self, rows: usize) -> Result<(), OutputError> {
        self.ends.truncate(rows + 1);
        let end = self.ends[self.ends.len() - 1];
        self.stream.as_mut().map_or(Ok(()), |stream| stream.truncate(end))
    }

    /// Adds columns to a file that has rows already; these get empty fields. Costs a rewrite of the file.
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
        let old = read(&path).map_err(|source| OutputError::Write { path, source })?;
        let mut text = header(self.dimension, &extra);
        let mut ends = vec![text.len() as u64];
        for bounds in self.ends.windows(2) {
            // Cut at the recorded lengths: a quoted name may hold a line end, a row never does.
            let row = old.get(bounds[0] as usize..(bounds[1] - 1) as usize).unwrap_or_default();
            text.extend_from_slice(row);
            text.extend(names.iter().map(|_| b','));
            text.push(b'\n');
            ends.push(text.len() as u64);
        }
        self.stream = Some(self.files.filled(NAME, |file| file.write_all(&text))?);
        (self.extra, self.ends) = (extra, ends);
        Ok(())
    }
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
}
