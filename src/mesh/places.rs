//! Places of errors in mesh files.

use std::path::Path;

use super::error::MeshError;
use super::file_error::{FileError, FilePosition, FileProblem};

impl MeshError {
    /// Place in the mesh file or in the included file, if the error has one.
    pub fn place(&self) -> Option<FilePosition> {
        use MeshError::*;
        match self {
            InvertedCell { at, .. }
            | DegenerateCell { at, .. }
            | RepeatedNode { at, .. }
            | CrowdedFacet { at, .. }
            | Unmatched { at, .. } => *at,
            File(FileError { problem: FileProblem::Unreadable { .. }, .. }) => None,
            File(error) => Some(error.at),
            Included { error, .. } => error.place(),
            _ => None,
        }
    }

    /// Sets the place of an error that has one.
    pub(super) fn set_place(&mut self, place: FilePosition) {
        use MeshError::*;
        match self {
            InvertedCell { at, .. }
            | DegenerateCell { at, .. }
            | RepeatedNode { at, .. }
            | CrowdedFacet { at, .. }
            | Unmatched { at, .. } => *at = Some(place),
            File(error) => error.at = place,
            _ => {}
        }
    }

    /// Line of the file, counted from 1, if the error has one.
    pub fn line(&self) -> Option<usize> {
        match self.place() {
            Some(FilePosition::Line(line)) => Some(line),
            _ => None,
        }
    }

    /// Byte of the file, counted from 0, if the error has one.
    pub fn offset(&self) -> Option<usize> {
        match self.place() {
            Some(FilePosition::Byte(byte)) => Some(byte),
            _ => None,
        }
    }

    /// The included file with the error; `None` if the error is in the mesh file itself.
    pub fn included_file(&self) -> Option<&Path> {
        match self {
            MeshError::Included { file, .. } => Some(file),
            _ => None,
        }
    }
}
