//! Parquet: a table with types and missing values for pandas, Polars, DuckDB, Arrow and R.
//!
//! One row group for each [`GROUP`] rows, `INT64` for counts, `DOUBLE` for other numbers and UTF-8 strings, all optional; plain or
//! dictionary pages without compression, since digits of a simulation hardly compress. The output does not depend on the clock, so equal
//! tables give equal bytes. (Apache Parquet format 2, crate `parquet` without Arrow.)

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::table::{Column, Table, TextColumn};

/// Rows of a row group: readers take one at a time.
const GROUP: usize = 1 << 17;

/// Column of numbers or of words.
#[derive(Clone, Copy, Debug)]
pub enum Field<'a> {
    /// Column of numbers.
    Numbers(&'a Column),
    /// Column of texts.
    Texts(&'a TextColumn),
}

impl Field<'_> {
    fn rows(&self) -> usize {
        match self {
            Field::Numbers(column) => column.values.len(),
            Field::Texts(column) => column.values.len(),
        }
    }

    fn kind(&self) -> Result<Type> {
        let (name, kind, logical) = match self {
            Field::Numbers(column) if column.is_count => (&column.name, PhysicalType::INT64, None),
            Field::Numbers(column) => (&column.name, PhysicalType::DOUBLE, None),
            Field::Texts(column) => (&column.name, PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
        };
        Type::primitive_type_builder(name, kind).with_logical_type(logical).with_repetition(Repetition::OPTIONAL).build()
    }
}

/// Encodes a table.
///
/// # Errors
/// The format refuses the table; the text gives the reason. No table of numbers with columns of different names is known to be refused.
pub fn parquet(table: &Table) -> std::result::Result<Vec<u8>, String> {
    parquet_in_units(table, &BTreeMap::new())
}

/// Encodes a table with the units of its columns, as a JSON object under the key `units` of the file's metadata.
///
/// # Errors
/// As [`parquet()`].
pub fn parquet_in_units(table: &Table, units: &BTreeMap<String, String>) -> std::result::Result<Vec<u8>, String> {
    encoded(&table.columns.iter().map(Field::Numbers).collect::<Vec<_>>(), units)
}

/// Encodes columns of equal length with their units, as [`parquet_in_units`].
///
/// # Errors
/// As [`parquet()`].
pub fn parquet_of(fields: &[Field], units: &BTreeMap<String, String>) -> std::result::Result<Vec<u8>, String> {
    encoded(fields, units)
}

fn encoded(fields: &[Field], units: &BTreeMap<String, String>) -> std::result::Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    match write(fields, units, &mut bytes) {
        Ok(()) => Ok(bytes),
        Err(error) => Err(error.to_string()),
    }
}

fn write(columns: &[Field], units: &BTreeMap<String, String>, bytes: &mut Vec<u8>) -> Result<()> {
    let fields = columns.iter().map(|column| column.kind().map(Arc::new)).collect::<Result<Vec<_>>>()?;
    let schema = Arc::new(Type::group_type_builder("table").with_fields(fields).build()?);
    let named = (!units.is_empty()).then(|| serde_json::to_string(units).ok()).flatten();
    let named = named.map(|units| vec![KeyValue::new("units".into(), units)]);
    let properties = WriterProperties::builder().set_created_by(concat!("conserva ", env!("CARGO_PKG_VERSION")).into());
    let properties = properties.set_key_value_metadata(named).build();
    let mut writer = SerializedFileWriter::new(bytes, schema, Arc::new(properties))?;
    for start in (0..columns.first().map_or(0, Field::rows)).step_by(GROUP) {
        write_group(columns, start, &mut writer)?;
    }
    writer.close().map(drop)
}

fn write_group<W: Write + Send>(columns: &[Field], start: usize, writer: &mut SerializedFileWriter<W>) -> Result<()> {
    let mut group = writer.next_row_group()?;
    for field in columns {
        let rows = start..field.rows().min(start + GROUP);
        let Some(mut column) = group.next_column()? else {
            return Err(ParquetError::General("a column more than the schema has".into()));
        };
        match (field, column.untyped()) {
            (Field::Numbers(numbers), ColumnWriter::Int64ColumnWriter(typed)) => {
                let (known, levels) = known(&numbers.values[rows], |&value| value as i64);
                typed.write_batch(&known, Some(&levels), None)?;
            }
            (Field::Numbers(numbers), ColumnWriter::DoubleColumnWriter(typed)) => {
                let (known, levels) = known(&numbers.values[rows], |&value| value);
                typed.write_batch(&known, Some(&levels), None)?;
            }
            (Field::Texts(texts), ColumnWriter::ByteArrayColumnWriter(typed)) => {
                let (known, levels) = known(&texts.values[rows], |text| ByteArray::from(text.as_str()));
                typed.write_batch(&known, Some(&levels), None)?;
            }
            _ => return Err(ParquetError::General("a column of another type than the schema's".into())),
        }
        column.close()?;
    }
    group.close().map(drop)
}

/// Returns the existing values, and for each row 1 if its value exists, else 0 (definition levels of Parquet).
fn known<T, U>(values: &[Option<T>], as_written: impl Fn(&T) -> U) -> (Vec<U>, Vec<i16>) {
    (values.iter().flatten().map(as_written).collect(), values.iter().map(|value| i16::from(value.is_some())).collect())
}
