//! Symmetric block pattern of a graph whose vertices carry a few unknowns each, as compressed columns.
//!
//! All columns of a vertex have equal rows, so that two numbers locate a block: position of its first entry, distance to the next column.
//! Blocks are column-major.

use std::cmp::Ordering;
use std::ops::Range;

use serde::{Deserialize, Serialize};

/// Role of the unknowns of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Coordinates of a node or director, or other unknowns with inertia or stiffness on the diagonal.
    Coordinates,
    /// Coordinates of a massless (carried) node, which anchored constraints express by the coordinates of other vertices.
    Carried,
    /// Multipliers of one group of constraints; their diagonal block may be zero.
    Multipliers,
}

/// A vertex of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vertex {
    /// Role of the unknowns.
    pub role: Role,
    /// Number of unknowns.
    pub size: u8,
}

impl Vertex {
    /// Returns a vertex with `size` coordinates.
    pub const fn coordinates(size: u8) -> Self {
        Vertex { role: Role::Coordinates, size }
    }

    /// Returns a vertex with the coordinates of a massless (carried) node.
    pub const fn carried(size: u8) -> Self {
        Vertex { role: Role::Carried, size }
    }

    /// Returns a vertex with `size` multipliers.
    pub const fn multipliers(size: u8) -> Self {
        Vertex { role: Role::Multipliers, size }
    }
}

/// Pattern of a sparse matrix on a graph.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// Role of the unknowns of each vertex.
    roles: Vec<Role>,
    /// First unknown of each vertex, and the number of all unknowns at the end.
    first: Vec<usize>,
    /// Range of each vertex's neighbors in `neighbors`, itself included.
    starts: Vec<usize>,
    /// Neighboring vertices in ascending order.
    neighbors: Vec<u32>,
    /// For each entry of `neighbors`, the position of the block's first row inside a column of the vertex, or [`NO_PLACE`].
    offsets: Vec<u32>,
    /// Position of the values of each vertex's first column.
    columns: Vec<usize>,
    /// Length of a column of each vertex.
    lengths: Vec<usize>,
    /// Anchor of each multiplier, `u32::MAX` elsewhere; empty without any.
    anchors: Vec<u32>,
}

/// Position of a matrix block in the array of values: entry `(i, k)` at `start + k * stride + i`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Block {
    /// Position of entry `(0, 0)` in the array of values.
    pub start: u32,
    /// Distance between successive columns of the block.
    pub stride: u32,
}

/// Offset of a block without values.
const NO_PLACE: u32 = u32::MAX;

impl Block {
    /// Marker of a zero block, which has no position among the values.
    pub(super) const NOWHERE: Block = Block { start: u32::MAX, stride: 0 };

    /// Position of entry `(row, column)` of the block in the array of values.
    #[inline(always)]
    pub fn at(self, row: usize, column: usize) -> usize {
        self.start as usize + column * self.stride as usize + row
    }
}

impl Pattern {
    /// Pattern of a graph given by its vertices and cliques of mutually coupled vertices. Every vertex is coupled with itself.
    pub fn new<'a>(vertices: &[Vertex], cliques: impl Iterator<Item = &'a [u32]>) -> Self {
        let count = vertices.len();
        let size = |v: usize| vertices[v].size as usize;
        // Cliques of each vertex by counting sort; lists of neighbors with repetitions would take the sum of their squares.
        let cliques: Vec<&[u32]> = cliques.collect();
        let mut ends = vec![0usize; count + 1];
        cliques.iter().flat_map(|clique| clique.iter()).for_each(|&v| ends[v as usize + 1] += 1);
        for v in 0..count {
            ends[v + 1] += ends[v];
        }
        let (mut next, mut of_vertices) = (ends.clone(), vec![0u32; ends[count]]);
        for (clique, index) in cliques.iter().zip(0u32..) {
            for &v in *clique {
                of_vertices[next[v as usize]] = index;
                next[v as usize] += 1;
            }
        }
        let mut found_by = vec![u32::MAX; count];
        let mut for_each_neighbor = |v: usize, mark: usize, visit: &mut dyn FnMut(u32)| {
            let members = of_vertices[ends[v]..ends[v + 1]].iter().flat_map(|&clique| cliques[clique as usize]);
            for &u in std::iter::once(&(v as u32)).chain(members) {
                if std::mem::replace(&mut found_by[u as usize], mark as u32) != mark as u32 {
                    visit(u);
                }
            }
        };
        let mut starts = vec![0usize; count + 1];
        for v in 0..count {
            starts[v + 1] = starts[v];
            for_each_neighbor(v, v, &mut |_| starts[v + 1] += 1);
        }
        let mut neighbors = vec![0; starts[count]];
        for v in 0..count {
            let mut place = starts[v];
            for_each_neighbor(v, count + v, &mut |u| {
                neighbors[place] = u;
                place += 1;
            });
            neighbors[starts[v]..place].sort_unstable();
        }
        let mut first = vec![0usize; count + 1];
        for v in 0..count {
            first[v + 1] = first[v] + size(v);
        }
        let mut offsets = Vec::with_capacity(neighbors.len());
        let (mut columns, mut lengths) = (vec![0usize; count + 1], vec![0usize; count]);
        for v in 0..count {
            let mut length = 0;
            for &u in &neighbors[starts[v]..starts[v + 1]] {
                offsets.push(length as u32);
                length += size(u as usize);
            }
            lengths[v] = length;
            columns[v + 1] = columns[v] + length * size(v);
        }
        let roles = vertices.iter().map(|vertex| vertex.role).collect();
        Pattern { roles, first, starts, neighbors, offsets, columns, lengths, anchors: Vec::new() }
    }

    /// Returns this pattern with an *anchor* for some multipliers: the node whose motion the multiplier opposes, so that eliminating the
    /// node fills the multiplier's zero diagonal.
    ///
    /// A node should anchor no more multipliers than it has coordinates. A multiplier without an anchor is eliminated after all its
    /// neighbors.
    pub fn with_anchors(mut self, anchors: impl IntoIterator<Item = (u32, u32)>) -> Self {
        self.anchors = vec![u32::MAX; self.vertices()];
        for (multiplier, node) in anchors {
            self.anchors[multiplier as usize] = node;
        }
        self
    }

    /// Returns a pattern of the same vertices with the given couplings; blocks of common couplings keep their positions among the values.
    ///
    /// Blocks of dropped couplings have no position any more; couplings that this pattern lacks get [`NO_PLACE`].
    pub(super) fn restricted(&self, couplings: &Couplings) -> Self {
        let mut offsets = Vec::with_capacity(couplings.neighbors.len());
        for v in 0..self.vertices() {
            let mut own = self.starts[v]..self.starts[v + 1];
            for &u in couplings.of(v) {
                while own.start < own.end && self.neighbors[own.start] < u {
                    own.start += 1;
                }
                let is_there = own.start < own.end && self.neighbors[own.start] == u;
                offsets.push(if is_there { self.offsets[own.start] } else { NO_PLACE });
            }
        }
        Pattern { starts: couplings.starts.clone(), neighbors: couplings.neighbors.clone(), offsets, ..self.clone() }
    }

    /// Couplings with a nonzero value in the block or its transposed counterpart; a vertex is always coupled with itself.
    pub(super) fn present(&self, values: &[f64]) -> Couplings {
        let mut present = vec![false; self.neighbors.len()];
        // Since vertices are visited in ascending order, each one is the next unvisited entry in the sorted list of its neighbor.
        let mut next: Vec<usize> = self.starts[..self.vertices()].to_vec();
        for v in 0..self.vertices() {
            for (k, block) in (self.starts[v]..self.starts[v + 1]).zip(self.column_blocks(v)) {
                let u = self.neighbors[k] as usize;
                let mirrored = next[u];
                next[u] += 1;
                let rows = self.size(u);
                if u == v || (0..self.size(v)).any(|column| values[block.at(0, column)..][..rows].iter().any(|&x| x != 0.0)) {
                    present[k] = true;
                    present[mirrored] = true;
                }
            }
        }
        let mut couplings = Couplings { starts: vec![0], neighbors: Vec::with_capacity(present.len()) };
        for range in self.starts.windows(2) {
            couplings.neighbors.extend((range[0]..range[1]).filter(|&k| present[k]).map(|k| self.neighbors[k]));
            couplings.starts.push(couplings.neighbors.len());
        }
        couplings
    }

    /// Positions of the values of all couplings outside the given ones, as ascending ranges.
    pub(super) fn left_out(&self, couplings: &Couplings) -> Vec<Range<u32>> {
        let mut ranges: Vec<Range<u32>> = Vec::new();
        let mut left_out: Vec<(Block, usize)> = Vec::new();
        for v in 0..self.vertices() {
            left_out.clear();
            let mut kept = couplings.of(v).iter().peekable();
            for (&u, block) in self.neighbors(v).iter().zip(self.column_blocks(v)) {
                while kept.next_if(|&&other| other < u).is_some() {}
                if kept.peek() != Some(&&u) {
                    left_out.push((block, self.size(u as usize)));
                }
            }
            for column in 0..self.size(v) {
                for &(block, rows) in &left_out {
                    let start = block.at(0, column) as u32;
                    let end = start + rows as u32;
                    match ranges.last_mut() {
                        Some(last) if last.end == start => last.end = end,
                        _ => ranges.push(start..end),
                    }
                }
            }
        }
        ranges
    }

    /// Number of vertices.
    #[inline]
    pub fn vertices(&self) -> usize {
        self.lengths.len()
    }

    /// A vertex.
    #[inline]
    pub fn vertex(&self, vertex: usize) -> Vertex {
        Vertex { role: self.roles[vertex], size: self.size(vertex) as u8 }
    }

    /// Number of unknowns of a vertex.
    #[inline]
    pub fn size(&self, vertex: usize) -> usize {
        self.first[vertex + 1] - self.first[vertex]
    }

    /// True if the unknowns of a vertex are coordinates of a massless (carried) node.
    #[inline]
    pub(crate) fn is_carried(&self, vertex: usize) -> bool {
        self.roles[vertex] == Role::Carried
    }

    /// True if the unknowns of a vertex are multipliers.
    #[inline]
    pub(crate) fn is_multiplier(&self, vertex: usize) -> bool {
        self.roles[vertex] == Role::Multipliers
    }

    /// Anchor of a multiplier; `None` without one.
    #[inline]
    pub fn anchor(&self, vertex: usize) -> Option<u32> {
        self.anchors.get(vertex).copied().filter(|&anchor| anchor != u32::MAX)
    }

    /// Vertex of an unknown.
    pub(crate) fn vertex_of(&self, unknown: usize) -> usize {
        self.first.partition_point(|&first| first <= unknown) - 1
    }

    /// For each neighbor of a vertex, itself included: the block in its row and the vertex's column.
    pub(super) fn column_blocks(&self, vertex: usize) -> impl Iterator<Item = Block> + '_ {
        let (start, stride) = (self.columns[vertex] as u32, self.lengths[vertex] as u32);
        self.offsets[self.starts[vertex]..self.starts[vertex + 1]].iter().map(move |&offset| match offset {
            NO_PLACE => Block::NOWHERE,
            offset => Block { start: start + offset, stride },
        })
    }

    /// Number of unknowns.
    #[inline]
    pub fn unknowns(&self) -> usize {
        self.first[self.first.len() - 1]
    }

    /// Number of stored values.
    #[inline]
    pub fn values(&self) -> usize {
        self.columns[self.columns.len() - 1]
    }

    /// First unknown of a vertex.
    #[inline]
    pub fn first_unknown(&self, vertex: usize) -> usize {
        self.first[vertex]
    }

    /// Block in row `u` and column `v` (vertices), which must be coupled.
    ///
    /// # Panics
    /// When the two are not coupled in the pattern.
    #[inline]
    pub fn block(&self, u: u32, v: u32) -> Block {
        self.find_block(u, v).expect("the vertices are coupled in the pattern")
    }

    /// Block in row `u` and column `v` (vertices); `None` if they are not coupled.
    pub(super) fn find_block(&self, u: u32, v: u32) -> Option<Block> {
        let range = self.starts[v as usize]..self.starts[v as usize + 1];
        let place = self.neighbors[range.clone()].binary_search(&u).ok()?;
        let stride = self.lengths[v as usize];
        Some(Block { start: (self.columns[v as usize] + self.offsets[range.start + place] as usize) as u32, stride: stride as u32 })
    }

    /// Neighbors of a vertex, itself included, in ascending order.
    #[inline]
    pub fn neighbors(&self, vertex: usize) -> &[u32] {
        &self.neighbors[self.starts[vertex]..self.starts[vertex + 1]]
    }

    /// Sets the blocks that couple vertices before `first` with other vertices to zero.
    pub fn clear_couplings(&self, first: usize, values: &mut [f64]) {
        for v in 0..self.vertices() {
            let place = self.starts[v] + self.neighbors(v).partition_point(|&u| (u as usize) < first);
            let split = if place < self.starts[v + 1] { self.offsets[place] as usize } else { self.lengths[v] };
            let rows = if v < first { split..self.lengths[v] } else { 0..split };
            let columns = self.columns[v]..self.columns[v] + self.size(v) * self.lengths[v];
            values[columns].chunks_exact_mut(self.lengths[v]).for_each(|column| column[rows.clone()].fill(0.0));
        }
    }

    /// `y = A x` with the given values, for the leading unknowns that `x` and `y` contain (whole vertices).
    pub fn multiply_into(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        (0..self.lengths.len()).take_while(|&v| self.first[v] < x.len()).for_each(|v| self.add_vertex(v, values, x, y));
    }

    /// `y = A x` for several vectors in sequence; the result for each vector is bitwise independent of the others.
    pub(super) fn multiply_each_into(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        let unknowns = self.unknowns().max(1);
        y.fill(0.0);
        for v in 0..self.lengths.len() {
            x.chunks_exact(unknowns).zip(y.chunks_exact_mut(unknowns)).for_each(|(x, y)| self.add_vertex(v, values, x, y));
        }
    }

    /// `y += A x` for the columns of a vertex.
    #[inline(always)]
    fn add_vertex(&self, v: usize, values: &[f64], x: &[f64], y: &mut [f64]) {
        match self.size(v) {
            1 => self.add_columns::<1>(v, values, x, y),
            2 => self.add_columns::<2>(v, values, x, y),
            3 => self.add_columns::<3>(v, values, x, y),
            size => (0..size).for_each(|k| self.add_one_column(v, k, values, x[self.first[v] + k], y)),
        }
    }

    /// `y += A x` for the columns of a vertex with `N` unknowns, all at once.
    #[inline(always)]
    fn add_columns<const N: usize>(&self, v: usize, values: &[f64], x: &[f64], y: &mut [f64]) {
        let length = self.lengths[v];
        let mut columns = values[self.columns[v]..][..N * length].chunks_exact(length);
        let columns: [&[f64]; N] = std::array::from_fn(|_| columns.next().unwrap_or_default());
        let x: [f64; N] = std::array::from_fn(|k| x[self.first[v] + k]);
        let mut place = 0;
        for &u in self.neighbors(v) {
            let rows = self.first[u as usize]..self.first[u as usize + 1];
            let count = rows.len();
            let Some(y) = y.get_mut(rows) else { break };
            for (i, y) in y.iter_mut().enumerate() {
                for k in 0..N {
                    *y += columns[k][place + i] * x[k];
                }
            }
            place += count;
        }
    }

    fn add_one_column(&self, v: usize, k: usize, values: &[f64], x: f64, y: &mut [f64]) {
        let column = &values[self.columns[v] + k * self.lengths[v]..][..self.lengths[v]];
        let rows = self.neighbors(v).iter().flat_map(|&u| self.first[u as usize]..self.first[u as usize + 1]);
        for (row, value) in rows.zip(column) {
            if let Some(y) = y.get_mut(row) {
                *y += value * x;
            }
        }
    }

    /// `y = |A| |x|`, the sum of the magnitudes of the terms in every row of `A x`.
    pub(super) fn multiply_sizes_into(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for v in 0..self.lengths.len() {
            for k in 0..self.size(v) {
                let column = &values[self.columns[v] + k * self.lengths[v]..][..self.lengths[v]];
                let rows = self.neighbors(v).iter().flat_map(|&u| self.first[u as usize]..self.first[u as usize + 1]);
                rows.zip(column).for_each(|(row, value)| y[row] += (value * x[self.first[v] + k]).abs());
            }
        }
    }

    /// Compressed columns: start of every column, row of every entry, and position of the value of every entry (`None` without a value).
    pub fn compressed_columns(&self) -> (Vec<usize>, Vec<usize>, Vec<Option<usize>>) {
        let mut starts = Vec::with_capacity(self.unknowns() + 1);
        let (mut rows, mut places) = (Vec::new(), Vec::new());
        starts.push(0);
        for v in 0..self.lengths.len() {
            for column in 0..self.size(v) {
                for (&u, block) in self.neighbors(v).iter().zip(self.column_blocks(v)) {
                    rows.extend(self.first[u as usize]..self.first[u as usize + 1]);
                    places.extend((0..self.size(u as usize)).map(|row| (block != Block::NOWHERE).then(|| block.at(row, column))));
                }
                starts.push(rows.len());
            }
        }
        (starts, rows, places)
    }
}

/// Set of couplings between vertices: each pair is listed for both vertices, and each vertex is coupled with itself. Couplings refer to
/// vertices, independent of a pattern.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Couplings {
    /// Range of each vertex's neighbors in `neighbors`.
    starts: Vec<usize>,
    /// Neighbors of each vertex in ascending order.
    neighbors: Vec<u32>,
}

impl Couplings {
    /// Size in bytes.
    pub(super) fn size(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.neighbors[..])
    }

    /// Number of vertices; 0 for empty couplings.
    pub(super) fn vertices(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// True if the neighbors of every vertex are valid vertices in ascending order, include the vertex itself, and the relation is
    /// symmetric.
    pub(super) fn is_sound(&self) -> bool {
        let vertices = self.vertices();
        let ends =
            self.starts.first().is_none_or(|&first| first == 0) && self.starts.last().is_none_or(|&last| last == self.neighbors.len());
        let have = |v: u32, u: u32| self.of(v as usize).binary_search(&u).is_ok();
        let are_mutual = |v: u32| have(v, v) && self.of(v as usize).iter().all(|&u| have(u, v));
        ends && self.starts.is_sorted()
            && self.neighbors.iter().all(|&neighbor| (neighbor as usize) < vertices)
            && (0..vertices).all(|v| self.of(v).is_sorted_by(|a, b| a < b))
            && (0..vertices as u32).all(are_mutual)
    }

    /// Number of couplings, each counted from both sides.
    pub(super) fn count(&self) -> usize {
        self.neighbors.len()
    }

    /// Neighbors of a vertex.
    fn of(&self, vertex: usize) -> &[u32] {
        &self.neighbors[self.starts[vertex]..self.starts[vertex + 1]]
    }

    /// Union of two sets of couplings of equal vertices.
    pub(super) fn joined(&self, other: &Self) -> Self {
        let mut joined = Couplings { starts: vec![0], neighbors: Vec::with_capacity(self.count().max(other.count())) };
        for v in 0..self.vertices() {
            let (mut own, mut others) = (self.of(v), other.of(v));
            while let ([a, rest @ ..], [b, other_rest @ ..]) = (own, others) {
                joined.neighbors.push(*a.min(b));
                (own, others) = match a.cmp(b) {
                    Ordering::Less => (rest, others),
                    Ordering::Equal => (rest, other_rest),
                    Ordering::Greater => (own, other_rest),
                };
            }
            joined.neighbors.extend(own.iter().chain(others));
            joined.starts.push(joined.neighbors.len());
        }
        joined
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_stand_where_the_compressed_columns_say() {
        let sizes = [2u8, 2, 1, 2];
        let vertices = sizes.map(Vertex::coordinates);
        let cliques: [&[u32]; 2] = [&[0, 1], &[1, 2, 3]];
        let pattern = Pattern::new(&vertices, cliques.into_iter());
        assert_eq!(pattern.unknowns(), 7);
        assert_eq!(pattern.neighbors(0), [0, 1]);
        assert_eq!(pattern.neighbors(1), [0, 1, 2, 3]);
        let (starts, rows, places) = pattern.compressed_columns();
        assert!(places.into_iter().eq((0..pattern.values()).map(Some)));
        let mut cleared = vec![1.0; pattern.values()];
        pattern.clear_couplings(2, &mut cleared);
        let zeros = [(1, 2), (1, 3), (2, 1), (3, 1)].map(|(u, v)| pattern.block(u, v));
        assert_eq!(cleared.iter().filter(|value| **value == 0.0).count(), 2 * (2 + 4));
        assert!(zeros.iter().all(|block| cleared[block.at(0, 0)] == 0.0));
        for (u, v) in [(0u32, 1u32), (1, 0), (2, 3), (3, 3), (2, 2)] {
            let block = pattern.block(u, v);
            for i in 0..sizes[u as usize] as usize {
                for k in 0..sizes[v as usize] as usize {
                    let (place, column) = (block.at(i, k), pattern.first_unknown(v as usize) + k);
                    assert!((starts[column]..starts[column + 1]).contains(&place));
                    assert_eq!(rows[place], pattern.first_unknown(u as usize) + i);
                }
            }
        }
    }
}
