//! Visible surface of a body in space: the facets of its hull, or their remainder behind a section plane together with the cut through its
//! cells.
//!
//! A facet is a polygon of nodes, so is each face of a cell. Polygons are clipped at the plane (Sutherland and Hodgman 1974, with one
//! plane); the new edges of a cell's faces, chained, are the outline of the cut through the cell. New points lie on edges of cells, so that
//! neighbors share them, and values are linear along edges.

use std::collections::HashMap;

use super::section::CutPlane;
use crate::dynamics::BodyFields;
use crate::mesh::Facet;
use crate::output::obstacle_surfaces::ObstacleSurface;

/// Largest number of corners of a cut through a cell; more indicate a fault.
const CORNERS: usize = 64;

/// Point of a cut: the ends of its edge, and the position between them from 0 to 1.
type Cut = ([u32; 2], f64);

/// Visible surface of a body, in indices of its points.
pub(super) struct Skin {
    /// Number of nodes of the body.
    pub nodes: usize,
    /// Nodes of the body, followed by the points of the cut.
    pub points: Vec<[f64; 3]>,
    /// For each point of a cut, the ends of its edge and the position between them.
    cuts: Vec<Cut>,
    /// Facets of the hull, clipped at the section plane.
    pub facets: Vec<Vec<u32>>,
    /// Polygons of the cut through cells, counter-clockwise as seen from the removed side.
    pub faces: Vec<Vec<u32>>,
    /// Normal of the cut.
    pub normal: [f64; 3],
}

impl Skin {
    /// Returns the visible surface of a body with nodes at `position`, cut by `section`.
    pub fn new(body: &BodyFields, position: impl Fn(usize) -> [f64; 3], section: Option<&CutPlane>) -> Self {
        let points: Vec<[f64; 3]> = (0..body.mesh.points.len()).map(position).collect();
        let hull: Vec<Vec<u32>> = body.mesh.hull().into_iter().map(|facet| body.mesh.around(facet)).collect();
        let mut skin = Skin { nodes: points.len(), points, cuts: Vec::new(), facets: Vec::new(), faces: Vec::new(), normal: [0.0; 3] };
        let Some(section) = section else {
            skin.facets = hull;
            return skin;
        };
        let mut knife = CuttingPlane::new(section, &skin.points);
        skin.normal = section.normal;
        skin.facets = hull.iter().map(|facet| knife.cut(facet).0).filter(|facet| facet.len() > 2).collect();
        for (cell, (kind, nodes)) in body.mesh.cells_with_kinds().enumerate() {
            let is_left = nodes.iter().filter(|&&node| knife.keeps(node)).count();
            if is_left > 0 && is_left < nodes.len() {
                let around = (0..kind.facets().len() as u8).map(|local| body.mesh.around(Facet { cell: cell as u32, local }));
                skin.faces.extend(knife.through(&around.collect::<Vec<_>>()));
            }
        }
        (skin.points, skin.cuts) = knife.finish(skin.points);
        skin
    }

    /// Visible points.
    pub fn seen(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.facets.iter().chain(&self.faces).flatten().map(|&point| self.points[point as usize])
    }

    /// Returns values at all points from nodal values.
    pub fn values(&self, nodal: &[f64]) -> Vec<f64> {
        let between = |&([a, b], share): &Cut| nodal[a as usize] + share * (nodal[b as usize] - nodal[a as usize]);
        nodal.iter().copied().chain(self.cuts.iter().map(between)).collect()
    }
}

/// Clipping of polygons at a plane.
pub(super) struct CuttingPlane {
    /// Heights of the points above the plane.
    heights: Vec<f64>,
    /// Points of the cut by their edges (end nodes ascending), in the order of creation.
    at: HashMap<[u32; 2], u32>,
    cuts: Vec<Cut>,
}

impl CuttingPlane {
    pub fn new(section: &CutPlane, points: &[[f64; 3]]) -> Self {
        CuttingPlane { heights: section.heights(points), at: HashMap::new(), cuts: Vec::new() }
    }

    /// True if a point is kept.
    fn keeps(&self, point: u32) -> bool {
        self.heights[point as usize] <= 0.0
    }

    /// Returns the point of the cut on an edge: an end of the edge if the end lies in the plane.
    fn point_on(&mut self, a: u32, b: u32) -> u32 {
        if let Some(end) = [a, b].into_iter().find(|&end| self.heights[end as usize] == 0.0) {
            return end;
        }
        let edge = [a.min(b), a.max(b)];
        let next = (self.heights.len() + self.cuts.len()) as u32;
        *self.at.entry(edge).or_insert_with(|| {
            let [from, to] = edge.map(|point| self.heights[point as usize]);
            self.cuts.push((edge, (from / (from - to)).clamp(0.0, 1.0)));
            next
        })
    }

    /// Returns the part of a polygon that is kept, and its new edges in the sense of the polygon.
    pub fn cut(&mut self, polygon: &[u32]) -> (Vec<u32>, Vec<[u32; 2]>) {
        let (mut left, mut ends) = (Vec::new(), Vec::new());
        for (&a, &b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            if self.keeps(a) {
                left.push(a);
            }
            if self.keeps(a) != self.keeps(b) {
                let point = self.point_on(a, b);
                left.push(point);
                ends.push((self.keeps(a), point));
            }
        }
        left.dedup();
        if left.len() > 1 && left.first() == left.last() {
            left.pop();
        }
        // Pairs of points at which the polygon leaves the kept side and returns.
        let pairs = ends.iter().zip(ends.iter().cycle().skip(1)).filter(|((leaves, _), _)| *leaves);
        let edges = pairs.map(|(&(_, from), &(_, to))| [from, to]).filter(|[from, to]| from != to).collect();
        (left, edges)
    }

    /// Returns the loops of the cut through a cell with the given faces, which close its remainder.
    fn through(&mut self, faces: &[Vec<u32>]) -> Vec<Vec<u32>> {
        let mut after: HashMap<u32, u32> = HashMap::new();
        let mut starts = Vec::new();
        for face in faces {
            for [from, to] in self.cut(face).1 {
                after.insert(to, from);
                starts.push(to);
            }
        }
        let mut loops = Vec::new();
        for start in starts {
            let mut corners = Vec::new();
            let mut at = start;
            while let Some(next) = after.remove(&at) {
                corners.push(at);
                at = next;
            }
            if (3..CORNERS).contains(&corners.len()) {
                loops.push(corners);
            }
        }
        loops
    }

    /// Returns the points, followed by those of the cut.
    pub fn finish(self, mut points: Vec<[f64; 3]>) -> (Vec<[f64; 3]>, Vec<Cut>) {
        let between = |&([a, b], share): &Cut| {
            let (a, b) = (points[a as usize], points[b as usize]);
            [0, 1, 2].map(|d| a[d] + share * (b[d] - a[d]))
        };
        let new: Vec<[f64; 3]> = self.cuts.iter().map(between).collect();
        points.extend(new);
        (points, self.cuts)
    }
}

/// Returns the part of an obstacle's surface that a section plane keeps, and the line segments of the cut.
pub(super) fn cut_surface(surface: ObstacleSurface, section: &CutPlane) -> (ObstacleSurface, Vec<[[f64; 3]; 2]>) {
    let mut knife = CuttingPlane::new(section, &surface.points);
    let (left, edges): (Vec<_>, Vec<_>) = surface.facets.iter().map(|facet| knife.cut(facet)).unzip();
    let points = knife.finish(surface.points).0;
    let edges = edges.into_iter().flatten().map(|edge| edge.map(|point| points[point as usize])).collect();
    let facets = left.into_iter().filter(|facet: &Vec<u32>| facet.len() > 2).collect();
    (ObstacleSurface { points, facets, ..surface }, edges)
}

#[cfg(test)]
mod tests {
    use super::super::view::{View, dot};
    use super::*;
    use crate::elements::CellKind;
    use crate::output::samples::block;

    fn area(skin: &Skin, face: &[u32]) -> [f64; 3] {
        let at = |k: usize| skin.points[face[k % face.len()] as usize];
        let mut sum = [0.0; 3];
        for k in 0..face.len() {
            let (a, b) = (at(k), at(k + 1));
            for d in 0..3 {
                let (e, f) = ((d + 1) % 3, (d + 2) % 3);
                sum[d] += 0.5 * (a[e] * b[f] - a[f] * b[e]);
            }
        }
        sum
    }

    /// The remainder of a block is closed for planes through cells and along their faces: the area vectors of hull and cut sum to zero, the
    /// area of the cut is that of the section, and values are linear in the cut.
    #[test]
    fn a_cut_closes_what_is_left() {
        let plain = block([4, 2, 2], [4.0, 1.0, 2.0]);
        for kind in [CellKind::Hex8, CellKind::Tet4, CellKind::Hex20, CellKind::Tet10, CellKind::Hex27] {
            let mesh = plain.mesh.with_cells(kind).expect("hexahedra become cells of any kind");
            let body = BodyFields { mesh: mesh.into(), ..plain.clone() };
            let values: Vec<f64> = body.mesh.points.iter().map(|[x, y, z]| 2.0 * x - y + 0.5 * z).collect();
            for (point, normal) in
                [([1.3, 0.0, 0.0], [1.0, 0.0, 0.0]), ([2.0, 0.5, 1.0], [1.0, 0.0, 0.0]), ([2.0, 0.5, 1.0], [3.0, -1.0, 1.0])]
            {
                let section = CutPlane::new(Some(point), normal, &View::default()).expect("it faces the viewer");
                let skin = Skin::new(&body, |node| body.mesh.points[node], Some(&section));
                let faces = skin.faces.iter().map(|face| area(&skin, face));
                let cut = faces.fold([0.0; 3], |sum, area| [0, 1, 2].map(|d| sum[d] + area[d]));
                let hull = skin.facets.iter().map(|face| area(&skin, face)).fold([0.0; 3], |sum, area| [0, 1, 2].map(|d| sum[d] + area[d]));
                // Section of 1 by 2 along x, visible to the viewer from the front.
                assert!((cut[0] - 2.0).abs() < 1e-12, "{kind:?} {point:?}: {cut:?}");
                assert!((0..3).all(|d| (cut[d] + hull[d]).abs() < 1e-12), "{kind:?} {point:?}: {cut:?} {hull:?}");
                for (x, value) in skin.points.iter().zip(skin.values(&values)) {
                    assert!((value - dot([2.0, -1.0, 0.5], *x)).abs() < 1e-12);
                }
            }
        }
    }
}
