//! Floor 6: results as files. One file per format; bytes are made by pure functions, apart from where they are written.
//!
//! Every file of a run passes through [`RunFiles`], which keeps it below the output directory and replaces it in one piece.

mod axis;
mod braille;
mod colormap;
mod contours;
mod files;
mod history_csv;
mod history_svg;
mod picture;
mod pvd;
mod summary;
mod vtu;
mod writer;

#[cfg(test)]
mod samples;

pub use braille::braille_plot;
pub use files::{OutputError, RunFiles, Stream};
pub use history_csv::HistoryCsv;
pub use history_svg::{energies, plot};
pub use picture::{Field, PictureOptions, picture};
pub use pvd::{FieldSeries, pvd};
pub use summary::{
    COMPLETED, Drifts, EnergyChange, FindingRecord, Inertia, KEYS, NOT_CONSERVING, Summary, WallSeconds, drifts, peak_memory_bytes,
};
pub use vtu::{Frame, Grid};
pub use writer::FieldWriter;
