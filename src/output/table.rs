//! A table: named columns of numbers, written as CSV or Parquet.
//!
//! Columns of counts stay whole numbers in both formats. A missing value (a force before the first step) is an empty field of a CSV file
//! and a null of a Parquet file; NaN and infinities are values. CSV has the fewest digits that read back as the same number, Parquet the
//! exact bits, so both return exactly the values that scripts read. Columns of a history with counts are known by their names
//! ([`is_count`]).

use std::fmt::Write as _;

use super::csv_text::line;

/// True if a column of a history holds counts, which are written without a fraction.
pub fn is_count(column: &str) -> bool {
    ["step", "newton_iterations", "halvings", "active", "factorizations"].contains(&column)
}

/// A named column; `None` where there is no value.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name of the column.
    pub name: String,
    /// Values by row.
    pub values: Vec<Option<f64>>,
    /// True if the values are whole numbers.
    pub is_count: bool,
}

impl Column {
    /// Returns a column of a history. In columns behind those of the ledger, NaN is a missing value, as in `history.csv`.
    pub fn of_history(name: &str, values: impl IntoIterator<Item = f64>, is_ledger: bool) -> Self {
        let values: Vec<Option<f64>> = values.into_iter().map(|value| Some(value).filter(|value| is_ledger || !value.is_nan())).collect();
        let is_count = is_count(name) && values.iter().flatten().all(|value| value.fract() == 0.0);
        Column { name: name.into(), values, is_count }
    }
}

/// Named column of texts.
#[derive(Clone, Debug, PartialEq)]
pub struct TextColumn {
    /// Name of the column.
    pub name: String,
    /// Texts of the column, row by row; `None` for missing texts.
    pub values: Vec<Option<String>>,
}

/// Columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The columns.
    pub columns: Vec<Column>,
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// Returns the column with a name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Returns the table as CSV (RFC 4180 with line feeds): a header and the rows.
    pub fn to_csv(&self) -> Vec<u8> {
        let mut text = line(&self.columns.iter().map(|column| &column.name).collect::<Vec<_>>());
        let mut row_text = String::new();
        for row in 0..self.rows() {
            row_text.clear();
            for (index, column) in self.columns.iter().enumerate() {
                let comma = if index > 0 { "," } else { "" };
                let _ = match column.values[row] {
                    Some(value) if column.is_count => write!(row_text, "{comma}{value}"),
                    Some(value) => write!(row_text, "{comma}{value:?}"),
                    // A single empty field is quoted, since the line would be empty otherwise.
                    None if self.columns.len() == 1 => write!(row_text, "\"\""),
                    None => write!(row_text, "{comma}"),
                };
            }
            row_text.push('\n');
            text.extend_from_slice(row_text.as_bytes());
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_whole_numbers_and_gaps_are_empty() {
        let table = Table {
            columns: vec![
                Column::of_history("step", [0.0, 1.0], true),
                Column::of_history("active", [f64::NAN, 3.0], false),
                Column::of_history("total", [f64::NAN, 0.1 + 0.2], true),
                Column::of_history("a,b", [-0.0, 1e300], false),
            ],
        };
        assert_eq!(String::from_utf8(table.to_csv()).unwrap(), "step,active,total,\"a,b\"\n0,,NaN,-0.0\n1,3,0.30000000000000004,1e300\n");
        assert_eq!((table.rows(), table.column("total").map(|column| column.is_count)), (2, Some(false)));
    }

    #[test]
    fn one_column_keeps_its_empty_rows() {
        let table = Table { columns: vec![Column::of_history("tip.ux", [f64::NAN, 1.0], false)] };
        assert_eq!(String::from_utf8(table.to_csv()).unwrap(), "tip.ux\n\"\"\n1.0\n");
    }
}
