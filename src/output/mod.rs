//! Floor 6 of `ARCHITECTURE.md`: results as files. One file per format; bytes are made by pure functions, apart from where they are
//! written.
//!
//! Every file of a run passes through [`RunFiles`], which keeps it below the output directory and replaces it in one piece.

mod axis;
#[cfg(feature = "formats")]
mod blocks;
mod braille;
pub mod checkpoint;
mod colormap;
mod comparison;
mod contours;
mod counted;
mod csv_text;
mod drawing;
mod energies;
#[cfg(feature = "formats")]
mod export;
mod file_record;
mod files;
mod history;
mod history_csv;
mod inputs;
pub mod journal;
mod markup;
mod movie;
#[cfg(feature = "formats")]
mod node_table;
mod obstacle_surfaces;
mod obstacles;
#[cfg(feature = "formats")]
mod parquet;
mod picture;
mod plot;
mod point_log;
mod pvd;
mod reading;
mod recording;
mod report;
mod response;
mod rows_csv;
mod run_lock;
mod still_fields;
mod study_page;
mod summary;
mod table;
mod units;
mod vtu;
#[cfg(feature = "formats")]
mod vtu_text;
mod writer;
#[cfg(feature = "formats")]
mod xdmf;

#[cfg(test)]
mod samples;

pub use braille::braille_plot;
pub use comparison::{ColumnDifference, Comparison, EntryDifference, Exactness, FieldDifference, compare};
pub use counted::CountedFile;
pub use csv_text::{field as csv_field, line as csv_line, meant as csv_text};
pub use drawing::{Drawing, png, svg};
pub use energies::{ENERGIES, above_lowest_potential, energies};
#[cfg(feature = "formats")]
pub use export::{ExportError, ExportFormat, export};
pub use files::{OutputError, RunFiles, Stream};
pub use history::{History, RowStore};
pub use history_csv::HistoryCsv;
pub use inputs::Inputs;
pub use markup::escaped;
pub use movie::{MovieFormat, movie};
pub use obstacles::Surroundings;
#[cfg(feature = "formats")]
pub use parquet::{Field as TableField, parquet, parquet_in_units, parquet_of};
pub use picture::{
    CutPlane, Field, Measure, Panel, PictureBounds, PictureOptions, VIEWS, Vectors, View, picture, picture_of_boundaries, sight,
};
pub use plot::{Curve, CurveStyle, Plot, PlotAxis};
pub use point_log::{PointLog, decoded, encoded};
pub use pvd::{FieldSeries, pvd};
pub use reading::columns::{ReadColumn, read_columns};
pub use reading::error::ReadError;
pub use reading::fields::{ArrayRead, FieldsRead, Numbers, Section, read_fields};
pub use reading::folder::{RunFolder, read_summary, runs_below};
pub use reading::frames::{ListedFrame, read_frames};
#[cfg(feature = "formats")]
pub use reading::parquet_table::read_parquet;
pub use reading::table::{TableRead, read_table};
pub use recording::{Recording, Skin, Still, shapes};
pub use report::{
    Activity, LiveModel, LiveOutcome, LiveProblem, LiveReport, LiveSimulation, Mark, Report, ReportChanges, ReportPage, ReportPicture,
    ReportTable, kept_rows, labels, marks, report, report_of_several,
};
pub use response::Response;
pub use rows_csv::{RowsCsv, read_rows, rows_csv};
pub use run_lock::RunLock;
pub use still_fields::StillOptions;
pub use study_page::study_page;
pub use summary::{
    COMPLETED, Drifts, EnergyChange, FindingRecord, Inertia, KEYS, NOT_CONSERVING, SUMMARY, Summary, WallSeconds, drifts, peak_memory_bytes,
};
pub use table::{Column, Table, TextColumn, is_count};
pub use units::{
    Dimension, ListedUnits, ModelUnits, SETS, Scale, UNITS_FILE, Unit, UnitError, UnitSet, UnitSetError, pretty as pretty_unit, read_units,
};
pub use vtu::{Frame, Grid};
pub use writer::FieldWriter;
