//! Drawn parts of a body: triangles, edges of its cells, its outline, in indices of the recorded nodes.

use std::collections::BTreeMap;

use crate::elements::CellKind;
use crate::mesh::{Facet, Mesh};
use crate::output::recording::Skin;

/// Cosine of the angle between facets in space from which their common edge is drawn.
const SHARP: f64 = 0.8;

/// Drawn parts of a body.
pub struct Surface {
    /// Undeformed positions of the recorded nodes.
    pub points: Vec<[f64; 3]>,
    /// Triangles; in space their normals point outward.
    pub triangles: Vec<[u32; 3]>,
    /// Edges of cells, in space of the facets of the hull, each once.
    pub edges: Vec<[u32; 2]>,
    /// Outline of a plane body; in space, the sharp edges.
    pub outline: Vec<[u32; 2]>,
    /// Tetrahedra that fill the cells of a body in space, if its inside is recorded.
    pub tetrahedra: Vec<[u32; 4]>,
}

impl Surface {
    /// Returns triangles, edges and outline of a mesh in indices of the nodes that `skin` records.
    pub fn new(mesh: &Mesh, skin: &Skin) -> Self {
        let place = |node: u32| skin.nodes.binary_search(&node).map_or(0, |place| place as u32);
        let hull: Vec<Vec<u32>> = mesh.hull().into_iter().map(|facet| mesh.around(facet).into_iter().map(place).collect()).collect();
        let polygons: Vec<Vec<u32>> = if mesh.dimension() == 2 {
            // Around the cell: the start of every edge, and its mid-side node if it has one.
            let around = |kind: CellKind| kind.facets().iter().flat_map(|facet| facet.iter().step_by(2));
            mesh.cells_with_kinds().map(|(kind, cell)| around(kind).map(|&node| place(cell[node])).collect()).collect()
        } else {
            hull.clone()
        };
        let points: Vec<[f64; 3]> = skin.nodes.iter().map(|&node| mesh.points[node as usize]).collect();
        let is_quadratic = mesh.is_quadratic();
        let triangles = polygons.iter().flat_map(|polygon| triangles(polygon, is_quadratic)).collect();
        let mut edges: Vec<[u32; 2]> = polygons.iter().flat_map(|polygon| sides(polygon)).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.sort_unstable();
        edges.dedup();
        let outline =
            if mesh.dimension() == 2 { mesh.outline().into_iter().map(|ends| ends.map(place)).collect() } else { sharp(&points, &hull) };
        let tetrahedra = if mesh.dimension() == 3 && skin.nodes.len() == mesh.points.len() { tetrahedra(mesh) } else { Vec::new() };
        Surface { points, triangles, edges, outline, tetrahedra }
    }
}

/// Divides cells into tetrahedra between the first corner and the facets without that corner.
fn tetrahedra(mesh: &Mesh) -> Vec<[u32; 4]> {
    let step = if mesh.is_quadratic() { 2 } else { 1 };
    let of_cell = |(cell, (kind, nodes)): (usize, (CellKind, &[u32]))| -> Vec<[u32; 4]> {
        let around = (0..kind.facets().len() as u8).map(|local| mesh.around(Facet { cell: cell as u32, local }));
        let opposite = around.map(|facet| facet.into_iter().step_by(step).collect::<Vec<_>>()).filter(|facet| !facet.contains(&nodes[0]));
        opposite.flat_map(|facet| triangles(&facet, false)).map(|[a, b, c]| [nodes[0], a, b, c]).collect()
    };
    mesh.cells_with_kinds().enumerate().flat_map(of_cell).collect()
}

fn sides(polygon: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])
}

/// Divides a polygon into triangles; with mid-side nodes, ears at the corners first and then the remainder.
fn triangles(polygon: &[u32], is_quadratic: bool) -> Vec<[u32; 3]> {
    let fan = |corners: &[u32]| -> Vec<[u32; 3]> { (2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]).collect() };
    if !is_quadratic {
        return fan(polygon);
    }
    let count = polygon.len();
    let ear = |corner: usize| [polygon[(corner + count - 1) % count], polygon[corner], polygon[corner + 1]];
    let middles: Vec<u32> = polygon.iter().skip(1).step_by(2).copied().collect();
    (0..count).step_by(2).map(ear).chain(fan(&middles)).collect()
}

/// Returns edges between facets in space that meet at an angle.
fn sharp(points: &[[f64; 3]], hull: &[Vec<u32>]) -> Vec<[u32; 2]> {
    let mut at: BTreeMap<[u32; 2], Vec<[f64; 3]>> = BTreeMap::new();
    for facet in hull {
        let normal = normal(points, facet);
        for [a, b] in sides(facet) {
            at.entry([a.min(b), a.max(b)]).or_default().push(normal);
        }
    }
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    at.into_iter().filter(|(_, normals)| normals.len() != 2 || dot(&normals[0], &normals[1]) < SHARP).map(|(edge, _)| edge).collect()
}

/// Returns the unit normal by Newell's sums.
fn normal(points: &[[f64; 3]], facet: &[u32]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for [a, b] in sides(facet) {
        let (a, b) = (points[a as usize], points[b as usize]);
        for (d, component) in sum.iter_mut().enumerate() {
            let (e, f) = ((d + 1) % 3, (d + 2) % 3);
            *component += (a[e] - b[e]) * (a[f] + b[f]);
        }
    }
    let length = sum[0].hypot(sum[1]).hypot(sum[2]);
    if length > 0.0 { sum.map(|x| x / length) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_of_a_cell_cover_it_once() {
        let square = [0, 1, 2, 3];
        assert_eq!(triangles(&square, false), [[0, 1, 2], [0, 2, 3]]);
        // Corners 0, 2, 4 and middles 1, 3, 5: ears of a quarter each and the middle one.
        assert_eq!(triangles(&[0, 1, 2, 3, 4, 5], true), [[5, 0, 1], [1, 2, 3], [3, 4, 5], [1, 3, 5]]);
        assert_eq!(triangles(&[0, 1, 2, 3, 4, 5, 6, 7], true).len(), 6);
    }
}
