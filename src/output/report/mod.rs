//! `report.html`: a run in one page that opens without a network.
//!
//! The page is a template (`assets/`) with the data of the run beside it: what is small as JSON, the rest as arrays of numbers, compressed
//! and in base64. It is built by its own program from these data alone, as text and never as markup, so that no name can become part of
//! the page. Nothing in it depends on the clock, the machine or the folder: two runs of the same script have the same report.

mod assets;
mod blob;
mod geometry;
mod page;
mod rows;

#[cfg(test)]
mod tests;

pub use page::{Report, ReportTable, report};
pub use rows::kept_rows;
