//! Tables of texts.

use serde::Serialize;

/// A table of texts.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReportTable {
    /// Its title.
    pub title: String,
    /// Names of its columns; none for a list of names with what they mean.
    pub head: Vec<String>,
    /// Its rows.
    pub rows: Vec<Vec<String>>,
}
