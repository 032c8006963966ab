//! `report.html`: a run in one page that needs no network, and its variant that follows a run.
//!
//! The page is a template (`assets/`) with the data of the run: small data as JSON, large arrays of numbers compressed and in base64. The
//! program of the page builds it from these data alone, as text and never as markup, so that names cannot inject markup. The page does not
//! depend on the clock, the machine or the folder: two runs of one script have equal reports.
//!
//! A page that follows a run (`live.rs`, `news.rs`) has an additional part of the program, which requests updates from its server.

mod assets;
mod blob;
mod followed;
mod geometry;
mod live;
mod marks;
mod news;
mod page;
mod rows;
mod several;
mod tables;
mod template;

#[cfg(test)]
mod tests;

pub use live::{Activity, LiveModel, LiveOutcome, LiveProblem, LiveReport, LiveSimulation};
pub use marks::{Mark, marks};
pub use news::ReportChanges;
pub use page::{Report, ReportPicture, report};
pub use rows::kept_rows;
pub use several::{ReportPage, labels, report_of_several};
pub use tables::ReportTable;
