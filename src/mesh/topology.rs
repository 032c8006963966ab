//! How cells touch: facets by their node sets, the outer hull, and the corners and edges of the two cell kinds.
//!
//! A facet is known by its sorted nodes; sorting all facets of a mesh brings the sides of each together, which finds the hull
//! (one side) and overlapping cells (more than two) without hashing.

use super::{Facet, Mesh};
use crate::elements::CellKind;

/// The sorted nodes of a facet, filled up with `u32::MAX` in the plane.
pub(super) type FacetKey = [u32; 4];

/// Which end of each reference direction a local node stands at; both cell kinds number them alike.
pub(super) fn corner(local: usize) -> [bool; 3] {
    [matches!(local % 4, 1 | 2), matches!(local % 4, 2 | 3), local >= 4]
}

/// Pairs of local nodes that an edge joins.
pub(super) fn edges(kind: CellKind) -> Vec<[usize; 2]> {
    let nodes = kind.nodes();
    let apart = |a: usize, b: usize| (0..3).filter(|&i| corner(a)[i] != corner(b)[i]).count();
    (0..nodes).flat_map(|a| (a + 1..nodes).map(move |b| [a, b])).filter(|&[a, b]| apart(a, b) == 1).collect()
}

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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_those_of_square_and_cube() {
        assert_eq!(edges(CellKind::Quad4), [[0, 1], [0, 3], [1, 2], [2, 3]]);
        assert_eq!(edges(CellKind::Hex8).len(), 12);
    }

    #[test]
    fn corners_follow_the_facets_of_the_reference_cells() {
        // all nodes of a facet share one end of one direction
        for kind in CellKind::ALL {
            for facet in kind.facets() {
                let flat = (0..3).take(kind.dimension()).filter(|&i| facet.iter().all(|&a| corner(a)[i] == corner(facet[0])[i]));
                assert_eq!(flat.count(), 1, "{kind:?} {facet:?}");
            }
        }
    }

    #[test]
    fn the_hull_of_a_rectangle_is_its_perimeter() {
        let mesh = crate::mesh::rectangle([2.0, 1.0], [4, 3], [0.0, 0.0]).unwrap();
        assert_eq!(mesh.hull().len(), 2 * (4 + 3));
        let mut named: Vec<Facet> = mesh.boundaries.iter().flat_map(|b| b.facets.clone()).collect();
        named.sort_unstable();
        assert_eq!(mesh.hull(), named);
    }
}
