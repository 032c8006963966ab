//! How cells touch: facets by their node sets, the outer hull.
//!
//! A facet is known by its sorted nodes; sorting all facets of a mesh brings the sides of each together, which finds the hull
//! (one side) and overlapping cells (more than two) without hashing.

use super::{Facet, Mesh};

/// The sorted nodes of a facet, filled up with `u32::MAX` in the plane.
pub(super) type FacetKey = [u32; 4];

/// The key of a set of nodes.
pub(super) fn facet_key(nodes: impl Iterator<Item = u32>) -> FacetKey {
    let mut key = [u32::MAX; 4];
    for (slot, node) in key.iter_mut().zip(nodes) {
        *slot = node;
    }
    key.sort_unstable();
    key
}

impl Mesh {
    /// Every facet of every cell, cell by cell.
    pub(super) fn facets(&self) -> impl Iterator<Item = Facet> + '_ {
        let per_cell = self.kind.facets().len() as u8;
        (0..self.cell_count() as u32).flat_map(move |cell| (0..per_cell).map(move |local| Facet { cell, local }))
    }

    /// Facets with their keys, sorted so that the sides of one facet follow each other.
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

    /// The straight pieces of a facet in the plane, given by their ends: two where it has a middle node; none of a face, which is no edge.
    pub fn straight_pieces(&self, facet: Facet) -> Vec<[u32; 2]> {
        let nodes: Vec<u32> = self.facet_nodes(facet).filter(|_| self.dimension() == 2).collect();
        match nodes[..] {
            [from, to, middle] => vec![[from, middle], [middle, to]],
            [from, to] => vec![[from, to]],
            _ => Vec::new(),
        }
    }

    /// The straight pieces of the hull of a plane mesh, the body on their left.
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
