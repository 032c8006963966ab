//! Contact of edges of second order in the plane: several straight facets per edge between points that are linear combinations of its
//! nodes. `on_curves.rs` transforms a contact method on these points to the nodes.
//!
//! A polygon through points of a curve lies inside the curve, and raising some of its vertices makes teeth that obstruct sliding, so *all*
//! points are raised equally. With the offset `d = x_m - (1/2 - tau) x_a - (1/2 + tau) x_b` of the mid-side node from the chord (`tau`: its
//! shift along the chord from the chord's middle in the reference positions, in chord lengths), an edge of `N` facets has the points
//!
//! ```text
//! inner point, s = k/N     y = x(s) + r d,        x(s) = (1-s) x_a + s x_b + 4 s (1-s) (x_m - (x_a + x_b)/2)
//! vertex of two edges      y = x_a + (l r d + l' r' d')/(l + l'),       l, l' the lengths of the facets that meet there
//!                          r = 2/(3 N^2) + 8/15 (h/l_ab)^2,             h, l_ab the sagitta and the chord in the reference positions
//! ```
//!
//! The first part of `r` gives the polygon the area under the parabola: nodal forces of a constant pressure equal the consistent forces of
//! the quadratic edge, exactly on straight edges with any mid-side node, to second order on curved ones. The second part is the further
//! area of the circle through the three nodes, so that press fits between rings have the interference of their radii. At a corner or an end
//! of the surface each curved edge raises the vertex by its own offset. A vertex between straight edges stays at its node, without forces
//! on mid-side nodes, and their inner points are raised more, for the same area. On evenly divided curves the polygons are regular and
//! slide without obstruction. Edges longer than the opposite ones have more facets, for equally small corners.
//!
//! Multipliers belong to the nodes, piecewise linear between mid-side and end nodes; multipliers of sub-facets would be too many. Methods
//! with nodal constraints use the points of the nodes, rigid obstacles the nodes with their tributary lengths. (Facets of two nodes on
//! quadratic edges: Puso, Laursen and Solberg, CMAME 197, 2008; the area-preserving points are new here.)

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use super::combinations::Combinations;
use super::exact::ExactShape;
use super::facet_shape::FacetShape;
use super::kernel::{ContactKernel, Setting};
use super::on_curves::OnCurves;
use super::profile::{FacetCurves, Profile};
use super::surface::{Sides, Surface};
use crate::math::tolerances;

/// Number of facets per half edge if edges of both sides are equally long.
const PIECES: f64 = 2.0;
/// Largest number of facets per half edge.
const MOST_PIECES: f64 = 6.0;

/// Additional area of a circular segment over a parabolic one with chord `l` and sagitta `h`: `A/(l h) = 2/3 + 8/15 (h/l)^2 + ...`.
const CIRCLE: f64 = 8.0 / 15.0;

/// Cosine of the largest angle between two edges of a smooth curve in the reference positions, 20 degrees.
const SMOOTH: f64 = 0.94;

/// Mid-side nodes with the end nodes of their edges, `[middle, from, to]`, ascending.
#[derive(Clone, Debug, Default)]
pub struct ProxyNodes(Vec<[u32; 3]>);

/// Kind of the constraints of the secondary side, which decides between which points its facets lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowsOf {
    /// Weighted integrals over the surface: facets between all points.
    Facets,
    /// Nodal constraints: facets between the points of the nodes.
    Nodes,
}

impl ProxyNodes {
    /// Mid-side nodes of edges `[from, to, middle]`.
    pub fn new(edges: impl Iterator<Item = [u32; 3]>) -> Self {
        let mut middles: Vec<[u32; 3]> = edges.map(|[from, to, middle]| [middle, from, to]).collect();
        middles.sort_unstable();
        ProxyNodes(middles)
    }

    /// Edge `[middle, from, to]` of a mid-side node.
    fn edge(&self, node: u32) -> Option<[u32; 3]> {
        self.0.binary_search_by_key(&node, |edge| edge[0]).ok().map(|found| self.0[found])
    }

    /// Contact representation of two surfaces that are given by their facets between nodes.
    pub fn surfaces<'a>(&self, [secondary, primary]: [&'a [[u32; 2]]; 2], reference: &'a [f64], rows: RowsOf) -> ProxySurfaces<'a> {
        if !secondary.iter().chain(primary).any(|facet| self.edge(facet[1]).is_some()) {
            return ProxySurfaces {
                secondary: secondary.into(),
                primary: primary.into(),
                reference: reference.into(),
                on_curves: None,
                profiles: Default::default(),
            };
        }
        let curves = Curves::new(self, [secondary, primary], reference);
        let mut sides = Sides::new(secondary, primary, reference);
        let is_nodal = rows == RowsOf::Nodes;
        if is_nodal && let Some(lengths) = self.lengths(secondary, reference) {
            sides.weights = lengths;
        }
        // Both sides of a self-contact must have the same facets.
        let is_same = secondary == primary;
        ProxySurfaces {
            secondary: if is_nodal { curves.halves(secondary) } else { curves.fine(secondary) }.into(),
            primary: if is_nodal && is_same { curves.halves(primary) } else { curves.fine(primary) }.into(),
            reference: curves.points.points(2, reference).into(),
            on_curves: Some((curves, sides, rows)),
            profiles: Default::default(),
        }
    }

    /// Tributary lengths of the nodes of a surface, `int N_A ds` in the reference positions `[length]`, with the shape functions of the
    /// edges. `None` without edges of second order.
    pub fn lengths(&self, facets: &[[u32; 2]], reference: &[f64]) -> Option<Vec<f64>> {
        if !facets.iter().any(|facet| self.edge(facet[1]).is_some()) {
            return None;
        }
        let surface = Surface::new(facets);
        let mut lengths = vec![0.0; surface.nodes().len()];
        let mut add = |node: u32, length: f64| lengths[surface.index(node).unwrap_or(0)] += length;
        for (number, &[from, to]) in facets.iter().enumerate() {
            if let Some(edge) = self.edge(to) {
                edge.into_iter().zip(edge_lengths(edge, reference)).for_each(|(node, length)| add(node, length));
            } else if self.edge(from).is_none() {
                let half = 0.5 * surface.facet_measure(number, reference);
                [from, to].into_iter().for_each(|node| add(node, half));
            }
        }
        Some(lengths)
    }
}

/// Tributary lengths `int N_A ds` of the nodes `[middle, from, to]` of an edge, by three Gauss points.
fn edge_lengths([m, a, b]: [u32; 3], q: &[f64]) -> [f64; 3] {
    let at = |node: u32, i: usize| q[2 * node as usize + i];
    let mut sums = [0.0; 3];
    for (xi, weight) in [(-0.6f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6f64.sqrt(), 5.0 / 9.0)] {
        let along: [f64; 2] = std::array::from_fn(|i| (xi - 0.5) * at(a, i) + (xi + 0.5) * at(b, i) - 2.0 * xi * at(m, i));
        let shape = [1.0 - xi * xi, 0.5 * xi * (xi - 1.0), 0.5 * xi * (xi + 1.0)];
        sums.iter_mut().zip(shape).for_each(|(sum, n)| *sum += weight * n * along[0].hypot(along[1]));
    }
    sums
}

/// Surfaces as contact represents them: facets between nodes, or between points on edges of second order.
pub struct ProxySurfaces<'a> {
    /// Facets of the secondary side.
    pub secondary: Cow<'a, [[u32; 2]]>,
    /// Facets of the primary side.
    pub primary: Cow<'a, [[u32; 2]]>,
    /// Reference positions of the nodes or points `[length]`.
    pub reference: Cow<'a, [f64]>,
    on_curves: Option<(Curves, Sides, RowsOf)>,
    /// Height profiles of the facets of both sides; empty for straight facets.
    profiles: [Vec<Profile>; 2],
}

impl ProxySurfaces<'_> {
    /// Adds height profiles if the facet shape is `Curved`.
    pub fn of_shape(mut self, shape: FacetShape) -> Self {
        if shape == FacetShape::Curved {
            self.profiles = [&self.secondary, &self.primary].map(|facets| {
                let between_nodes = FacetCurves::new(&Surface::new(facets), &self.reference).profiles();
                let Some((curves, ..)) = &self.on_curves else { return between_nodes };
                facets.iter().zip(between_nodes).map(|(facet, profile)| curves.profiles.get(facet).copied().unwrap_or(profile)).collect()
            });
        }
        self
    }

    /// Replaces the height profiles of sides with exact shapes.
    pub fn of_exact(mut self, shapes: [Option<&ExactShape>; 2]) -> Self {
        let at = |point: u32| [self.reference[2 * point as usize], self.reference[2 * point as usize + 1]];
        for ((facets, profiles), shape) in [&self.secondary, &self.primary].into_iter().zip(&mut self.profiles).zip(shapes) {
            for (facet, profile) in facets.iter().zip(profiles) {
                *profile = shape.and_then(|shape| shape.profile(facet.map(at))).unwrap_or(*profile);
            }
        }
        self
    }

    /// Transforms a contact method for the facets between points to the nodes of the model.
    pub fn on_nodes(self, mut kernel: Box<dyn ContactKernel>) -> Box<dyn ContactKernel> {
        if !self.profiles[0].is_empty() {
            kernel.set(Setting::Profiles(self.profiles));
        }
        let Some((curves, mut sides, rows)) = self.on_curves else { return kernel };
        if rows == RowsOf::Nodes || kernel.row_nodes().is_empty() {
            // Corner constraints use the facet size of their contact.
            sides.facet_size = kernel.facet_size();
        }
        let made_of = curves.rows(&*kernel, &sides, rows);
        let row_nodes = if kernel.row_nodes().is_empty() { Vec::new() } else { sides.secondary.nodes().to_vec() };
        Box::new(OnCurves::new(kernel, sides, [curves.points, made_of, curves.homes], row_nodes))
    }
}

/// Points that divide second-order edges into straight facets, as linear combinations of the nodes.
struct Curves {
    /// Coefficients of the nodes in each point.
    points: Combinations,
    /// Point of each node.
    nodes: BTreeMap<u32, u32>,
    /// Points of each edge, ends included, by its mid-side node.
    edges: BTreeMap<u32, Vec<u32>>,
    /// Home nodes of each point: nodes whose multipliers it interpolates, with their shape function values.
    homes: Combinations,
    /// Height profiles of facets between points of one edge.
    profiles: BTreeMap<[u32; 2], Profile>,
}

/// Edge of second order in the reference positions.
#[derive(Clone, Copy)]
struct Edge {
    middle: u32,
    ends: [u32; 2],
    /// Chord `[length]`.
    chord: [f64; 2],
    /// Offset of the mid-side node from the chord's middle `[length]`.
    offset: [f64; 2],
    /// Shift of the mid-side node along the chord, in chord lengths.
    shift: f64,
    /// Sagitta in chord lengths.
    sagitta: f64,
    /// Number of facets, even.
    pieces: u32,
    /// Factor `r` of the offset `d` in the positions of the points.
    raised: f64,
}

impl Edge {
    /// Edge in the reference positions, with its number of facets chosen for opposite facets of the given length `[length]`.
    fn new([middle, from, to]: [u32; 3], reference: &[f64], length: f64) -> Self {
        let [m, a, b] = [middle, from, to].map(|node| [reference[2 * node as usize], reference[2 * node as usize + 1]]);
        let chord = [b[0] - a[0], b[1] - a[1]];
        let offset = [m[0] - 0.5 * (a[0] + b[0]), m[1] - 0.5 * (a[1] + b[1])];
        let square = dot(chord, chord);
        let sagitta = (offset[0] * chord[1] - offset[1] * chord[0]) / square;
        let half = (PIECES * 0.5 * square.sqrt() / length).round().clamp(PIECES, MOST_PIECES);
        let raised = 1.0 / (6.0 * half * half) + CIRCLE * sagitta * sagitta;
        Edge { middle, ends: [from, to], chord, offset, shift: dot(offset, chord) / square, sagitta, pieces: 2 * half as u32, raised }
    }

    /// True if the mid-side node lies off the chord.
    fn is_curved(&self) -> bool {
        self.sagitta.abs() > tolerances::STRAIGHT
    }

    /// Tangent vector at the first or the last end.
    fn tangent(&self, end: usize) -> [f64; 2] {
        let sign = if end == 0 { 4.0 } else { -4.0 };
        std::array::from_fn(|i| self.chord[i] + sign * self.offset[i])
    }

    /// Facet vector at an end, between points of the parabola `[length]`.
    fn end_facet(&self, end: usize) -> [f64; 2] {
        let (s, sign) = (1.0 / f64::from(self.pieces), if end == 0 { 1.0 } else { -1.0 });
        std::array::from_fn(|i| s * self.chord[i] + sign * 4.0 * s * (1.0 - s) * self.offset[i])
    }

    /// Projection of the facet at an end on the chord, in chord lengths.
    fn end_share(&self, end: usize) -> f64 {
        dot(self.end_facet(end), self.chord) / dot(self.chord, self.chord)
    }

    /// Height of the curve over the chord and its slope, at the distance `x` from the chord's middle, in chord lengths.
    ///
    /// The curve is the parabola of the shape functions; for a symmetric edge it is the circle through the three nodes.
    fn height(&self, x: f64) -> [f64; 2] {
        if !self.is_curved() {
            return [0.0; 2];
        }
        let (h, square) = (self.sagitta, x * x);
        // Edge coordinate of the parabola: x + 1/2 = xi + 4 shift xi (1 - xi).
        let linear = 1.0 + 4.0 * self.shift;
        let root = (linear * linear - 16.0 * self.shift * (x + 0.5)).max(0.0).sqrt();
        let xi = 2.0 * (x + 0.5) / (linear + root);
        let parabola = [4.0 * h * xi * (1.0 - xi), 4.0 * h * (1.0 - 2.0 * xi) / root];
        // Distances of the circle's center from the chord, and of the point from the line through the center parallel to the chord.
        let center = (0.25 / h - h).abs() * 0.5;
        let across = (0.25 + center * center - square).max(0.0).sqrt();
        let circle = [h.signum() * (0.25 - square) / (across + center), -h.signum() * x / across];
        [parabola[0] + circle[0] - h * (1.0 - 4.0 * square), parabola[1] + circle[1] + 8.0 * h * x]
    }

    /// Height profile of the curve over a facet with the given end points `[length]`; `origin` is the first node of the edge.
    fn profile_over(&self, origin: [f64; 2], facet: [[f64; 2]; 2]) -> Profile {
        let square = dot(self.chord, self.chord);
        // Coordinates along the chord from its middle, and outwards, in chord lengths.
        let [a, b] = facet.map(|y| {
            let from = [y[0] - origin[0], y[1] - origin[1]];
            [dot(from, self.chord) / square - 0.5, (from[0] * self.chord[1] - from[1] * self.chord[0]) / square]
        });
        let t = [b[0] - a[0], b[1] - a[1]];
        let length = t[0].hypot(t[1]);
        let (cos, sin) = (t[0] / length, t[1] / length);
        let [first, middle, last] = [0.0, 0.5, 1.0].map(|xi| {
            let (x, y) = (a[0] + xi * t[0], a[1] + xi * t[1]);
            let mut z = 0.0;
            for _ in 0..6 {
                z += cos * (self.height(x - z * sin)[0] - y - z * cos);
            }
            let slope = self.height(x - z * sin)[1];
            [z / length, (cos * slope - sin) / (cos + sin * slope)]
        });
        // Simpson's rule with end derivatives, exact for polynomials of fifth degree.
        let mean = (7.0 * first[0] + 16.0 * middle[0] + 7.0 * last[0]) / 30.0 + (first[1] - last[1]) / 60.0;
        let is_flat = first.into_iter().chain(last).all(|value| value.abs() < tolerances::STRAIGHT);
        if is_flat { Profile::default() } else { Profile::new(first, last, mean) }
    }

    /// Coefficients of the edge's three nodes in the vector `by d`, `d` being the offset of the mid-side node.
    fn across(&self, by: f64) -> [(u32, f64); 3] {
        let [a, b] = self.ends;
        [(self.middle, by), (a, -by * (0.5 - self.shift)), (b, -by * (0.5 + self.shift))]
    }

    /// Coefficients of the edge's three nodes in the point of the parabola at the edge coordinate `s`.
    fn point(&self, s: f64) -> [(u32, f64); 3] {
        let ([a, b], h) = (self.ends, 4.0 * s * (1.0 - s));
        [(self.middle, h), (a, 1.0 - s - 0.5 * h), (b, s - 0.5 * h)]
    }
}

/// Mean length of facets between nodes `[length]`; infinite without facets.
fn mean_length(facets: &[[u32; 2]], q: &[f64]) -> f64 {
    let at = |node: u32, i: usize| q[2 * node as usize + i];
    let lengths = facets.iter().map(|&[a, b]| (at(b, 0) - at(a, 0)).hypot(at(b, 1) - at(a, 1)));
    if facets.is_empty() { f64::INFINITY } else { lengths.sum::<f64>() / facets.len() as f64 }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Edges whose offsets shift their common vertex, each with its end (0 or 1) there and its weight. Two smoothly joined edges share the
/// vertex; at corners and ends each curved edge has the weight 1. `is_mixed`: a straight edge is adjacent, too.
fn raising([coming, leaving]: &[Vec<Edge>; 2], is_mixed: bool) -> Vec<(Edge, usize, f64)> {
    if let ([one], [other], false) = (&coming[..], &leaving[..], is_mixed) {
        let (t, u) = (one.tangent(1), other.tangent(0));
        if dot(t, u) > SMOOTH * t[0].hypot(t[1]) * u[0].hypot(u[1]) {
            let lengths = [one.end_facet(1), other.end_facet(0)].map(|t| t[0].hypot(t[1]));
            let sum = lengths[0] + lengths[1];
            return vec![(*one, 1, lengths[0] / sum), (*other, 0, lengths[1] / sum)];
        }
    }
    let ends = coming.iter().map(|edge| (*edge, 1, 1.0)).chain(leaving.iter().map(|edge| (*edge, 0, 1.0)));
    let is_only = coming.len() + leaving.len() == 1 && !is_mixed;
    ends.filter(|(edge, ..)| is_only || edge.is_curved()).collect()
}

impl Curves {
    fn new(middles: &ProxyNodes, sides: [&[[u32; 2]]; 2], reference: &[f64]) -> Self {
        // The number of facets is chosen so that facets of both sides have similar lengths.
        let length = sides.map(|facets| mean_length(facets, reference)).into_iter().fold(f64::INFINITY, f64::min);
        // For each node, edges that end and edges that start there; and nodes of first-order edges.
        let mut edges = BTreeMap::new();
        let mut meeting: BTreeMap<u32, [Vec<Edge>; 2]> = BTreeMap::new();
        let mut straight = BTreeSet::new();
        for &[from, to] in sides.into_iter().flatten() {
            match (middles.edge(from), middles.edge(to)) {
                (_, Some(nodes)) => drop(edges.entry(to).or_insert_with(|| Edge::new(nodes, reference, length))),
                (Some(_), None) => {}
                (None, None) => straight.extend([from, to]),
            }
        }
        for edge in edges.values() {
            for (end, node) in edge.ends.into_iter().enumerate() {
                meeting.entry(node).or_default()[1 - end].push(*edge);
            }
        }
        let raises = |node: u32| meeting.get(&node).map_or_else(Vec::new, |edges| raising(edges, straight.contains(&node)));
        let mut curves = Curves {
            points: Combinations::default(),
            nodes: BTreeMap::new(),
            edges: BTreeMap::new(),
            homes: Combinations::default(),
            profiles: BTreeMap::new(),
        };
        let ends: BTreeSet<u32> = straight.iter().chain(meeting.keys()).copied().collect();
        for node in ends {
            let raised = raises(node).into_iter().flat_map(|(edge, _, weight)| edge.across(edge.raised * weight));
            let point = curves.points.push([(node, 1.0)].into_iter().chain(raised));
            curves.nodes.insert(node, point);
            curves.homes.push([(node, 1.0)]);
        }
        for edge in edges.values() {
            // Inner points are raised more if an end vertex is not raised, for equal area.
            let has = |&end: &usize| raises(edge.ends[end]).iter().any(|(other, at, _)| (other.middle, *at) == (edge.middle, end));
            let at_ends: f64 = [0, 1].into_iter().filter(has).map(|end| 0.5 * edge.end_share(end)).sum();
            let pieces = f64::from(edge.pieces);
            let raised = edge.raised * (1.0 - at_ends) / (1.0 - 1.0 / pieces);
            let mut list = vec![curves.nodes[&edge.ends[0]]];
            for k in 1..edge.pieces {
                let s = f64::from(k) / pieces;
                list.push(curves.points.push(edge.point(s).into_iter().chain(edge.across(raised))));
                let end = edge.ends[usize::from(s > 0.5)];
                let share = 1.0 - (1.0 - 2.0 * s).abs();
                curves.homes.push([(edge.middle, share), (end, 1.0 - share)].into_iter().filter(|(_, share)| *share > 0.0));
            }
            list.push(curves.nodes[&edge.ends[1]]);
            curves.nodes.insert(edge.middle, list[list.len() / 2]);
            curves.edges.insert(edge.middle, list);
        }
        let places = curves.points.points(2, reference);
        let at = |x: &[f64], node: u32| [x[2 * node as usize], x[2 * node as usize + 1]];
        for edge in edges.values() {
            let list = &curves.edges[&edge.middle];
            let halves = [[list[0], list[list.len() / 2]], [list[list.len() / 2], list[list.len() - 1]]];
            for ends in list.windows(2).map(|ends| [ends[0], ends[1]]).chain(halves) {
                let profile = edge.profile_over(at(reference, edge.ends[0]), ends.map(|point| at(&places, point)));
                curves.profiles.insert(ends, profile);
            }
        }
        curves
    }

    /// Facets between points that replace facets between nodes.
    fn fine(&self, facets: &[[u32; 2]]) -> Vec<[u32; 2]> {
        let pieces = |&[from, to]: &[u32; 2]| -> Vec<[u32; 2]> {
            let points = match (self.edges.get(&from), self.edges.get(&to)) {
                (_, Some(points)) => &points[..=points.len() / 2],
                (Some(points), None) => &points[points.len() / 2..],
                (None, None) => return vec![[self.nodes[&from], self.nodes[&to]]],
            };
            points.windows(2).map(|ends| [ends[0], ends[1]]).collect()
        };
        facets.iter().flat_map(pieces).collect()
    }

    /// Facets between the points that belong to nodes.
    fn halves(&self, facets: &[[u32; 2]]) -> Vec<[u32; 2]> {
        facets.iter().map(|facet| facet.map(|node| self.nodes[&node])).collect()
    }

    /// Inner constraints as combinations of nodal constraints; constraints without a point are taken over unchanged. Nodal constraints get
    /// the weights of `sides`.
    fn rows(&self, kernel: &dyn ContactKernel, sides: &Sides, rows: RowsOf) -> Combinations {
        let (stride, mut made) = (kernel.rows_per_node(), Combinations::default());
        for (row, weight) in kernel.weights().iter().enumerate() {
            let Some(&point) = kernel.row_nodes().get(row / stride) else {
                made.push([(row as u32, 1.0)]);
                continue;
            };
            made.push(self.homes.parts(point as usize).iter().map(|&(node, share)| {
                let index = sides.secondary.index(node).unwrap_or(0);
                let share = if rows == RowsOf::Nodes { sides.weights[index] / weight } else { share };
                ((stride * index + row % stride) as u32, share)
            }));
        }
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area enclosed by a chain of facets (shoelace formula), and nodal forces of a unit pressure, half of each facet's force at each end.
    fn area(facets: &[[u32; 2]], y: &[f64]) -> (f64, Vec<f64>) {
        let (mut sum, mut forces) = (0.0, vec![0.0; y.len()]);
        for facet in facets {
            let [a, b] = facet.map(|point| 2 * point as usize);
            sum += 0.5 * (y[a] * y[b + 1] - y[a + 1] * y[b]);
            for end in [a, b] {
                forces[end] += 0.5 * (y[b + 1] - y[a + 1]);
                forces[end + 1] -= 0.5 * (y[b] - y[a]);
            }
        }
        (sum, forces)
    }

    /// Chain of edges through the given number of nodes, alternately ends and mid-side nodes.
    fn chain(nodes: u32) -> (ProxyNodes, Vec<[u32; 2]>) {
        let edges = (0..nodes / 2).map(|k| [2 * k, (2 * k + 2) % nodes.next_multiple_of(2), 2 * k + 1]);
        (ProxyNodes::new(edges.clone()), edges.flat_map(|[a, b, m]| [[a, m], [m, b]]).collect())
    }

    /// Closed form: consistent forces of a straight quadratic edge of length l with its mid-side node off by s: l/6 + 2/3 s, 2/3 l, l/6 -
    /// 2/3 s.
    #[test]
    fn a_constant_pressure_is_exact_on_straight_edges_with_uneven_middles() {
        let x = [0.0, 0.6, 1.0, 1.4, 2.5, 3.2, 4.4];
        let q: Vec<f64> = x.into_iter().flat_map(|x| [x, 0.5 * x]).collect();
        let (middles, facets) = chain(7);
        let surfaces = middles.surfaces([&facets, &[]], &q, RowsOf::Facets);
        let (_, on_points) = area(&surfaces.secondary, &surfaces.reference);
        let (curves, ..) = surfaces.on_curves.expect("its edges are of second order");
        let mut forces = vec![0.0; q.len()];
        curves.points.add_vectors_back(2, &on_points, &mut forces);
        let mut expected = [0.0; 7];
        for k in [0, 2, 4] {
            let (l, s) = (x[k + 2] - x[k], x[k + 1] - 0.5 * (x[k] + x[k + 2]));
            [l / 6.0 + 2.0 / 3.0 * s, 2.0 / 3.0 * l, l / 6.0 - 2.0 / 3.0 * s].iter().enumerate().for_each(|(i, f)| expected[k + i] += f);
        }
        for (force, expected) in forces.chunks_exact(2).zip(expected) {
            assert!((force[1] + expected).abs() < 1e-14 && (force[0] - 0.5 * expected).abs() < 1e-14, "{force:?} {expected}");
        }
        let lengths = middles.lengths(&facets, &q).expect("of second order");
        lengths.iter().zip(expected).for_each(|(length, expected)| assert!((length - expected * 1.25f64.sqrt()).abs() < 1e-14));
    }

    #[test]
    fn rings_hold_the_area_of_their_circle() {
        let q: Vec<f64> = (0..24).flat_map(|k| <[f64; 2]>::from((std::f64::consts::TAU * f64::from(k) / 24.0).sin_cos())).rev().collect();
        let (middles, facets) = chain(24);
        let surfaces = middles.surfaces([&facets, &[]], &q, RowsOf::Facets);
        let (sum, _) = area(&surfaces.secondary, &surfaces.reference);
        // With parabolas alone the area is 2e-4 smaller; the remaining error is of sixth order in the angle.
        assert!((sum.abs() / std::f64::consts::PI - 1.0).abs() < 2e-5, "{sum}");
        assert_eq!(surfaces.secondary.len(), 48);
    }

    #[test]
    fn facets_between_corners_stay_as_they_are() {
        let q = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0];
        let facets = [[0, 1], [1, 2]];
        let surfaces = ProxyNodes::default().surfaces([&facets, &[]], &q, RowsOf::Facets);
        assert!(surfaces.on_curves.is_none() && *surfaces.secondary == facets && *surfaces.reference == q);
    }
}
