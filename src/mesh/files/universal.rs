//! Universal files of I-deas, NX, Salome and Gmsh (`.unv`): nodes (datasets 2411, 781), elements (2412), groups (2435, 2452, 2467, 2477).
//!
//! Element groups become parts and boundaries, node groups boundaries. Second-order cells list their nodes around each face, corners and
//! mid-side nodes alternately. All other datasets, including units, are left out (I-deas, Universal Dataset Number 2411, 2412, 2467).

use std::collections::HashMap;

use super::tables::{NodeSet, Shape, Tables};
use super::text::utf8;
use super::words::malformed;
use crate::elements::CellKind;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Line that begins and ends a dataset.
const MARK: &str = "-1";

/// Codes of entities in groups.
const NODE: u64 = 7;
const ELEMENT: u64 = 8;

/// Family of an element by its number of the finite element descriptor.
enum Family {
    /// Beams, whose records have a line with their orientation before the nodes.
    Line,
    /// Plane or solid cells.
    Cell,
    /// Plates, membranes and thin shells.
    Shell,
}

/// Shape of a finite element descriptor, its family, and the place of each node in the file; empty for equal orders.
fn shape_of(descriptor: u64) -> Option<(Shape, Family, &'static [u8])> {
    let cell = |kind, order: &'static [u8]| Some((Shape::Cell(kind), Family::Cell, order));
    match descriptor {
        11 | 21 | 22 => Some((Shape::Line(2), Family::Line, &[])),
        23 | 24 => Some((Shape::Line(3), Family::Line, &[0, 2, 1])),
        111 => cell(CellKind::Tet4, &[]),
        112 => cell(CellKind::Wedge6, &[]),
        113 => cell(CellKind::Wedge15, &[0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8]),
        115 => cell(CellKind::Hex8, &[]),
        116 => cell(CellKind::Hex20, &[0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11]),
        118 => cell(CellKind::Tet10, &[0, 2, 4, 9, 1, 3, 5, 6, 7, 8]),
        41..=99 => {
            // Descriptors of plane stress, plane strain and axisymmetric cells; others are plates, membranes and thin shells.
            let family = if matches!(descriptor / 10, 4 | 5 | 8) { Family::Cell } else { Family::Shell };
            let (kind, order): (_, &[u8]) = match descriptor % 10 {
                1 => (CellKind::Tri3, &[]),
                2 => (CellKind::Tri6, &[0, 2, 4, 1, 3, 5]),
                4 => (CellKind::Quad4, &[]),
                5 => (CellKind::Quad8, &[0, 2, 4, 6, 1, 3, 5, 7]),
                _ => return None,
            };
            Some((Shape::Cell(kind), family, order))
        }
        _ => None,
    }
}

/// True if a file begins like a universal file.
pub(super) fn begins(content: &[u8]) -> bool {
    let mut lines = content.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty());
    lines.next() == Some(MARK.as_bytes())
}

/// Reads the tables of nodes, cells and groups from the content of a universal file.
pub(super) fn read(content: &[u8]) -> Result<Tables, MeshError> {
    let mut file = File { lines: utf8(content)?.lines().collect(), at: 0, dataset: String::new() };
    let (mut tables, mut elements, mut groups) = (Tables::default(), Vec::new(), Groups::default());
    while file.begin_dataset()? {
        match file.dataset.as_str() {
            "2411" | "781" => nodes(&mut file, &mut tables)?,
            "2412" => read_elements(&mut file, &mut tables, &mut elements)?,
            "2435" | "2452" | "2467" | "2477" => read_groups(&mut file, &mut tables, &mut groups)?,
            _ => while file.record()?.is_some() {},
        }
    }
    for Element { number, shape, order, nodes, at } in elements {
        let mut of_element = groups.of_elements.remove(&number).unwrap_or_default();
        of_element.dedup();
        let list = tables.groups_index(of_element);
        tables.add_element(shape, number, list, (&nodes, order), at);
    }
    if let Some((&number, list)) = groups.of_elements.iter().min_by_key(|(number, _)| **number)
        && !groups.left_out.contains(&number)
    {
        let name = tables.name(0, list[0]);
        let problem = FileProblem::UnknownMember { owner: "group", name, kind: "element", number };
        return Err(FileError { at: groups.places[&list[0]], problem }.into());
    }
    Ok(tables)
}

/// Lines of a file.
struct File<'a> {
    lines: Vec<&'a str>,
    /// Number of lines that are read.
    at: usize,
    /// Number of the dataset.
    dataset: String,
}

impl<'a> File<'a> {
    fn place(&self) -> FilePosition {
        FilePosition::Line(self.at.max(1))
    }

    /// Continues after the next mark and the number of the dataset; false at the end of the file.
    fn begin_dataset(&mut self) -> Result<bool, MeshError> {
        loop {
            let Some(line) = self.lines.get(self.at) else { return Ok(false) };
            self.at += 1;
            match line.trim() {
                "" => {}
                MARK => break,
                other => return Err(malformed(self.place(), "the line -1 before a dataset", other)),
            }
        }
        let Some(number) = self.lines.get(self.at) else { return Ok(false) };
        self.at += 1;
        self.dataset = number.trim().into();
        Ok(true)
    }

    /// The next line of the dataset; `None` at its end.
    fn record(&mut self) -> Result<Option<&'a str>, MeshError> {
        let Some(&line) = self.lines.get(self.at) else {
            return Err(malformed(self.place(), "the line -1 at the end of the dataset", "the end of the file"));
        };
        self.at += 1;
        Ok((line.trim() != MARK).then_some(line))
    }

    /// Next line of the dataset with at least `least` whole numbers.
    fn numbers(&mut self, least: usize, expected: &'static str) -> Result<Option<Vec<u64>>, MeshError> {
        let Some(line) = self.record()? else { return Ok(None) };
        let numbers: Option<Vec<u64>> = line.split_ascii_whitespace().map(|word| word.parse().ok()).collect();
        match numbers.filter(|numbers| numbers.len() >= least) {
            Some(numbers) => Ok(Some(numbers)),
            None => Err(malformed(self.place(), expected, line.trim())),
        }
    }
}

fn nodes(file: &mut File, tables: &mut Tables) -> Result<(), MeshError> {
    const EXPECTED: &str = "three coordinates of a node";
    while let Some(head) = file.numbers(1, "the number of a node and its coordinate systems")? {
        let at = file.place();
        let line = file.record()?.unwrap_or(MARK);
        let numbers = line.split_ascii_whitespace().map(|word| word.replace(['D', 'd'], "E").parse::<f64>().ok());
        match numbers.collect::<Option<Vec<f64>>>().as_deref() {
            Some(&[x, y, z]) => tables.add_node(head[0], [x, y, z], at)?,
            _ => return Err(malformed(file.place(), EXPECTED, line.trim())),
        }
    }
    Ok(())
}

/// Element whose groups are added after all of them were read.
struct Element {
    number: u64,
    shape: Shape,
    order: &'static [u8],
    nodes: Vec<u64>,
    at: FilePosition,
}

fn read_elements(file: &mut File, tables: &mut Tables, elements: &mut Vec<Element>) -> Result<(), MeshError> {
    tables.elements_begin = Some(file.place());
    while let Some(head) = file.numbers(6, "number, type, properties, color and number of nodes of an element")? {
        let (number, descriptor, count, at) = (head[0], head[1], head[5] as usize, file.place());
        let known = shape_of(descriptor);
        // The record of a beam or rod has a line with its orientation, also if its type is unknown.
        if matches!(descriptor, 11 | 21..=24) {
            file.record()?;
        }
        let mut nodes = Vec::new();
        while nodes.len() < count {
            match file.numbers(1, "the nodes of an element")? {
                Some(more) => nodes.extend(more),
                None => return Err(malformed(file.place(), "the nodes of an element", MARK)),
            }
        }
        let Some((shape, family, order)) = known.filter(|(shape, ..)| shape.nodes() == count) else {
            if matches!(descriptor, 101..=119) {
                let problem =
                    FileProblem::UnsupportedCell { element: number, kind: format!("solid of type {descriptor} and {count} nodes") };
                return Err(FileError { at, problem }.into());
            }
            tables.left_out.entry(format!("element of type {descriptor}")).or_insert((0, at)).0 += 1;
            continue;
        };
        if matches!(family, Family::Shell) {
            tables.structural.insert(number);
            tables.structural_types.entry(shape).or_insert(("thin shell".into(), at));
        }
        elements.push(Element { number, shape, order, nodes, at });
    }
    Ok(())
}

/// Groups of elements.
#[derive(Default)]
struct Groups {
    /// Groups of an element by its number.
    of_elements: HashMap<u64, Vec<u64>>,
    places: HashMap<u64, FilePosition>,
    left_out: Vec<u64>,
}

fn read_groups(file: &mut File, tables: &mut Tables, groups: &mut Groups) -> Result<(), MeshError> {
    const EXPECTED: &str = "pairs of a code of entities and the number of one";
    while let Some(head) = file.numbers(8, "the number of a group, seven numbers of sets, and the number of its entities")? {
        let (at, count, number) = (file.place(), head[7] as usize, groups.places.len() as u64 + 1);
        let name = file.record()?.unwrap_or("").trim().to_string();
        (0..4).for_each(|dimension| drop(tables.names.insert((dimension, number), name.clone())));
        groups.places.insert(number, at);
        let (mut found, mut nodes) = (0, Vec::new());
        while found < count {
            let Some(entities) = file.numbers(4, EXPECTED)? else { return Err(malformed(file.place(), EXPECTED, MARK)) };
            for entity in entities.chunks(4) {
                match entity[0] {
                    NODE => nodes.extend(entity.get(1)),
                    ELEMENT => entity.get(1).into_iter().for_each(|&of| groups.of_elements.entry(of).or_default().push(number)),
                    _ => {}
                }
                found += 1;
            }
        }
        if !nodes.is_empty() {
            tables.node_sets.push(NodeSet { name, at, nodes });
        }
    }
    Ok(())
}
