//! A table of texts that grows by rows, one for each point of a study, and is whole after each of them.
//!
//! A row is appended with one call to the operating system. One that brings a new column writes the file anew, in one piece.

use super::files::{OutputError, RunFiles, Stream};

/// A growing CSV file (RFC 4180 with line feeds).
#[derive(Debug)]
pub struct RowsCsv {
    files: RunFiles,
    name: String,
    columns: Vec<String>,
    /// The column that stays the last one.
    last: &'static str,
    rows: Vec<Vec<String>>,
    stream: Option<Stream>,
}

impl RowsCsv {
    /// A file without rows; nothing is written yet. `last` is the name of a column that stays behind all others.
    pub fn new(files: RunFiles, name: &str, last: &'static str) -> Self {
        RowsCsv { files, name: name.into(), columns: Vec::new(), last, rows: Vec::new(), stream: None }
    }

    /// Adds a row of named fields and the one of the last column.
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
            // Columns that came later are empty in earlier rows.
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

/// The text of a table of texts.
pub fn rows_csv<S: AsRef<[u8]>>(header: &[S], rows: &[Vec<S>]) -> Vec<u8> {
    std::iter::once(line(header)).chain(rows.iter().map(|row| line(row))).flatten().collect()
}

fn line<S: AsRef<[u8]>>(fields: &[S]) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new().from_writer(Vec::new());
    // Memory takes everything, and there is one record.
    let _ = writer.write_record(fields);
    writer.into_inner().unwrap_or_default()
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
    }
}
