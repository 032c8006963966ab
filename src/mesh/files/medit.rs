//! Files of Medit, FreeFEM and MMG (`.mesh`, ASCII): a list of vertices, and a list of elements of each kind.
//!
//! Each vertex and element ends with a reference number. Numbers of cells name parts, those of elements one dimension below name
//! boundaries; 0 means none. Corners, ridges, normals and other data are left out (P. J. Frey, Medit: an interactive mesh visualization
//! software, INRIA RT-0253, 2001).

use super::tables::{Shape, Tables};
use super::text::utf8;
use super::words::{Words, malformed};
use crate::elements::CellKind;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Keywords of supported elements. Hexahedra have two spellings.
const ELEMENTS: &[(&str, Shape)] = &[
    ("Edges", Shape::Line(2)),
    ("Triangles", Shape::Cell(CellKind::Tri3)),
    ("Quadrilaterals", Shape::Cell(CellKind::Quad4)),
    ("Tetrahedra", Shape::Cell(CellKind::Tet4)),
    ("Hexahedra", Shape::Cell(CellKind::Hex8)),
    ("Hexaedra", Shape::Cell(CellKind::Hex8)),
    ("Prisms", Shape::Cell(CellKind::Wedge6)),
    ("Pyramids", Shape::Cell(CellKind::Pyr5)),
];

/// Endings of the keywords of second-order elements, whose node order depends on the mesher.
const SECOND_ORDER: [&str; 2] = ["P2", "Q2"];

/// True if a file begins like a Medit file.
pub(super) fn begins(content: &[u8]) -> bool {
    let keyword = b"MeshVersionFormatted";
    let mut lines = content.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty());
    lines.find(|line| !line.starts_with(b"#")).is_some_and(|line| line.starts_with(keyword))
}

/// Reads the tables of vertices and elements from the content of a MEDIT file.
pub(super) fn read(content: &[u8]) -> Result<Tables, MeshError> {
    let mut words = Words::new(utf8(content)?, '#');
    let (mut tables, mut dimension, mut number) = (Tables::default(), 3, 0);
    let mut has_vertices = false;
    loop {
        let at = words.place();
        let Some(keyword) = words.next() else { break };
        match keyword {
            "End" => break,
            "MeshVersionFormatted" => drop(words.number::<u32>("the version of the format")?),
            "Dimension" => {
                let place = words.place();
                dimension = words.number("the dimension, 2 or 3")?;
                if !matches!(dimension, 2 | 3) {
                    return Err(malformed(place, "the dimension, 2 or 3", &dimension.to_string()));
                }
            }
            "Vertices" => {
                vertices(&mut words, &mut tables, dimension, at)?;
                has_vertices = true;
            }
            _ => match ELEMENTS.iter().find(|(name, _)| *name == keyword) {
                Some(&(name, shape)) => elements(&mut words, &mut tables, name, shape, &mut number, at)?,
                None if SECOND_ORDER.iter().any(|ending| keyword.ends_with(ending)) && !keyword.contains("At") => {
                    let cure = "write cells of first order, or save the mesh as Gmsh or VTK file";
                    let found = format!("elements of second order ({keyword})");
                    return Err(FileError { at, problem: FileProblem::Form { found, cure } }.into());
                }
                None if keyword.starts_with(|c: char| c.is_ascii_alphabetic()) => {
                    while words.peek().is_some_and(|word| !word.starts_with(|c: char| c.is_ascii_alphabetic())) {
                        words.next();
                    }
                }
                None => return Err(malformed(at, "a keyword, such as Vertices or Tetrahedra", keyword)),
            },
        }
    }
    if !has_vertices {
        return Err(FileError { at: words.place(), problem: FileProblem::MissingSection { section: "Vertices" } }.into());
    }
    Ok(tables)
}

/// Error of a list that is cut off by the end of the file.
fn ended(section: &str, begin: FilePosition, found: usize, announced: usize, at: FilePosition) -> MeshError {
    FileError { at, problem: FileProblem::Truncated { section: section.into(), begin, found, announced } }.into()
}

fn vertices(words: &mut Words, tables: &mut Tables, dimension: usize, begin: FilePosition) -> Result<(), MeshError> {
    const EXPECTED: &str = "the coordinates of a vertex and its reference number";
    let count = words.number("the number of vertices")?;
    for index in 0..count {
        let at = words.place();
        if words.peek().is_none() {
            return Err(ended("Vertices", begin, index, count, at));
        }
        let mut point = [0.0; 3];
        for x in &mut point[..dimension] {
            *x = words.number(EXPECTED)?;
        }
        words.number::<i64>(EXPECTED)?;
        tables.add_node(index as u64 + 1, point, at)?;
    }
    Ok(())
}

fn elements(
    words: &mut Words,
    tables: &mut Tables,
    section: &str,
    shape: Shape,
    number: &mut u64,
    begin: FilePosition,
) -> Result<(), MeshError> {
    const EXPECTED: &str = "the vertices of an element and its reference number";
    tables.elements_begin.get_or_insert(begin);
    let count = words.number("the number of elements")?;
    let mut nodes = [0; 8];
    let nodes = &mut nodes[..shape.nodes()];
    for index in 0..count {
        let at = words.place();
        if words.peek().is_none() {
            return Err(ended(section, begin, index, count, at));
        }
        for node in &mut *nodes {
            *node = words.number(EXPECTED)?;
        }
        let reference: i64 = words.number(EXPECTED)?;
        let groups = if reference == 0 { Vec::new() } else { vec![reference.unsigned_abs()] };
        let groups = tables.groups_index(groups);
        *number += 1;
        tables.add_element(shape, *number, groups, (nodes, &[]), at);
    }
    Ok(())
}
