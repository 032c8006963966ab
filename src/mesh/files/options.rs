//! Options of reading mesh files, and notes on changes that reading makes to meshes.

use std::path::PathBuf;

/// Treatment of elements that are no cells: springs, masses, beams, shells beside solid cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Structural {
    /// The elements are left out, with a note that counts them.
    #[default]
    Skipped,
    /// The file is refused.
    Refused,
}

/// Treatment of shells and membranes in a file without solid or plane cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shells {
    /// The file is refused: a shell bends, a plane cell does not.
    #[default]
    Refused,
    /// The elements are read as plane cells.
    Plane,
}

/// Options of reading a mesh file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Elements that are no cells.
    pub structural: Structural,
    /// Shells without solid or plane cells.
    pub shells: Shells,
    /// Name of the only part that is read, with its boundaries; `None` for the whole file.
    pub part: Option<String>,
}

/// Path of an included file by its name, or the reason why it may not be read; `None` refuses all included files.
pub type Includes<'a> = Option<&'a dyn Fn(&str) -> Result<PathBuf, String>>;

/// A change made by a reader to the content of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum FileNote {
    /// Elements that are no cells were left out: their types with counts.
    Skipped(Vec<(String, usize)>),
    /// Plane cells whose nodes run clockwise were reversed.
    Turned {
        /// Number of reversed cells.
        count: usize,
        /// Number of the first reversed cell in the file.
        first: u64,
    },
    /// Lines of elements have more numbers than the elements have nodes; surplus numbers were left out.
    LongLines {
        /// Number of elements with surplus numbers.
        count: usize,
        /// Number in the file of the first element with surplus numbers.
        first: u64,
    },
    /// Node sets of second-order faces contain corners only; the whole faces were used.
    CornerSets(Vec<String>),
    /// An instance without cells was left out.
    WithoutCells(String),
    /// Nodes in faces and middles of cells were left out.
    FaceNodes {
        /// Number of cells and facets with nodes in faces or middles.
        count: usize,
        /// Number in the file of the first cell or facet with such nodes.
        first: u64,
    },
    /// Arrays of results were left out: their names.
    Arrays(Vec<String>),
    /// Cells with repeated nodes became cells of a kind with fewer corners, such as wedges in place of hexahedra.
    Collapsed {
        /// For each pair of kinds, as written and as read: the kinds and the number of cells.
        counts: Vec<(&'static str, &'static str, usize)>,
        /// Smallest number in the file of a cell with repeated nodes.
        first: u64,
    },
}

impl FileNote {
    /// Stable code of the message.
    pub fn code(&self) -> &'static str {
        match self {
            FileNote::Skipped(_) => "C0851",
            FileNote::Turned { .. } => "C0852",
            FileNote::LongLines { .. } => "C0853",
            FileNote::CornerSets(_) => "C0854",
            FileNote::WithoutCells(_) => "C0855",
            FileNote::FaceNodes { .. } => "C0856",
            FileNote::Arrays(_) => "C0857",
            FileNote::Collapsed { .. } => "C0858",
        }
    }
}

impl std::fmt::Display for FileNote {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            FileNote::Skipped(counts) => {
                let counts: Vec<String> = counts.iter().map(|(name, count)| format!("{count} {name}")).collect();
                write!(out, "elements that are no cells of bodies are left out: {}", counts.join(", "))
            }
            FileNote::Turned { count, first } => {
                write!(out, "the nodes of {count} {} reversed: they run clockwise, first in element {first}", cells_are(*count))
            }
            FileNote::LongLines { count, first } => {
                let have = if *count == 1 { "element has" } else { "elements have" };
                write!(out, "{count} {have} more numbers than nodes, first element {first}; the last numbers are left out")
            }
            FileNote::WithoutCells(name) => write!(out, "the instance \"{name}\" has no solid or plane cells and is left out"),
            FileNote::FaceNodes { count, first } => {
                let have = if *count == 1 { "cell or facet is" } else { "cells and facets are" };
                write!(
                    out,
                    "{count} {have} read without the nodes in faces and middles, as wedges and pyramids have none here; first {first}"
                )
            }
            FileNote::Arrays(names) => write!(out, "arrays that are no groups of cells are left out: {}", names.join(", ")),
            FileNote::Collapsed { counts, first } => {
                let counts: Vec<String> = counts.iter().map(|(written, kind, count)| format!("{count} {written} as {kind}")).collect();
                write!(out, "cells with repeated nodes are read as what they are: {}; first element {first}", counts.join(", "))
            }
            FileNote::CornerSets(names) => {
                let names: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
                write!(out, "sets of corner nodes are taken as the whole faces that have these corners: {}", names.join(", "))
            }
        }
    }
}

fn cells_are(count: usize) -> &'static str {
    if count == 1 { "cell are" } else { "cells are" }
}
