//! What mesh files hold, whatever their format: nodes, elements by their shape, and the groups they belong to, as the file numbers them.

use std::collections::{BTreeMap, HashMap};

use crate::elements::{CellKind, CellRow};
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FileProblem, Place};

/// The shape of an element with its number of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Shape {
    /// A single node.
    Point,
    /// A line of 2 or 3 nodes.
    Line(usize),
    /// A cell, or in space a facet of one.
    Cell(CellKind),
}

impl Shape {
    /// How many nodes it has.
    pub fn nodes(self) -> usize {
        match self {
            Shape::Point => 1,
            Shape::Line(nodes) => nodes,
            Shape::Cell(kind) => kind.nodes(),
        }
    }

    /// Its cell kind's row, where it is a cell.
    pub fn row(self) -> Option<&'static CellRow> {
        if let Shape::Cell(kind) = self { Some(kind.row()) } else { None }
    }

    /// Its own dimension.
    pub fn dimension(self) -> usize {
        match self {
            Shape::Point => 0,
            Shape::Line(_) => 1,
            Shape::Cell(kind) => kind.dimension(),
        }
    }
}

/// Elements of one shape.
#[derive(Default)]
pub(super) struct Elements {
    /// Numbers in the file.
    pub numbers: Vec<u64>,
    /// Where they stand: line or byte.
    places: Vec<u64>,
    /// Indices into [`Tables::groups`].
    pub groups: Vec<u32>,
    /// Numbers of the nodes in the file, those of one element after those of the one before.
    pub nodes: Vec<u64>,
}

/// Sides of elements under one name.
pub(super) struct Surface {
    pub name: String,
    /// Where it begins.
    pub at: Place,
    /// Numbers of elements, each with a side from 1; 0 for all its sides on the hull.
    pub sides: Vec<(u64, u8)>,
}

/// Nodes under one name.
pub(super) struct NodeSet {
    pub name: String,
    /// Where it begins.
    pub at: Place,
    /// Numbers of the nodes.
    pub nodes: Vec<u64>,
}

/// The content of a file, not yet connected.
#[derive(Default)]
pub(super) struct Tables {
    /// Whether places are bytes.
    pub is_binary: bool,
    pub node_numbers: Vec<u64>,
    node_places: Vec<u64>,
    pub points: Vec<[f64; 3]>,
    pub elements: BTreeMap<Shape, Elements>,
    /// Lists of groups that elements belong to.
    pub groups: Vec<Vec<u64>>,
    group_index: HashMap<Vec<u64>, u32>,
    /// Names of groups by dimension and number.
    pub names: BTreeMap<(usize, u64), String>,
    pub surfaces: Vec<Surface>,
    pub node_sets: Vec<NodeSet>,
    /// Where the elements begin.
    pub elements_begin: Option<Place>,
}

impl Tables {
    fn place(&self, stored: u64) -> Place {
        if self.is_binary { Place::Byte(stored as usize) } else { Place::Line(stored as usize) }
    }

    /// Where a node of the table stands.
    pub fn node_place(&self, index: usize) -> Place {
        self.place(self.node_places[index])
    }

    /// Where an element stands.
    pub fn element_place(&self, elements: &Elements, index: usize) -> Place {
        self.place(elements.places[index])
    }

    /// Index of a list of groups.
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
    pub fn add_node(&mut self, node: u64, point: [f64; 3], at: Place) -> Result<(), MeshError> {
        if let Some(&value) = point.iter().find(|x| !x.is_finite()) {
            return Err(FileError { at, problem: FileProblem::Coordinate { node, value } }.into());
        }
        self.node_numbers.push(node);
        self.node_places.push(number_of(at));
        self.points.push(point);
        Ok(())
    }

    /// Keeps an element, whose nodes stand in the file in such an order ([`crate::elements::CellRow::gmsh_order`]).
    pub fn add_element(&mut self, shape: Shape, number: u64, groups: u32, (nodes, order): (&[u64], &[u8]), at: Place) {
        let elements = self.elements.entry(shape).or_default();
        elements.numbers.push(number);
        elements.places.push(number_of(at));
        elements.groups.push(groups);
        if order.is_empty() {
            elements.nodes.extend(nodes);
        } else {
            elements.nodes.extend(order.iter().map(|&place| nodes[usize::from(place)]));
        }
    }

    /// Name of a group: as in the file, or its number.
    pub fn name(&self, dimension: usize, group: u64) -> String {
        self.names.get(&(dimension, group)).cloned().unwrap_or_else(|| group.to_string())
    }
}

fn number_of(at: Place) -> u64 {
    match at {
        Place::Line(number) | Place::Byte(number) => number as u64,
    }
}
