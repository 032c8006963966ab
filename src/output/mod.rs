//! Floor 6: results as files. One file per format; bytes are made by pure functions, apart from where they are written.
//!
//! Every file of a run passes through [`RunFiles`], which keeps it below the output directory and replaces it in one piece.

mod axis;
mod braille;
mod colormap;
mod contours;
mod drawing;
mod energies;
mod files;
mod history_csv;
mod movie;
mod obstacles;
mod picture;
mod plot;
mod pvd;
mod recording;
mod report;
mod summary;
mod vtu;
mod writer;

#[cfg(test)]
mod samples;

pub use braille::braille_plot;
pub use drawing::{Drawing, png, svg};
pub use energies::{ENERGIES, above_lowest_potential, energies};
pub use files::{OutputError, RunFiles, Stream};
pub use history_csv::HistoryCsv;
pub use movie::{MovieFormat, movie};
pub use obstacles::Surroundings;
pub use picture::{Component, Field, Measure, Panel, PictureOptions, Sight, VIEWS, Vectors, View, picture, sight};
pub use plot::{Curve, CurveStyle, Plot, PlotAxis};
pub use pvd::{FieldSeries, pvd};
pub use recording::{Recording, Skin, Still, shapes};
pub use report::{Report, Table, kept_rows, report};
pub use summary::{
    COMPLETED, Drifts, EnergyChange, FindingRecord, Inertia, KEYS, NOT_CONSERVING, Summary, WallSeconds, drifts, peak_memory_bytes,
};
pub use vtu::{Frame, Grid};
pub use writer::FieldWriter;
