//! Contact of faces of second order in space: four facets per face between combinations of its nodes (`on_curves.rs`).
//!
//! Triangles of six nodes are divided into four triangles, quadrilaterals of eight or nine into four about the center. With the offset
//! `d = x_m - (1/2 - tau) x_a - (1/2 + tau) x_b` of a mid-side node from its chord (`tau`: its shift from the middle along the chord in the
//! reference positions, in chord lengths), and the offset `D` of a ninth node from the center of the eight-node interpolation,
//!
//! ```text
//! corner            y = x_a + R_a,           R_a = mean over the faces there, and the two edges of each, of k d, k = 1/4 of triangles,
//!                                            1/3 of quadrilaterals;
//!                                            zero where none of them lies off the plane of a face's corners in the reference positions
//! middle            y = chord + r d + (R_a + R_b)/2
//! center            y = center of the chords + sum of r d/2 over the edges + mean of R + g D
//! ```
//!
//! The factors `r` and `g` of each edge and face are chosen so that the sum over the points of area vector (`faces::vector_shares`) times
//! coefficient of `d`, `D` equals the integral of the corresponding shape function times the normal over the faces, in the direction of
//! this integral. Nodal forces of a constant pressure then equal the consistent forces: on plane faces with straight edges at all nodes, on
//! curved ones at mid-side nodes and centers. With areas in place of area vectors, forces at corners of spheres with 16 cells around were
//! too large by 5 % (nine nodes) or 60 % (six nodes, whose corners have almost none). On even meshes of curved surfaces `r` is close to 1:
//! all points, also at borders, are raised equally, so that the polyhedron preserves the volume. Corners of plane faces stay at their
//! nodes, so that only nodes of two faces are coupled.
//!
//! Multipliers belong to the nodes and are linear on the sub-facets; a center without a node has the mean of the mid-side multipliers.
//! (First-order facets on quadratic faces: Puso, Laursen and Solberg, CMAME 197, 2008; the force-preserving points are new here.)

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use super::curved_face::{center, corner_normals};
use super::exact_profile::exact_profile;
use super::facet_profile::Profile;
use super::profiles::{across_triangles, profiles, stretching};
use super::quadric::Quadric;
use crate::contact::combinations::Combinations;
use crate::contact::faces::{self, Vector};
use crate::contact::facet_shape::FacetShape;
use crate::contact::kernel::ContactKernel;
use crate::contact::on_curves::OnCurves;
use crate::contact::surface::{Sides, Surface};
use crate::elements::face_points;
use crate::math::tolerances;
use crate::mesh::{flat_pieces, pieces_of};

/// Factor `k` of the edge offsets in the shift of corners of triangles.
const OF_TRIANGLES: f64 = 1.0 / 4.0;
/// Factor `k` of the edge offsets in the shift of corners of quadrilaterals.
const OF_QUADRILATERALS: f64 = 1.0 / 3.0;

/// Iterations in which the areas of the points and the factors of the offsets are adapted to each other; one is exact if the points of
/// plane faces are the nodes.
const ROUNDS: usize = 3;

/// Ratio of the magnitude of a surface integral of `N n` to that of `N` below which the faces at an edge count as folded onto each other.
const FOLDED: f64 = 0.5;

/// Difference in height of the points of faces of second order over the height of their facets' middles: points on spheres are raised by
/// amounts that differ by a fifth of the mean height. Vertices of a hollow surface may overlap by it: otherwise those at the rims of
/// matching octants of spheres (`hex20`, 16 cells around) take two thirds of the pressure of the surface there, or close and open in turn.
const UNEVEN: f64 = 1.0 / 6.0;

/// Surfaces as contact in space represents them: facets between nodes, or between points on faces of second order.
pub struct ProxySurfacesInSpace<'a> {
    /// Secondary surface, whose points have the constraints.
    pub secondary: Surface,
    /// Primary surface, without constraints.
    pub primary: Surface,
    /// Reference positions of the nodes or points between which facets lie `[length]`.
    pub reference: Cow<'a, [f64]>,
    /// Reference positions of those points of the curved surface that the nodes or points represent `[length]`.
    pub curve: Cow<'a, [f64]>,
    /// For ties: a node inside of the body behind each primary facet; otherwise empty.
    pub inner: Vec<u32>,
    /// Height profiles of the facets of both sides.
    pub(super) profiles: [Vec<Profile>; 2],
    on_faces: Option<(Combinations, Combinations, Sides)>,
}

impl<'a> ProxySurfacesInSpace<'a> {
    /// Two surfaces given by the nodes of their faces: three, four, six, eight or nine each.
    pub fn new(sides: [&[Vec<u32>]; 2], reference: &'a [f64]) -> Self {
        Self::with_inner(sides, &[], reference)
    }

    /// Two surfaces given by the nodes of their faces, with a node inside of the body behind each primary face.
    pub fn with_inner(sides: [&[Vec<u32>]; 2], inner: &[u32], reference: &'a [f64]) -> Self {
        let of = |pieces: &[Vec<u32>]| Surface::in_space(pieces.iter().map(|piece| &piece[..]));
        if sides.into_iter().flatten().all(|face| face.len() <= 4) {
            let [secondary, primary] = sides.map(of);
            let profiles = [&secondary, &primary].map(|surface| profiles(surface, reference, reference, &[]));
            return ProxySurfacesInSpace {
                secondary,
                primary,
                reference: reference.into(),
                curve: reference.into(),
                inner: inner.to_vec(),
                profiles,
                on_faces: None,
            };
        }
        let mut proxies = Proxies::new(sides, inner, reference);
        for _ in 0..ROUNDS {
            proxies.adjust(reference);
        }
        let (points, homes) = proxies.combinations();
        let [secondary, primary] = sides.map(|faces| of(&faces.iter().flat_map(|face| proxies.pieces(face)).collect::<Vec<_>>()));
        let [own, other] = sides.map(|faces| of(&faces.iter().flat_map(|face| pieces_of(face)).collect::<Vec<_>>()));
        let seen = points.points(3, reference);
        let behind = |(face, node): (&Vec<u32>, &u32)| vec![proxies.point_of[node]; proxies.pieces(face).len()];
        let inner = sides[1].iter().zip(inner).flat_map(behind).collect();
        let truth = proxies.nodes(&seen, reference);
        let normals = sides.map(|faces| faces.iter().flat_map(|face| corner_normals(face, reference)).collect::<Vec<_>>());
        let mut profiles = [(&secondary, &normals[0]), (&primary, &normals[1])].map(|(surface, of)| profiles(surface, &seen, &truth, of));
        for ((surface, faces), profiles) in [&secondary, &primary].into_iter().zip(sides).zip(&mut profiles) {
            let pieces = faces.iter().flat_map(|face| std::iter::repeat_n(face, proxies.pieces(face).len()));
            for (facet, (face, profile)) in pieces.zip(profiles).enumerate().filter(|(_, (face, _))| face.len() >= 6) {
                let of_face = Quadric::through(face, reference)
                    .and_then(|quadric| exact_profile(|x, normal| quadric.height(x, normal), surface.facet(facet), &seen));
                if let Some(of_face) = of_face {
                    *profile = of_face;
                }
            }
        }
        let on_faces = Some((points, homes, Sides::of(own, other, reference)));
        ProxySurfacesInSpace { secondary, primary, reference: seen.into(), curve: truth.into(), inner, profiles, on_faces }
    }

    /// Difference in height of the points of curved faces over the height of their facets' middles; 0 if facets lie between nodes.
    pub(super) fn unevenness(&self) -> f64 {
        if self.on_faces.is_some() { UNEVEN } else { 0.0 }
    }

    /// True if facets lie between points on faces of second order.
    pub(super) fn is_on_faces(&self) -> bool {
        self.on_faces.is_some()
    }

    /// Removes the height profiles for the facet shape `Straight`.
    pub fn of_shape(mut self, shape: FacetShape) -> Self {
        if shape == FacetShape::Straight {
            self.profiles.iter_mut().flatten().for_each(|profile| *profile = Profile::default());
        }
        self
    }

    /// Replaces the height profiles of sides by those of exact shapes. A shape is a function that returns the height over a point of a
    /// facet with a given unit normal; `None` where the facet does not represent the shape.
    pub fn of_exact(mut self, shapes: [Option<impl Fn(Vector, Vector) -> Option<f64>>; 2]) -> Self {
        for ((surface, profiles), shape) in [&self.secondary, &self.primary].into_iter().zip(&mut self.profiles).zip(shapes) {
            let Some(height) = shape else { continue };
            for (facet, profile) in profiles.iter_mut().enumerate() {
                if let Some(exact) = exact_profile(&height, surface.facet(facet), &self.reference) {
                    *profile = exact;
                }
            }
        }
        self
    }

    /// Height profiles of the secondary facets, which follow the stretches of the facets.
    pub(super) fn secondary_profiles(&self) -> Vec<Profile> {
        let profiles = self.profiles[0].iter().cloned().map(Profile::of_secondary).collect();
        stretching(&self.secondary, &self.reference, profiles)
    }

    /// Height profiles of the primary facets, along the normals of their triangles, which follow the stretches of the facets.
    pub(super) fn primary_profiles(&self) -> Vec<Profile> {
        let mut profiles = self.profiles[1].clone();
        across_triangles(&self.primary, &self.reference, &mut profiles);
        stretching(&self.primary, &self.reference, profiles.into_iter().map(Profile::of_primary).collect())
    }

    /// True for each secondary node or point that belongs to one of the given model nodes (ascending).
    pub fn belongs_to(&self, nodes: &[u32]) -> Vec<bool> {
        let home = |&point: &u32| self.on_faces.as_ref().map_or(point, |(_, homes, _)| homes.parts(point as usize)[0].0);
        self.secondary.nodes().iter().map(|point| nodes.binary_search(&home(point)).is_ok()).collect()
    }

    /// Height of the curved surface over each node or point of a side, averaged over its facets with height profiles `[length]`.
    pub fn heights(&self, side: usize) -> Vec<f64> {
        let (surface, profiles) = ([&self.secondary, &self.primary][side], &self.profiles[side]);
        let of_node = |node: usize| {
            let curved = surface.adjacent_facets(node).iter().map(|&facet| facet as usize).filter(|&facet| !profiles[facet].is_flat());
            let heights = curved.map(|facet| {
                let nodes = surface.local_facet(facet);
                let place = nodes.iter().position(|&other| other as usize == node).unwrap_or(0);
                profiles[facet].corner(place)
            });
            let (count, sum) = heights.fold((0, 0.0), |(count, sum), height| (count + 1, sum + height));
            sum / f64::from(count.max(1))
        };
        (0..surface.nodes().len()).map(of_node).collect()
    }

    /// Transforms `kernel`, a contact method on the points of the proxy surfaces, to the nodes of the model. `is_of_surface`: constraints
    /// belong to the secondary nodes, not to selected points of either side.
    pub fn on_nodes(&self, kernel: Box<dyn ContactKernel>, is_of_surface: bool) -> Box<dyn ContactKernel> {
        let Some((points, homes, mut sides)) = self.on_faces.clone() else { return kernel };
        let mut rows = Combinations::default();
        if is_of_surface {
            let stride = kernel.rows_per_node() as u32;
            for &point in kernel.row_nodes() {
                let index = |node: u32| sides.secondary.index(node).unwrap_or(0) as u32;
                for slot in 0..stride {
                    rows.push(homes.parts(point as usize).iter().map(|&(node, share)| (stride * index(node) + slot, share)));
                }
            }
            let row_nodes = sides.secondary.nodes().to_vec();
            return Box::new(OnCurves::new(kernel, sides, [points, rows, homes], row_nodes));
        }
        for row in 0..kernel.rows() as u32 {
            rows.push([(row, 1.0)]);
        }
        let row_nodes = kernel.row_nodes().iter().map(|&point| homes.parts(point as usize)[0].0).collect();
        sides.facet_size = kernel.facet_size();
        Box::new(OnCurves::new(kernel, sides, [points, rows, homes], row_nodes))
    }
}

/// Edge of second order.
struct Edge {
    middle: u32,
    ends: [u32; 2],
    /// Shift of the mid-side node along the chord from the chord's middle in the reference positions, in chord lengths.
    shift: f64,
    is_curved: bool,
    /// Factor `k` of the offset in the shift of the corners of the face.
    by: f64,
    /// Factor `r` of the edge's offset `d` in its points.
    raised: f64,
}

impl Edge {
    fn new(middle: u32, ends: [u32; 2], by: f64, q: &[f64]) -> Self {
        let [a, b, m] = [ends[0], ends[1], middle].map(|node| faces::at(node, q));
        let shift = (m - 0.5 * (a + b)).dot(&(b - a)) / (b - a).norm_squared();
        Edge { middle, ends, shift, is_curved: false, by, raised: 1.0 }
    }

    /// Distance of the mid-side node from the chord along a face normal, in chord lengths.
    fn sagitta(&self, normal: Vector, q: &[f64]) -> f64 {
        let [a, b, m] = [self.ends[0], self.ends[1], self.middle].map(|node| faces::at(node, q));
        (m - 0.5 * (a + b)).dot(&normal) / (b - a).norm()
    }

    /// Coefficients of the end nodes in `by` times the point of the chord below the mid-side node.
    fn chord(&self, by: f64) -> [(u32, f64); 2] {
        [(self.ends[0], by * (0.5 - self.shift)), (self.ends[1], by * (0.5 + self.shift))]
    }
}

/// Face of eight or nine nodes.
struct Center {
    nodes: Vec<u32>,
    /// Factor `g` of the ninth node's offset `D` in the center.
    raised: f64,
}

/// Point of the representation as a combination of nodes and edge offsets.
#[derive(Default)]
struct Proxy {
    /// Coefficients of the nodes, without offsets.
    base: Vec<(u32, f64)>,
    /// Edges whose offsets shift the point, with factors that are independent of `r`.
    raised: Vec<(usize, f64)>,
    /// Edges whose offsets shift the point, with factors to be multiplied by `r`.
    own: Vec<(usize, f64)>,
    /// Home nodes, whose multipliers the point interpolates.
    homes: Vec<(u32, f64)>,
}

/// Points on the faces of two surfaces, with the edges and centers that define them.
struct Proxies {
    edges: Vec<Edge>,
    edge_of: BTreeMap<u32, usize>,
    centers: Vec<Center>,
    /// Index of the point of each node.
    point_of: BTreeMap<u32, u32>,
    /// Index of the point at the center of each face of eight or nine nodes.
    center_of: BTreeMap<Vec<u32>, u32>,
    proxies: Vec<Proxy>,
    faces: Vec<Vec<u32>>,
    /// Integrals over the faces of the shape function that multiplies each edge's offset times the normal, to which the factors `r` are
    /// adapted; zero at edges of faces that are folded onto each other, whose factors stay 1.
    wanted: Vec<Vector>,
}

/// Number of corners of a face.
fn corners(face: &[u32]) -> usize {
    if matches!(face.len(), 3 | 6) { 3 } else { 4 }
}

impl Proxies {
    /// Makes the points on the faces, and points of the nodes `others` that belong to no face.
    fn new(sides: [&[Vec<u32>]; 2], others: &[u32], q: &[f64]) -> Self {
        let faces: BTreeSet<Vec<u32>> = sides.into_iter().flatten().cloned().collect();
        let mut made = Proxies {
            edges: Vec::new(),
            edge_of: BTreeMap::new(),
            centers: Vec::new(),
            point_of: BTreeMap::new(),
            center_of: BTreeMap::new(),
            proxies: Vec::new(),
            faces: faces.into_iter().collect(),
            wanted: Vec::new(),
        };
        let mut around: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for face in made.faces.iter().filter(|face| face.len() > 4) {
            let count = corners(face);
            let by = if count == 3 { OF_TRIANGLES } else { OF_QUADRILATERALS };
            for k in 0..count {
                let ends = [face[k], face[(k + 1) % count]];
                let edge = *made.edge_of.entry(face[count + k]).or_insert_with(|| {
                    made.edges.push(Edge::new(face[count + k], ends, by, q));
                    made.edges.len() - 1
                });
                ends.iter().for_each(|&end| around.entry(end).or_default().push(edge));
                let sagitta = made.edges[edge].sagitta(faces::normal(&face[..count], q), q);
                made.edges[edge].is_curved |= sagitta.abs() > tolerances::STRAIGHT;
            }
        }
        made.wanted = vec![Vector::zeros(); made.edges.len()];
        let raising = |corner: u32| -> Vec<(usize, f64)> {
            let edges = around.get(&corner).map_or(&[][..], |edges| &edges[..]);
            let share = if edges.iter().any(|&edge| made.edges[edge].is_curved) { 1.0 / edges.len() as f64 } else { 0.0 };
            edges.iter().filter(|_| share > 0.0).map(|&edge| (edge, share * made.edges[edge].by)).collect()
        };
        let scaled = |corner: u32, by: f64| raising(corner).into_iter().map(move |(edge, share)| (edge, by * share));
        let nodes: BTreeSet<u32> = made.faces.iter().flatten().chain(others).copied().collect();
        let centers: BTreeMap<u32, &Vec<u32>> = made.faces.iter().filter(|face| face.len() == 9).map(|face| (face[8], face)).collect();
        let central = |face: &[u32]| {
            let edges: Vec<usize> = face[4..8].iter().map(|middle| made.edge_of[middle]).collect();
            let chords = edges.iter().flat_map(|&edge| made.edges[edge].chord(0.5));
            Proxy {
                base: chords.chain(face[..4].iter().map(|&corner| (corner, -0.25))).collect(),
                raised: face[..4].iter().flat_map(|&corner| scaled(corner, 0.25)).collect(),
                own: edges.iter().map(|&edge| (edge, 0.5)).collect(),
                homes: if face.len() == 9 { vec![(face[8], 1.0)] } else { face[4..8].iter().map(|&middle| (middle, 0.25)).collect() },
            }
        };
        let mut proxies = Vec::new();
        for (&node, point) in nodes.iter().zip(0..) {
            made.point_of.insert(node, point);
            proxies.push(if let Some(&edge) = made.edge_of.get(&node) {
                let Edge { ends, .. } = made.edges[edge];
                let raised = ends.into_iter().flat_map(|end| scaled(end, 0.5)).collect();
                Proxy { base: made.edges[edge].chord(1.0).to_vec(), raised, own: vec![(edge, 1.0)], homes: vec![(node, 1.0)] }
            } else if let Some(face) = centers.get(&node) {
                central(face)
            } else {
                Proxy { base: vec![(node, 1.0)], raised: raising(node), own: Vec::new(), homes: vec![(node, 1.0)] }
            });
        }
        for face in made.faces.iter().filter(|face| face.len() >= 8) {
            if face.len() == 8 {
                made.center_of.insert(face.clone(), proxies.len() as u32);
                proxies.push(central(face));
            } else {
                made.center_of.insert(face.clone(), made.point_of[&face[8]]);
            }
            made.centers.push(Center { nodes: face.clone(), raised: 1.0 });
        }
        made.proxies = proxies;
        made.integrate(q);
        made
    }

    /// Integrates the shape functions that multiply the edges' offsets times the normal over the reference faces.
    fn integrate(&mut self, q: &[f64]) {
        let mut sizes = vec![0.0; self.edges.len()];
        for face in self.faces.iter().filter(|face| face.len() > 4) {
            let (places, count) = (face.iter().map(|&node| faces::at(node, q).into()).collect::<Vec<[f64; 3]>>(), corners(face));
            for point in face_points(face.len()) {
                let area = point.weight * Vector::from(point.normal(&places));
                for k in 0..count {
                    // The center function of a nine-node face is expressed by the offset `D`; half of it is added to each mid-side
                    // function.
                    let shape = point.shapes[count + k] + point.shapes.get(8).map_or(0.0, |center| 0.5 * center);
                    let edge = self.edge_of[&face[count + k]];
                    self.wanted[edge] += area * shape;
                    sizes[edge] += area.norm() * shape;
                }
            }
        }
        for (wanted, size) in self.wanted.iter_mut().zip(sizes) {
            if wanted.norm() < FOLDED * size {
                *wanted = Vector::zeros();
            }
        }
    }

    /// Facets between points into which a face is divided.
    fn pieces(&self, face: &[u32]) -> Vec<Vec<u32>> {
        let point = |k: &usize| if *k == 8 { self.center_of[face] } else { self.point_of[&face[*k]] };
        let pieces = flat_pieces(if face.len() == 8 { 9 } else { face.len() });
        pieces.iter().map(|piece| piece.iter().map(point).collect()).collect()
    }

    /// Points as combinations of nodes, and the nodes whose multipliers they interpolate.
    fn combinations(&self) -> (Combinations, Combinations) {
        let (mut points, mut homes) = (Combinations::default(), Combinations::default());
        let ninth: BTreeMap<u32, &Center> =
            self.centers.iter().filter(|center| center.nodes.len() == 9).map(|center| (self.center_of[&center.nodes], center)).collect();
        for (proxy, number) in self.proxies.iter().zip(0..) {
            let offset = |(edge, by): (usize, f64)| {
                let edge = &self.edges[edge];
                [(edge.middle, by)].into_iter().chain(edge.chord(-by))
            };
            let raised = proxy.raised.iter().copied();
            let own = proxy.own.iter().map(|&(edge, by)| (edge, by * self.edges[edge].raised));
            let center = ninth.get(&number).map(|center| {
                let (nodes, raised) = (&center.nodes, center.raised);
                let middles = nodes[4..8].iter().map(move |&middle| (middle, -0.5 * raised));
                nodes[..4].iter().map(move |&corner| (corner, 0.25 * raised)).chain(middles).chain([(nodes[8], raised)])
            });
            let parts = proxy.base.iter().copied().chain(raised.chain(own).flat_map(offset)).chain(center.into_iter().flatten());
            points.push(parts);
            homes.push(proxy.homes.iter().copied());
        }
        (points, homes)
    }

    /// Positions of the points: those of the nodes that they represent, or of the centers of eight-node faces; others are taken from
    /// `seen`.
    fn nodes(&self, seen: &[f64], q: &[f64]) -> Vec<f64> {
        let mut places = seen.to_vec();
        let mut set = |point: u32, place: Vector| places[3 * point as usize..][..3].copy_from_slice(place.as_slice());
        self.point_of.iter().for_each(|(&node, &point)| set(point, faces::at(node, q)));
        for (face, &point) in &self.center_of {
            set(point, center(face, q));
        }
        places
    }

    /// Computes the factors `r` of edges and `g` of faces from the area vectors of the points in the reference positions.
    fn adjust(&mut self, q: &[f64]) {
        let seen = self.combinations().0.points(3, q);
        let mut areas = vec![Vector::zeros(); self.proxies.len()];
        for piece in self.faces.iter().flat_map(|face| self.pieces(face)) {
            piece.iter().zip(faces::vector_shares(&piece, &seen)).for_each(|(&point, share)| areas[point as usize] += share);
        }
        let (mut fixed, mut own) = (vec![Vector::zeros(); self.edges.len()], vec![Vector::zeros(); self.edges.len()]);
        for (proxy, &area) in self.proxies.iter().zip(&areas) {
            proxy.raised.iter().for_each(|&(edge, by)| fixed[edge] += by * area);
            proxy.own.iter().for_each(|&(edge, by)| own[edge] += by * area);
        }
        for ((edge, wanted), (fixed, own)) in self.edges.iter_mut().zip(&self.wanted).zip(fixed.iter().zip(&own)) {
            if *wanted != Vector::zeros() {
                edge.raised = wanted.dot(&(wanted - fixed)) / wanted.dot(own);
            }
        }
        for center in self.centers.iter_mut().filter(|center| center.nodes.len() == 9) {
            let places: Vec<[f64; 3]> = center.nodes.iter().map(|&node| faces::at(node, q).into()).collect();
            let of_point = |point: &crate::elements::FacePoint| point.weight * point.shapes[8] * Vector::from(point.normal(&places));
            let wanted = face_points(9).iter().map(of_point).sum::<Vector>();
            center.raised = wanted.norm_squared() / wanted.dot(&areas[self.center_of[&center.nodes] as usize]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::space::forms::{derivatives, value};
    use crate::contact::space::products::POINTS;
    use crate::elements::CellKind;
    use crate::mesh::{Round, hollow_sphere, tube};

    /// Faces of six nodes on a quarter cylinder of radius 1, `count` around and two along, with alternating diagonals.
    fn cylinder(count: u32, size: f64, is_alternating: bool) -> (Vec<Vec<u32>>, Vec<f64>) {
        let (across, along) = (2 * count + 1, 5);
        let angle = |i: u32| std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(2 * count);
        let q =
            (0..along).flat_map(|j| (0..across).flat_map(move |i| [angle(i).cos(), angle(i).sin(), 0.5 * size * f64::from(j)])).collect();
        let node = |i: u32, j: u32| across * j + i;
        let mut faces = Vec::new();
        for (i, j) in (0..count).flat_map(|i| [0, 1].map(|j| (2 * i, 2 * j))) {
            let at = |[a, b]: [u32; 2]| node(i + a, j + b);
            let triangle = |corners: [[u32; 2]; 3]| {
                let middle = |a: usize, b: usize| std::array::from_fn(|k| (corners[a][k] + corners[b][k]) / 2);
                [corners[0], corners[1], corners[2], middle(0, 1), middle(1, 2), middle(2, 0)].map(at).to_vec()
            };
            if is_alternating && (i / 2 + j / 2) % 2 == 1 {
                faces.extend([triangle([[0, 0], [2, 0], [0, 2]]), triangle([[2, 0], [2, 2], [0, 2]])]);
            } else {
                faces.extend([triangle([[0, 0], [2, 0], [2, 2]]), triangle([[0, 0], [2, 2], [0, 2]])]);
            }
        }
        (faces, q)
    }

    /// Mean, root mean square and largest error of the curved surface represented by the profiles.
    fn errors(faces: &[Vec<u32>], q: &[f64]) -> [f64; 3] {
        let seen = ProxySurfacesInSpace::new([faces, &[]], q);
        let (mut sum, mut square, mut most, mut count) = (0.0, 0.0, 0.0f64, 0.0);
        for facet in 0..seen.secondary.count() {
            let nodes = seen.secondary.facet(facet);
            let normal = faces::normal(nodes, &seen.reference);
            for l in [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8], [0.4, 0.5, 0.1], [0.1, 0.4, 0.5], [0.5, 0.1, 0.4], [1.0 / 3.0; 3]]
            {
                let height = value(&derivatives(seen.profiles[0][facet].form(0), &l), &l);
                let flat: Vector = (0..3).map(|k| faces::at(nodes[k], &seen.reference) * l[k]).sum();
                let place = flat + normal * height;
                let off = place.x.hypot(place.y) - 1.0;
                (sum, square, most, count) = (sum + off, square + off * off, most.max(off.abs()), count + 1.0);
            }
        }
        [sum / count, (square / count).sqrt(), most]
    }

    /// Faces of the outer side of a round mesh.
    fn outer(mesh: &crate::mesh::Mesh) -> (Vec<Vec<u32>>, Vec<f64>) {
        let boundary = mesh.boundary("outer").expect("it has one");
        let faces = boundary.facets.iter().map(|&facet| mesh.facet_nodes(facet).collect()).collect();
        (faces, mesh.points.iter().flatten().copied().collect())
    }

    /// Root mean square of the mean heights of a curved surface over its facets above a surface with the height `over`.
    fn off(faces: &[Vec<u32>], q: &[f64], over: impl Fn(Vector) -> f64) -> f64 {
        let proxies = ProxySurfacesInSpace::new([faces, &[]], q);
        let (surface, q) = (&proxies.secondary, &proxies.reference);
        let of_facet = |facet: usize| {
            let nodes = surface.facet(facet);
            let (normal, mut sum, mut count) = (faces::normal(nodes, q), 0.0, 0.0);
            for (k, [a, b, c]) in faces::triangles(nodes, q).enumerate() {
                let form = proxies.profiles[0][facet].form(k);
                let height = |l: &[f64; 3]| over(a * l[0] + b * l[1] + c * l[2] + normal * value(&derivatives(form, l), l));
                sum += POINTS.iter().map(|(l, weight)| weight * height(l)).sum::<f64>();
                count += 1.0;
            }
            sum / count
        };
        ((0..surface.count()).map(|facet| of_facet(facet).powi(2)).sum::<f64>() / surface.count() as f64).sqrt()
    }

    /// Closed form: spheres and tubes of radius 1, whose facets rise by `l^2/8`; parabolas and centers by serendipity interpolation are off
    /// by `l^4/700` and more.
    #[test]
    fn faces_of_second_order_follow_spheres_and_tubes() {
        let kinds = [CellKind::Hex20, CellKind::Hex27, CellKind::Tet10];
        for (kind, around) in kinds.map(|kind| (kind, 16)).into_iter().chain([(CellKind::Tet10, 24)]) {
            let least = (std::f64::consts::TAU / around as f64).powi(4) * 1e-4;
            let ball = hollow_sphere([0.5, 1.0], [1, around], [0.0; 3], 1.0).expect("it is a mesh");
            let (faces, q) = outer(&ball.with_round_cells(kind, Round::AboutPoint([0.0; 3])).expect("cells are round"));
            let found = off(&faces, &q, |x| x.norm() - 1.0);
            assert!(found < 2.0 * least, "sphere of {around} {kind:?}: {found} of {least}");
            let pipe = tube([0.5, 1.0], 0.25, [1, around, 2], [0.0; 3], [1.0; 2]).expect("it is a mesh");
            let (faces, q) = outer(&pipe.with_round_cells(kind, Round::About([0.0; 2])).expect("cells are round"));
            let found = off(&faces, &q, |x| x.x.hypot(x.y) - 1.0);
            assert!(found < 2.0 * least, "tube of {around} {kind:?}: {found} of {least}");
        }
    }

    /// Closed form: faces of six nodes have the cylinder's shape up to their borders, whatever the diagonals.
    #[test]
    fn triangles_of_second_order_follow_cylinders() {
        for is_alternating in [false, true] {
            for count in [5, 7, 12] {
                for size in [0.1, 0.4] {
                    let (faces, q) = cylinder(count, size, is_alternating);
                    let [mean, square, most] = errors(&faces, &q);
                    let segment = (std::f64::consts::FRAC_PI_4 / f64::from(count)).powi(2);
                    assert!(mean.abs() < 2e-3 * segment && square < 5e-3 * segment && most < 0.02 * segment, "{count} {size}");
                }
            }
        }
    }

    /// Closed form: the nodal forces of a constant pressure on a sphere are `int N n dA`. Area in place of area vectors is off by 5 % at
    /// corners and 1.6 % at mid-side nodes of faces of nine nodes, 16 around.
    #[test]
    fn constant_pressure_on_spheres_has_consistent_forces() {
        for (kind, least) in [(CellKind::Hex20, 0.015), (CellKind::Hex27, 0.035)] {
            let ball = hollow_sphere([0.5, 1.0], [1, 16], [0.0; 3], 1.0).expect("it is a mesh");
            let (faces, q) = outer(&ball.with_round_cells(kind, Round::AboutPoint([0.0; 3])).expect("cells are round"));
            let (mut exact, mut found) = (vec![0.0; q.len()], vec![0.0; q.len()]);
            let add = |to: &mut [f64], node: u32, force: Vector| (0..3).for_each(|i| to[3 * node as usize + i] += force[i]);
            for face in &faces {
                let places: Vec<[f64; 3]> = face.iter().map(|&node| faces::at(node, &q).into()).collect();
                for point in face_points(face.len()) {
                    let area = point.weight * Vector::from(point.normal(&places));
                    face.iter().zip(&point.shapes).for_each(|(&node, shape)| add(&mut exact, node, area * *shape));
                }
            }
            let proxies = ProxySurfacesInSpace::new([&faces, &[]], &q);
            let (points, ..) = proxies.on_faces.as_ref().expect("faces are of second order");
            let mut forces = vec![0.0; proxies.reference.len()];
            for piece in (0..proxies.secondary.count()).map(|facet| proxies.secondary.facet(facet)) {
                let shares = faces::vector_shares(piece, &proxies.reference);
                piece.iter().zip(shares).for_each(|(&point, share)| add(&mut forces, point, share));
            }
            points.add_vectors_back(3, &forces, &mut found);
            for (place, most) in (0..faces[0].len()).map(|place| (place, if place < 4 { least } else { 1e-3 })) {
                for face in &faces {
                    let [exact, found] = [&exact, &found].map(|forces| faces::at(face[place], forces).dot(&faces::at(face[place], &q)));
                    assert!((found / exact - 1.0).abs() < most, "{kind:?}, node {place}: {found} for {exact}");
                }
            }
        }
    }
}
