//! Rigid surface of flat triangles: signed distances from the nearest face, edge or vertex, with gradient and Hessian (`obstacle.rs`).
//!
//! The sign follows from the normal at the nearest point: that of the face, the sum over both faces of an edge, or the sum over the faces
//! of a vertex weighted with their angles (Baerentzen and Aanaes, IEEE TVCG 11, 2005). Outside of a closed surface it is positive.
//!
//! In a re-entrant edge a point touches two sides simultaneously, and the distance from the nearest one has a kink. Surfaces with
//! re-entrant edges are divided along edges of more than 30 degrees into *sides*; a point has a distance from its nearest side, and from
//! each adjacent side across a re-entrant edge.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rstar::{AABB, PointDistance, RTree, RTreeObject};
use thiserror::Error;

use crate::contact::edge_plane::AtEdge;
use crate::contact::obstacle_side::Distance;
use crate::math::tolerances::{COPLANAR, FACING};

/// Cosine of the angle between the faces at an edge between two sides: 30 degrees.
const SAME_SIDE: f64 = 0.866_025_403_784_438_6;

/// Cosine of the angle between the faces at a sharp edge: 10 degrees.
const SMOOTH: f64 = super::features::SMOOTH;

/// Flat triangles that bound an obstacle.
#[derive(Clone, Debug)]
pub struct Facets {
    points: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    whole: RTree<Face>,
    /// Search trees of the sides (parts between edges of more than 30 degrees); empty without re-entrant edges.
    sides: Vec<RTree<Face>>,
    side_of: Vec<usize>,
    /// For each side, the adjacent sides across re-entrant edges.
    rising: Vec<Vec<usize>>,
}

/// Error in triangles that should bound an obstacle.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FacetsError {
    /// No triangle has an area.
    #[error("there is no triangle with an area")]
    Empty,
    /// A coordinate is not finite.
    #[error("point {0} has a coordinate that is not finite")]
    NotFinite(usize),
    /// An edge with more than two triangles, or with two of opposite orientation.
    #[error("the triangles at the edge from ({:?}) to ({:?}) face opposite sides", .0[0], .0[1])]
    Turned([[f64; 3]; 2]),
}

impl FacetsError {
    /// Stable message code, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            FacetsError::Empty => "C0281",
            FacetsError::NotFinite(..) => "C0282",
            FacetsError::Turned(..) => "C0283",
        }
    }
}

impl PartialEq for Facets {
    fn eq(&self, other: &Self) -> bool {
        self.points == other.points && self.triangles == other.triangles
    }
}

/// Kind of the nearest point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Feature {
    Face,
    /// Edge from the given corner (0 to 2) to the next one.
    Edge(usize),
    Vertex(usize),
}

/// Triangle with the normals of its edges and vertices.
#[derive(Clone, Debug)]
struct Face {
    triangle: usize,
    corners: [Vector3<f64>; 3],
    normal: Vector3<f64>,
    of_edges: [Vector3<f64>; 3],
    of_vertices: [Vector3<f64>; 3],
    /// True for each edge, and for each vertex, at which the surface ends.
    ends: [[bool; 3]; 2],
    /// True for each edge, and for each vertex, at a re-entrant border to another side, across which this side is continued as a plane.
    goes_on: [[bool; 3]; 2],
    /// True for each sharp edge that is not re-entrant.
    is_sharp: [bool; 3],
}

impl RTreeObject for Face {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_points(&self.corners.map(<[f64; 3]>::from))
    }
}

impl PointDistance for Face {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        let x = Vector3::from(*point);
        (x - self.nearest(x).0).norm_squared()
    }
}

impl Face {
    /// Nearest point of the triangle, and its kind (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
    fn nearest(&self, x: Vector3<f64>) -> (Vector3<f64>, Feature) {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let dots = |from: Vector3<f64>| (ab.dot(&(x - from)), ac.dot(&(x - from)));
        let ((d1, d2), (d3, d4), (d5, d6)) = (dots(a), dots(b), dots(c));
        let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
        if d1 <= 0.0 && d2 <= 0.0 {
            (a, Feature::Vertex(0))
        } else if d3 >= 0.0 && d4 <= d3 {
            (b, Feature::Vertex(1))
        } else if d6 >= 0.0 && d5 <= d6 {
            (c, Feature::Vertex(2))
        } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            (a + ab * (d1 / (d1 - d3)), Feature::Edge(0))
        } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            (a + ac * (d2 / (d2 - d6)), Feature::Edge(2))
        } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
            (b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), Feature::Edge(1))
        } else {
            let inverse = 1.0 / (va + vb + vc);
            (a + ab * (vb * inverse) + ac * (vc * inverse), Feature::Face)
        }
    }

    fn distance(&self, x: Vector3<f64>) -> Distance<3> {
        let (at, place) = self.nearest(x);
        let (pseudo, covered, is_plane) = match place {
            Feature::Face => (self.normal, true, true),
            Feature::Edge(k) => (self.of_edges[k], !self.ends[0][k], self.goes_on[0][k]),
            Feature::Vertex(k) => (self.of_vertices[k], !self.ends[1][k], self.goes_on[1][k]),
        };
        // An edge between coplanar faces, such as a diagonal, is ignored: the distance above it is that from the faces.
        let is_flat = covered && pseudo.dot(&self.normal) >= 1.0 - COPLANAR;
        if is_plane || is_flat {
            let gap = self.normal.dot(&(x - self.corners[0]));
            return Distance::flat(gap, self.normal, covered);
        }
        let (r, sign) = (x - at, if pseudo.dot(&(x - at)) < 0.0 { -1.0 } else { 1.0 });
        let length = r.norm();
        if length == 0.0 {
            return Distance::flat(0.0, pseudo, covered);
        }
        let normal = r * (sign / length);
        let mut across = Matrix3::identity() - normal * normal.transpose();
        if let Feature::Edge(k) = place {
            let along = (self.corners[(k + 1) % 3] - self.corners[k]).normalize();
            across -= along * along.transpose();
        }
        Distance { gap: sign * length, normal, curvature: across * (sign / length), covered }
    }
}

/// Edge between two faces.
#[derive(Clone, Copy, Debug)]
struct Edge {
    faces: [usize; 2],
    /// Cosine of the angle between the faces.
    cosine: f64,
    is_reentrant: bool,
}

/// Faces and edges of a surface, from which its sides and search trees are built.
struct Net<'a> {
    points: &'a [[f64; 3]],
    triangles: &'a [[u32; 3]],
    normals: Vec<Vector3<f64>>,
    /// Edges with two faces, by their nodes in ascending order.
    edges: BTreeMap<[u32; 2], Edge>,
}

impl<'a> Net<'a> {
    fn new(points: &'a [[f64; 3]], triangles: &'a [[u32; 3]]) -> Result<Self, FacetsError> {
        let at = |node: u32| Vector3::from(points[node as usize]);
        let normal = |&[a, b, c]: &[u32; 3]| (at(b) - at(a)).cross(&(at(c) - at(a))).normalize();
        let normals: Vec<Vector3<f64>> = triangles.iter().map(normal).collect();
        let mut found: BTreeMap<[u32; 2], Vec<(usize, bool)>> = BTreeMap::new();
        for (face, nodes) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
                found.entry([a.min(b), a.max(b)]).or_default().push((face, a < b));
            }
        }
        let mut edges = BTreeMap::new();
        for (nodes, sides) in found {
            match sides[..] {
                [_] => {}
                [(one, up), (other, down)] if up != down => {
                    let middle = triangles[other].iter().map(|&node| at(node)).sum::<Vector3<f64>>() / 3.0;
                    let is_reentrant = normals[one].dot(&(middle - at(nodes[0]))) > 0.0;
                    edges.insert(nodes, Edge { faces: [one, other], cosine: normals[one].dot(&normals[other]), is_reentrant });
                }
                _ => return Err(FacetsError::Turned(nodes.map(|node| points[node as usize]))),
            }
        }
        Ok(Net { points, triangles, normals, edges })
    }

    /// Side number of each triangle, and number of sides.
    fn sides(&self) -> (Vec<usize>, usize) {
        let mut next: Vec<Vec<usize>> = vec![Vec::new(); self.triangles.len()];
        for edge in self.edges.values().filter(|edge| edge.cosine >= SAME_SIDE) {
            let [one, other] = edge.faces;
            next[one].push(other);
            next[other].push(one);
        }
        let (mut sides, mut count) = (vec![usize::MAX; self.triangles.len()], 0);
        for start in 0..sides.len() {
            if sides[start] != usize::MAX {
                continue;
            }
            let mut open = vec![start];
            while let Some(face) = open.pop() {
                if sides[face] == usize::MAX {
                    sides[face] = count;
                    open.extend(&next[face]);
                }
            }
            count += 1;
        }
        (sides, count)
    }

    /// Search tree of the triangles for which `of` is true.
    fn tree(&self, of: impl Fn(usize) -> bool) -> RTree<Face> {
        let faces: Vec<usize> = (0..self.triangles.len()).filter(|&face| of(face)).collect();
        let at = |node: u32| Vector3::from(self.points[node as usize]);
        let mut of_vertices: BTreeMap<u32, Vector3<f64>> = BTreeMap::new();
        let [mut ends, mut rises]: [BTreeSet<u32>; 2] = Default::default();
        let edge_of = |face: usize, k: usize| {
            let nodes = self.triangles[face];
            let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
            self.edges.get(&[a.min(b), a.max(b)])
        };
        let other = |face: usize, edge: &Edge| if edge.faces[0] == face { edge.faces[1] } else { edge.faces[0] };
        let is_border = |face: usize, k: usize| edge_of(face, k).is_none_or(|edge| !of(other(face, edge)));
        let rises_at = |face: usize, k: usize| is_border(face, k) && edge_of(face, k).is_some_and(|edge| edge.is_reentrant);
        let is_end = |face: usize, k: usize| is_border(face, k) && !rises_at(face, k);
        for &face in &faces {
            let nodes = self.triangles[face];
            for k in 0..3 {
                let [to, from] = [1, 2].map(|step| (at(nodes[(k + step) % 3]) - at(nodes[k])).normalize());
                let angle = to.cross(&from).norm().atan2(to.dot(&from));
                *of_vertices.entry(nodes[k]).or_default() += self.normals[face] * angle;
                if is_end(face, k) {
                    ends.extend([nodes[k], nodes[(k + 1) % 3]]);
                }
                if rises_at(face, k) {
                    rises.extend([nodes[k], nodes[(k + 1) % 3]]);
                }
            }
        }
        let made = faces.iter().map(|&face| {
            let nodes = self.triangles[face];
            let both = |k: usize| edge_of(face, k).map(|edge| other(face, edge)).filter(|&other| of(other));
            let sharp = |k: usize| edge_of(face, k).is_some_and(|edge| edge.cosine < SMOOTH && !edge.is_reentrant);
            Face {
                triangle: face,
                corners: nodes.map(at),
                normal: self.normals[face],
                of_edges: [0, 1, 2]
                    .map(|k| (self.normals[face] + both(k).map_or(Vector3::zeros(), |other| self.normals[other])).normalize()),
                of_vertices: nodes.map(|node| of_vertices[&node].normalize()),
                ends: [[0, 1, 2].map(|k| is_end(face, k)), nodes.map(|node| ends.contains(&node))],
                goes_on: [[0, 1, 2].map(|k| rises_at(face, k)), nodes.map(|node| rises.contains(&node))],
                is_sharp: [0, 1, 2].map(sharp),
            }
        });
        RTree::bulk_load(made.collect())
    }
}

impl Facets {
    /// Surface of triangles, counter-clockwise as seen from the bodies. Equal points are merged, and triangles without area are removed.
    ///
    /// # Errors
    /// All triangles are removed; a coordinate is not finite; an edge has more than two triangles, or two of opposite orientation.
    pub fn new(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Self, FacetsError> {
        if let Some(point) = points.iter().position(|point| point.iter().any(|x| !x.is_finite())) {
            return Err(FacetsError::NotFinite(point));
        }
        let mut kept: Vec<[f64; 3]> = Vec::new();
        let mut known: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        let mut number = |node: u32| {
            // Adding 0.0 turns -0.0 into 0.0, so that both have equal bits.
            let point = points[node as usize].map(|x| x + 0.0);
            *known.entry(point.map(f64::to_bits)).or_insert_with(|| {
                kept.push(point);
                kept.len() as u32 - 1
            })
        };
        let joined: Vec<[u32; 3]> = triangles.iter().map(|nodes| nodes.map(&mut number)).collect();
        let at = |node: u32| Vector3::from(kept[node as usize]);
        let has_area = |[a, b, c]: &[u32; 3]| {
            let (u, v) = (at(*b) - at(*a), at(*c) - at(*a));
            u.cross(&v).norm() > FACING * FACING * u.norm().max(v.norm()).powi(2)
        };
        let triangles: Vec<[u32; 3]> = joined.into_iter().filter(has_area).collect();
        if triangles.is_empty() {
            return Err(FacetsError::Empty);
        }
        let net = Net::new(&kept, &triangles)?;
        let whole = net.tree(|_| true);
        let (side_of, count) = net.sides();
        let reentrant: Vec<[usize; 2]> =
            net.edges.values().filter(|edge| edge.is_reentrant).map(|edge| edge.faces.map(|face| side_of[face])).collect();
        let mut rising = vec![BTreeSet::new(); count];
        for &[one, other] in reentrant.iter().filter(|[one, other]| one != other) {
            rising[one].insert(other);
            rising[other].insert(one);
        }
        let has_any = rising.iter().any(|rising| !rising.is_empty());
        let sides = if has_any { (0..count).map(|side| net.tree(|face| side_of[face] == side)).collect() } else { Vec::new() };
        let rising = rising.into_iter().map(|rising| rising.into_iter().collect()).collect();
        Ok(Facets { points: kept, triangles, whole, sides, side_of, rising })
    }

    /// Box with edges along the axes, between its lowest and its highest corner.
    ///
    /// # Errors
    /// The box has no volume.
    pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> Result<Self, FacetsError> {
        let corner = |k: usize| std::array::from_fn(|i| if k >> i & 1 == 1 { high[i] } else { low[i] });
        let points: Vec<[f64; 3]> = (0..8).map(corner).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let made = Facets::new(&points, &triangles)?;
        if made.triangles.len() == 12 { Ok(made) } else { Err(FacetsError::Empty) }
    }

    /// Surface with mapped points; `map` must preserve the orientation.
    ///
    /// # Errors
    /// As in [`Facets::new`].
    pub fn mapped(&self, map: impl FnMut([f64; 3]) -> [f64; 3]) -> Result<Self, FacetsError> {
        let points: Vec<[f64; 3]> = self.points.iter().copied().map(map).collect();
        Facets::new(&points, &self.triangles)
    }

    /// Surface rotated by an angle `[rad]` about an axis through a point.
    ///
    /// # Errors
    /// As in [`Facets::new`].
    pub fn turned(&self, point: [f64; 3], axis: [f64; 3], angle: f64) -> Result<Self, FacetsError> {
        if angle == 0.0 {
            return Ok(self.clone());
        }
        let (point, turn) = (Vector3::from(point), Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::from(axis)), angle));
        self.mapped(|x| (point + turn * (Vector3::from(x) - point)).into())
    }

    /// Points `[length]`.
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// Triangles, counter-clockwise as seen from the bodies.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// True if the surface has edges with only one triangle.
    pub(in crate::contact) fn is_open(&self) -> bool {
        self.whole.iter().any(|face| face.ends[0].contains(&true))
    }

    /// Signed distance from the whole surface.
    pub(super) fn distance(&self, x: Vector3<f64>) -> Distance<3> {
        from(&self.whole, x)
    }

    /// Signed distance from side number `side` of the surface.
    pub(super) fn side_distance(&self, side: usize, x: Vector3<f64>) -> Distance<3> {
        from(&self.sides[side], x)
    }

    /// True if a point may touch several sides simultaneously.
    pub(super) fn has_pockets(&self) -> bool {
        !self.sides.is_empty()
    }

    /// Nearest side of a point, and adjacent sides across re-entrant edges that are opposite the point and nearer than `near`, nearest
    /// first; empty without adjacent ones.
    pub(super) fn around(&self, x: Vector3<f64>, near: f64) -> Vec<usize> {
        if !self.has_pockets() {
            return Vec::new();
        }
        let Some(nearest) = self.whole.nearest_neighbor(x.into()) else { return Vec::new() };
        let side = self.side_of[nearest.triangle];
        let seen = self.rising[side].iter().map(|&other| (self.side_distance(other, x), other));
        let mut close: Vec<(f64, usize)> =
            seen.filter(|(at, _)| at.covered && at.gap.abs() < near).map(|(at, other)| (at.gap, other)).collect();
        close.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let own = (!close.is_empty()).then_some(side);
        own.into_iter().chain(close.into_iter().map(|(_, other)| other)).collect()
    }

    /// Faces at the sharp edge or vertex within `near` of a point, in descending order of the point's signed distance from their planes.
    pub(super) fn at_edge(&self, x: Vector3<f64>, near: f64) -> Option<AtEdge<3>> {
        let nearest = self.whole.nearest_neighbor(x.into())?;
        let at = nearest.nearest(x).0;
        if (x - at).norm() > near || !nearest.distance(x).covered {
            return None;
        }
        let on_edges = |face: &Face| -> Vec<Vector3<f64>> {
            let on_edge = |k: usize| {
                let (a, b) = (face.corners[k], face.corners[(k + 1) % 3]);
                a + (b - a) * ((at - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0)
            };
            (0..3).filter(|&k| face.is_sharp[k]).map(on_edge).filter(|point| (at - point).norm() <= near).collect()
        };
        let faces = self.whole.locate_within_distance(x.into(), 4.0 * near * near);
        let mut around: Vec<(&Face, Vec<Vector3<f64>>)> =
            faces.map(|face| (face, on_edges(face))).filter(|(_, on)| !on.is_empty()).collect();
        let height = |face: &Face| face.normal.dot(&(x - face.corners[0]));
        around.sort_by(|(a, _), (b, _)| height(b).total_cmp(&height(a)).then(a.triangle.cmp(&b.triangle)));
        let edge: Vec<Vector3<f64>> = around.iter().flat_map(|(_, on)| on.iter().copied()).collect();
        let distance = edge.iter().map(|point| (at - point).norm()).fold(f64::INFINITY, f64::min).max((x - at).norm());
        let (points, normals) = around.into_iter().map(|(face, _)| (face.corners[0], face.normal)).unzip();
        Some(AtEdge { normals, points, edge, distance }).filter(|at| !at.edge.is_empty())
    }

    /// True if the straight path between two points crosses a face.
    pub(in crate::contact) fn is_crossed(&self, x_0: Vector3<f64>, x_1: Vector3<f64>) -> bool {
        let way = x_1 - x_0;
        let area = AABB::from_points(&[x_0, x_1].map(<[f64; 3]>::from));
        self.whole.locate_in_envelope_intersecting(area).any(|face| {
            let [a, b, c] = face.corners;
            let volume = |u: Vector3<f64>, v: Vector3<f64>| way.dot(&(u - x_0).cross(&(v - x_0)));
            let turns = [volume(a, b), volume(b, c), volume(c, a)];
            let heights = [x_0, x_1].map(|x| face.normal.dot(&(x - a)));
            let passes = turns.iter().all(|&turn| turn > 0.0) || turns.iter().all(|&turn| turn < 0.0);
            passes && heights[0] * heights[1] < 0.0
        })
    }
}

/// Signed distance from the faces of a tree; infinite for an empty tree.
fn from(tree: &RTree<Face>, x: Vector3<f64>) -> Distance<3> {
    let none = Distance { gap: f64::INFINITY, ..Distance::none() };
    tree.nearest_neighbor(x.into()).map_or(none, |face| face.distance(x))
}
