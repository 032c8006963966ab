//! Reading a mesh file of any supported format.

use std::path::Path;

use super::abaqus::Deck;
use super::assembly::assemble;
use super::options::{FileNote, Includes, ReadOptions};
use super::text::format_of;
use super::{abaqus, gmsh, medit, nastran, su2, universal, vtk};
use crate::machine::files;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};
use crate::mesh::{Mesh, MeshError};

/// Extensions of supported mesh files.
pub const MESH_ENDINGS: [&str; 9] = ["msh", "inp", "vtu", "vtk", "mesh", "unv", "bdf", "nas", "su2"];

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

/// Reads the content of an input file as a deck; see [`read_deck`]. Included files are refused.
///
/// # Errors
/// Errors of [`read_deck`].
pub fn read_deck_bytes(content: &[u8], options: ReadOptions) -> Result<Deck, MeshError> {
    deck(content, options, None)
}

fn deck(content: &[u8], options: ReadOptions, includes: Includes) -> Result<Deck, MeshError> {
    match first_byte(content) {
        Some(b'*') => abaqus::read_deck(content, &options, includes),
        Some(b'$') => Err(other_format("a file without materials and instances")),
        _ => Err(other_format(format_of(content))),
    }
}

fn other_format(found: &'static str) -> MeshError {
    FileError { at: FilePosition::Line(1), problem: FileProblem::OtherFormat { found } }.into()
}

/// Reads the bytes of the file at `path`.
fn content_of(path: &Path) -> Result<Vec<u8>, MeshError> {
    files::read(path).map_err(|error| {
        let problem = FileProblem::Unreadable { path: path.into(), reason: error.to_string() };
        FileError { at: FilePosition::Line(1), problem }.into()
    })
}

/// Reads the content of a mesh file, whose format is recognized from its beginning: Gmsh, Abaqus or CalculiX, VTK (XML or legacy), Medit,
/// universal file, bulk data of Nastran, SU2. Included files are refused.
///
/// # Errors
/// Another format or version, incomplete or contradictory content, unsupported kinds of cells or cells of different order, inverted cells,
/// nodes off the plane, boundary elements without a cell.
pub fn read_mesh_bytes(content: &[u8]) -> Result<Mesh, MeshError> {
    read(content, ReadOptions::default(), None).map(|(mesh, _)| mesh)
}

fn read(content: &[u8], options: ReadOptions, includes: Includes) -> Result<(Mesh, Vec<FileNote>), MeshError> {
    let begins =
        |with: &str| content.trim_ascii_start().strip_prefix("\u{feff}".as_bytes()).unwrap_or(content).starts_with(with.as_bytes());
    match first_byte(content) {
        Some(b'*') => abaqus::read_whole(content, &options, includes),
        Some(b'<') => assemble_grid(vtk::read_xml(content)?, &options),
        Some(b'#') if begins("# vtk") => assemble_grid(vtk::read_legacy(content)?, &options),
        _ if medit::begins(content) => assemble(medit::read(content)?, &options),
        _ if su2::begins(content) => assemble(su2::read(content)?, &options),
        _ if universal::begins(content) => assemble(universal::read(content)?, &options),
        _ if nastran::begins(content) => assemble(nastran::read(content)?, &options),
        Some(b'$') => assemble(gmsh::read(content)?, &options),
        _ => Err(other_format(format_of(content))),
    }
}

/// Mesh of a grid, with a note of the arrays that are no groups of cells.
fn assemble_grid(mut grid: vtk::Content, options: &ReadOptions) -> Result<(Mesh, Vec<FileNote>), MeshError> {
    grid.tables.turn_wedges();
    let (mesh, mut notes) = assemble(grid.tables, options)?;
    if !grid.left_out.is_empty() {
        notes.push(FileNote::Arrays(grid.left_out.into_iter().collect()));
    }
    Ok((mesh, notes))
}

/// First byte after white space, by which formats are distinguished.
fn first_byte(content: &[u8]) -> Option<u8> {
    content.strip_prefix("\u{feff}".as_bytes()).unwrap_or(content).trim_ascii_start().first().copied()
}
