//! Boundaries in the node numbers of the model.

use super::definitions::Model;
use super::interactions::BodyBoundary;
use crate::contact::Surface;

/// Facets of a boundary in the plane, whose body's nodes are numbered from `first_node`; a quadratic edge is two of them.
pub fn boundary_facets(model: &Model, on: &BodyBoundary, first_node: usize) -> Vec<[u32; 2]> {
    let mesh = &model.bodies[on.body].mesh;
    let pieces = |&facet| {
        let nodes: Vec<u32> = mesh.facet_nodes(facet).map(|node| node + first_node as u32).collect();
        straight_pieces(&nodes)
    };
    on.boundary.facets.iter().flat_map(pieces).collect()
}

/// The straight pieces of an edge, given by its ends and its middle node if it has one.
pub fn straight_pieces(edge: &[u32]) -> Vec<[u32; 2]> {
    match *edge {
        [from, to, middle] => vec![[from, middle], [middle, to]],
        _ => vec![[edge[0], edge[1]]],
    }
}

/// Facets of several boundaries, those in more than one of them once.
pub fn facets_of_all(boundaries: &[BodyBoundary], facets: impl Fn(&BodyBoundary) -> Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    let mut known = std::collections::BTreeSet::new();
    boundaries.iter().flat_map(facets).filter(|&facet| known.insert(facet)).collect()
}

/// Distance within which a tie holds when none is given: half of the shortest secondary facet.
pub fn tie_reach(secondary: &[[u32; 2]], reference: &[f64]) -> f64 {
    0.5 * Surface::new(secondary).shortest_facet(reference)
}
