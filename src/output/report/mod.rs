//! `report.html`: a run in one page that opens without a network; and the same page while the run goes on.
//!
//! The page is a template (`assets/`) with the data of the run beside it: what is small as JSON, the rest as arrays of numbers, compressed
//! and in base64. It is built by its own program from these data alone, as text and never as markup, so that no name can become part of
//! the page. Nothing in it depends on the clock, the machine or the folder: two runs of the same script have the same report.
//!
//! A page that follows a run (`live.rs`, `news.rs`) has one part more in its program, which asks whoever gave the page for what is new.

mod assets;
mod blob;
mod followed;
mod geometry;
mod live;
mod news;
mod page;
mod rows;
mod tables;

#[cfg(test)]
mod tests;

pub use live::{Doing, LiveModel, LiveOutcome, LiveProblem, LiveReport, LiveSimulation};
pub use news::News;
pub use page::{Report, report};
pub use rows::kept_rows;
pub use tables::ReportTable;
