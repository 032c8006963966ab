//! Text of files, and descriptions of unreadable content for messages: its first characters, its probable format.

use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// The beginning of a text, for a message.
pub(super) fn shortened(text: &str) -> String {
    const LENGTH: usize = 60;
    let clean = |part: &str| part.chars().map(|c| if c.is_control() { '?' } else { c }).collect::<String>();
    match text.char_indices().nth(LENGTH) {
        Some((end, _)) => format!("{}…", clean(&text[..end])),
        None => clean(text),
    }
}

/// Text of a file, without a byte order mark.
pub(super) fn utf8(content: &[u8]) -> Result<&str, MeshError> {
    match std::str::from_utf8(content) {
        Ok(text) => Ok(text.trim_start_matches('\u{feff}')),
        Err(error) => {
            let line = content[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count() + 1;
            Err(FileError { at: FilePosition::Line(line), problem: FileProblem::NotText }.into())
        }
    }
}

/// Description of the probable format of a file that does not begin like a readable mesh file.
pub(super) fn format_of(content: &[u8]) -> &'static str {
    let begin = content.trim_ascii_start();
    let starts = |prefix: &str| begin.get(..prefix.len()).is_some_and(|b| b.eq_ignore_ascii_case(prefix.as_bytes()));
    let known = [
        ("# vtk", "a legacy VTK file, which has no materials and instances"),
        ("<", "an XML file, which has no materials and instances"),
        ("solid", "an STL file"),
        ("ISO-10303", "a STEP file"),
        ("{", "a JSON file"),
        ("OFF", "an OFF file"),
        ("ply", "a PLY file"),
        ("CDF", "a NetCDF file, such as Exodus"),
        ("SetFactory", "a Gmsh geometry (`.geo`), which has to be meshed first"),
        ("Point(", "a Gmsh geometry (`.geo`), which has to be meshed first"),
        ("//", "a Gmsh geometry (`.geo`), which has to be meshed first"),
        ("$", "a file whose first section is not $MeshFormat"),
    ];
    if begin.is_empty() {
        return "an empty file";
    }
    if [[1, 0, 0, 0], [0, 0, 0, 1]].iter().any(|code| content.starts_with(code)) {
        return "a binary file of Medit (`.meshb`)";
    }
    if begin.starts_with(b"\x89HDF") {
        return "an HDF5 file, such as MED or CGNS";
    }
    known.iter().find(|(prefix, _)| starts(prefix)).map_or("something that begins like no known mesh file", |(_, name)| name)
}
