//! Reading of the columns of a Parquet file, for its description and for comparison with the original table.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use parquet::column::reader::ColumnReader;
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::super::table::{Column, Table};
use super::error::ReadError;
use crate::machine::files;

/// Reads a table of numbers.
///
/// # Errors
/// A file that cannot be read, is no Parquet file, or has columns that are no numbers.
pub fn read_parquet(path: &Path) -> Result<Table, ReadError> {
    // The crate checks most of the content of a file, and panics on some errors.
    let read = catch_unwind(AssertUnwindSafe(|| read_columns(path)));
    read.unwrap_or_else(|_| Err(ReadError::damaged(path, "it contradicts itself")))
}

fn read_columns(path: &Path) -> Result<Table, ReadError> {
    let (file, _) = files::open(path).map_err(|error| ReadError::io(path, &error))?;
    let refused = |error: parquet::errors::ParquetError| ReadError {
        cause: Some(error.to_string()),
        ..ReadError::damaged(path, "it is no Parquet file that this program knows")
    };
    let reader = SerializedFileReader::new(file).map_err(refused)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let column = |index: usize| Column { name: schema.column(index).path().parts().join("."), values: Vec::new(), is_count: false };
    let mut columns: Vec<Column> = (0..schema.num_columns()).map(column).collect();
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(refused)?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        for (index, column) in columns.iter_mut().enumerate() {
            let most = schema.column(index).max_def_level();
            let mut levels = Vec::new();
            let (numbers, is_count): (Vec<f64>, bool) = match group.get_column_reader(index).map_err(refused)? {
                ColumnReader::Int64ColumnReader(mut typed) => {
                    let mut values = Vec::new();
                    typed.read_records(rows, Some(&mut levels), None, &mut values).map_err(refused)?;
                    (values.into_iter().map(|value| value as f64).collect(), true)
                }
                ColumnReader::DoubleColumnReader(mut typed) => {
                    let mut values = Vec::new();
                    typed.read_records(rows, Some(&mut levels), None, &mut values).map_err(refused)?;
                    (values, false)
                }
                _ => {
                    let what = format!("has a column `{}` that is no column of numbers", column.name);
                    return Err(ReadError::new(path, what, "name a file that `sim.table` or `conserva export` has written"));
                }
            };
            column.is_count = is_count;
            let mut numbers = numbers.into_iter();
            match most {
                0 => column.values.extend(numbers.map(Some)),
                _ => column.values.extend(levels.into_iter().map(|level| if level == most { numbers.next() } else { None })),
            }
        }
    }
    Ok(Table { columns })
}

#[cfg(test)]
mod tests {
    use super::super::super::parquet::parquet;
    use super::super::super::samples::scratch;
    use super::*;

    #[test]
    fn a_table_comes_back_bit_by_bit() {
        // More than one row group.
        let rows = (1 << 17) + 5;
        let odd = [0.1 + 0.2, -0.0, 5e-324, f64::INFINITY, f64::MAX, 1.0 / 3.0, f64::NAN];
        let table = Table {
            columns: vec![
                Column::of_history("step", (0..rows).map(|row| row as f64), true),
                Column::of_history("total", (0..rows).map(|row| odd[row % odd.len()]), true),
                Column::of_history("active", (0..rows).map(|row| if row == 0 { f64::NAN } else { 3.0 }), false),
                Column::of_history("tip.ux", (0..rows).map(|row| if row < 9 { f64::NAN } else { row as f64 * 0.1 }), false),
            ],
        };
        let (directory, files) = scratch("parquet");
        files.write("x.parquet", parquet(&table).unwrap()).unwrap();
        let read = read_parquet(&directory.join("x.parquet")).unwrap();
        let bits = |table: &Table| -> Vec<(String, bool, Vec<Option<u64>>)> {
            let of = |column: &Column| {
                let values = column.values.iter().map(|value| value.map(f64::to_bits)).collect();
                (column.name.clone(), column.is_count, values)
            };
            table.columns.iter().map(of).collect()
        };
        assert_eq!(bits(&read), bits(&table));
        assert_eq!(parquet(&table).unwrap(), parquet(&table).unwrap());
    }

    #[test]
    fn an_empty_table_and_a_damaged_file() {
        let (directory, files) = scratch("parquet damaged");
        let table = Table { columns: vec![Column::of_history("time", [], true)] };
        let bytes = parquet(&table).unwrap();
        files.write("x.parquet", &bytes).unwrap();
        assert_eq!(read_parquet(&directory.join("x.parquet")).unwrap().rows(), 0);
        for end in [0, 3, bytes.len() / 2, bytes.len() - 1] {
            files.write("x.parquet", &bytes[..end]).unwrap();
            let error = read_parquet(&directory.join("x.parquet")).unwrap_err();
            assert!(error.to_string().contains("is damaged"), "{error}");
        }
    }
}
