//! Sharp vertices and edges of a surface in space, in the reference positions.

use crate::contact::faces::{self, Vector};
use crate::contact::surface::Surface;

/// Cosine of the angle by which facets turn at an edge that is sharp: 10 degrees.
pub const SMOOTH: f64 = 0.984_807_753_012_208;

/// How far a facet, or a sharp edge, may be left and still be met, over its size: across a border behind which the surface goes on
/// smoothly, and across one into which another part of the surface rises (a point in the crease of two coarse facets would be opposite
/// neither).
const LAP_SMOOTH: f64 = 0.05;
const LAP_CONCAVE: f64 = 0.25;

/// A node on sharp edges.
#[derive(Clone, Debug)]
pub struct Vertex {
    pub node: u32,
    /// The other ends of the edges that meet there.
    pub spokes: Vec<u32>,
}

/// A sharp edge that is not re-entrant, or a smooth one.
#[derive(Clone, Debug)]
pub struct SharpEdge {
    pub nodes: [u32; 2],
    /// The facets that meet there; one on the rim of an open surface.
    pub facets: [Option<u32>; 2],
    /// How far it may be left at either end, over its length.
    pub laps: [f64; 2],
}

/// What is sharp on a surface.
#[derive(Clone, Debug)]
pub struct Features {
    pub vertices: Vec<Vertex>,
    pub edges: Vec<SharpEdge>,
    /// For each facet how far it may be left across the border that begins at each of its nodes, over its size.
    pub laps: Vec<Vec<f64>>,
}

/// How a surface goes on across an edge.
#[derive(Clone, Copy, PartialEq)]
enum Bend {
    /// Not at all, or turned away by more than 10 degrees.
    Sharp,
    Smooth,
    Concave,
}

impl Features {
    /// The features of a surface. Where it ends, its body is taken to have a sharp edge.
    pub fn new(surface: &Surface, q: &[f64]) -> Features {
        Features::with_edges(surface, q, |bend| bend == Bend::Sharp)
    }

    /// The same with its smooth edges among the sharp ones: for what lies across flat ground on a line.
    pub fn with_smooth_edges(surface: &Surface, q: &[f64]) -> Features {
        Features::with_edges(surface, q, |bend| bend != Bend::Concave)
    }

    fn with_edges(surface: &Surface, q: &[f64], is_kept: impl Fn(Bend) -> bool) -> Features {
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
            SharpEdge { nodes: edge.nodes, facets: edge.facets, laps: edge.nodes.map(|node| lap(index, node)) }
        };
        let mut nodes: Vec<u32> = sharp().flat_map(|index| edges[index].nodes).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let vertex = |node: u32| {
            let spokes = around(node).iter().map(|&index| edges[index].nodes).map(|[a, b]| if a == node { b } else { a }).collect();
            Vertex { node, spokes }
        };
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
            vertices: nodes.into_iter().map(vertex).collect(),
            edges: (0..edges.len()).filter(|&index| is_kept(bends[index])).map(sharp_edge).collect(),
            laps: (0..surface.count()).map(laps_of).collect(),
        }
    }
}

/// How a surface goes on at an edge.
fn bend(surface: &Surface, facets: [Option<u32>; 2], nodes: [u32; 2], q: &[f64]) -> Bend {
    let [Some(one), Some(other)] = facets.map(|facet| facet.map(|facet| surface.facet(facet as usize))) else { return Bend::Sharp };
    let [n_one, n_other] = [one, other].map(|nodes| faces::normal(nodes, q));
    if n_one.dot(&n_other) >= SMOOTH {
        return Bend::Smooth;
    }
    let on_edge = 0.5 * (faces::at(nodes[0], q) + faces::at(nodes[1], q));
    if n_one.dot(&(faces::middle(other, q) - on_edge)) > 0.0 { Bend::Concave } else { Bend::Sharp }
}

/// Unit vectors in the facets that meet at an edge, away from it.
pub fn into_facets(edge: &SharpEdge, surface: &Surface, q: &[f64]) -> Vec<Vector> {
    let [a, b] = edge.nodes.map(|node| faces::at(node, q));
    let along = (b - a).try_normalize(0.0).unwrap_or_default();
    let into = |facet: u32| {
        let arm = faces::middle(surface.facet(facet as usize), q) - a;
        (arm - along * along.dot(&arm)).try_normalize(0.0).unwrap_or_default()
    };
    edge.facets.iter().flatten().map(|&facet| into(facet)).collect()
}

/// Sum of the outward normals of the facets that meet at an edge.
pub fn outward(edge: &SharpEdge, surface: &Surface, q: &[f64]) -> Vector {
    edge.facets.iter().flatten().map(|&facet| faces::normal(surface.facet(facet as usize), q)).sum()
}

/// Whether a point lies over a facet, seen along its normal; `laps` how far its borders may be left.
pub fn is_inside(x: Vector, nodes: &[u32], normal: Vector, laps: &[f64], q: &[f64]) -> bool {
    let size = faces::area_vector(nodes, q).norm().sqrt();
    (0..nodes.len()).all(|k| {
        let [a, b] = [nodes[k], nodes[(k + 1) % nodes.len()]].map(|node| faces::at(node, q));
        let inward = normal.cross(&(b - a)).try_normalize(0.0).unwrap_or_default();
        inward.dot(&(x - a)) >= -laps[k] * size
    })
}
