//! Unstructured grids: cells by VTK's numbers of types, arrays of whole numbers of the cells as their groups.

use std::collections::{BTreeMap, BTreeSet};

use super::super::tables::{Shape, Tables};
use crate::elements::CellKind;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Largest number of different values of an array of groups; an array with more values contains cell numbers.
const MOST_GROUPS: usize = 256;

/// Arrays with numbers of single cells or for filters.
const NO_GROUPS: [&str; 4] = ["GlobalIds", "GlobalCellIds", "GlobalElementId", "ElementId"];

/// Cells of a piece of a grid.
pub(super) struct GridPiece {
    pub points: Vec<f64>,
    pub connectivity: Vec<i64>,
    /// End of each cell in the connectivity.
    pub ends: Vec<i64>,
    pub types: Vec<i64>,
    /// Arrays of whole numbers, one for each cell.
    pub groups: Vec<(String, Vec<i64>)>,
    /// Places of the points and of the cells.
    pub at: [FilePosition; 2],
}

/// Nodes, cells and group numbers read from a VTK file, with the names of ignored arrays.
pub(in crate::mesh::files) struct Content {
    pub tables: Tables,
    /// Names of arrays that were left out.
    pub left_out: BTreeSet<String>,
    /// Number of cells.
    cells: u64,
}

impl Content {
    pub(super) fn new() -> Content {
        Content { tables: Tables::default(), left_out: BTreeSet::new(), cells: 0 }
    }

    /// Records an array as left out.
    pub(super) fn leave_out(&mut self, name: &str) {
        self.left_out.insert(name.into());
    }

    /// Adds a piece of the grid. Group names are looked up by array and value, otherwise composed of both.
    pub(super) fn add(&mut self, mut piece: GridPiece, names: &BTreeMap<(String, i64), String>) -> Result<(), MeshError> {
        let first = self.tables.points.len() as u64;
        for (index, point) in (first..).zip(piece.points.chunks_exact(3)) {
            self.tables.add_node(index, [point[0], point[1], point[2]], piece.at[0])?;
        }
        let is_group = |(name, values): &(String, Vec<i64>)| {
            let distinct: BTreeSet<i64> = values.iter().copied().collect();
            !name.starts_with("vtk") && !NO_GROUPS.contains(&name.as_str()) && distinct.len() <= MOST_GROUPS
        };
        let (groups, others): (Vec<_>, Vec<_>) = std::mem::take(&mut piece.groups).into_iter().partition(is_group);
        others.iter().for_each(|(name, _)| self.leave_out(name));
        let number = self.numbers_of_groups(&groups, names);
        self.tables.elements_begin.get_or_insert(piece.at[1]);
        let mut start = 0;
        for (cell, (&end, &vtk_type)) in piece.ends.iter().zip(&piece.types).enumerate() {
            let nodes = usize::try_from(end).ok().and_then(|end| piece.connectivity.get(start..end));
            let Some(nodes) = nodes else {
                let found = format!("cell {cell} ends at {end}");
                let problem = FileProblem::Malformed { expected: "ends of cells that ascend within their connectivity", found };
                return Err(FileError { at: piece.at[1], problem }.into());
            };
            start += nodes.len();
            let list = groups.iter().map(|(name, values)| number[&(name.as_str(), values[cell])]).collect();
            let list = self.tables.groups_index(list);
            let nodes: Vec<u64> =
                nodes.iter().map(|&node| u64::try_from(node).map_or(u64::MAX, |node| node.saturating_add(first))).collect();
            // Cells of type 0 are empty and are skipped.
            if vtk_type != 0 {
                self.add_cell(self.cells + cell as u64, vtk_type, &nodes, list, piece.at[1])?;
            }
        }
        self.cells += piece.ends.len() as u64;
        Ok(())
    }

    /// Group numbers by array and value; registers the names of the groups.
    fn numbers_of_groups<'a>(
        &mut self,
        groups: &'a [(String, Vec<i64>)],
        names: &BTreeMap<(String, i64), String>,
    ) -> BTreeMap<(&'a str, i64), u64> {
        let mut numbers = BTreeMap::new();
        for (array, values) in groups {
            for &value in values.iter().collect::<BTreeSet<_>>() {
                let name = names.get(&(array.clone(), value)).cloned().unwrap_or_else(|| format!("{array} {value}"));
                let known = self.tables.names.iter().find(|(_, known)| **known == name).map(|(&(_, number), _)| number);
                let number = known.unwrap_or(self.tables.names.len() as u64 / 4);
                (0..4).for_each(|dimension| drop(self.tables.names.insert((dimension, number), name.clone())));
                numbers.insert((array.as_str(), value), number);
            }
        }
        numbers
    }

    fn add_cell(&mut self, number: u64, vtk_type: i64, nodes: &[u64], groups: u32, at: FilePosition) -> Result<(), MeshError> {
        let row_of = |vtk_type: i64| CellKind::ALL.iter().copied().find(|kind| i64::from(kind.row().vtk_type) == vtk_type);
        let cell = |kind| Some((Shape::Cell(kind), &[][..]));
        // Polygons of three and four nodes, pixels, voxels, and cells with nodes in their faces are converted to supported kinds.
        let known: Option<(Shape, &[u8])> = match (vtk_type, nodes.len()) {
            (1, _) => Some((Shape::Point, &[])),
            (3 | 4, 2) => Some((Shape::Line(2), &[])),
            (21, _) => Some((Shape::Line(3), &[])),
            (7, 3) => cell(CellKind::Tri3),
            (7, 4) => cell(CellKind::Quad4),
            (8, _) => Some((Shape::Cell(CellKind::Quad4), &[0, 1, 3, 2])),
            (11, _) => Some((Shape::Cell(CellKind::Hex8), &[0, 1, 3, 2, 4, 5, 7, 6])),
            (32, 18) => self.tables.without_face_nodes(CellKind::Wedge15, number),
            (33, 24) => self.tables.without_face_nodes(CellKind::Hex20, number),
            (34, 7) => self.tables.without_face_nodes(CellKind::Tri6, number),
            (37, 19) => self.tables.without_face_nodes(CellKind::Pyr13, number),
            _ => row_of(vtk_type).and_then(cell),
        };
        let Some((shape, order)) = known else {
            let problem = FileProblem::UnsupportedCell { element: number, kind: kind_name(vtk_type) };
            return Err(FileError { at, problem }.into());
        };
        let nodes = if matches!(vtk_type, 32 | 33 | 34 | 37) { &nodes[..shape.nodes()] } else { nodes };
        if nodes.len() != shape.nodes() {
            let found = format!("cell {number} of VTK type {vtk_type} with {} of them", nodes.len());
            return Err(FileError { at, problem: FileProblem::Malformed { expected: "as many nodes as the type has", found } }.into());
        }
        self.tables.add_element(shape, number, groups, (nodes, order), at);
        Ok(())
    }
}

fn kind_name(vtk_type: i64) -> String {
    let known = match vtk_type {
        2 => "list of points (poly vertex)",
        4 => "line of more than two points (poly line)",
        6 => "strip of triangles",
        7 => "polygon",
        15 | 16 => "prism over a polygon",
        35 => "cubic line",
        42 => "polyhedron",
        68..=74 => "Lagrange cell",
        75..=81 => "Bezier cell",
        other => return format!("cell of VTK type {other}"),
    };
    format!("{known} (VTK type {vtk_type})")
}
