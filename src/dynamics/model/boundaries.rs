//! Boundaries in the node numbers of the model.

use super::definitions::Model;
use super::interactions::BodyBoundary;
use crate::contact::{ProxyNodes, Surface};

/// Facets of a boundary in the plane, whose body's nodes are numbered from `first_node`; a quadratic edge is two of them.
pub fn boundary_facets(model: &Model, on: &BodyBoundary, first_node: usize) -> Vec<[u32; 2]> {
    let mesh = &model.bodies[on.body].mesh;
    let pieces = on.boundary.facets.iter().flat_map(|&facet| mesh.straight_pieces(facet));
    pieces.map(|ends| ends.map(|node| node + first_node as u32)).collect()
}

/// Facets of a boundary in space, whose body's nodes are numbered from `first_node`, counter-clockwise as seen from outside.
pub fn boundary_faces(model: &Model, on: &BodyBoundary, first_node: usize) -> Vec<Vec<u32>> {
    let mesh = &model.bodies[on.body].mesh;
    on.boundary.facets.iter().map(|&facet| mesh.facet_nodes(facet).map(|node| node + first_node as u32).collect()).collect()
}

/// The middle nodes of edges of second order on the hulls of plane bodies, whose nodes are numbered from where `first` says.
pub fn middles(model: &Model, first: impl Fn(usize) -> usize) -> ProxyNodes {
    let curved = model.bodies.iter().enumerate().filter(|(_, body)| body.mesh.dimension() == 2 && body.mesh.kind.is_quadratic());
    let edges = curved.flat_map(|(index, body)| {
        let first = first(index) as u32;
        let edge = move |facet| {
            let nodes: Vec<u32> = body.mesh.facet_nodes(facet).map(|node| node + first).collect();
            [nodes[0], nodes[1], nodes[2]]
        };
        body.mesh.hull().into_iter().map(edge)
    });
    ProxyNodes::new(edges)
}

/// Facets of several boundaries, those in more than one of them once.
pub fn facets_of_all<F: Clone + Ord>(boundaries: &[BodyBoundary], facets: impl Fn(&BodyBoundary) -> Vec<F>) -> Vec<F> {
    let mut known = std::collections::BTreeSet::new();
    boundaries.iter().flat_map(facets).filter(|facet| known.insert(facet.clone())).collect()
}

/// Distance within which a tie holds when none is given: half of the shortest secondary facet.
pub fn tie_reach(secondary: &[[u32; 2]], reference: &[f64]) -> f64 {
    0.5 * Surface::new(secondary).shortest_facet(reference)
}
