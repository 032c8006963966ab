//! Elements and names of groups, which have a common layout in both versions.

use super::super::tables::{Shape, Tables};
use super::source::{Entry, Section, Source};
use crate::elements::CellKind;
use crate::mesh::MeshError;
use crate::mesh::file_error::FileProblem;

/// Description of an element entry for messages.
pub(super) const ELEMENT: &str = "an element with its number, tags and nodes";

/// Shape of an element type number in Gmsh files; `None` if the type is not read.
fn shape_of(gmsh_type: u64) -> Option<Shape> {
    let cell = || CellKind::ALL.iter().find(|kind| kind.row().gmsh_type == gmsh_type).map(|&kind| Shape::Cell(kind));
    match gmsh_type {
        15 => Some(Shape::Point),
        1 => Some(Shape::Line(2)),
        8 => Some(Shape::Line(3)),
        _ => cell(),
    }
}

/// Gmsh's number of a shape.
pub(in crate::mesh::files) fn number_of(shape: Shape) -> u64 {
    match shape {
        Shape::Point => 15,
        Shape::Line(3) => 8,
        Shape::Line(_) => 1,
        Shape::Cell(kind) => kind.row().gmsh_type,
    }
}

/// Adds an element whose nodes are the remaining numbers of its entry.
pub(super) fn add_element(tables: &mut Tables, gmsh_type: u64, number: u64, groups: u32, mut entry: Entry) -> Result<(), MeshError> {
    // Prisms of 18 and pyramids of 14 nodes are read without their last nodes, which lie in their faces.
    let known = match gmsh_type {
        13 => tables.without_face_nodes(CellKind::Wedge15, number).map(|(shape, _)| (shape, 3)),
        14 => tables.without_face_nodes(CellKind::Pyr13, number).map(|(shape, _)| (shape, 1)),
        _ => shape_of(gmsh_type).map(|shape| (shape, 0)),
    };
    let Some((shape, in_faces)) = known else {
        return entry.fail(FileProblem::UnsupportedCell { element: number, kind: kind_name(gmsh_type) });
    };
    // Buffer larger than the number of nodes of any element.
    let mut nodes = [0; 32];
    let nodes = &mut nodes[..shape.nodes()];
    for node in &mut *nodes {
        *node = entry.node(ELEMENT)?;
    }
    (0..in_faces).try_for_each(|_| entry.node(ELEMENT).map(drop))?;
    entry.end(ELEMENT)?;
    let order = shape.row().map_or(&[][..], |row| row.gmsh_order);
    tables.add_element(shape, number, groups, (nodes, order), entry.place());
    Ok(())
}

/// Reads the section of names, common to both versions: `dimension number "name"`.
pub(super) fn read_names(source: &mut Source, tables: &mut Tables) -> Result<(), MeshError> {
    const EXPECTED: &str = "dimension, number and name in quotation marks of a physical group";
    let mut section = Section::new("$PhysicalNames", source);
    section.announced = source.line(&section)?.word("the number of physical groups")?;
    while section.found < section.announced {
        let mut entry = source.line(&section)?;
        let (dimension, number): (usize, u64) = (entry.word(EXPECTED)?, entry.word(EXPECTED)?);
        let text = entry.text();
        let (Some(open), Some(close)) = (text.find('"'), text.rfind('"')) else { return Err(entry.malformed(EXPECTED)) };
        if open == close || dimension > 3 {
            return Err(entry.malformed(EXPECTED));
        }
        let name = text[open + 1..close].to_string();
        let same = tables.names.iter().find(|((d, n), other)| *d == dimension && *n != number && **other == name);
        if let Some((&(_, first), _)) = same {
            return entry.fail(FileProblem::AmbiguousName { dimension, name, first, second: number });
        }
        tables.names.insert((dimension, number), name);
        section.found += 1;
    }
    source.close(&section)
}

fn kind_name(gmsh_type: u64) -> String {
    let known = match gmsh_type {
        21 => "10-node triangle (third order)",
        26 => "4-node line (third order)",
        29 => "20-node tetrahedron (third order)",
        36 => "16-node quadrilateral (third order)",
        other => return format!("cell of Gmsh type {other}"),
    };
    known.into()
}
