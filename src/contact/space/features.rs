//! Detection of sharp vertices, sharp edges and bumps of a surface in space in the reference positions (`corners.rs`, `round.rs`).

use super::profiles::Profiles;
use crate::contact::faces::{self, Vector};
use crate::contact::surface::{Edge, Surface};

/// Cosine of the smallest angle between the facets at a sharp edge: 10 degrees.
pub const SMOOTH: f64 = 0.984_807_753_012_208;

/// Cosine of the smallest angle between the facets at a convex edge whose ends may be bumps: 2.5 degrees.
const BUMP: f64 = 0.999_048;

/// Smallest height of the curved surface over its facets, relative to the drop at an edge (depth of the middle of one facet below the plane
/// of the other), at which a surface counts as curved; below, it is uneven. For a circle the ratio is 1/6.
const ROUND: f64 = 1.0 / 24.0;

/// Distances beyond a facet or a sharp edge, in facet sizes, up to which a point still counts as opposite: `LAP_SMOOTH` across a border to
/// a smoothly continuing surface, `LAP_CONCAVE` across a concave border. Without the latter, a point in the crease between two coarse
/// facets would be opposite neither of them.
const LAP_SMOOTH: f64 = 0.05;
const LAP_CONCAVE: f64 = 0.25;

/// Node at the end of a sharp edge, or single bump, which gets separate constraints.
#[derive(Clone, Debug)]
pub struct Vertex {
    pub node: u32,
    /// Other ends of all edges at the node.
    pub spokes: Vec<u32>,
    /// True for a bump: a node without a sharp edge.
    pub is_bump: bool,
    /// Height of its point above the surface of second order that it represents; 0 on others `[length]`.
    pub raised: f64,
}

/// Edge with separate constraints: a sharp edge that is not re-entrant, or a smooth edge of an obstacle.
#[derive(Clone, Debug)]
pub struct SharpEdge {
    pub nodes: [u32; 2],
    /// Adjacent facets; one at the border of an open surface.
    pub facets: [Option<u32>; 2],
    /// Distance beyond each end, in edge lengths, up to which a point counts as opposite.
    pub laps: [f64; 2],
    /// Largest height of its points above the surface of second order that they represent; 0 on others `[length]`.
    pub raised: f64,
}

/// Sharp features of a surface.
#[derive(Clone, Debug)]
pub struct Features {
    pub vertices: Vec<Vertex>,
    pub edges: Vec<SharpEdge>,
    /// Distance beyond each border of each facet, in facet sizes, up to which a point counts as opposite. Borders are numbered by the node
    /// at which they start.
    pub laps: Vec<Vec<f64>>,
}

/// Angle between the facets at an edge of a surface, by its effect.
#[derive(Clone, Copy, PartialEq)]
enum Bend {
    /// End of the surface, or convex angle of more than 10 degrees.
    Sharp,
    Smooth,
    Concave,
}

impl Features {
    /// Sharp features of a surface; a border of the surface counts as a sharp edge of its body.
    pub fn new(surface: &Surface, q: &[f64]) -> Features {
        Features::with_edges(surface, q, &[], |bend| bend == Bend::Sharp)
    }

    /// Sharp features of a surface and its bumps: ends of convex edges that belong to no curve.
    pub fn with_bumps(surface: &Surface, q: &[f64], profiles: &Profiles) -> Features {
        Features::with_edges(surface, q, &bumps(surface, q, profiles), |bend| bend == Bend::Sharp)
    }

    /// Sharp and smooth edges of a surface, for obstacle edges that lie across flat regions.
    pub fn with_smooth_edges(surface: &Surface, q: &[f64]) -> Features {
        Features::with_edges(surface, q, &[], |bend| bend != Bend::Concave)
    }

    fn with_edges(surface: &Surface, q: &[f64], bumps: &[u32], is_kept: impl Fn(Bend) -> bool) -> Features {
        let edges = surface.edges();
        let bends: Vec<Bend> = edges.iter().map(|edge| bend(surface, edge.facets, edge.nodes, q)).collect();
        let along = |nodes: [u32; 2]| (faces::at(nodes[1], q) - faces::at(nodes[0], q)).try_normalize(0.0).unwrap_or_default();
        let mut of_node: Vec<Vec<usize>> = vec![Vec::new(); surface.nodes().len()];
        for (index, edge) in edges.iter().enumerate() {
            edge.nodes.iter().filter_map(|&node| surface.index(node)).for_each(|node| of_node[node].push(index));
        }
        let around = |node: u32| surface.index(node).map_or(&[][..], |index| &of_node[index]);
        let lap = |own: usize, node: u32| {
            let others = || around(node).iter().filter(|&&other| other != own);
            let goes_on =
                |&&other: &&usize| bends[other] == bends[own] && along(edges[other].nodes).dot(&along(edges[own].nodes)).abs() > SMOOTH;
            if others().any(|&other| bends[other] == Bend::Concave) {
                LAP_CONCAVE
            } else if others().any(|other| goes_on(&other)) {
                LAP_SMOOTH
            } else {
                0.0
            }
        };
        let sharp = || (0..edges.len()).filter(|&index| bends[index] == Bend::Sharp);
        let sharp_edge = |index: usize| {
            let edge = &edges[index];
            SharpEdge { nodes: edge.nodes, facets: edge.facets, laps: edge.nodes.map(|node| lap(index, node)), raised: 0.0 }
        };
        let mut nodes: Vec<u32> = sharp().flat_map(|index| edges[index].nodes).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let vertex = |is_bump: bool, node: u32| {
            let spokes = around(node).iter().map(|&index| edges[index].nodes).map(|[a, b]| if a == node { b } else { a }).collect();
            Vertex { node, spokes, is_bump, raised: 0.0 }
        };
        let bumps = bumps.iter().filter(|bump| nodes.binary_search(bump).is_err());
        let laps_of = |facet: usize| {
            let nodes = surface.facet(facet);
            let of_side = |k: usize| {
                let (a, b) = (nodes[k], nodes[(k + 1) % nodes.len()]);
                let ends = [a.min(b), a.max(b)];
                match edges.binary_search_by(|edge| edge.nodes.cmp(&ends)).map(|index| bends[index]) {
                    Ok(Bend::Smooth) => LAP_SMOOTH,
                    Ok(Bend::Concave) => LAP_CONCAVE,
                    _ => 0.0,
                }
            };
            (0..nodes.len()).map(of_side).collect()
        };
        Features {
            vertices: nodes.iter().map(|&node| vertex(false, node)).chain(bumps.map(|&node| vertex(true, node))).collect(),
            edges: (0..edges.len()).filter(|&index| is_kept(bends[index])).map(sharp_edge).collect(),
            laps: (0..surface.count()).map(laps_of).collect(),
        }
    }
}

impl Features {
    /// The features of a surface whose points at `reference` represent those of a surface of second order at `curve`.
    pub fn raised(mut self, surface: &Surface, reference: &[f64], curve: &[f64]) -> Features {
        let height = |node: u32| rise(surface, node, reference, curve);
        self.vertices.iter_mut().for_each(|vertex| vertex.raised = height(vertex.node));
        self.edges.iter_mut().for_each(|edge| edge.raised = edge.nodes.map(height).into_iter().fold(0.0, f64::max));
        self
    }
}

/// Height of a point at `reference`, which represents a surface of second order, over the point of that surface at `curve`, at least 0.
fn rise(surface: &Surface, node: u32, reference: &[f64], curve: &[f64]) -> f64 {
    let around = surface.index(node).map_or(&[][..], |index| surface.adjacent_facets(index));
    let normal = around.iter().map(|&facet| faces::normal(surface.facet(facet as usize), curve)).sum::<Vector>();
    let rise = faces::at(node, reference) - faces::at(node, curve);
    normal.try_normalize(0.0).map_or(0.0, |normal| normal.dot(&rise).max(0.0))
}

/// Largest [`rise`] of the nodes of each facet.
pub fn rises(surface: &Surface, reference: &[f64], curve: &[f64]) -> Vec<f64> {
    let of = |facet| surface.facet(facet).iter().fold(0.0, |most: f64, &node| most.max(rise(surface, node, reference, curve)));
    (0..surface.count()).map(of).collect()
}

/// Bumps: ends of convex edges on a surface that is not curved.
fn bumps(surface: &Surface, q: &[f64], profiles: &Profiles) -> Vec<u32> {
    // Drop at an edge: depth of the middle of one facet below the plane of the other facet.
    let drop = |edge: &Edge| {
        let [one, other] = edge.facets.map(|facet| facet.map(|facet| surface.facet(facet as usize)));
        let [normal, next] = [faces::normal(one?, q), faces::normal(other?, q)];
        let drop = normal.dot(&(faces::at(edge.nodes[0], q) - faces::middle(other?, q)));
        (drop > 0.0 && normal.dot(&next) < BUMP).then_some(drop)
    };
    let is_curve = |node: u32, drop: f64| {
        let around = surface.index(node).map_or(&[][..], |index| surface.adjacent_facets(index));
        around.iter().all(|&facet| profiles.height(facet as usize) > ROUND * drop)
    };
    let edges = surface.edges();
    let ends = edges.iter().filter_map(|edge| Some((edge.nodes, drop(edge)?)));
    let mut bumps: Vec<u32> = ends.flat_map(|(nodes, drop)| nodes.into_iter().filter(move |&node| !is_curve(node, drop))).collect();
    bumps.sort_unstable();
    bumps.dedup();
    bumps
}

/// Kind of angle between the facets at an edge.
fn bend(surface: &Surface, facets: [Option<u32>; 2], nodes: [u32; 2], q: &[f64]) -> Bend {
    let [Some(one), Some(other)] = facets.map(|facet| facet.map(|facet| surface.facet(facet as usize))) else { return Bend::Sharp };
    let [n_one, n_other] = [one, other].map(|nodes| faces::normal(nodes, q));
    if n_one.dot(&n_other) >= SMOOTH {
        return Bend::Smooth;
    }
    let on_edge = 0.5 * (faces::at(nodes[0], q) + faces::at(nodes[1], q));
    if n_one.dot(&(faces::middle(other, q) - on_edge)) > 0.0 { Bend::Concave } else { Bend::Sharp }
}

/// Unit vectors in the adjacent facets of an edge, perpendicular to the edge and away from it.
pub fn into_facets(edge: &SharpEdge, surface: &Surface, q: &[f64]) -> Vec<Vector> {
    let [a, b] = edge.nodes.map(|node| faces::at(node, q));
    let along = (b - a).try_normalize(0.0).unwrap_or_default();
    let into = |facet: u32| {
        let arm = faces::middle(surface.facet(facet as usize), q) - a;
        (arm - along * along.dot(&arm)).try_normalize(0.0).unwrap_or_default()
    };
    edge.facets.iter().flatten().map(|&facet| into(facet)).collect()
}

/// Sum of the outward normals of the adjacent facets of an edge.
pub fn outward(edge: &SharpEdge, surface: &Surface, q: &[f64]) -> Vector {
    edge.facets.iter().flatten().map(|&facet| faces::normal(surface.facet(facet as usize), q)).sum()
}

/// True if a point projects into a facet along its normal; `laps` are the distances beyond its borders that count as inside.
pub fn is_inside(x: Vector, nodes: &[u32], normal: Vector, laps: &[f64], q: &[f64]) -> bool {
    let size = faces::area_vector(nodes, q).norm().sqrt();
    (0..nodes.len()).all(|k| {
        let [a, b] = [nodes[k], nodes[(k + 1) % nodes.len()]].map(|node| faces::at(node, q));
        let inward = normal.cross(&(b - a)).try_normalize(0.0).unwrap_or_default();
        inward.dot(&(x - a)) >= -laps[k] * size
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Face of `n` by `n` facets of size 0.5 with the given heights.
    fn face(n: u32, height: impl Fn(f64, f64) -> f64) -> (Surface, Vec<f64>) {
        let place = |k: u32| 0.5 * f64::from(k) - 0.25 * f64::from(n);
        let nodes = (0..=n).flat_map(|j| (0..=n).map(move |i| (place(i), place(j))));
        let q = nodes.flat_map(|(x, y)| [x, y, height(x, y)]).collect();
        let first = |i: u32, j: u32| i + j * (n + 1);
        let facets = (0..n).flat_map(|j| (0..n).map(move |i| [first(i, j), first(i + 1, j), first(i + 1, j + 1), first(i, j + 1)]));
        let facets: Vec<[u32; 4]> = facets.collect();
        (Surface::in_space(facets.iter().map(|facet| &facet[..])), q)
    }

    #[test]
    fn bumps_stick_out_of_a_face_that_is_no_curve() {
        let found = |(surface, q): (Surface, Vec<f64>)| bumps(&surface, &q, &Profiles::new(&surface, &q));
        let waves = found(face(4, |x, y| 0.05 * (3.0 * x).sin() * (3.0 * y).sin()));
        // Nodes at (-0.5, -0.5) and (0.5, 0.5) are maxima, the node at (-0.5, 0.5) is a minimum.
        assert!(waves.contains(&6) && waves.contains(&18) && !waves.contains(&16), "{waves:?}");
        assert_eq!(found(face(6, |x, _| -0.08 * x * x)), Vec::<u32>::new());
        assert_eq!(found(face(6, |x, y| -0.06 * (x * x + y * y))), Vec::<u32>::new());
        assert_eq!(found(face(6, |x, y| 0.06 * (x * x + y * y))), Vec::<u32>::new());
        assert_eq!(found(face(6, |x, y| 0.3 * x - 0.2 * y)), Vec::<u32>::new());
    }
}
