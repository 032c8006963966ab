//! Contact of edges of second order: each is a few straight facets between points that are linear combinations of its nodes.
//!
//! A polygon through points of a parabola lies inside it, and a polygon with some of its vertices raised has teeth that hold what should
//! slide. So *all* points are raised alike. With the middle's offset `d = x_m - (1/2 - tau) x_a - (1/2 + tau) x_b` from the chord (`tau` the
//! share by which the middle lies off its middle in the reference positions), an edge of `N` facets has its points at
//!
//! ```text
//! inner point, s = k/N     y = x(s) + r d,          x(s) = (1-s) x_a + s x_b + 4 s (1-s) (x_m - (x_a + x_b)/2),     r = 2/(3 N^2)
//! vertex of two edges      y = x_a + r (l d + l' d')/(l + l'),     l, l' the lengths of the facets that meet there
//! ```
//!
//! The raised polygon holds the parabola's area: a constant pressure on straight edges, whose middles may lie anywhere, goes to the nodes
//! exactly as a quadratic edge's consistent forces, and on curved ones to second order. Where a surface ends or has a corner, each curved
//! edge raises the vertex by its own; a corner between straight ones stays where its node is, so that none pulls at the other's middle, and
//! their inner points are raised by a little more, for the same sum. On a curve that is divided evenly the polygon is regular, so that two
//! of them slide on each other without holding.
//!
//! Multipliers stay at the nodes, linear between a middle and its ends: those of sub-facets of their own would be too many.
//! (Facets of two nodes on quadratic edges: Puso, Laursen and Solberg, CMAME 197, 2008; the points that keep the area are ours.)

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use super::combinations::Combinations;
use super::kernel::ContactKernel;
use super::on_curves::OnCurves;
use super::surface::{Sides, Surface};
use crate::math::tolerances;

/// Facets of an edge, an even number.
const PIECES: u32 = 4;

/// By how much of the middle's offset all points are raised.
const RAISED: f64 = 2.0 / (3.0 * PIECES as f64 * PIECES as f64);

/// Cosine of the turn between two edges in the reference positions up to which a curve goes on from one to the other: 20 degrees.
const SMOOTH: f64 = 0.94;

/// Middle nodes with the ends of their edges, `[middle, from, to]`, in ascending order.
#[derive(Clone, Debug, Default)]
pub struct Middles(Vec<[u32; 3]>);

/// Which nodes of the secondary side have constraints, and how contact sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowsOf {
    /// Functions of the whole surface, weighted and summed.
    Facets,
    /// Each node has its own.
    Nodes,
}

impl Middles {
    /// Of edges given by their ends and their middle.
    pub fn new(edges: impl Iterator<Item = [u32; 3]>) -> Self {
        let mut middles: Vec<[u32; 3]> = edges.map(|[from, to, middle]| [middle, from, to]).collect();
        middles.sort_unstable();
        Middles(middles)
    }

    /// The edge in whose middle a node is.
    fn edge(&self, node: u32) -> Option<[u32; 3]> {
        self.0.binary_search_by_key(&node, |edge| edge[0]).ok().map(|found| self.0[found])
    }

    /// Two surfaces, given by their facets between nodes, as a contact method sees them.
    pub fn seen<'a>(&self, [secondary, primary]: [&'a [[u32; 2]]; 2], reference: &'a [f64], rows: RowsOf) -> Seen<'a> {
        let all: Vec<[u32; 2]> = secondary.iter().chain(primary).copied().collect();
        if !all.iter().any(|facet| self.edge(facet[1]).is_some()) {
            return Seen { secondary: secondary.into(), primary: primary.into(), reference: reference.into(), on_curves: None };
        }
        let curves = Curves::new(self, &all, reference);
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
            reference: curves.points.points(reference).into(),
            on_curves: Some((curves, sides, rows)),
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
                let half = 0.5 * surface.facet_length(number, reference);
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
}

impl Seen<'_> {
    /// A method made for these facets, on the nodes of the model.
    pub fn on_nodes(self, kernel: Box<dyn ContactKernel>) -> Box<dyn ContactKernel> {
        let Some((curves, mut sides, rows)) = self.on_curves else { return kernel };
        if rows == RowsOf::Nodes || kernel.row_nodes().is_empty() {
            // Corners have the size of their contact.
            sides.facet_size = kernel.facet_size();
        }
        let made_of = curves.rows(&*kernel, &sides, rows);
        Box::new(OnCurves::new(kernel, sides, curves.points, made_of))
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
    homes: Vec<Vec<(u32, f64)>>,
}

/// An edge of second order in the reference positions.
#[derive(Clone, Copy)]
struct Edge {
    middle: u32,
    ends: [u32; 2],
    /// Chord, and the middle's offset from the chord's middle `[length]`.
    chord: [f64; 2],
    offset: [f64; 2],
    /// By how much of the chord the middle lies off its middle.
    shift: f64,
}

impl Edge {
    fn new([middle, from, to]: [u32; 3], reference: &[f64]) -> Self {
        let [m, a, b] = [middle, from, to].map(|node| [reference[2 * node as usize], reference[2 * node as usize + 1]]);
        let chord = [b[0] - a[0], b[1] - a[1]];
        let offset = [m[0] - 0.5 * (a[0] + b[0]), m[1] - 0.5 * (a[1] + b[1])];
        Edge { middle, ends: [from, to], chord, offset, shift: dot(offset, chord) / dot(chord, chord) }
    }

    /// Whether its middle lies off the chord.
    fn is_curved(&self) -> bool {
        (self.offset[0] * self.chord[1] - self.offset[1] * self.chord[0]).abs() > tolerances::FLAT * dot(self.chord, self.chord)
    }

    /// Direction in which it leaves its first end, or comes to its last.
    fn tangent(&self, end: usize) -> [f64; 2] {
        let sign = if end == 0 { 4.0 } else { -4.0 };
        std::array::from_fn(|i| self.chord[i] + sign * self.offset[i])
    }

    /// The facet at an end, as a vector from node to node of the parabola `[length]`.
    fn end_facet(&self, end: usize) -> [f64; 2] {
        let (s, sign) = (1.0 / f64::from(PIECES), if end == 0 { 1.0 } else { -1.0 });
        std::array::from_fn(|i| s * self.chord[i] + sign * 4.0 * s * (1.0 - s) * self.offset[i])
    }

    /// Its share of the chord.
    fn end_share(&self, end: usize) -> f64 {
        dot(self.end_facet(end), self.chord) / dot(self.chord, self.chord)
    }

    /// The middle's offset across the chord, times a factor.
    fn raised(&self, by: f64) -> [(u32, f64); 3] {
        let [a, b] = self.ends;
        [(self.middle, by), (a, -by * (0.5 - self.shift)), (b, -by * (0.5 + self.shift))]
    }

    /// The point of the parabola at the share `s`.
    fn point(&self, s: f64) -> [(u32, f64); 3] {
        let ([a, b], h) = (self.ends, 4.0 * s * (1.0 - s));
        [(self.middle, h), (a, 1.0 - s - 0.5 * h), (b, s - 0.5 * h)]
    }
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
    fn new(middles: &Middles, facets: &[[u32; 2]], reference: &[f64]) -> Self {
        // Per node: the edges that come to it and leave it; others that meet there.
        let mut edges = BTreeMap::new();
        let mut meeting: BTreeMap<u32, [Vec<Edge>; 2]> = BTreeMap::new();
        let mut straight = BTreeSet::new();
        for &[from, to] in facets {
            match (middles.edge(from), middles.edge(to)) {
                (_, Some(nodes)) => drop(edges.entry(to).or_insert_with(|| Edge::new(nodes, reference))),
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
        let mut curves = Curves { points: Combinations::default(), nodes: BTreeMap::new(), edges: BTreeMap::new(), homes: Vec::new() };
        let ends: BTreeSet<u32> = straight.iter().chain(meeting.keys()).copied().collect();
        for node in ends {
            let raised = raises(node).into_iter().flat_map(|(edge, _, weight)| edge.raised(RAISED * weight));
            let point = curves.points.push([(node, 1.0)].into_iter().chain(raised));
            curves.nodes.insert(node, point);
            curves.homes.push(vec![(node, 1.0)]);
        }
        for edge in edges.values() {
            // What the ends do not have, the inner points have more.
            let has = |&end: &usize| raises(edge.ends[end]).iter().any(|(other, at, _)| (other.middle, *at) == (edge.middle, end));
            let at_ends: f64 = [0, 1].into_iter().filter(has).map(|end| 0.5 * edge.end_share(end)).sum();
            let raised = RAISED * (1.0 - at_ends) / (1.0 - 1.0 / f64::from(PIECES));
            let mut list = vec![curves.nodes[&edge.ends[0]]];
            for k in 1..PIECES {
                let s = f64::from(k) / f64::from(PIECES);
                list.push(curves.points.push(edge.point(s).into_iter().chain(edge.raised(raised))));
                let end = edge.ends[usize::from(s > 0.5)];
                let share = 1.0 - (1.0 - 2.0 * s).abs();
                curves.homes.push(if share == 1.0 { vec![(edge.middle, 1.0)] } else { vec![(end, 1.0 - share), (edge.middle, share)] });
            }
            list.push(curves.nodes[&edge.ends[1]]);
            curves.nodes.insert(edge.middle, list[PIECES as usize / 2]);
            curves.edges.insert(edge.middle, list);
        }
        curves
    }

    /// The facets between points in place of those between nodes.
    fn fine(&self, facets: &[[u32; 2]]) -> Vec<[u32; 2]> {
        let half = PIECES as usize / 2;
        let pieces = |&[from, to]: &[u32; 2]| -> Vec<[u32; 2]> {
            let points = match (self.edges.get(&from), self.edges.get(&to)) {
                (_, Some(points)) => &points[..=half],
                (Some(points), None) => &points[half..],
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
            made.push(self.homes[point as usize].iter().map(|&(node, share)| {
                let index = sides.secondary.index(node).unwrap_or(0);
                let share = if rows == RowsOf::Nodes { sides.weights[index] / weight } else { share };
                ((stride * index + row % stride) as u32, share)
            }));
        }
        made
    }
}
