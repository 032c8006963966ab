//! Contact of edges of second order: each is a few straight facets between points that are linear combinations of its nodes.
//!
//! A polygon through points of a curve lies inside it, and a polygon with some of its vertices raised has teeth that hold what should
//! slide. So *all* points are raised alike. With the middle's offset `d = x_m - (1/2 - tau) x_a - (1/2 + tau) x_b` from the chord (`tau`
//! the share by which the middle lies off the chord's middle in the reference positions), an edge of `N` facets has its points at
//!
//! ```text
//! inner point, s = k/N     y = x(s) + r d,        x(s) = (1-s) x_a + s x_b + 4 s (1-s) (x_m - (x_a + x_b)/2)
//! vertex of two edges      y = x_a + (l r d + l' r' d')/(l + l'),       l, l' the lengths of the facets that meet there
//!                          r = 2/(3 N^2) + 8/15 (h/l_ab)^2,             h, l_ab the sagitta and the chord in the reference positions
//! ```
//!
//! The first part of `r` makes the polygon hold the parabola's area: a constant pressure on straight edges, whose middles may lie anywhere,
//! goes to the nodes exactly as a quadratic edge's consistent forces, and on curved ones to second order. The second part is what the
//! circle through the three nodes holds besides: press fits between rings are as large as their radii say. Where a surface ends or has a
//! corner, each curved edge raises the vertex by its own; a corner between straight ones stays where its node is, so that none pulls at the
//! other's middle, and their inner points are raised by a little more, for the same sum. On a curve that is divided evenly the polygon is
//! regular, so that two of them slide on each other without holding. Long edges have more facets than short ones opposite, so that what is
//! left of their corners is as small.
//!
//! Multipliers stay at the nodes, linear between a middle and its ends: those of sub-facets of their own would be too many. Methods with a
//! constraint for each node see the points of the nodes, and a rigid obstacle the nodes themselves, with the lengths that belong to them.
//! (Facets of two nodes on quadratic edges: Puso, Laursen and Solberg, CMAME 197, 2008; the points that keep the area are ours.)

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use super::combinations::Combinations;
use super::facet_shape::FacetShape;
use super::kernel::ContactKernel;
use super::on_curves::OnCurves;
use super::profile::{FacetCurves, Profile};
use super::surface::{Sides, Surface};
use crate::math::tolerances;

/// Facets of half an edge where edges of both sides are alike long, and at most.
const PIECES: f64 = 2.0;
const MOST_PIECES: f64 = 6.0;

/// What a circle's segment holds more than a parabola's, over chord and sagitta: `A/(l h) = 2/3 + 8/15 (h/l)^2 + ...`.
const CIRCLE: f64 = 8.0 / 15.0;

/// Cosine of the turn between two edges in the reference positions up to which a curve goes on from one to the other: 20 degrees.
const SMOOTH: f64 = 0.94;

/// Middle nodes with the ends of their edges, `[middle, from, to]`, in ascending order.
#[derive(Clone, Debug, Default)]
pub struct ProxyNodes(Vec<[u32; 3]>);

/// Which nodes of the secondary side have constraints, and how contact sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowsOf {
    /// Functions of the whole surface, weighted and summed.
    Facets,
    /// Each node has its own.
    Nodes,
}

impl ProxyNodes {
    /// Of edges given by their ends and their middle.
    pub fn new(edges: impl Iterator<Item = [u32; 3]>) -> Self {
        let mut middles: Vec<[u32; 3]> = edges.map(|[from, to, middle]| [middle, from, to]).collect();
        middles.sort_unstable();
        ProxyNodes(middles)
    }

    /// The edge in whose middle a node is.
    fn edge(&self, node: u32) -> Option<[u32; 3]> {
        self.0.binary_search_by_key(&node, |edge| edge[0]).ok().map(|found| self.0[found])
    }

    /// Two surfaces, given by their facets between nodes, as a contact method sees them.
    pub fn seen<'a>(&self, [secondary, primary]: [&'a [[u32; 2]]; 2], reference: &'a [f64], rows: RowsOf) -> Seen<'a> {
        if !secondary.iter().chain(primary).any(|facet| self.edge(facet[1]).is_some()) {
            return Seen {
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
        // A surface that touches itself must know its facets again.
        let is_same = secondary == primary;
        Seen {
            secondary: if is_nodal { curves.halves(secondary) } else { curves.fine(secondary) }.into(),
            primary: if is_nodal && is_same { curves.halves(primary) } else { curves.fine(primary) }.into(),
            reference: curves.points.points(2, reference).into(),
            on_curves: Some((curves, sides, rows)),
            profiles: Default::default(),
        }
    }

    /// Lengths that belong to the nodes of a surface, `int N_A ds` in the reference positions `[length]`: a constant pressure on them is
    /// that on the edges. `None` where none of the edges is of second order.
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

/// `int N_A ds` over an edge for its middle and its ends, by three Gauss points.
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

/// Two surfaces as a contact method sees them: between their nodes, or between points on edges of second order.
pub struct Seen<'a> {
    /// Facets of the side with the constraints.
    pub secondary: Cow<'a, [[u32; 2]]>,
    /// Those of the other.
    pub primary: Cow<'a, [[u32; 2]]>,
    /// Reference positions of the nodes or points `[length]`.
    pub reference: Cow<'a, [f64]>,
    on_curves: Option<(Curves, Sides, RowsOf)>,
    /// Height profiles of the facets of both sides; empty for straight facets.
    profiles: [Vec<Profile>; 2],
}

impl Seen<'_> {
    /// These surfaces with facets of another shape than straight lines.
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

    /// A method made for these facets, on the nodes of the model.
    pub fn on_nodes(self, mut kernel: Box<dyn ContactKernel>) -> Box<dyn ContactKernel> {
        if !self.profiles[0].is_empty() {
            kernel.set_profiles(self.profiles);
        }
        let Some((curves, mut sides, rows)) = self.on_curves else { return kernel };
        if rows == RowsOf::Nodes || kernel.row_nodes().is_empty() {
            // Corners have the size of their contact.
            sides.facet_size = kernel.facet_size();
        }
        let made_of = curves.rows(&*kernel, &sides, rows);
        let row_nodes = if kernel.row_nodes().is_empty() { Vec::new() } else { sides.secondary.nodes().to_vec() };
        Box::new(OnCurves::new(kernel, sides, [curves.points, made_of, curves.homes], row_nodes))
    }
}

/// The points that contact sees on the edges of some facets.
struct Curves {
    /// What they are made of.
    points: Combinations,
    /// Per node: its point.
    nodes: BTreeMap<u32, u32>,
    /// Per middle node: the points of its edge, ends included.
    edges: BTreeMap<u32, Vec<u32>>,
    /// Per point: the nodes whose multipliers it has, with their shares.
    homes: Combinations,
    /// Height profiles of the facets between points of one edge.
    profiles: BTreeMap<[u32; 2], Profile>,
}

/// An edge of second order in the reference positions.
#[derive(Clone, Copy)]
struct Edge {
    middle: u32,
    ends: [u32; 2],
    /// Chord, and the middle's offset from the chord's middle `[length]`.
    chord: [f64; 2],
    offset: [f64; 2],
    /// By how much of the chord the middle lies off its middle, and the chord.
    shift: f64,
    sagitta: f64,
    /// Number of its facets, even.
    pieces: u32,
    /// By how much of the middle's offset its points are raised.
    raised: f64,
}

impl Edge {
    /// An edge opposite facets between nodes of that length `[length]`.
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

    /// Whether its middle lies off the chord.
    fn is_curved(&self) -> bool {
        self.sagitta.abs() > tolerances::STRAIGHT
    }

    /// Direction in which it leaves its first end, or comes to its last.
    fn tangent(&self, end: usize) -> [f64; 2] {
        let sign = if end == 0 { 4.0 } else { -4.0 };
        std::array::from_fn(|i| self.chord[i] + sign * self.offset[i])
    }

    /// The facet at an end, as a vector from node to node of the parabola `[length]`.
    fn end_facet(&self, end: usize) -> [f64; 2] {
        let (s, sign) = (1.0 / f64::from(self.pieces), if end == 0 { 1.0 } else { -1.0 });
        std::array::from_fn(|i| s * self.chord[i] + sign * 4.0 * s * (1.0 - s) * self.offset[i])
    }

    /// Its share of the chord.
    fn end_share(&self, end: usize) -> f64 {
        dot(self.end_facet(end), self.chord) / dot(self.chord, self.chord)
    }

    /// Height of the curve above the chord, in chord lengths, at the distance `x` from the middle of the chord, and its slope.
    ///
    /// The curve is the parabola of the shape functions, and over a symmetric edge the circle through its three nodes.
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
        // Distance of the circle's center from the chord, and of its point from the line through the center.
        let center = (0.25 / h - h).abs() * 0.5;
        let across = (0.25 + center * center - square).max(0.0).sqrt();
        let circle = [h.signum() * (0.25 - square) / (across + center), -h.signum() * x / across];
        [parabola[0] + circle[0] - h * (1.0 - 4.0 * square), parabola[1] + circle[1] + 8.0 * h * x]
    }

    /// Height profile of the curve over a facet with these end points `[length]`; `origin` is the first node.
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
        // Simpson's rule with derivatives at the ends, exact for polynomials of fifth degree.
        let mean = (7.0 * first[0] + 16.0 * middle[0] + 7.0 * last[0]) / 30.0 + (first[1] - last[1]) / 60.0;
        let is_flat = first.into_iter().chain(last).all(|value| value.abs() < tolerances::STRAIGHT);
        if is_flat { Profile::default() } else { Profile::new(first, last, mean) }
    }

    /// The middle's offset across the chord, times a factor.
    fn across(&self, by: f64) -> [(u32, f64); 3] {
        let [a, b] = self.ends;
        [(self.middle, by), (a, -by * (0.5 - self.shift)), (b, -by * (0.5 + self.shift))]
    }

    /// The point of the parabola at the share `s`.
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

/// The edges that raise the vertex where they come together, with the end of each that is there and its weight: two that go on smoothly
/// share it, at corners and ends each that is curved has its own.
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
        // Facets of both sides are about alike long.
        let length = sides.map(|facets| mean_length(facets, reference)).into_iter().fold(f64::INFINITY, f64::min);
        // Per node: the edges that come to it and leave it; others that meet there.
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
            // What the ends do not have, the inner points have more.
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

    /// The facets between points in place of those between nodes.
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

    /// The facets between the points of the nodes.
    fn halves(&self, facets: &[[u32; 2]]) -> Vec<[u32; 2]> {
        facets.iter().map(|facet| facet.map(|node| self.nodes[&node])).collect()
    }

    /// Of which rows of the nodes those of a method are made: its own where they are no points'. Those of single nodes have the weights of
    /// `sides`.
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

    /// Shoelace area of a chain of facets, and what a unit pressure does on their ends, half of each facet's on either.
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

    /// A chain of edges through these nodes, ends and middles in turn.
    fn chain(nodes: u32) -> (ProxyNodes, Vec<[u32; 2]>) {
        let edges = (0..nodes / 2).map(|k| [2 * k, (2 * k + 2) % nodes.next_multiple_of(2), 2 * k + 1]);
        (ProxyNodes::new(edges.clone()), edges.flat_map(|[a, b, m]| [[a, m], [m, b]]).collect())
    }

    /// Closed form: the consistent forces of a straight quadratic edge of length l with its middle off by s are l/6 + 2/3 s, 2/3 l and
    /// l/6 - 2/3 s.
    #[test]
    fn a_constant_pressure_is_exact_on_straight_edges_with_uneven_middles() {
        let x = [0.0, 0.6, 1.0, 1.4, 2.5, 3.2, 4.4];
        let q: Vec<f64> = x.into_iter().flat_map(|x| [x, 0.5 * x]).collect();
        let (middles, facets) = chain(7);
        let seen = middles.seen([&facets, &[]], &q, RowsOf::Facets);
        let (_, on_points) = area(&seen.secondary, &seen.reference);
        let (curves, ..) = seen.on_curves.expect("its edges are of second order");
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
        let seen = middles.seen([&facets, &[]], &q, RowsOf::Facets);
        let (sum, _) = area(&seen.secondary, &seen.reference);
        // Parabolas alone hold 2e-4 less; what is left is of sixth order in the angle.
        assert!((sum.abs() / std::f64::consts::PI - 1.0).abs() < 2e-5, "{sum}");
        assert_eq!(seen.secondary.len(), 48);
    }

    #[test]
    fn facets_between_corners_stay_as_they_are() {
        let q = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0];
        let facets = [[0, 1], [1, 2]];
        let seen = ProxyNodes::default().seen([&facets, &[]], &q, RowsOf::Facets);
        assert!(seen.on_curves.is_none() && *seen.secondary == facets && *seen.reference == q);
    }
}
