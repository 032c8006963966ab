//! `conserva export`: files of a run in other formats.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::complaint::refuse;
use super::console::{Console, complain, ink};
use super::process::exit_code;
use crate::output::{ExportError, ExportFormat, RunFolder, export};
use crate::script::{Class, Diagnostic};

/// Arguments of `conserva export`.
#[derive(Args)]
#[command(after_help = "Exit code: 0 done, 2 no run, nothing to convert or a damaged file, 3 a file cannot be written.\n\
    The run's own files stay as they are: history.csv reads into pandas, R and spreadsheets, fields.pvd into ParaView and PyVista.")]
pub struct Arguments {
    /// Folder of a run
    folder: PathBuf,
    /// Format to convert to
    #[arg(long, value_enum)]
    format: Format,
    /// Output folder [default: the run's]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// A format to convert to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// history.parquet, for pandas, Polars, DuckDB, R
    Parquet,
    /// fields-csv/: every frame as a table of its nodes, with a list of their times
    Csv,
    /// fields-text.pvd: every frame as VTU in plain text, for programs that read no compressed files
    Vtu,
    /// fields-blocks.pvd: every frame with a block for each body by its name, for ParaView and PyVista
    Vtm,
    /// fields.xdmf with HDF5 files, for h5py, MATLAB, Julia, meshio, ParaView
    Xdmf,
}

/// Converts files; returns the exit code.
pub fn export_run(arguments: Arguments) -> u8 {
    let Arguments { folder, format, out } = arguments;
    let run = match RunFolder::open(&folder) {
        Ok(run) => run,
        Err(error) => return refuse(&error),
    };
    let into = out.unwrap_or_else(|| folder.clone());
    let format = match format {
        Format::Parquet => ExportFormat::Parquet,
        Format::Csv => ExportFormat::Csv,
        Format::Vtu => ExportFormat::Vtu,
        Format::Vtm => ExportFormat::Vtm,
        Format::Xdmf => ExportFormat::Xdmf,
    };
    match export(&run, format, &into) {
        Ok(written) => {
            let console = Console::new(true);
            written.iter().for_each(|file| console.say(&into.join(file).display().to_string()));
            0
        }
        Err(ExportError::Read(error)) => refuse(&error),
        Err(ExportError::Write(error)) => {
            let message = Diagnostic::error(Class::Numerics, error.to_string()).code(error.code());
            complain(&message.hint(error.hint()).render(ink()));
            exit_code(Class::Numerics)
        }
    }
}
