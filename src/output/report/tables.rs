//! Tables of texts.

use serde::Serialize;

/// A table of texts.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReportTable {
    /// Title of the table.
    pub title: String,
    /// Names of the columns; empty for a list of names with their meanings.
    pub head: Vec<String>,
    /// Cell texts by row.
    pub rows: Vec<Vec<String>>,
}
