//! Conversion of a run's files into other formats.

use std::path::{Path, PathBuf};

use super::blocks::{part, vtm};
use super::files::{OutputError, RunFiles};
use super::node_table::node_table;
use super::parquet::parquet_in_units;
use super::pvd::pvd;
use super::reading::error::ReadError;
use super::reading::fields::{FieldsRead, read_fields};
use super::reading::folder::RunFolder;
use super::reading::frames::{ListedFrame, read_frames};
use super::reading::table::read_table;
use super::units::read_units;
use super::vtu_text::vtu_text;
use super::xdmf::{grid, hdf5, xdmf};

/// A format to convert to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// `history.csv` as `history.parquet`.
    Parquet,
    /// Every frame as a table of its points, `fields-csv/fields_000000.csv`.
    Csv,
    /// Every frame as VTU in plain text, `fields-text.pvd`.
    Vtu,
    /// Every frame as a multiblock file with a block for each body by its name, `fields-blocks.pvd`.
    Vtm,
    /// Every series as XDMF with HDF5, `fields.xdmf`.
    Xdmf,
}

/// Error of a conversion.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Error of reading a file of the run.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Error of writing a file.
    #[error(transparent)]
    Write(#[from] OutputError),
}

impl ExportError {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            ExportError::Read(error) => error.code(),
            ExportError::Write(error) => error.code(),
        }
    }
}

/// Names of the series that a run may contain.
const SERIES: [&str; 3] = ["fields", "contacts", "obstacles"];

/// Converts the files of a run, including its further simulations; returns the names of the files that a reader opens.
///
/// # Errors
/// No run, no file to convert, a damaged file, or a file that cannot be written.
pub fn export(run: &RunFolder, format: ExportFormat, into: &Path) -> Result<Vec<String>, ExportError> {
    let mut written = export_simulation(run, format, into)?;
    for name in run.further() {
        let further = RunFolder::open(&run.path.join(&name))?;
        written.extend(export_simulation(&further, format, &into.join(&name))?.into_iter().map(|file| format!("{name}/{file}")));
    }
    if written.is_empty() {
        let (what, hint) = match format {
            ExportFormat::Parquet => ("history.csv", "run the script again: every simulation writes one"),
            _ => ("fields.pvd with frames", "run the script again: every simulation writes its first and its last frame"),
        };
        return Err(ReadError::new(&run.path, format!("has no {what} to convert"), hint).into());
    }
    Ok(written)
}

fn export_simulation(run: &RunFolder, format: ExportFormat, into: &Path) -> Result<Vec<String>, ExportError> {
    if format == ExportFormat::Parquet {
        let Some(history) = run.file("history.csv") else { return Ok(Vec::new()) };
        let table = read_table(&history)?.table;
        let refused = |what: String| ReadError::new(&history, format!("cannot be written as Parquet: {what}"), "name no column twice");
        let units = read_units(&run.path)?.map(|units| units.columns).unwrap_or_default();
        let bytes = parquet_in_units(&table, &units).map_err(refused)?;
        RunFiles::create(into)?.write("history.parquet", bytes)?;
        return Ok(vec!["history.parquet".into()]);
    }
    let mut written = Vec::new();
    for name in SERIES {
        let Some(list) = run.file(&format!("{name}.pvd")) else { continue };
        let frames = read_frames(&list)?;
        if !frames.is_empty() {
            written.push(export_series(name, &frames, format, &RunFiles::create(into)?)?);
        }
    }
    Ok(written)
}

/// Converts a series frame by frame, so that only one is in memory at a time.
fn export_series(name: &str, frames: &[ListedFrame], format: ExportFormat, files: &RunFiles) -> Result<String, ExportError> {
    let (folder, ending) = match format {
        ExportFormat::Csv | ExportFormat::Parquet => (format!("{name}-csv"), "csv"),
        ExportFormat::Vtu => (format!("{name}-text"), "vtu"),
        ExportFormat::Vtm => (format!("{name}-blocks"), "vtm"),
        ExportFormat::Xdmf => (format!("{name}-hdf5"), "h5"),
    };
    let file_of = |number: usize| format!("{folder}/{name}_{number:06}.{ending}");
    remove_older(files, file_of, frames.len())?;
    let (mut listed, mut grids) = (Vec::new(), Vec::new());
    for (number, ListedFrame { time, path, .. }) in frames.iter().enumerate() {
        let frame: FieldsRead = read_fields(path)?;
        let file = file_of(number);
        let refused = |what: String| ReadError::new(path, format!("cannot be converted: {what}"), "choose another format");
        match format {
            ExportFormat::Csv | ExportFormat::Parquet => files.write(&file, node_table(&frame).to_csv())?,
            ExportFormat::Vtu => files.write(&file, vtu_text(&frame))?,
            ExportFormat::Vtm => write_blocks(&frame, &file, files)?,
            ExportFormat::Xdmf => {
                grids.push(grid(&frame, *time, &file).map_err(refused)?);
                files.write(&file, hdf5(&frame).map_err(refused)?)?
            }
        };
        listed.push((*time, file));
    }
    let list = match format {
        // A table of the frames with their times, which the tables of frames do not contain.
        ExportFormat::Csv | ExportFormat::Parquet => {
            let lines = listed.iter().map(|(time, file)| format!("{time:?},{file}\n"));
            let list = format!("{name}-csv.csv");
            files.write(&list, std::iter::once("time,file\n".to_string()).chain(lines).collect::<String>())?;
            list
        }
        ExportFormat::Vtu | ExportFormat::Vtm => {
            let list = format!("{folder}.pvd");
            files.write(&list, pvd(listed.iter().map(|(time, file)| (*time, file.as_str()))))?;
            list
        }
        ExportFormat::Xdmf => {
            let list = format!("{name}.xdmf");
            files.write(&list, xdmf(&grids))?;
            list
        }
    };
    Ok(list)
}

/// Writes the parts of a frame beside its multiblock file.
fn write_blocks(frame: &FieldsRead, file: &str, files: &RunFiles) -> Result<PathBuf, OutputError> {
    let stem = file.trim_end_matches(".vtm");
    let mut blocks = Vec::new();
    for (index, name) in frame.parts.iter().enumerate() {
        let block = format!("{stem}_{index}.vtu");
        files.write(&block, vtu_text(&part(frame, index)))?;
        // Paths in the file are relative to it.
        blocks.push((name.clone(), block.rsplit('/').next().unwrap_or_default().to_string()));
    }
    files.write(file, vtm(&blocks))
}

/// Removes surplus frames of an earlier conversion with more than `count` frames.
fn remove_older(files: &RunFiles, name: impl Fn(usize) -> String, count: usize) -> Result<(), OutputError> {
    let further = (count..).map(|number| files.place(&name(number)));
    for path in further {
        let path = path?;
        if !path.is_file() {
            break;
        }
        std::fs::remove_file(&path).map_err(|source| OutputError::Write { path, source })?;
    }
    Ok(())
}
