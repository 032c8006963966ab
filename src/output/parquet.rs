//! Parquet: a table as pandas, Polars, DuckDB, Arrow and R read it, types and missing values included.
//!
//! One row group for each [`GROUP`] rows, `INT64` for counts and `DOUBLE` for the rest, all optional; plain or dictionary pages without
//! compression, since digits of a simulation hardly compress. Nothing depends on the clock, so equal tables give equal bytes.
//! (Apache Parquet format 2, crate `parquet` without Arrow.)

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Repetition, Type as PhysicalType};
use parquet::column::writer::ColumnWriter;
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::table::{Column, Table};

/// Rows of a row group: readers take one at a time.
const GROUP: usize = 1 << 17;

/// The bytes of the file.
///
/// # Errors
/// What the format refuses, in words; no table of numbers with columns of different names is known to be refused.
pub fn parquet(table: &Table) -> std::result::Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    match write(table, &mut bytes) {
        Ok(()) => Ok(bytes),
        Err(error) => Err(error.to_string()),
    }
}

fn write(table: &Table, bytes: &mut Vec<u8>) -> Result<()> {
    let field = |column: &Column| {
        let kind = if column.is_count { PhysicalType::INT64 } else { PhysicalType::DOUBLE };
        Type::primitive_type_builder(&column.name, kind).with_repetition(Repetition::OPTIONAL).build().map(Arc::new)
    };
    let fields = table.columns.iter().map(field).collect::<Result<Vec<_>>>()?;
    let schema = Arc::new(Type::group_type_builder("table").with_fields(fields).build()?);
    let properties = WriterProperties::builder().set_created_by(concat!("conserva ", env!("CARGO_PKG_VERSION")).into()).build();
    let mut writer = SerializedFileWriter::new(bytes, schema, Arc::new(properties))?;
    for start in (0..table.rows()).step_by(GROUP) {
        write_group(table, start, &mut writer)?;
    }
    writer.close().map(drop)
}

fn write_group<W: Write + Send>(table: &Table, start: usize, writer: &mut SerializedFileWriter<W>) -> Result<()> {
    let mut group = writer.next_row_group()?;
    for column in &table.columns {
        let values = &column.values[start..column.values.len().min(start + GROUP)];
        let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
        let known = || values.iter().copied().flatten();
        let Some(mut column) = group.next_column()? else {
            return Err(ParquetError::General("a column more than the schema has".into()));
        };
        match column.untyped() {
            ColumnWriter::Int64ColumnWriter(typed) => {
                typed.write_batch(&known().map(|value| value as i64).collect::<Vec<_>>(), Some(&levels), None)?;
            }
            ColumnWriter::DoubleColumnWriter(typed) => {
                typed.write_batch(&known().collect::<Vec<_>>(), Some(&levels), None)?;
            }
            _ => return Err(ParquetError::General("a column of another type than the schema's".into())),
        }
        column.close()?;
    }
    group.close().map(drop)
}
