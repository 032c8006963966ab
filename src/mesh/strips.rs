//! Strips of thin cells along the rim of a region: their nodes, their cells, and the rim of the remaining region.
//!
//! The remaining region is filled first. Nodes of a strip on its rim exist then, identified by a vertex or the middle of a rim segment; the
//! others are added.

use super::filling::{FilledRegion, PlacedEdges};
use super::grid::{UNSTRUCTURED, room_for};
use super::triangulation::Rim;
use super::{Facet, MeshError};
use crate::elements::CellKind;

type Point = [f64; 2];

/// A piece of a curve, with the parameters of its ends.
pub(super) type CurveSegment = (usize, [f64; 2]);

/// Columns along a stretch of the rim.
pub(super) struct Strip {
    /// Points of each column, from the boundary inward; a closed strip repeats its first column as the last one.
    pub columns: Vec<Vec<Point>>,
    /// Role of each column node in the mesh of the remaining region.
    pub nodes: Vec<Vec<Node>>,
    /// Curve segment under each stack (the cells between two neighboring columns).
    pub pieces: Vec<CurveSegment>,
    /// Curve that the first and the last column run along, with the curve parameters of their points; `None` for a column inside the body.
    pub along: [Option<(usize, Vec<f64>)>; 2],
    /// True if the strip follows a whole closed loop.
    pub is_closed: bool,
}

/// Strips of layers, the rim of the remaining region, and the order of facets along the whole rim.
pub(super) struct Layered {
    pub rest: Rim,
    pub strips: Vec<Strip>,
    pub order: Vec<Order>,
}

/// Role of a column node in the mesh of the remaining region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Node {
    /// Node of the strip alone.
    Own,
    /// Vertex on the rim of the remaining region.
    Vertex(usize),
    /// Node at the middle of a rim segment of the remaining region.
    Middle(usize),
}

/// Location of the facets of a stretch of the rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// On a rim segment of the remaining region.
    Piece(usize),
    /// On the boundary side of a stack (the cells between two neighboring columns): indices of strip and stack.
    Stack(usize, usize),
    /// Along the first column of a strip, from its inner end on.
    Start(usize),
    /// Along the last column of a strip.
    End(usize),
}

/// Part of the whole rim: its curve, and the source of the facets there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Order {
    pub curve: usize,
    pub source: Source,
}

/// Side of a stack of cells on which facets of a boundary lie: on the curve (foot), or along the left or right column.
#[derive(Clone, Copy)]
enum StackSide {
    Foot,
    Left,
    Right,
}

impl Layered {
    /// Adds a rim segment without layers.
    pub fn add_piece(&mut self, (curve, ends): CurveSegment) {
        let piece = self.rest.add_piece(self.rest.curve_at(curve, ends[0]), (curve, ends), None);
        self.order.push(Order { curve, source: Source::Piece(piece) });
    }

    /// Adds a strip, with its front and the columns that end within the body.
    pub fn add_strip(&mut self, mut strip: Strip, halves: usize) {
        let (top, last) = (strip.columns[0].len() - 1, strip.columns.len() - 1);
        // Column and level of each node along the inner boundary of the strip, from one end to the other.
        let mut path: Vec<(usize, usize)> = Vec::new();
        if !strip.is_closed && strip.along[0].is_none() {
            path.extend((0..top).map(|level| (0, level)));
        }
        path.extend((0..=last).map(|column| (column, top)));
        if !strip.is_closed && strip.along[1].is_none() {
            path.extend((0..top).rev().map(|level| (last, level)));
        }
        for pair in path[..path.len() - 1].chunks(halves) {
            let at = |(column, level): (usize, usize)| strip.columns[column][level];
            let middle = pair.get(1).map(|&place| at(place));
            let piece = self.rest.add_piece(at(pair[0]), (self.rest.front(), [0.0, 1.0]), middle);
            let nodes = [Node::Vertex(piece), Node::Middle(piece)];
            pair.iter().zip(nodes).for_each(|(&(column, level), node)| strip.nodes[column][level] = node);
        }
        if strip.is_closed {
            strip.nodes[last] = strip.nodes[0].clone();
        } else if let Some(&(column, level)) = path.last() {
            // The last node is the first vertex of the following gap.
            strip.nodes[column][level] = Node::Vertex(self.rest.vertices.len());
        }
        let number = self.strips.len();
        let order = |curve, source| Order { curve, source };
        self.order.extend(strip.along[0].iter().map(|(curve, _)| order(*curve, Source::Start(number))));
        self.order.extend(strip.pieces.iter().enumerate().map(|(stack, (curve, _))| order(*curve, Source::Stack(number, stack))));
        self.order.extend(strip.along[1].iter().map(|(curve, _)| order(*curve, Source::End(number))));
        self.strips.push(strip);
    }

    /// Adds the cells of all strips to those of the remaining region, with the positions of their mid-side nodes; returns the facets on
    /// each stretch of the rim.
    ///
    /// # Errors
    /// Too many cells.
    pub fn complete(&self, filled: &mut FilledRegion) -> Result<Vec<(usize, Vec<Facet>)>, MeshError> {
        let per_stack = |strip: &Strip| strip.columns[0].len() - 1;
        let cells: usize = self.strips.iter().map(|strip| 2 * per_stack(strip) * strip.columns.len()).sum();
        room_for(cells, UNSTRUCTURED)?;
        let stacks: Vec<Stacks> = self.strips.iter().map(|strip| Stacks::added(strip, &self.rest, filled)).collect();
        let facets = |source: Source| match source {
            Source::Piece(piece) => filled.along.get(&piece).cloned().unwrap_or_default(),
            Source::Stack(strip, stack) => vec![stacks[strip].facet(stack, 0, StackSide::Foot)],
            Source::Start(strip) => (0..stacks[strip].levels).rev().map(|level| stacks[strip].facet(0, level, StackSide::Left)).collect(),
            Source::End(strip) => {
                let last = self.strips[strip].pieces.len() - 1;
                (0..stacks[strip].levels).map(|level| stacks[strip].facet(last, level, StackSide::Right)).collect()
            }
        };
        Ok(self.order.iter().map(|order| (order.curve, facets(order.source))).collect())
    }
}

/// Cells of a strip in the mesh.
struct Stacks {
    first: u32,
    levels: usize,
    /// For each quadrilateral divided into triangles: true if the diagonal begins at its second corner.
    cuts: Option<Vec<bool>>,
}

impl Stacks {
    /// The facet of a cell on a side.
    fn facet(&self, stack: usize, level: usize, side: StackSide) -> Facet {
        let cell = stack * self.levels + level;
        let (cell, local) = match (&self.cuts, side) {
            (None, StackSide::Foot) => (cell, 0),
            (None, StackSide::Right) => (cell, 1),
            (None, StackSide::Left) => (cell, 3),
            (Some(_), StackSide::Foot) => (2 * cell, 0),
            (Some(cuts), StackSide::Right) if cuts[cell] => (2 * cell + 1, 0),
            (Some(_), StackSide::Right) => (2 * cell, 1),
            (Some(cuts), StackSide::Left) if cuts[cell] => (2 * cell, 2),
            (Some(_), StackSide::Left) => (2 * cell + 1, 2),
        };
        Facet { cell: self.first + cell as u32, local }
    }

    /// Adds the nodes and cells of a strip.
    fn added(strip: &Strip, rest: &Rim, filled: &mut FilledRegion) -> Stacks {
        let levels = strip.columns[0].len() - 1;
        let first = filled.mesh.cell_count() as u32;
        let mut nodes: Vec<Vec<u32>> = Vec::with_capacity(strip.columns.len());
        for (column, (points, kinds)) in strip.columns.iter().zip(&strip.nodes).enumerate() {
            if strip.is_closed && column + 1 == strip.columns.len() {
                nodes.push(nodes[0].clone());
                continue;
            }
            let node = |(&[x, y], &kind): (&Point, &Node)| match kind {
                Node::Vertex(vertex) => filled.corners[&vertex],
                Node::Middle(piece) => filled.middles[&piece],
                Node::Own => {
                    filled.mesh.points.push([x, y, 0.0]);
                    filled.mesh.points.len() as u32 - 1
                }
            };
            nodes.push(points.iter().zip(kinds).map(node).collect());
        }
        let is_cut = filled.mesh.only_kind() == Some(CellKind::Tri3);
        let connectivity = &mut filled.mesh.blocks[0].connectivity;
        let mut cuts = Vec::new();
        for stack in 0..strip.pieces.len() {
            for level in 0..levels {
                let corner = |column: usize, level: usize| (nodes[stack + column][level], strip.columns[stack + column][level]);
                let corners = [corner(0, level), corner(1, level), corner(1, level + 1), corner(0, level + 1)];
                let [a, b, c, d] = corners.map(|(node, _)| node);
                if !is_cut {
                    connectivity.extend([a, b, c, d]);
                    continue;
                }
                let length = |from: usize, to: usize| distance(corners[from].1, corners[to].1);
                let is_turned = length(1, 3) < length(0, 2);
                connectivity.extend(if is_turned { [a, b, d, b, c, d] } else { [a, b, c, a, c, d] });
                cuts.push(is_turned);
            }
            note_middles(strip, stack, &nodes, rest, &mut filled.placed);
        }
        for (end, column) in [(0, 0), (1, strip.columns.len() - 1)] {
            let Some((curve, places)) = &strip.along[end] else { continue };
            for level in 0..levels {
                let place = rest.on_curve(*curve, 0.5 * (places[level] + places[level + 1]));
                let ends = [nodes[column][level], nodes[column][level + 1]];
                filled.placed.extend(place.map(|place| (sorted(ends), place)));
            }
        }
        Stacks { first, levels, cuts: is_cut.then_some(cuts) }
    }
}

fn distance(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Adds mid-side nodes of a stack along a curve: the sagitta of each level is proportional to its length, so that thin cells on a curve are
/// not inverted.
fn note_middles(strip: &Strip, stack: usize, nodes: &[Vec<u32>], rest: &Rim, placed: &mut PlacedEdges) {
    let (curve, [from, to]) = strip.pieces[stack];
    let Some(on) = rest.on_curve(curve, 0.5 * (from + to)) else { return };
    let ends = |level: usize| [strip.columns[stack][level], strip.columns[stack + 1][level]];
    let half = |[a, b]: [Point; 2]| [0, 1].map(|i| 0.5 * (a[i] + b[i]));
    let foot = half(ends(0));
    let length = distance(ends(0)[0], ends(0)[1]);
    let mut below: Option<Point> = None;
    for level in 0..strip.columns[stack].len() {
        let [a, b] = ends(level);
        let share = distance(a, b) / length;
        let straight = half([a, b]);
        let middle = [0, 1].map(|i| straight[i] + share * (on[i] - foot[i]));
        placed.insert(sorted([nodes[stack][level], nodes[stack + 1][level]]), middle);
        if let Some(below) = below {
            // Center of the quadrilateral, used as the midpoint of either diagonal.
            let center = half([below, middle]);
            placed.insert(sorted([nodes[stack][level - 1], nodes[stack + 1][level]]), center);
            placed.insert(sorted([nodes[stack + 1][level - 1], nodes[stack][level]]), center);
        }
        below = Some(middle);
    }
}
