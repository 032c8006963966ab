//! Files of SU2 (`.su2`): cells by VTK's numbers of their types, points, and markers, which are boundaries.
//!
//! Nodes and cells are counted from 0; surplus numbers at the ends of lines are ignored (SU2 documentation, "Mesh file").

use super::tables::{Shape, Tables};
use super::text::utf8;
use super::words::malformed;
use crate::elements::CellKind;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Lines with content and their numbers.
struct Lines<'a>(Box<dyn Iterator<Item = (usize, &'a str)> + 'a>);

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Lines<'a> {
        let content = |line: &'a str| line.split('%').next().unwrap_or("").trim();
        Lines(Box::new((1..).zip(text.lines().map(content)).filter(|(_, line)| !line.is_empty())))
    }

    /// The next line of a section, which must not be a keyword.
    fn of_section(&mut self, section: &str, begin: usize, found: usize, announced: usize) -> Result<(usize, &'a str), MeshError> {
        match self.0.next() {
            Some((line, content)) if !content.contains('=') => Ok((line, content)),
            other => {
                let at = FilePosition::Line(other.map_or(begin, |(line, _)| line));
                let problem = FileProblem::Truncated { section: section.into(), begin: FilePosition::Line(begin), found, announced };
                Err(FileError { at, problem }.into())
            }
        }
    }
}

/// True if a file begins like an SU2 file.
pub(super) fn begins(content: &[u8]) -> bool {
    let mut lines = content.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty());
    lines.find(|line| !line.starts_with(b"%")).is_some_and(|line| [&b"NDIME"[..], b"NZONE"].iter().any(|word| line.starts_with(word)))
}

/// Reads the tables of nodes, cells and markers from the content of an SU2 file.
pub(super) fn read(content: &[u8]) -> Result<Tables, MeshError> {
    let mut lines = Lines::new(utf8(content)?);
    let (mut tables, mut dimension, mut number) = (Tables::default(), 0, 0);
    while let Some((line, content)) = lines.0.next() {
        let at = FilePosition::Line(line);
        let Some((keyword, value)) = content.split_once('=').map(|(keyword, value)| (keyword, value.trim())) else {
            return Err(malformed(at, "a keyword with its value, such as NELEM= 10", content));
        };
        let count = || {
            let first = value.split_ascii_whitespace().next().unwrap_or("");
            first.parse::<usize>().map_err(|_| malformed(at, "a whole number behind the keyword", value))
        };
        match keyword.trim() {
            "NZONE" if count()? > 1 => {
                let cure = "save each zone in a file of its own";
                return Err(FileError { at, problem: FileProblem::Form { found: format!("{} zones", count()?), cure } }.into());
            }
            "NDIME" => {
                dimension = count()?;
                if !matches!(dimension, 2 | 3) {
                    return Err(malformed(at, "the dimension, 2 or 3", value));
                }
            }
            "NPOIN" | "NELEM" | "MARKER_TAG" if dimension == 0 => {
                return Err(FileError { at, problem: FileProblem::MissingSection { section: "NDIME" } }.into());
            }
            "NPOIN" => points(&mut lines, &mut tables, dimension, count()?, line)?,
            "NELEM" => {
                tables.elements_begin = Some(at);
                let none = tables.groups_index(Vec::new());
                elements(&mut lines, &mut tables, ("NELEM", none), count()?, line, &mut number)?;
            }
            "MARKER_TAG" => {
                let group = tables.names.len() as u64 + 1;
                tables.names.insert((dimension - 1, group), value.into());
            }
            "MARKER_ELEMS" => {
                let group = tables.names.len() as u64;
                let group = tables.groups_index(if group > 0 { vec![group] } else { Vec::new() });
                elements(&mut lines, &mut tables, ("MARKER_ELEMS", group), count()?, line, &mut number)?;
            }
            _ => {}
        }
    }
    tables.turn_wedges();
    Ok(tables)
}

fn points(lines: &mut Lines, tables: &mut Tables, dimension: usize, count: usize, begin: usize) -> Result<(), MeshError> {
    const EXPECTED: &str = "the coordinates of a point";
    for index in 0..count {
        let (line, content) = lines.of_section("NPOIN", begin, index, count)?;
        let at = FilePosition::Line(line);
        let (mut point, mut words) = ([0.0; 3], content.split_ascii_whitespace());
        for x in &mut point[..dimension] {
            *x = words.next().and_then(|word| word.parse().ok()).ok_or_else(|| malformed(at, EXPECTED, content))?;
        }
        tables.add_node(index as u64, point, at)?;
    }
    Ok(())
}

fn elements(
    lines: &mut Lines,
    tables: &mut Tables,
    (section, group): (&str, u32),
    count: usize,
    begin: usize,
    number: &mut u64,
) -> Result<(), MeshError> {
    const EXPECTED: &str = "the type of an element and its points";
    for index in 0..count {
        let (line, content) = lines.of_section(section, begin, index, count)?;
        let at = FilePosition::Line(line);
        let mut words = content.split_ascii_whitespace().map(str::parse::<u64>);
        let Some(Ok(vtk_type)) = words.next() else { return Err(malformed(at, EXPECTED, content)) };
        let shape = match vtk_type {
            1 => Some(Shape::Point),
            3 => Some(Shape::Line(2)),
            _ => CellKind::ALL.iter().find(|kind| u64::from(kind.row().vtk_type) == vtk_type).map(|&kind| Shape::Cell(kind)),
        };
        let Some(shape) = shape else {
            let problem = FileProblem::UnsupportedCell { element: *number, kind: format!("cell of VTK type {vtk_type}") };
            return Err(FileError { at, problem }.into());
        };
        let nodes: Vec<u64> = words.map_while(Result::ok).take(shape.nodes()).collect();
        if nodes.len() < shape.nodes() {
            return Err(malformed(at, EXPECTED, content));
        }
        tables.add_element(shape, *number, group, (&nodes, &[]), at);
        *number += 1;
    }
    Ok(())
}
