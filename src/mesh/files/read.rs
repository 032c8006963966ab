//! A mesh from a file of any format that is read.

use std::path::Path;

use super::assembly::assemble;
use super::text::format_of;
use super::{abaqus, gmsh};
use crate::machine::files;
use crate::mesh::file_error::{FileError, FileProblem, Place};
use crate::mesh::{Mesh, MeshError};

/// Reads a mesh file; see [`read_mesh_bytes`].
///
/// # Errors
/// A file that cannot be read, and all that [`read_mesh_bytes`] refuses.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<Mesh, MeshError> {
    let path = path.as_ref();
    match files::read(path) {
        Ok(content) => read_mesh_bytes(&content),
        Err(error) => {
            let problem = FileProblem::Unreadable { path: path.into(), reason: error.to_string() };
            Err(FileError { at: Place::Line(1), problem }.into())
        }
    }
}

/// The mesh that the content of a file describes, whose format shows in its first character: Gmsh, Abaqus or CalculiX.
///
/// # Errors
/// Another format or version, incomplete or contradictory content, cells of kinds that are not read or of several kinds, cells that are
/// inside out, nodes off the plane, elements of boundaries that belong to no cell.
pub fn read_mesh_bytes(content: &[u8]) -> Result<Mesh, MeshError> {
    let begin = content.strip_prefix("\u{feff}".as_bytes()).unwrap_or(content).trim_ascii_start();
    let tables = match begin.first() {
        Some(b'$') => gmsh::read(content)?,
        Some(b'*') => abaqus::read(content)?,
        _ => return Err(FileError { at: Place::Line(1), problem: FileProblem::OtherFormat { found: format_of(content) } }.into()),
    };
    assemble(&tables)
}
