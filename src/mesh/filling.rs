//! Cells of first order inside a rim: triangles, or three quadrilaterals for each triangle.

use std::collections::HashMap;

use super::cell_size::CellSize;
use super::triangulation::{Rim, Triangles, triangulate};
use super::{Boundary, Facet, Mesh, MeshError};
use crate::elements::CellKind;

/// Boundary curve segment of an edge between two nodes, and the curve parameter of its mid-side node as a share of the segment.
type RimEdges = HashMap<[u32; 2], (usize, f64)>;

/// Positions of the midpoints of edges, by their end nodes in ascending order.
pub(super) type PlacedEdges = HashMap<[u32; 2], [f64; 2]>;

/// Cells inside a rim.
pub(super) struct FilledRegion {
    /// The cells, without boundaries.
    pub mesh: Mesh,
    edges: RimEdges,
    /// Midpoints of edges that are not on the rim.
    pub placed: PlacedEdges,
    /// Facets on each rim segment, in the order of the rim.
    pub along: HashMap<usize, Vec<Facet>>,
    /// Nodes at the vertices of the rim.
    pub corners: HashMap<usize, u32>,
    /// Nodes in the middle of rim segments, if there are any.
    pub middles: HashMap<usize, u32>,
}

impl FilledRegion {
    /// Mesh of a kind with the given boundaries; mid-side nodes lie on the curves of their edges.
    pub fn finished(self, rim: &Rim, boundaries: Vec<Boundary>, kind: CellKind) -> Result<Mesh, MeshError> {
        let mesh = Mesh { boundaries, ..self.mesh };
        let middle = |[a, b]: [u32; 2], _| {
            let placed = self.placed.get(&[a.min(b), a.max(b)]).copied();
            let [x, y] = placed.or_else(|| self.edges.get(&[a, b]).and_then(|&(piece, share)| rim.between(piece, share)))?;
            Some([x, y, 0.0])
        };
        mesh.checked()?.with_cells(kind)?.curved(middle)
    }
}

/// Cells of first order inside a rim: triangles if `factor` is 1, otherwise quadrilaterals.
pub(super) fn filled<E: From<MeshError>>(rim: &Rim, size: &mut CellSize<E>, factor: f64) -> Result<FilledRegion, E> {
    let triangles = triangulate(rim, size, factor)?;
    Ok(if factor == 1.0 { of_triangles(&triangles, rim) } else { quadrilaterals(&triangles, rim) })
}

/// Region whose cells are the triangles of the triangulation.
fn of_triangles(Triangles { vertices, triangles }: &Triangles, rim: &Rim) -> FilledRegion {
    let (mut along, mut edges) = (HashMap::new(), RimEdges::new());
    for (nodes, cell) in triangles.iter().zip(0..) {
        for (from, local) in nodes.iter().zip(0..) {
            if rim.next.get(*from) == Some(&nodes[(local + 1) % 3]) {
                along.insert(*from, vec![Facet { cell, local: local as u8 }]);
                edges.insert([*from as u32, nodes[(local + 1) % 3] as u32], (*from, 0.5));
            }
        }
    }
    let points = vertices.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    let connectivity = triangles.as_flattened().iter().map(|&vertex| vertex as u32).collect();
    let mesh = Mesh::new(CellKind::Tri3, points, connectivity);
    let corners = (0..rim.vertices.len()).map(|vertex| (vertex, vertex as u32)).collect();
    FilledRegion { mesh, edges, placed: PlacedEdges::new(), along, corners, middles: HashMap::new() }
}

/// Region with each triangle divided into three quadrilaterals.
fn quadrilaterals(Triangles { vertices, triangles }: &Triangles, rim: &Rim) -> FilledRegion {
    let mut rim_edges = RimEdges::new();
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut corner: HashMap<usize, u32> = HashMap::new();
    let mut middle: HashMap<[usize; 2], u32> = HashMap::new();
    let mut connectivity = Vec::new();
    // Cells at the start and at the end of each triangle edge that lies on the rim.
    let (mut along, mut rim_middles) = (HashMap::new(), HashMap::new());
    for (triangle, nodes) in triangles.iter().enumerate() {
        let mut add = |sum: &[usize]| {
            let mean = |i: usize| sum.iter().map(|&vertex| vertices[vertex][i]).sum::<f64>() / sum.len() as f64;
            points.push([mean(0), mean(1), 0.0]);
            points.len() as u32 - 1
        };
        let own = nodes.map(|vertex| *corner.entry(vertex).or_insert_with(|| add(&[vertex])));
        let edges = [0, 1, 2].map(|k| [nodes[k], nodes[(k + 1) % 3]]);
        let middles = edges.map(|[a, b]| *middle.entry([a.min(b), a.max(b)]).or_insert_with(|| add(&[a, b])));
        let center = add(nodes);
        for k in 0..3 {
            connectivity.extend([own[k], middles[k], center, middles[(k + 2) % 3]]);
        }
        for (k, [from, to]) in edges.into_iter().enumerate() {
            if rim.next.get(from) == Some(&to) {
                if let Some([x, y]) = rim.middle(from) {
                    points[middles[k] as usize] = [x, y, 0.0];
                }
                rim_edges.insert([own[k], middles[k]], (from, 0.25));
                rim_edges.insert([middles[k], own[(k + 1) % 3]], (from, 0.75));
                let [start, end] = [k, (k + 1) % 3].map(|k| (3 * triangle + k) as u32);
                along.insert(from, vec![Facet { cell: start, local: 0 }, Facet { cell: end, local: 3 }]);
                rim_middles.insert(from, middles[k]);
            }
        }
    }
    let mesh = Mesh::new(CellKind::Quad4, points, connectivity);
    FilledRegion { mesh, edges: rim_edges, placed: PlacedEdges::new(), along, corners: corner, middles: rim_middles }
}
