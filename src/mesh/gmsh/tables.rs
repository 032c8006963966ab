//! What both versions of the format hold: nodes, elements of three kinds, and the physical groups they belong to, as the file numbers them.

use std::collections::{BTreeMap, HashMap};

use super::lines::{Fields, Lines, Section};
use crate::mesh::MeshError;

/// An element with `N` nodes.
pub(super) struct Element<const N: usize> {
    /// Number in the file.
    pub number: u64,
    /// Line of the file.
    pub line: u32,
    /// Index into [`Tables::groups`].
    pub groups: u32,
    /// Numbers of its nodes in the file.
    pub nodes: [u64; N],
}

/// The content of a file, not yet connected.
#[derive(Default)]
pub(super) struct Tables {
    pub node_numbers: Vec<u64>,
    pub node_lines: Vec<u32>,
    pub points: Vec<[f64; 3]>,
    pub single_points: Vec<Element<1>>,
    pub lines: Vec<Element<2>>,
    pub quads: Vec<Element<4>>,
    pub hexes: Vec<Element<8>>,
    /// Lists of physical groups that elements belong to; the first list is empty.
    pub groups: Vec<Vec<u64>>,
    group_index: HashMap<Vec<u64>, u32>,
    /// Names of physical groups by dimension and number.
    pub names: BTreeMap<(usize, u64), String>,
    /// Line of the section of elements.
    pub elements_line: usize,
}

impl Tables {
    /// Index of a list of physical groups.
    pub fn groups_index(&mut self, list: Vec<u64>) -> u32 {
        if let Some(&index) = self.group_index.get(&list) {
            return index;
        }
        let index = self.groups.len() as u32;
        self.groups.push(list.clone());
        self.group_index.insert(list, index);
        index
    }

    /// Keeps a node; its coordinates must be finite.
    pub fn add_node(&mut self, node: u64, point: [f64; 3], line: usize) -> Result<(), MeshError> {
        if let Some(&value) = point.iter().find(|x| !x.is_finite()) {
            return Err(MeshError::Coordinate { line, node, value });
        }
        self.node_numbers.push(node);
        self.node_lines.push(line as u32);
        self.points.push(point);
        Ok(())
    }

    /// Keeps an element of a kind that is read, whose nodes are the fields that are left; points are passed over.
    pub fn add_element(&mut self, gmsh_type: u64, number: u64, groups: u32, fields: &mut Fields, at: usize) -> Result<(), MeshError> {
        let line = at as u32;
        match gmsh_type {
            POINT => {
                self.single_points.push(Element { number, line, groups, nodes: fields.numbers(ELEMENT)? });
                fields.end(ELEMENT)
            }
            LINE => {
                self.lines.push(Element { number, line, groups, nodes: fields.numbers(ELEMENT)? });
                fields.end(ELEMENT)
            }
            QUAD4 => {
                self.quads.push(Element { number, line, groups, nodes: fields.numbers(ELEMENT)? });
                fields.end(ELEMENT)
            }
            HEX8 => {
                self.hexes.push(Element { number, line, groups, nodes: fields.numbers(ELEMENT)? });
                fields.end(ELEMENT)
            }
            _ => Err(MeshError::UnsupportedCell { line: at, element: number, gmsh_type, kind: kind_name(gmsh_type) }),
        }
    }

    /// The section of names, the same in both versions: `dimension number "name"`.
    pub fn read_names(&mut self, lines: &mut Lines) -> Result<(), MeshError> {
        const EXPECTED: &str = "dimension, number and name in quotation marks of a physical group";
        let mut section = Section { name: "PhysicalNames", begin: lines.number, announced: 0, found: 0 };
        let mut count = lines.entry(&section)?;
        section.announced = count.number("the number of physical groups")?;
        while section.found < section.announced {
            let mut fields = lines.entry(&section)?;
            let [dimension, number]: [u64; 2] = fields.numbers(EXPECTED)?;
            let text = fields.text();
            let (Some(open), Some(close)) = (text.find('"'), text.rfind('"')) else { return Err(fields.malformed(EXPECTED)) };
            if open == close || dimension > 3 {
                return Err(fields.malformed(EXPECTED));
            }
            let (dimension, name) = (dimension as usize, text[open + 1..close].to_string());
            let same = self.names.iter().find(|((d, n), other)| *d == dimension && *n != number && **other == name);
            if let Some((&(_, first), _)) = same {
                return Err(MeshError::AmbiguousName { line: lines.number, dimension, name, first, second: number });
            }
            self.names.insert((dimension, number), name);
            section.found += 1;
        }
        lines.close(&section)
    }
}

const POINT: u64 = 15;
const LINE: u64 = 1;
const QUAD4: u64 = 3;
const HEX8: u64 = 5;

/// What a line of an element holds.
pub(super) const ELEMENT: &str = "an element with its number, tags and nodes";

fn kind_name(gmsh_type: u64) -> String {
    let known = match gmsh_type {
        2 => "3-node triangle",
        4 => "4-node tetrahedron",
        6 => "6-node prism",
        7 => "5-node pyramid",
        8 => "3-node line (second order)",
        9 => "6-node triangle (second order)",
        10 => "9-node quadrilateral (second order)",
        11 => "10-node tetrahedron (second order)",
        12 => "27-node hexahedron (second order)",
        16 => "8-node quadrilateral (second order)",
        17 => "20-node hexahedron (second order)",
        other => return format!("cell of Gmsh type {other}"),
    };
    known.into()
}
