//! Content of mesh files of any format: nodes, elements by their shape, and their groups, numbered as in the file.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::collapse::{Collapse, first_places, smaller_kinds};
use super::options::FileNote;
use crate::elements::{CellKind, CellRow};
use crate::mesh::MeshError;
use crate::mesh::check::repeated;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

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
    /// Number of nodes of an element of this shape.
    pub fn nodes(self) -> usize {
        match self {
            Shape::Point => 1,
            Shape::Line(nodes) => nodes,
            Shape::Cell(kind) => kind.nodes(),
        }
    }

    /// Catalogue row of the cell kind; `None` for points and lines.
    pub fn row(self) -> Option<&'static CellRow> {
        if let Shape::Cell(kind) = self { Some(kind.row()) } else { None }
    }

    /// Topological dimension: 0 for a point, 1 for a line, 2 or 3 for a cell.
    pub fn dimension(self) -> usize {
        match self {
            Shape::Point => 0,
            Shape::Line(_) => 1,
            Shape::Cell(kind) => kind.dimension(),
        }
    }
}

/// Elements of one shape.
#[derive(Clone, Default)]
pub(super) struct Elements {
    /// Numbers in the file.
    pub numbers: Vec<u64>,
    /// Places of the elements: line or byte.
    places: Vec<u64>,
    /// Indices into [`Tables::groups`].
    pub groups: Vec<u32>,
    /// Numbers of the nodes in the file, element by element.
    pub nodes: Vec<u64>,
}

/// An element that was taken out of its table.
struct Element {
    number: u64,
    place: u64,
    groups: u32,
    nodes: Vec<u64>,
}

/// Sides of elements under one name.
#[derive(Clone)]
pub(super) struct Surface {
    pub name: String,
    /// Numbers of elements, each with a side from 1, or 0 for all its sides on the hull, and the place that names it.
    pub sides: Vec<(u64, u8, FilePosition)>,
}

/// Nodes under one name.
#[derive(Clone)]
pub(super) struct NodeSet {
    pub name: String,
    /// Place of the definition.
    pub at: FilePosition,
    /// Numbers of the nodes.
    pub nodes: Vec<u64>,
}

/// Nodes, elements, groups and sets as read from a mesh file, by their numbers in the file, before a mesh is built from them.
#[derive(Clone, Default)]
pub(super) struct Tables {
    /// True if places are byte offsets, not lines.
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
    /// Start of the elements.
    pub elements_begin: Option<FilePosition>,
    /// Structural elements: elements with a shape that are no cells, such as shells, by their numbers.
    pub structural: HashSet<u64>,
    /// For each shape of structural elements, the name of a type and its place.
    pub structural_types: BTreeMap<Shape, (String, FilePosition)>,
    /// True if lines among the structural elements are beams.
    pub has_beams: bool,
    /// Left-out elements without a shape: for each type, their count and the place of the first.
    pub left_out: BTreeMap<String, (usize, FilePosition)>,
    /// Cells whose nodes in faces were left out: their count, and the number of the first such cell.
    pub without_face_nodes: Option<(usize, u64)>,
    /// Cells that were written with repeated nodes, by their numbers.
    pub collapsed: HashMap<u64, Collapse>,
    /// Original numbers of nodes that were renumbered from 1; empty if the numbers are those of the file.
    written_nodes: Vec<u64>,
    /// Original numbers of elements that were renumbered from 1; empty if the numbers are those of the file.
    written_elements: Vec<u64>,
}

/// Pairs `(old, new)` of numbers of the nodes and elements of appended tables.
pub(super) struct Appended {
    pub nodes: Vec<(u64, u64)>,
    pub elements: Vec<(u64, u64)>,
}

impl Elements {
    /// Removes and returns the elements, with `nodes_each` nodes each, whose number and nodes satisfy `condition`.
    fn take_out(&mut self, nodes_each: usize, condition: impl Fn(u64, &[u64]) -> bool) -> Vec<Element> {
        let nodes = |k: usize| &self.nodes[k * nodes_each..(k + 1) * nodes_each];
        let (taken, kept): (Vec<usize>, Vec<usize>) = (0..self.numbers.len()).partition(|&k| condition(self.numbers[k], nodes(k)));
        if taken.is_empty() {
            return Vec::new();
        }
        let element =
            |&k: &usize| Element { number: self.numbers[k], place: self.places[k], groups: self.groups[k], nodes: nodes(k).to_vec() };
        let elements = taken.iter().map(element).collect();
        self.nodes = kept.iter().flat_map(|&k| nodes(k)).copied().collect();
        self.places = kept.iter().map(|&k| self.places[k]).collect();
        self.groups = kept.iter().map(|&k| self.groups[k]).collect();
        self.numbers = kept.iter().map(|&k| self.numbers[k]).collect();
        elements
    }

    fn push(&mut self, element: Element) {
        self.numbers.push(element.number);
        self.places.push(element.place);
        self.groups.push(element.groups);
        self.nodes.extend(element.nodes);
    }
}

impl Tables {
    fn place(&self, stored: u64) -> FilePosition {
        if self.is_binary { FilePosition::Byte(stored as usize) } else { FilePosition::Line(stored as usize) }
    }

    /// Place of a node of the table.
    pub fn node_place(&self, index: usize) -> FilePosition {
        self.place(self.node_places[index])
    }

    /// Place of an element.
    pub fn element_place(&self, elements: &Elements, index: usize) -> FilePosition {
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

    /// Adds a node; its coordinates must be finite.
    pub fn add_node(&mut self, node: u64, point: [f64; 3], at: FilePosition) -> Result<(), MeshError> {
        if let Some(&value) = point.iter().find(|x| !x.is_finite()) {
            return Err(FileError { at, problem: FileProblem::Coordinate { node, value } }.into());
        }
        self.node_numbers.push(node);
        self.node_places.push(number_of(at));
        self.points.push(point);
        Ok(())
    }

    /// Adds an element whose nodes have the given order in the file ([`crate::elements::CellRow::gmsh_order`]).
    pub fn add_element(&mut self, shape: Shape, number: u64, groups: u32, (nodes, order): (&[u64], &[u8]), at: FilePosition) {
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

    /// Shape of a cell that is read without the nodes in its faces and its center, which are the last ones.
    pub fn without_face_nodes(&mut self, kind: CellKind, number: u64) -> Option<(Shape, &'static [u8])> {
        self.without_face_nodes.get_or_insert((0, number)).0 += 1;
        Some((Shape::Cell(kind), &[]))
    }

    /// Removes the nodes in faces and centers from all cells if some are read without them, so that neighbors match.
    pub fn match_face_nodes(&mut self) {
        if let Some(elements) = self.elements.get(&Shape::Cell(CellKind::Hex27)) {
            let mut cells = elements.nodes.chunks_exact(CellKind::Hex27.nodes());
            let first = cells.position(|nodes| repeated(nodes).is_some());
            first.map(|first| self.without_face_nodes.get_or_insert((0, elements.numbers[first])));
        }
        let Some((count, _)) = &mut self.without_face_nodes else { return };
        for (kind, reduced) in [(CellKind::Hex27, CellKind::Hex20), (CellKind::Quad9, CellKind::Quad8)] {
            let Some(elements) = self.elements.remove(&Shape::Cell(kind)) else { continue };
            *count += elements.numbers.len();
            let own = self.elements.entry(Shape::Cell(reduced)).or_default();
            own.nodes.extend(elements.nodes.chunks_exact(kind.nodes()).flat_map(|nodes| &nodes[..reduced.nodes()]));
            own.numbers.extend(elements.numbers);
            own.places.extend(elements.places);
            own.groups.extend(elements.groups);
        }
    }

    /// Converts cells with repeated nodes to the smaller kind that they represent; returns a note with their counts. Structural elements
    /// without extent are left out.
    ///
    /// # Errors
    /// A cell with repeated nodes that does not represent a smaller kind.
    pub fn collapse(&mut self) -> Result<Option<FileNote>, MeshError> {
        let mut known: HashMap<(CellKind, Vec<usize>), Option<Collapse>> = HashMap::new();
        let mut counts: BTreeMap<(CellKind, CellKind), usize> = BTreeMap::new();
        let mut first: Option<u64> = None;
        for &written in CellKind::ALL {
            let shape = Shape::Cell(written);
            let Some(elements) = self.elements.get_mut(&shape) else { continue };
            for element in elements.take_out(written.nodes(), |_, nodes| repeated(nodes).is_some()) {
                let pattern = (written, first_places(&element.nodes));
                let found = known.entry(pattern).or_insert_with_key(|(kind, first)| Collapse::new(*kind, first));
                let (number, at) = (element.number, self.place(element.place));
                let is_structural = self.structural.contains(&number);
                let Some(collapse) = found else {
                    if is_structural {
                        self.leave_out(shape, 1, at);
                        continue;
                    }
                    let node = repeated(&element.nodes).map_or(0, |node| self.written_node(node));
                    let (element, smaller) = (self.written_element(number), smaller_kinds(written).map(CellKind::name).collect());
                    return Err(FileError { at, problem: FileProblem::Collapsed { element, kind: written.name(), node, smaller } }.into());
                };
                let own = Shape::Cell(collapse.kind);
                if is_structural {
                    let known = self.structural_types.get(&shape).cloned();
                    known.map(|known| self.structural_types.entry(own).or_insert(known));
                } else {
                    *counts.entry((written, collapse.kind)).or_default() += 1;
                    first = Some(first.map_or(number, |first| first.min(number)));
                }
                let nodes = collapse.places.iter().map(|&place| element.nodes[place]).collect();
                self.collapsed.insert(number, collapse.clone());
                self.elements.entry(own).or_default().push(Element { nodes, ..element });
            }
        }
        let counts = counts.into_iter().map(|((written, kind), count)| (written.name(), kind.name(), count)).collect();
        Ok(first.map(|first| FileNote::Collapsed { counts, first: self.written_element(first) }))
    }

    /// Keeps the cells of one part only, with the elements and sides of boundaries on these cells.
    ///
    /// # Errors
    /// No cell is in a part of that name.
    pub fn keep_part(&mut self, part: &str) -> Result<(), MeshError> {
        let is_used = |(shape, elements): (&Shape, &Elements)| (!elements.numbers.is_empty()).then(|| shape.dimension());
        let Some(dimension) = self.elements.iter().filter_map(is_used).max() else { return Ok(()) };
        let cells = || self.elements.iter().filter(|(shape, _)| shape.dimension() == dimension);
        let used: BTreeSet<u64> =
            cells().flat_map(|(_, elements)| &elements.groups).flat_map(|&list| &self.groups[list as usize]).copied().collect();
        let Some(group) = used.iter().copied().find(|&group| self.name(dimension, group) == part) else {
            let available = used.iter().map(|&group| self.name(dimension, group)).collect();
            return Err(MeshError::UnknownPart { name: part.into(), available });
        };
        let (mut nodes, mut kept) = (HashSet::new(), HashSet::new());
        let groups = &self.groups;
        for (shape, elements) in self.elements.iter_mut().filter(|(shape, _)| shape.dimension() == dimension) {
            let is_member = |(&number, &list): (&u64, &u32)| groups[list as usize].contains(&group).then_some(number);
            let of_part: HashSet<u64> = elements.numbers.iter().zip(&elements.groups).filter_map(is_member).collect();
            elements.take_out(shape.nodes(), |number, _| !of_part.contains(&number));
            nodes.extend(elements.nodes.iter().copied());
            kept.extend(of_part);
        }
        for (shape, elements) in self.elements.iter_mut().filter(|(shape, _)| shape.dimension() < dimension) {
            elements.take_out(shape.nodes(), |_, own| own.iter().any(|node| !nodes.contains(node)));
        }
        self.surfaces.iter_mut().for_each(|surface| surface.sides.retain(|(number, ..)| kept.contains(number)));
        self.surfaces.retain(|surface| !surface.sides.is_empty());
        Ok(())
    }

    /// Reverses wedges whose first triangle faces away from the second, the order of VTK before version 9.6 and of SU2. Nodes must be
    /// numbered from 0 in their order.
    pub fn turn_wedges(&mut self) {
        for kind in [CellKind::Wedge6, CellKind::Wedge15] {
            let Some(elements) = self.elements.get_mut(&Shape::Cell(kind)) else { continue };
            for nodes in elements.nodes.chunks_exact_mut(kind.nodes()) {
                if is_inside_out(nodes, &self.points) {
                    let before = nodes.to_vec();
                    nodes.iter_mut().zip(TURNED_WEDGE).for_each(|(node, place)| *node = before[place]);
                }
            }
        }
    }

    /// Leaves out all elements of a shape that are no cells.
    pub fn leave_out_structural(&mut self, shape: Shape) {
        let Some(elements) = self.elements.get_mut(&shape) else { return };
        let taken = elements.take_out(shape.nodes(), |number, _| self.structural.contains(&number));
        if let Some(first) = taken.first() {
            self.leave_out(shape, taken.len(), self.place(first.place));
        }
    }

    /// Counts left-out elements of a shape; `at` is the place of the first.
    pub fn leave_out(&mut self, shape: Shape, count: usize, at: FilePosition) {
        let name = self.structural_types.get(&shape).map_or_else(|| "line".into(), |(name, _)| name.clone());
        self.left_out.entry(name).or_insert((0, at)).0 += count;
    }

    /// Appends nodes and elements of other tables, which get new numbers after the existing ones.
    pub fn append(&mut self, other: &Tables) -> Appended {
        let mut appended = Appended { nodes: Vec::new(), elements: Vec::new() };
        for ((&number, &place), &point) in other.node_numbers.iter().zip(&other.node_places).zip(&other.points) {
            self.written_nodes.push(number);
            let new = self.written_nodes.len() as u64;
            self.node_numbers.push(new);
            self.node_places.push(place);
            self.points.push(point);
            appended.nodes.push((number, new));
        }
        let new_nodes: HashMap<u64, u64> = appended.nodes.iter().copied().collect();
        for (&shape, elements) in &other.elements {
            let own = self.elements.entry(shape).or_default();
            for &number in &elements.numbers {
                self.written_elements.push(number);
                let new = self.written_elements.len() as u64;
                own.numbers.push(new);
                appended.elements.push((number, new));
                if other.structural.contains(&number) {
                    self.structural.insert(new);
                }
            }
            own.places.extend(&elements.places);
            own.groups.extend(&elements.groups);
            // A missing node gets the invalid number `u64::MAX`.
            own.nodes.extend(elements.nodes.iter().map(|node| new_nodes.get(node).copied().unwrap_or(u64::MAX)));
        }
        self.structural_types.extend(other.structural_types.iter().map(|(&shape, known)| (shape, known.clone())));
        self.has_beams |= other.has_beams;
        for (name, &(count, at)) in &other.left_out {
            self.left_out.entry(name.clone()).or_insert((0, at)).0 += count;
        }
        self.elements_begin = self.elements_begin.or(other.elements_begin);
        appended
    }

    /// Number of a node in the file.
    pub fn written_node(&self, number: u64) -> u64 {
        written(&self.written_nodes, number)
    }

    /// Number of an element in the file.
    pub fn written_element(&self, number: u64) -> u64 {
        written(&self.written_elements, number)
    }

    /// Name of a group: as in the file, or its number.
    pub fn name(&self, dimension: usize, group: u64) -> String {
        self.names.get(&(dimension, group)).cloned().unwrap_or_else(|| group.to_string())
    }
}

/// Node permutation of a wedge of either order that reverses its triangles.
const TURNED_WEDGE: [usize; 15] = [0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13];

/// True if the first triangle of a wedge faces away from the second.
fn is_inside_out(nodes: &[u64], points: &[[f64; 3]]) -> bool {
    let point = |k: usize| usize::try_from(nodes[k]).ok().and_then(|node| points.get(node));
    let (Some(a), Some(b), Some(c)) = (point(0), point(1), point(2)) else { return false };
    let (Some(d), Some(e), Some(f)) = (point(3), point(4), point(5)) else { return false };
    let [u, v] = [b, c].map(|end| [0, 1, 2].map(|i| end[i] - a[i]));
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    (0..3).map(|i| normal[i] * (d[i] + e[i] + f[i] - a[i] - b[i] - c[i])).sum::<f64>() < 0.0
}

fn written(written: &[u64], number: u64) -> u64 {
    let known = usize::try_from(number).ok().and_then(|number| written.get(number.checked_sub(1)?));
    known.copied().unwrap_or(number)
}

fn number_of(at: FilePosition) -> u64 {
    match at {
        FilePosition::Line(number) | FilePosition::Byte(number) => number as u64,
    }
}
