//! Reading of `history.csv` and other tables of numbers.
//!
//! A killed run may leave an incomplete last line (`output/history_csv.rs`), which is left out and reported.

use std::path::Path;

use super::super::csv_text::meant;
use super::super::table::{Column, Table, is_count};
use super::error::{ReadError, bytes_of};

/// Table read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct TableRead {
    /// Columns read from the file.
    pub table: Table,
    /// True if an incomplete last line was left out.
    pub is_cut: bool,
}

/// Reads a table of numbers with a header.
///
/// # Errors
/// A file that cannot be read; no header; a line with another number of fields; a field that is no number.
pub fn read_table(path: &Path) -> Result<TableRead, ReadError> {
    let bytes = bytes_of(path)?;
    table_of(path, &bytes)
}

/// Reads a table from the bytes of a file; `path` is for messages.
///
/// # Errors
/// As [`read_table`].
pub fn table_of(path: &Path, bytes: &[u8]) -> Result<TableRead, ReadError> {
    let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
    let is_cut = whole < bytes.len();
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(&bytes[..whole]);
    let text = |error: &csv::Error| match error.position() {
        Some(position) => ReadError::damaged(path, format!("line {} is not text", position.line())),
        None => ReadError::damaged(path, "it is not text"),
    };
    let header = reader.headers().map_err(|error| text(&error))?.clone();
    if header.is_empty() {
        return Err(ReadError::new(path, "is empty", "run the script again: its first line names the columns"));
    }
    let mut values: Vec<Vec<Option<f64>>> = vec![Vec::new(); header.len()];
    for record in reader.records() {
        let record = record.map_err(|error| text(&error))?;
        let line = record.position().map_or(0, csv::Position::line);
        if record.len() != header.len() {
            let (found, named) = (record.len(), header.len());
            return Err(ReadError::damaged(path, format!("line {line} has {found} fields, the header names {named} columns")));
        }
        for ((field, name), values) in record.iter().zip(&header).zip(&mut values) {
            let number = || field.trim().parse::<f64>();
            values.push(match field {
                "" => None,
                _ => Some(number().map_err(|_| {
                    let shown: String = field.chars().take(40).collect();
                    ReadError::damaged(path, format!("line {line} has \"{shown}\" in column `{name}`, which is no number"))
                })?),
            });
        }
    }
    let column = |(name, values): (&str, Vec<Option<f64>>)| {
        let name = meant(name);
        let is_count = is_count(name) && values.iter().flatten().all(|value| value.fract() == 0.0);
        Column { name: name.into(), values, is_count }
    };
    Ok(TableRead { table: Table { columns: header.iter().zip(values).map(column).collect() }, is_cut })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<TableRead, String> {
        table_of(Path::new("history.csv"), text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_written_reads_back() {
        let table = Table {
            columns: vec![
                Column::of_history("step", [0.0, 1.0, 2.0], true),
                Column::of_history("total", [0.1 + 0.2, -0.0, f64::INFINITY], true),
                Column::of_history("a \"b\",\nc", [f64::NAN, 2.0, 3.0], false),
            ],
        };
        let read = table_of(Path::new("x"), &table.to_csv()).unwrap();
        assert!(!read.is_cut);
        assert_eq!(read.table, table);
        assert_eq!(read.table.columns[1].values[1].map(f64::to_bits), Some((-0.0f64).to_bits()));
    }

    #[test]
    fn a_line_that_was_cut_is_left_out() {
        let found = read("step,total\n0,1.5\n1,1.").unwrap();
        assert!(found.is_cut);
        assert_eq!(found.table.rows(), 1);
        assert!(read("step,total").unwrap_err().contains("is empty"));
    }

    #[test]
    fn defects_have_a_place() {
        assert_eq!(read("").unwrap_err(), "\"history.csv\" is empty");
        let wrong = read("step,total\n0,1.0\n1,abc\n").unwrap_err();
        assert_eq!(wrong, "\"history.csv\" is damaged: line 3 has \"abc\" in column `total`, which is no number");
        let short = read("step,total\n0\n").unwrap_err();
        assert_eq!(short, "\"history.csv\" is damaged: line 2 has 1 fields, the header names 2 columns");
        let binary = table_of(Path::new("x"), b"a,b\n\xff\xfe,1\n").unwrap_err().to_string();
        assert_eq!(binary, "\"x\" is damaged: line 2 is not text");
    }
}
