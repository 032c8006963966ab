//! A mesh from a file of any format that is read.

use std::path::Path;

use super::abaqus::Deck;
use super::assembly::assemble;
use super::options::{FileNote, Includes, ReadOptions};
use super::text::format_of;
use super::{abaqus, gmsh};
use crate::machine::files;
use crate::mesh::file_error::{FileError, FileProblem, Place};
use crate::mesh::{Mesh, MeshError};

/// Reads a mesh file; see [`read_mesh_bytes`]. Files below its folder may be included.
///
/// # Errors
/// A file that cannot be read, and all that [`read_mesh_bytes`] refuses.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<Mesh, MeshError> {
    let find = abaqus::below_folder_of(path.as_ref());
    read_mesh_with(path, ReadOptions::default(), Some(&find)).map(|(mesh, _)| mesh)
}

/// Reads a mesh file with options; included files are found by `includes`. Returns the mesh and the changes made to the content.
///
/// # Errors
/// A file that cannot be read, and all that [`read_mesh_bytes`] refuses.
pub fn read_mesh_with(path: impl AsRef<Path>, options: ReadOptions, includes: Includes) -> Result<(Mesh, Vec<FileNote>), MeshError> {
    read(&content_of(path.as_ref())?, options, includes)
}

/// Reads an input file of Abaqus or CalculiX as a deck: every instance, or every connected piece of a file without instances, is a mesh.
///
/// # Errors
/// A file of another format, and all that [`read_mesh_bytes`] refuses.
pub fn read_deck(path: impl AsRef<Path>, options: ReadOptions, includes: Includes) -> Result<Deck, MeshError> {
    deck(&content_of(path.as_ref())?, options, includes)
}

/// The deck that the content of an input file describes; see [`read_deck`]. It includes no other files.
///
/// # Errors
/// Errors of [`read_deck`].
pub fn read_deck_bytes(content: &[u8], options: ReadOptions) -> Result<Deck, MeshError> {
    deck(content, options, None)
}

fn deck(content: &[u8], options: ReadOptions, includes: Includes) -> Result<Deck, MeshError> {
    match first_byte(content) {
        Some(b'*') => abaqus::read_deck(content, options, includes),
        Some(b'$') => Err(other_format("a Gmsh file, which has no materials and instances")),
        _ => Err(other_format(format_of(content))),
    }
}

fn other_format(found: &'static str) -> MeshError {
    FileError { at: Place::Line(1), problem: FileProblem::OtherFormat { found } }.into()
}

/// The content of a file.
fn content_of(path: &Path) -> Result<Vec<u8>, MeshError> {
    files::read(path).map_err(|error| {
        let problem = FileProblem::Unreadable { path: path.into(), reason: error.to_string() };
        FileError { at: Place::Line(1), problem }.into()
    })
}

/// The mesh that the content of a file describes, whose format shows in its first character: Gmsh, Abaqus or CalculiX. It includes no
/// other files.
///
/// # Errors
/// Another format or version, incomplete or contradictory content, cells of kinds that are not read or of several kinds, cells that are
/// inside out, nodes off the plane, elements of boundaries that belong to no cell.
pub fn read_mesh_bytes(content: &[u8]) -> Result<Mesh, MeshError> {
    read(content, ReadOptions::default(), None).map(|(mesh, _)| mesh)
}

fn read(content: &[u8], options: ReadOptions, includes: Includes) -> Result<(Mesh, Vec<FileNote>), MeshError> {
    match first_byte(content) {
        Some(b'$') => assemble(gmsh::read(content)?, options),
        Some(b'*') => abaqus::read_whole(content, options, includes),
        _ => Err(other_format(format_of(content))),
    }
}

/// The first byte behind spaces, by which formats are told apart.
fn first_byte(content: &[u8]) -> Option<u8> {
    content.strip_prefix("\u{feff}".as_bytes()).unwrap_or(content).trim_ascii_start().first().copied()
}
