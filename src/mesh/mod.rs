//! Floor 3 of `ARCHITECTURE.md`: nodes, cells and named boundaries; generators, readers and checks.
//!
//! A mesh is plain data whose dimension is that of its cell kinds; points always have three coordinates (the third is zero in the plane),
//! so that readers, generators and writers need no dimension parameter. Kernels copy the data they need once.

mod blocks;
mod cell_size;
mod check;
mod codes;
mod columns;
mod curved;
mod curves;
mod division;
mod error;
mod extrude;
mod file_error;
mod file_hints;
mod files;
mod filling;
mod generators;
mod grid;
mod hints;
mod join;
mod layers;
mod local_refinement;
mod locate;
mod path;
mod pieces;
mod places;
mod plane;
mod point_index;
mod polygon;
mod region;
mod revolve;
mod round;
mod selection;
mod sides;
mod solids;
mod strips;
mod surface;
mod sweep;
mod topology;
mod transform;
mod triangulation;

pub use blocks::Block;
pub use cell_size::CellSize;
pub use check::Quality;
pub use curved::Round;
pub use curves::{Curve, OutlineSide};
pub use error::MeshError;
pub use extrude::Change;
pub use file_error::{FileError, FilePosition, FileProblem};
pub use files::{
    Deck, DeckBoundary, DeckMaterial, DeckPair, DeckPart, DeckProperty, FileNote, Includes, ReadOptions, Shells, Structural, Triangles,
};
pub use files::{
    MESH_ENDINGS, below_folder_of, read_deck, read_deck_bytes, read_mesh, read_mesh_bytes, read_mesh_with, read_surface, read_surface_bytes,
};
pub use generators::{block, graded_block, graded_rectangle, rectangle};
pub use layers::Layers;
pub use locate::CellFinder;
pub use plane::{cross, is_inside};
pub use point_index::PointIndex;
pub use polygon::{layered_polygon, polygon, polygon_of};
pub use region::{layered_region, region};
pub use revolve::Axis;
pub use round::{arc, disk, graded_ring, half_disk, ring};
pub use selection::SelectionError;
pub use solids::{cylinder, hollow_sphere, rounded_block, sphere, torus, tube};
pub use sweep::Prisms;
pub use topology::{flat_pieces, pieces_of};

/// Largest number of cells of generators and refinement: some gigabytes in a simulation; a larger number in a script is probably a mistake.
pub const CELL_LIMIT: usize = 10_000_000;

/// Facet of the boundary: a cell and the index of its local facet. Its orientation follows from the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Facet {
    /// Cell number.
    pub cell: u32,
    /// Index into the facets of the cell's kind.
    pub local: u8,
}

/// A named set of facets.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// Name as used in scripts, such as `outer`.
    pub name: String,
    /// Facets, in the order of traversal where the generator or reader has one.
    pub facets: Vec<Facet>,
    /// Nodes in addition to those of the facets: single points that are fixed, moved or loaded.
    pub nodes: Vec<u32>,
}

impl Boundary {
    /// A boundary of facets.
    pub fn of_facets(name: &str, facets: Vec<Facet>) -> Self {
        Boundary { name: name.into(), facets, nodes: Vec::new() }
    }

    /// A single node.
    pub fn of_node(node: u32) -> Self {
        Boundary { name: format!("node {node}"), facets: Vec::new(), nodes: vec![node] }
    }

    /// Union of several boundaries of a mesh; common facets and nodes occur once.
    pub fn union(boundaries: &[Boundary]) -> Self {
        let names: Vec<&str> = boundaries.iter().map(|boundary| boundary.name.as_str()).collect();
        let mut joined = Boundary::of_facets(&names.join("+"), Vec::new());
        for boundary in boundaries {
            joined.facets.extend(boundary.facets.iter().filter(|facet| !joined.facets.contains(facet)).copied().collect::<Vec<_>>());
            joined.nodes.extend(boundary.nodes.iter().filter(|node| !joined.nodes.contains(node)).copied().collect::<Vec<_>>());
        }
        joined
    }
}

/// Nodes, cells in blocks of one kind each, named boundaries and named parts.
///
/// Generators and readers return valid meshes. A mesh constructed by hand may refer to missing nodes or cells; [`Mesh::defects`] reports
/// this, other methods panic.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Node positions `[length]`; the third coordinate is 0 for plane meshes.
    pub points: Vec<[f64; 3]>,
    /// Cells, at least one block; of one dimension, and all or none with mid-side nodes.
    pub blocks: Vec<Block>,
    /// Named boundaries.
    pub boundaries: Vec<Boundary>,
    /// Named groups of cells (physical groups of a mesh file), each with its cell numbers.
    pub parts: Vec<(String, Vec<u32>)>,
}

impl Mesh {
    /// Space dimension, 2 or 3.
    pub fn dimension(&self) -> usize {
        self.blocks.first().map_or(2, |block| block.kind.dimension())
    }

    /// Node numbers of a facet, with the body on the left (2D) or the normal outward (3D).
    pub fn facet_nodes(&self, facet: Facet) -> impl Iterator<Item = u32> + '_ {
        let (kind, cell) = self.kind_and_cell(facet.cell as usize);
        kind.facets()[facet.local as usize].iter().map(move |&local| cell[local])
    }

    /// Boundary with a name, if it exists.
    pub fn boundary(&self, name: &str) -> Option<&Boundary> {
        self.boundaries.iter().find(|boundary| boundary.name == name)
    }

    /// Node numbers of a boundary, each once, in ascending order.
    pub fn boundary_nodes(&self, boundary: &Boundary) -> Vec<u32> {
        let mut nodes: Vec<u32> = boundary.facets.iter().flat_map(|&facet| self.facet_nodes(facet)).collect();
        nodes.extend(&boundary.nodes);
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }
}
