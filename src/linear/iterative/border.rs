//! Border of a matrix: all unknowns that are not coordinates of nodes in bodies, and the nodes that couple with them.
//!
//! With the node coordinates `u` and the border unknowns `lambda` (multipliers of contacts, ties and joints; unknowns of rigid bodies) the
//! matrix is `[K B; C D]`.

use nalgebra::{DMatrix, DVector};

use super::blocks::{Block, BlockMatrix, frobenius};
use crate::linear::pattern::Pattern;

/// Matrix with symmetric diagonal scaling: block `(u, v)` is multiplied by the scales of `u` and `v`.
pub(super) struct Scaled<'a> {
    pub pattern: &'a Pattern,
    pub values: &'a [f64],
    /// Scale of each vertex.
    pub scales: &'a [f64],
    /// Positions of the nodes, as many numbers for each of the leading vertices as it has unknowns.
    pub positions: &'a [f64],
}

impl Scaled<'_> {
    /// Scale of the block in row `u` and column `v`.
    pub fn scale(&self, u: u32, v: u32) -> f64 {
        self.scales[u as usize] * self.scales[v as usize]
    }

    /// Scaled block in row `u` and column `v`.
    pub fn block<const R: usize, const C: usize>(&self, u: u32, v: u32) -> Block<R, C> {
        let (place, scale) = (self.pattern.block(u, v), self.scale(u, v));
        std::array::from_fn(|i| std::array::from_fn(|k| scale * self.values[place.at(i, k)]))
    }

    /// True if the row of `u` has an entry in a column of `v`.
    pub fn depends(&self, u: u32, v: u32) -> bool {
        let (place, rows) = (self.pattern.block(u, v), self.pattern.size(u as usize));
        (0..self.pattern.size(v as usize)).any(|k| self.values[place.at(0, k)..][..rows].iter().any(|x| *x != 0.0))
    }

    /// True if either of two vertices has an entry in the row of the other.
    pub fn couples(&self, u: u32, v: u32) -> bool {
        self.depends(u, v) || self.depends(v, u)
    }
}

/// Border of a matrix.
pub(super) struct Border {
    /// Number of unknowns of a node.
    pub dimension: usize,
    /// Nodes without constraints, in ascending order.
    pub free: Vec<u32>,
    /// Nodes that couple with the border, in ascending order; every level of the hierarchy contains them unchanged.
    pub kept: Vec<u32>,
    /// Vertices of the border, in ascending order.
    pub vertices: Vec<u32>,
    /// Decoupled vertices, whose rows contain their own unknowns only, such as the multipliers of inactive constraints, in ascending order.
    pub alone: Vec<u32>,
}

impl Border {
    /// Divides the vertices of a matrix, whose nodes have `D` unknowns, into free and kept nodes, border, and decoupled vertices.
    pub fn new<const D: usize>(matrix: &Scaled) -> Self {
        let pattern = matrix.pattern;
        let is_node = |v: usize| {
            let is_regular = !pattern.is_multiplier(v) && !pattern.is_carried(v) && pattern.size(v) == D;
            let is_located = pattern.first_unknown(v) + D <= matrix.positions.len();
            let has_stiffness = || {
                let own: Block<D, D> = matrix.block(v as u32, v as u32);
                (0..D).all(|i| own[i][i] != 0.0)
            };
            is_regular && is_located && has_stiffness()
        };
        let nodes: Vec<bool> = (0..pattern.vertices()).map(is_node).collect();
        let mut is_kept = vec![false; nodes.len()];
        let mut border = Border { dimension: D, free: Vec::new(), kept: Vec::new(), vertices: Vec::new(), alone: Vec::new() };
        for v in (0..nodes.len() as u32).filter(|&v| !nodes[v as usize]) {
            let neighbors = || pattern.neighbors(v as usize).iter().filter(|&&u| u != v);
            if neighbors().any(|&u| matrix.depends(v, u)) {
                border.vertices.push(v);
                neighbors().filter(|&&u| nodes[u as usize] && matrix.couples(u, v)).for_each(|&u| is_kept[u as usize] = true);
            } else {
                border.alone.push(v);
            }
        }
        for v in (0..nodes.len() as u32).filter(|&v| nodes[v as usize]) {
            if is_kept[v as usize] { &mut border.kept } else { &mut border.free }.push(v);
        }
        border
    }

    /// Number of unknowns of the border.
    pub fn unknowns(&self, pattern: &Pattern) -> usize {
        self.vertices.iter().map(|&v| pattern.size(v as usize)).sum()
    }
}

/// Decoupled vertex: its row contains its own unknowns only, so that they are solved before the iteration.
pub(super) struct Alone {
    first: usize,
    inverse: DMatrix<f64>,
    /// Matrix entries of other rows in the columns of the vertex.
    columns: Vec<Entry>,
}

/// Matrix entry in row `row` and in column `unknown` of a vertex.
struct Entry {
    row: usize,
    unknown: usize,
    value: f64,
}

impl Alone {
    /// Decoupled vertex of a scaled matrix; `None` if its diagonal block is singular.
    pub fn new(matrix: &Scaled, v: u32) -> Option<Self> {
        let (pattern, size) = (matrix.pattern, matrix.pattern.size(v as usize));
        let entry = |u: u32, i: usize, k: usize| matrix.scale(u, v) * matrix.values[pattern.block(u, v).at(i, k)];
        let inverse = DMatrix::from_fn(size, size, |i, k| entry(v, i, k)).try_inverse()?;
        let mut columns = Vec::new();
        for &u in pattern.neighbors(v as usize).iter().filter(|&&u| u != v && matrix.depends(u, v)) {
            let first = pattern.first_unknown(u as usize);
            let places = (0..pattern.size(u as usize)).flat_map(|i| (0..size).map(move |k| (i, k)));
            columns.extend(places.map(|(i, unknown)| Entry { row: first + i, unknown, value: entry(u, i, unknown) }));
        }
        Some(Alone { first: pattern.first_unknown(v as usize), inverse, columns })
    }

    /// Solves for the unknowns of the vertex, and subtracts their contribution to other rows from the right-hand side `b`.
    pub fn solve(&self, b: &mut [f64], x: &mut [f64]) {
        let range = self.first..self.first + self.inverse.nrows();
        let solution = &self.inverse * DVector::from_column_slice(&b[range.clone()]);
        x[range].copy_from_slice(solution.as_slice());
        self.columns.iter().for_each(|entry| b[entry.row] -= entry.value * solution[entry.unknown]);
    }
}

/// Rigid motions of the nodes in scaled unknowns (near-null vectors of the stiffness); zero in unknowns without couplings.
pub(super) fn rigid_motions<const D: usize, const M: usize>(
    matrix: &Scaled,
    nodes: &[u32],
    stiffness: &BlockMatrix<D, D>,
) -> Vec<Block<D, M>> {
    let position = |v: u32| -> [f64; D] {
        let first = matrix.pattern.first_unknown(v as usize);
        std::array::from_fn(|i| matrix.positions[first + i])
    };
    let mut middle = [0.0; D];
    nodes.iter().for_each(|&v| (0..D).for_each(|i| middle[i] += position(v)[i] / nodes.len() as f64));
    let mode = |(node, &v): (usize, &u32)| {
        let at = position(v);
        let arm: [f64; D] = std::array::from_fn(|i| at[i] - middle[i]);
        let (columns, blocks) = stiffness.row(node);
        std::array::from_fn(|i| {
            let couples = |(&j, block): (&u32, &Block<D, D>)| (0..D).any(|k| block[i][k] != 0.0 && (j != node as u32 || i != k));
            if !columns.iter().zip(blocks).any(couples) {
                return [0.0; M];
            }
            let mut row = [0.0; M];
            row[i] = 1.0;
            // A rotation for each pair of axes.
            let pairs = (0..D).flat_map(|a| (a + 1..D).map(move |b| (a, b)));
            for (m, (a, b)) in (D..M).zip(pairs) {
                row[m] = if i == a {
                    -arm[b]
                } else if i == b {
                    arm[a]
                } else {
                    0.0
                };
            }
            row.map(|x| x / matrix.scales[v as usize])
        })
    };
    nodes.iter().enumerate().map(mode).collect()
}

/// Stiffness block matrix between the given nodes, in their order.
pub(super) fn stiffness_of<const D: usize>(matrix: &Scaled, nodes: &[u32]) -> BlockMatrix<D, D> {
    let mut place = vec![None; matrix.pattern.vertices()];
    nodes.iter().enumerate().for_each(|(k, &v)| place[v as usize] = Some(k as u32));
    let mut stiffness = BlockMatrix::empty();
    let mut row: Vec<(u32, Block<D, D>)> = Vec::new();
    for &v in nodes {
        row.extend(matrix.pattern.neighbors(v as usize).iter().filter_map(|&u| {
            let at = place[u as usize]?;
            let block = matrix.block(v, u);
            (u == v || frobenius(&block) > 0.0).then_some((at, block))
        }));
        row.sort_unstable_by_key(|(at, _)| *at);
        stiffness.push_row(row.drain(..));
    }
    stiffness
}
