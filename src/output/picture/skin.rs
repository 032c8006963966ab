//! What can be seen of a body in space: the facets of its hull, or what a section leaves of them with the cells that it cuts.
//!
//! A facet is a polygon of nodes, so is each face of a cell. What lies beyond the plane is cut off from the polygons (Sutherland and
//! Hodgman 1974, with one plane); the new edges of the faces of a cell, chained, are the outline of the cut through it. New points belong
//! to edges of cells, so that neighbors share them, and values are linear along these.

use std::collections::HashMap;

use super::section::CutPlane;
use crate::dynamics::BodyFields;
use crate::mesh::Facet;
use crate::output::obstacle_surfaces::ObstacleSurface;

/// A cut may leave this many corners of a cell's polygon at most; more would be a fault.
const CORNERS: usize = 64;

/// A point of a cut: the ends of its edge, and how far it is from the first one to the second one.
type Cut = ([u32; 2], f64);

/// What can be seen of a body, in numbers of its points.
pub(super) struct Skin {
    /// Number of nodes of the body.
    pub nodes: usize,
    /// The nodes of the body, and behind them the points of a cut.
    pub points: Vec<[f64; 3]>,
    /// Of each point of a cut the ends of its edge, and how far it is from the first one to the second one.
    cuts: Vec<Cut>,
    /// What is left of the facets of the hull.
    pub facets: Vec<Vec<u32>>,
    /// The cut through cells, each counter-clockwise as seen from where material was taken away.
    pub faces: Vec<Vec<u32>>,
    /// Their normal.
    pub normal: [f64; 3],
}

impl Skin {
    /// Of a body with its nodes there.
    pub fn new(body: &BodyFields, position: impl Fn(usize) -> [f64; 3], section: Option<&CutPlane>) -> Self {
        let points: Vec<[f64; 3]> = (0..body.mesh.points.len()).map(position).collect();
        let hull: Vec<Vec<u32>> = body.mesh.hull().into_iter().map(|facet| body.mesh.around(facet)).collect();
        let mut skin = Skin { nodes: points.len(), points, cuts: Vec::new(), facets: Vec::new(), faces: Vec::new(), normal: [0.0; 3] };
        let Some(section) = section else {
            skin.facets = hull;
            return skin;
        };
        let mut knife = Knife::new(section, &skin.points);
        skin.normal = section.normal;
        skin.facets = hull.iter().map(|facet| knife.cut(facet).0).filter(|facet| facet.len() > 2).collect();
        let faces = body.mesh.kind.facets().len() as u8;
        for (cell, nodes) in body.mesh.cells().enumerate() {
            let is_left = nodes.iter().filter(|&&node| knife.keeps(node)).count();
            if is_left > 0 && is_left < nodes.len() {
                let around = (0..faces).map(|local| body.mesh.around(Facet { cell: cell as u32, local }));
                skin.faces.extend(knife.through(&around.collect::<Vec<_>>()));
            }
        }
        (skin.points, skin.cuts) = knife.finish(skin.points);
        skin
    }

    /// The points that are seen.
    pub fn seen(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.facets.iter().chain(&self.faces).flatten().map(|&point| self.points[point as usize])
    }

    /// Values at all points from those at the nodes.
    pub fn values(&self, nodal: &[f64]) -> Vec<f64> {
        let between = |&([a, b], share): &Cut| nodal[a as usize] + share * (nodal[b as usize] - nodal[a as usize]);
        nodal.iter().copied().chain(self.cuts.iter().map(between)).collect()
    }
}

/// Cuts polygons at a plane.
pub(super) struct Knife {
    /// Heights of the points above the plane.
    heights: Vec<f64>,
    /// Points of the cut by their edges, whose ends ascend, in the order in which they came.
    at: HashMap<[u32; 2], u32>,
    cuts: Vec<Cut>,
}

impl Knife {
    pub fn new(section: &CutPlane, points: &[[f64; 3]]) -> Self {
        Knife { heights: section.heights(points), at: HashMap::new(), cuts: Vec::new() }
    }

    /// Whether a point is left.
    fn keeps(&self, point: u32) -> bool {
        self.heights[point as usize] <= 0.0
    }

    /// The point of the cut on an edge: its end where that lies in the plane.
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

    /// What is left of a polygon, and its new edges in its sense.
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
        // From where the polygon leaves to where it comes back.
        let pairs = ends.iter().zip(ends.iter().cycle().skip(1)).filter(|((leaves, _), _)| *leaves);
        let edges = pairs.map(|(&(_, from), &(_, to))| [from, to]).filter(|[from, to]| from != to).collect();
        (left, edges)
    }

    /// The cut through a cell with these faces: loops that close its rest.
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

    /// The points with those of the cut behind them.
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

/// What a section leaves of an obstacle's surface, and where it cuts it.
pub(super) fn cut_surface(surface: ObstacleSurface, section: &CutPlane) -> (ObstacleSurface, Vec<[[f64; 3]; 2]>) {
    let mut knife = Knife::new(section, &surface.points);
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

    /// What is left of a block is closed: the areas of hull and cut sum to nothing, those of the cut to that of the section, whether the
    /// plane goes through cells or along their faces; values are linear in the cut.
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
                // The section of 1 by 2 as seen along x, which the viewer sees from the front.
                assert!((cut[0] - 2.0).abs() < 1e-12, "{kind:?} {point:?}: {cut:?}");
                assert!((0..3).all(|d| (cut[d] + hull[d]).abs() < 1e-12), "{kind:?} {point:?}: {cut:?} {hull:?}");
                for (x, value) in skin.points.iter().zip(skin.values(&values)) {
                    assert!((value - dot([2.0, -1.0, 0.5], *x)).abs() < 1e-12);
                }
            }
        }
    }
}
