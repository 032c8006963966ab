//! A growing table of texts, a row for each point of a study; the file is complete after each row.
//!
//! A row is appended by one system call. A row with a new column rewrites the file atomically.

use std::path::Path;

use super::csv_text::{line, meant};
use super::files::{OutputError, RunFiles, Stream};
use super::reading::error::{ReadError, bytes_of};
use super::table::{Column, Table};

/// A growing CSV file (RFC 4180 with line feeds).
#[derive(Debug)]
pub struct RowsCsv {
    files: RunFiles,
    name: String,
    columns: Vec<String>,
    /// Name of the column that stays last.
    last: &'static str,
    rows: Vec<Vec<String>>,
    stream: Option<Stream>,
}

impl RowsCsv {
    /// Returns a file without rows; no file is written yet. `last` is the name of the column that stays last.
    pub fn new(files: RunFiles, name: &str, last: &'static str) -> Self {
        RowsCsv { files, name: name.into(), columns: Vec::new(), last, rows: Vec::new(), stream: None }
    }

    /// Adds a row of named fields and the field of the last column.
    ///
    /// # Errors
    /// The operating system refused, or the name leads outside the directory of the run.
    pub fn add(&mut self, fields: &[(String, String)], last: &str) -> Result<(), OutputError> {
        let known = self.columns.len();
        for (name, _) in fields {
            if !self.columns.contains(name) {
                self.columns.push(name.clone());
            }
        }
        let field = |name: &String| fields.iter().find(|(known, _)| known == name).map(|(_, field)| field.clone()).unwrap_or_default();
        let mut row: Vec<String> = self.columns.iter().map(field).collect();
        row.push(last.into());
        let line = line(&row);
        self.rows.push(row);
        match &mut self.stream {
            Some(stream) if self.columns.len() == known => stream.append(&line),
            _ => self.rewrite(),
        }
    }

    fn rewrite(&mut self) -> Result<(), OutputError> {
        let header = self.columns.iter().map(String::as_str).chain([self.last]);
        let mut bytes = line(&header.collect::<Vec<_>>());
        for row in &self.rows {
            // Columns that were added later are empty in earlier rows.
            let (last, fields) = row.split_last().map_or(("", &[][..]), |(last, fields)| (last.as_str(), fields));
            let later = std::iter::repeat_n("", self.columns.len() - fields.len());
            bytes.extend(line(&fields.iter().map(String::as_str).chain(later).chain([last]).collect::<Vec<_>>()));
        }
        self.stream = None;
        self.files.write(&self.name, bytes)?;
        self.stream = Some(self.files.extend(&self.name)?);
        Ok(())
    }
}

/// Returns a table of texts as CSV: the header, then the rows.
pub fn rows_csv<S: AsRef<str>>(header: &[S], rows: &[Vec<S>]) -> Vec<u8> {
    std::iter::once(line(header)).chain(rows.iter().map(|row| line(row))).flatten().collect()
}

/// Reads the rows of a study: columns of numbers (other texts are missing values), and the fields of the last column.
///
/// # Errors
/// A file that cannot be read, is not text, or has a line with another number of fields.
pub fn read_rows(path: &Path) -> Result<(Table, Vec<String>), ReadError> {
    let bytes = bytes_of(path)?;
    let mut reader = csv::Reader::from_reader(&bytes[..]);
    let damaged = |error: csv::Error| {
        let line = error.position().map(|position| format!("line {} ", position.line())).unwrap_or_default();
        ReadError::damaged(path, format!("{line}is no row of it"))
    };
    let mut names: Vec<String> = reader.headers().map_err(damaged)?.iter().map(|name| meant(name).into()).collect();
    names.pop();
    let (mut columns, mut last) = (vec![Vec::new(); names.len()], Vec::new());
    for record in reader.records() {
        let record = record.map_err(damaged)?;
        columns.iter_mut().zip(&record).for_each(|(column, field)| column.push(field.parse::<f64>().ok()));
        last.push(meant(record.get(names.len()).unwrap_or_default()).to_string());
    }
    let column = |(name, values)| Column { name, values, is_count: false };
    Ok((Table { columns: names.into_iter().zip(columns).map(column).collect() }, last))
}

#[cfg(test)]
mod tests {
    use super::super::samples::scratch;
    use super::*;

    #[test]
    fn rows_are_in_the_file_at_once_and_a_new_column_stands_before_the_last() {
        let (directory, files) = scratch("rows");
        let mut csv = RowsCsv::new(files, "studies/sweep.csv", "failure");
        let read = || std::fs::read_to_string(directory.join("studies/sweep.csv")).unwrap();
        let field = |name: &str, value: &str| (name.to_string(), value.to_string());
        csv.add(&[field("dt", "0.1")], "it broke, \"badly\"").unwrap();
        assert_eq!(read(), "dt,failure\n0.1,\"it broke, \"\"badly\"\"\"\n");
        csv.add(&[field("dt", "0.2"), field("value", "3")], "").unwrap();
        csv.add(&[field("value", "4"), field("dt", "0.3")], "").unwrap();
        assert_eq!(read(), "dt,value,failure\n0.1,,\"it broke, \"\"badly\"\"\"\n0.2,3,\n0.3,4,\n");
        let (table, last) = read_rows(&directory.join("studies/sweep.csv")).unwrap();
        assert_eq!(table.column("value").unwrap().values, [None, Some(3.0), Some(4.0)]);
        assert_eq!(last, ["it broke, \"badly\"", "", ""]);
        std::fs::write(directory.join("cut.csv"), "dt,failure\n0.1\n").unwrap();
        assert!(read_rows(&directory.join("cut.csv")).unwrap_err().to_string().contains("line 2"));
    }
}
