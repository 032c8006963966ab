//! Boundaries in the node numbers of the model.

use nalgebra::Vector3;

use super::definitions::Model;
use super::interactions::BodyBoundary;
use crate::contact::{ProxyNodes, ProxySurfacesInSpace, Surface, Tie};
use crate::elements::CellKind;
use crate::mesh::Facet;

/// Facets of a boundary in the plane; node numbers of its body start at `first_node`. A quadratic edge gives two facets.
pub fn boundary_facets(model: &Model, on: &BodyBoundary, first_node: usize) -> Vec<[u32; 2]> {
    let mesh = &model.bodies[on.body].mesh;
    let pieces = on.boundary.facets.iter().flat_map(|&facet| mesh.straight_pieces(facet));
    pieces.map(|ends| ends.map(|node| node + first_node as u32)).collect()
}

/// Facets of a boundary in space, counter-clockwise as seen from outside; node numbers of its body start at `first_node`.
pub fn boundary_faces(model: &Model, on: &BodyBoundary, first_node: usize) -> Vec<Vec<u32>> {
    let mesh = &model.bodies[on.body].mesh;
    on.boundary.facets.iter().map(|&facet| mesh.facet_nodes(facet).map(|node| node + first_node as u32).collect()).collect()
}

/// For each facet of a boundary in space, the node of its cell deepest below the facet, inside the body.
pub fn inner_nodes(model: &Model, on: &BodyBoundary, first_node: usize) -> Vec<u32> {
    let mesh = &model.bodies[on.body].mesh;
    let deepest = |&facet: &Facet| {
        let corners: Vec<Vector3<f64>> = mesh.facet_nodes(facet).take(3).map(|node| mesh.points[node as usize].into()).collect();
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let height = |node: u32| (Vector3::from(mesh.points[node as usize]) - corners[0]).dot(&normal);
        let nodes = mesh.cell(facet.cell as usize).iter().copied();
        nodes.min_by(|&a, &b| height(a).total_cmp(&height(b))).map_or(0, |node| node + first_node as u32)
    };
    on.boundary.facets.iter().map(deepest).collect()
}

/// Mean thickness of the cells of constant strain (triangles of three nodes, tetrahedra of four) behind a boundary: distance of their nodes
/// from its facets `[length]`. `None` without such cells.
pub fn constant_strain_thickness(model: &Model, on: &BodyBoundary) -> Option<f64> {
    let mesh = &model.bodies[on.body].mesh;
    let point = |node: u32| Vector3::from(mesh.points[node as usize]);
    let thickness = |facet: &Facet| {
        let corners: Vec<Vector3<f64>> = mesh.facet_nodes(*facet).map(point).collect();
        let sides: Vec<Vector3<f64>> = corners[1..].iter().map(|corner| corner - corners[0]).collect();
        let height = |node: u32| {
            let way = point(node) - corners[0];
            match sides[..] {
                [along] => way.cross(&along).norm() / along.norm(),
                [first, second] => way.dot(&first.cross(&second).normalize()).abs(),
                _ => 0.0,
            }
        };
        mesh.cell(facet.cell as usize).iter().map(|&node| height(node)).fold(0.0, f64::max)
    };
    let is_constant = |facet: &&Facet| matches!(mesh.kind_of(facet.cell as usize), CellKind::Tri3 | CellKind::Tet4);
    let found: Vec<f64> = on.boundary.facets.iter().filter(is_constant).map(thickness).collect();
    (!found.is_empty()).then(|| found.iter().sum::<f64>() / found.len() as f64)
}

/// Mid-side nodes of second-order edges on the hulls of plane bodies; `first` maps a body to its first node number.
pub fn middles(model: &Model, first: impl Fn(usize) -> usize) -> ProxyNodes {
    let curved = model.bodies.iter().enumerate().filter(|(_, body)| body.mesh.dimension() == 2 && body.mesh.is_quadratic());
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

/// Facets of several boundaries, each facet once.
pub fn facets_of_all<F: Clone + Ord>(boundaries: &[BodyBoundary], facets: impl Fn(&BodyBoundary) -> Vec<F>) -> Vec<F> {
    let mut known = std::collections::BTreeSet::new();
    boundaries.iter().flat_map(facets).filter(|facet| known.insert(facet.clone())).collect()
}

/// Default distance of tied points: half of the shortest secondary facet.
pub fn tie_reach(secondary: &Surface, reference: &[f64]) -> f64 {
    0.5 * secondary.shortest_facet(reference)
}

/// Tie of two boundaries in space, on the points of [`ProxySurfacesInSpace`], and its reach; `first` maps a body to its first node number.
pub fn tied_in_space<'a>(
    model: &Model,
    [secondary, to]: [&BodyBoundary; 2],
    reach: Option<f64>,
    first: impl Fn(usize) -> usize,
    reference: &'a [f64],
) -> (ProxySurfacesInSpace<'a>, Tie, f64) {
    let faces = [secondary, to].map(|on| boundary_faces(model, on, first(on.body)));
    let inner = inner_nodes(model, to, first(to.body));
    let seen = ProxySurfacesInSpace::with_inner(faces.each_ref().map(|faces| &faces[..]), &inner, reference);
    let reach = reach.unwrap_or_else(|| tie_reach(&seen.secondary, &seen.reference));
    let tie = Tie::in_space(seen.secondary.clone(), seen.primary.clone(), &seen.inner, &seen.reference, reach);
    (seen, tie, reach)
}
