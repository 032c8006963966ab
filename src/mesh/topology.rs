//! Topology of a mesh: facets by their node sets, the hull.
//!
//! A facet is identified by its sorted nodes, a second-order face in space by its mid-side nodes. Sorting all facets of a mesh makes the
//! sides of each consecutive, which gives the hull (one side) and overlapping cells (more than two) without hashing.

use super::{Facet, Mesh};

/// Sorted nodes of a facet, padded with `u32::MAX` in the plane.
pub(super) type FacetKey = [u32; 4];

/// Key of a facet from its nodes.
pub(super) fn facet_key(nodes: impl Iterator<Item = u32>) -> FacetKey {
    let (mut all, mut count) = ([u32::MAX; 9], 0);
    for (slot, node) in all.iter_mut().zip(nodes) {
        *slot = node;
        count += 1;
    }
    let middles = match count {
        6 => 3..6,
        8 | 9 => 4..8,
        _ => 0..4,
    };
    let mut key = [u32::MAX; 4];
    key.iter_mut().zip(&all[middles]).for_each(|(slot, &node)| *slot = node);
    key.sort_unstable();
    key
}

/// Flat pieces of a face with `nodes` nodes, as indices of its nodes. The first node of each piece is a corner of the face, except in a
/// piece that has none.
pub fn flat_pieces(nodes: usize) -> &'static [&'static [usize]] {
    match nodes {
        3 => &[&[0, 1, 2]],
        6 => &[&[0, 3, 5], &[1, 4, 3], &[2, 5, 4], &[3, 4, 5]],
        8 => &[&[0, 4, 7], &[1, 5, 4], &[2, 6, 5], &[3, 7, 6], &[4, 5, 6, 7]],
        9 => &[&[0, 4, 8, 7], &[1, 5, 8, 4], &[2, 6, 8, 5], &[3, 7, 8, 6]],
        _ => &[&[0, 1, 2, 3]],
    }
}

/// Flat pieces of a face with the given nodes, as node numbers.
pub fn pieces_of(face: &[u32]) -> Vec<Vec<u32>> {
    flat_pieces(face.len()).iter().map(|piece| piece.iter().map(|&k| face[k]).collect()).collect()
}

impl Mesh {
    /// Every facet of every cell, cell by cell.
    pub(super) fn facets(&self) -> impl Iterator<Item = Facet> + '_ {
        self.numbered_blocks().flat_map(|(first, block)| {
            let per_cell = block.kind.facets().len() as u8;
            (first as u32..(first + block.count()) as u32).flat_map(move |cell| (0..per_cell).map(move |local| Facet { cell, local }))
        })
    }

    /// Facets with their keys, sorted so that the sides of one facet are consecutive.
    pub(super) fn sorted_facets(&self) -> Vec<(FacetKey, Facet)> {
        let mut sorted: Vec<_> = self.facets().map(|facet| (facet_key(self.facet_nodes(facet)), facet)).collect();
        sorted.sort_unstable();
        sorted
    }

    /// The outer hull: facets that belong to one cell only, cell by cell.
    pub fn hull(&self) -> Vec<Facet> {
        let sorted = self.sorted_facets();
        let mut hull: Vec<Facet> = sorted.chunk_by(|a, b| a.0 == b.0).filter(|sides| sides.len() == 1).map(|sides| sides[0].1).collect();
        hull.sort_unstable();
        hull
    }

    /// Straight pieces of a facet in the plane, given by their ends: two for an edge with a mid-side node; none for a face in space.
    pub fn straight_pieces(&self, facet: Facet) -> Vec<[u32; 2]> {
        let nodes: Vec<u32> = self.facet_nodes(facet).filter(|_| self.dimension() == 2).collect();
        match nodes[..] {
            [from, to, middle] => vec![[from, middle], [middle, to]],
            [from, to] => vec![[from, to]],
            _ => Vec::new(),
        }
    }

    /// Nodes around a face in space: for second order corners and mid-side nodes alternately, without the center.
    pub fn around(&self, facet: Facet) -> Vec<u32> {
        let nodes: Vec<u32> = self.facet_nodes(facet).collect();
        let corners = match nodes.len() {
            6 => 3,
            8 | 9 => 4,
            _ => return nodes,
        };
        (0..corners).flat_map(|k| [nodes[k], nodes[corners + k]]).collect()
    }

    /// Pieces of three and four nodes that represent a face in space: a second-order face is divided at the midpoints of its edges.
    pub fn flat_pieces(&self, facet: Facet) -> Vec<Vec<u32>> {
        pieces_of(&self.facet_nodes(facet).collect::<Vec<u32>>())
    }

    /// Straight pieces of the hull of a plane mesh, with the body on the left.
    pub fn outline(&self) -> Vec<[u32; 2]> {
        self.hull().into_iter().flat_map(|facet| self.straight_pieces(facet)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_rectangle_is_its_perimeter() {
        let mesh = crate::mesh::rectangle([2.0, 1.0], [4, 3], [0.0, 0.0]).unwrap();
        assert_eq!(mesh.hull().len(), 2 * (4 + 3));
        let mut named: Vec<Facet> = mesh.boundaries.iter().flat_map(|b| b.facets.clone()).collect();
        named.sort_unstable();
        assert_eq!(mesh.hull(), named);
    }
}
