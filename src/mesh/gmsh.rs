//! Reader for Gmsh mesh files, MSH 2.2 and 4.1 ASCII (Gmsh reference manual, "MSH file format").
//!
//! Physical groups of cells become parts, physical groups one dimension below become boundaries; their elements are matched to facets
//! of cells by their node sets, so that orientation always comes from the cell. Nodes that no cell uses are left out (centers of
//! circles, for instance), so are points, and in space lines. Elements of a boundary that lies between two cells stand for
//! both sides. Only quad4 and hex8 cells are read; nothing is turned round or repaired: what is wrong is an error with its line.

mod assembly;
mod lines;
mod tables;
mod version_2;
mod version_4;

use std::path::Path;

use lines::{Lines, Section, shortened};
use tables::Tables;

use super::{Mesh, MeshError};

/// Reads a mesh file; see [`read_gmsh`].
///
/// # Errors
/// A file that cannot be read, and all that [`read_gmsh_bytes`] refuses.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<Mesh, MeshError> {
    let path = path.as_ref();
    let unreadable = |error: std::io::Error| MeshError::Unreadable { path: path.into(), reason: error.to_string() };
    read_gmsh_bytes(&std::fs::read(path).map_err(unreadable)?)
}

/// Reads the content of a mesh file of which it is not known yet whether it is text.
///
/// # Errors
/// Binary files and text that is not UTF-8, and all that [`read_gmsh`] refuses.
pub fn read_gmsh_bytes(content: &[u8]) -> Result<Mesh, MeshError> {
    match std::str::from_utf8(content) {
        Ok(text) => read_gmsh(text),
        Err(error) => {
            let (valid, _) = content.split_at(error.valid_up_to());
            // what comes before the first strange byte tells binary Gmsh files and other formats apart
            let text = String::from_utf8_lossy(valid);
            let line = text.bytes().filter(|&byte| byte == b'\n').count() + 1;
            match read_gmsh(&text) {
                Err(known @ (MeshError::Binary { .. } | MeshError::OtherFormat { .. } | MeshError::Version { .. })) => Err(known),
                _ => Err(MeshError::NotText { line }),
            }
        }
    }
}

/// The mesh that the text of a Gmsh file describes.
///
/// # Errors
/// Text of another format or version, incomplete or contradictory content, cells of other kinds, cells that are inside out, nodes off
/// the plane, elements of boundaries that belong to no cell.
pub fn read_gmsh(text: &str) -> Result<Mesh, MeshError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = Lines::new(text);
    let mut version = None;
    let mut seen: Vec<&str> = Vec::new();
    let mut tables = Tables::default();
    let mut entities = None;
    while let Some(line) = lines.next() {
        let Some(name) = line.strip_prefix('$') else {
            return Err(match version {
                None => MeshError::OtherFormat { line: lines.number, found: format_of(text) },
                Some(_) => {
                    let expected = "a section, which begins with a dollar sign";
                    MeshError::Malformed { line: lines.number, expected, found: shortened(line) }
                }
            });
        };
        if matches!(name, "MeshFormat" | "PhysicalNames" | "Entities" | "Nodes" | "Elements") {
            if seen.contains(&name) {
                return Err(MeshError::RepeatedSection { line: lines.number, section: name.into() });
            }
            seen.push(name);
        }
        match (name, version) {
            ("MeshFormat", _) => version = Some(read_version(&mut lines)?),
            ("NOD" | "NOE", _) => return Err(MeshError::Version { line: lines.number, version: "1".into() }),
            ("PhysicalNames", _) => tables.read_names(&mut lines)?,
            ("Entities" | "Nodes" | "Elements", None) => {
                return Err(MeshError::MissingSection { line: lines.number, section: "MeshFormat" });
            }
            ("Entities", Some(Version::Four)) => version_4::read_entities(&mut lines, &mut entities)?,
            ("Nodes", Some(Version::Two)) => version_2::read_nodes(&mut lines, &mut tables)?,
            ("Nodes", Some(Version::Four)) => version_4::read_nodes(&mut lines, &mut tables)?,
            ("Elements", Some(known)) => {
                tables.elements_line = lines.number;
                match known {
                    Version::Two => version_2::read_elements(&mut lines, &mut tables)?,
                    Version::Four => version_4::read_elements(&mut lines, &mut tables, &entities)?,
                }
            }
            ("PartitionedEntities", _) => return Err(MeshError::Partitioned { line: lines.number, section: name.into() }),
            _ => lines.skip(name)?,
        }
    }
    for section in ["MeshFormat", "Nodes", "Elements"] {
        if !seen.contains(&section) {
            return Err(match seen.is_empty() {
                true => MeshError::OtherFormat { line: 1, found: format_of(text) },
                false => MeshError::MissingSection { line: lines.number, section },
            });
        }
    }
    if matches!(version, Some(Version::Four)) && entities.is_none() && !tables.names.is_empty() {
        // without it, the named groups would be lost without a word
        return Err(MeshError::MissingSection { line: lines.number, section: "Entities" });
    }
    assembly::assemble(tables)
}

/// The two layouts that are read.
#[derive(Clone, Copy)]
enum Version {
    Two,
    Four,
}

/// `version file-type data-size`.
fn read_version(lines: &mut Lines) -> Result<Version, MeshError> {
    const EXPECTED: &str = "the version of the format, 0 for ASCII, and a size";
    let section = Section { name: "MeshFormat", begin: lines.number, announced: 1, found: 0 };
    let mut fields = lines.entry(&section)?;
    let line = lines.number;
    let number: f64 = fields.number(EXPECTED)?;
    let file_type: u64 = fields.number(EXPECTED)?;
    if file_type != 0 {
        return Err(MeshError::Binary { line });
    }
    let version = match fields.text().split_ascii_whitespace().next() {
        // some programs write 2.2000
        _ if number == 2.2 => Version::Two,
        _ if number == 4.1 => Version::Four,
        written => return Err(MeshError::Version { line, version: shortened(written.unwrap_or_default()) }),
    };
    lines.close(&Section { found: 1, ..section })?;
    Ok(version)
}

/// What a text that does not begin like a Gmsh file looks like.
fn format_of(text: &str) -> &'static str {
    let begin = text.trim_start();
    let starts = |prefix: &str| begin.get(..prefix.len()).is_some_and(|b| b.eq_ignore_ascii_case(prefix));
    let known = [
        ("# vtk", "a legacy VTK file"),
        ("<VTKFile", "a VTK XML file"),
        ("<?xml", "an XML file"),
        ("solid", "an STL file"),
        ("*", "an Abaqus or LS-DYNA input file"),
        ("ISO-10303", "a STEP file"),
        ("{", "a JSON file"),
        ("OFF", "an OFF file"),
        ("ply", "a PLY file"),
        ("SetFactory", "a Gmsh geometry (`.geo`), which has to be meshed first"),
        ("Point(", "a Gmsh geometry (`.geo`), which has to be meshed first"),
        ("//", "a Gmsh geometry (`.geo`), which has to be meshed first"),
    ];
    if begin.is_empty() {
        return "an empty file";
    }
    known.iter().find(|(prefix, _)| starts(prefix)).map_or("something that does not begin with $MeshFormat", |(_, name)| name)
}

#[cfg(test)]
mod tests;
