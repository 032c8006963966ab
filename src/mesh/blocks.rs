//! Cells of a mesh: blocks of one kind each; cells are numbered consecutively through all blocks.

use super::{Facet, Mesh, MeshError};
use crate::elements::{CellKind, CellShape};

/// Cells of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Kind of the cells.
    pub kind: CellKind,
    /// Node numbers of the cells, `kind.nodes()` each.
    pub connectivity: Vec<u32>,
}

impl Block {
    /// Number of cells.
    pub fn count(&self) -> usize {
        self.connectivity.len() / self.kind.nodes()
    }

    /// Node numbers of every cell in turn.
    pub fn cells(&self) -> std::slice::ChunksExact<'_, u32> {
        self.connectivity.chunks_exact(self.kind.nodes())
    }
}

impl Mesh {
    /// Mesh with cells of one kind, without boundaries and parts.
    pub fn new(kind: CellKind, points: Vec<[f64; 3]>, connectivity: Vec<u32>) -> Mesh {
        Mesh { points, blocks: vec![Block { kind, connectivity }], boundaries: Vec::new(), parts: Vec::new() }
    }

    /// Blocks, each with the number of its first cell.
    pub fn numbered_blocks(&self) -> impl Iterator<Item = (usize, &Block)> {
        self.blocks.iter().scan(0, |next, block| {
            let first = *next;
            *next += block.count();
            Some((first, block))
        })
    }

    /// Block of a cell, and the number of the cell in it.
    fn block_of(&self, cell: usize) -> (&Block, usize) {
        let mut left = cell;
        for block in &self.blocks {
            let count = block.count();
            if left < count {
                return (block, left);
            }
            left -= count;
        }
        unreachable!("the mesh has no cell {cell}")
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.blocks.iter().map(Block::count).sum()
    }

    /// Node numbers of every cell in turn.
    pub fn cells(&self) -> impl Iterator<Item = &[u32]> {
        self.blocks.iter().flat_map(Block::cells)
    }

    /// Kind and node numbers of every cell in turn.
    pub fn cells_with_kinds(&self) -> impl Iterator<Item = (CellKind, &[u32])> {
        self.blocks.iter().flat_map(|block| block.cells().map(|cell| (block.kind, cell)))
    }

    /// Kind and node numbers of one cell.
    pub(super) fn kind_and_cell(&self, cell: usize) -> (CellKind, &[u32]) {
        let (block, index) = self.block_of(cell);
        let count = block.kind.nodes();
        (block.kind, &block.connectivity[index * count..(index + 1) * count])
    }

    /// Node numbers of one cell.
    pub fn cell(&self, cell: usize) -> &[u32] {
        self.kind_and_cell(cell).1
    }

    /// Kind of one cell.
    pub fn kind_of(&self, cell: usize) -> CellKind {
        self.block_of(cell).0.kind
    }

    /// Node numbers of all cells.
    pub fn connectivity(&self) -> impl Iterator<Item = u32> {
        self.blocks.iter().flat_map(|block| block.connectivity.iter().copied())
    }

    /// Renumbers the nodes of all cells.
    pub(super) fn renumber(&mut self, number: impl Fn(u32) -> u32) {
        self.blocks.iter_mut().flat_map(|block| &mut block.connectivity).for_each(|node| *node = number(*node));
    }

    /// Adds cells of a kind to the block of this kind, or to a new block; returns the index of the first cell in its block.
    pub(super) fn add_cells(&mut self, kind: CellKind, connectivity: impl IntoIterator<Item = u32>) -> usize {
        let place = self.blocks.iter().position(|block| block.kind == kind).unwrap_or_else(|| {
            self.blocks.push(Block { kind, connectivity: Vec::new() });
            self.blocks.len() - 1
        });
        let first = self.blocks[place].count();
        self.blocks[place].connectivity.extend(connectivity);
        first
    }

    /// Kinds of cells, one for each block.
    pub fn kinds(&self) -> impl Iterator<Item = CellKind> {
        self.blocks.iter().map(|block| block.kind)
    }

    /// Kind of all cells; `None` for a mixed mesh.
    pub fn only_kind(&self) -> Option<CellKind> {
        if let [block] = &self.blocks[..] { Some(block.kind) } else { None }
    }

    /// True if cells have mid-side nodes.
    pub fn is_quadratic(&self) -> bool {
        self.kinds().any(CellKind::is_quadratic)
    }

    /// Names of the kinds of cells, such as `hex8` or `hex8 and wedge6`.
    pub fn kind_names(&self) -> String {
        self.kinds().map(CellKind::name).collect::<Vec<_>>().join(" and ")
    }

    /// Number of cells of each kind, such as `12 hex8 cells` or `12 hex8 and 4 wedge6 cells`.
    pub fn counted_cells(&self) -> String {
        let counts: Vec<String> = self.blocks.iter().map(|block| format!("{} {}", block.count(), block.kind.name())).collect();
        format!("{} cells", counts.join(" and "))
    }

    /// First cell with a facet that does not match that of its neighbor, with the kinds on both sides: faces of second order with and
    /// without a center node, and quadrilaterals against two triangles.
    pub(super) fn unmatched(&self) -> Option<MeshError> {
        let is_mixed = self.blocks.len() > 1 || self.kinds().any(|kind| matches!(kind.shape(), CellShape::Wedge | CellShape::Pyramid));
        if !is_mixed || self.dimension() == 2 {
            return None;
        }
        let sorted = self.sorted_facets();
        let nodes = |facet: Facet| self.facet_nodes(facet).count();
        let error = |a: Facet, b: Facet| {
            let [kind, other] = [a, b].map(|facet| self.kind_of(facet.cell as usize).name());
            MeshError::Unmatched { at: None, cell: a.cell.into(), center: self.cell_center(a.cell as usize), kind, other }
        };
        for sides in sorted.chunk_by(|a, b| a.0 == b.0) {
            if let [(_, a), (_, b)] = sides
                && nodes(*a) != nodes(*b)
            {
                return Some(error(*a, *b));
            }
        }
        let free = sorted.chunk_by(|a, b| a.0 == b.0).filter(|sides| sides.len() == 1).map(|sides| sides[0].1);
        let corners = |facet: Facet| self.facet_nodes(facet).take(self.facet_corners(facet)).collect::<Vec<u32>>();
        let (quadrilaterals, triangles): (Vec<_>, Vec<_>) =
            free.map(|facet| (facet, corners(facet))).partition(|(_, nodes)| nodes.len() == 4);
        let mut diagonals = std::collections::HashMap::new();
        for (facet, nodes) in &quadrilaterals {
            for [a, b] in [[nodes[0], nodes[2]], [nodes[1], nodes[3]]] {
                diagonals.insert([a.min(b), a.max(b)], (*facet, nodes));
            }
        }
        for (facet, nodes) in &triangles {
            for k in 0..3 {
                let [a, b] = [nodes[k], nodes[(k + 1) % 3]];
                if let Some((other, all)) = diagonals.get(&[a.min(b), a.max(b)])
                    && all.contains(&nodes[(k + 2) % 3])
                {
                    return Some(error(*other, *facet));
                }
            }
        }
        None
    }

    /// Number of corners of a facet, which are its first nodes.
    pub fn facet_corners(&self, facet: Facet) -> usize {
        let nodes = self.facet_nodes(facet).count();
        if self.dimension() == 2 { 2 } else { CellKind::of_face(nodes).shape().corners() }
    }
}
