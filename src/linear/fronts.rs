//! Fronts, and the positions of matrix entries and update matrices in them.
//!
//! A *front* is a dense matrix of a few pivots and of the unknowns that their elimination couples. Its remainder after elimination, the
//! *update*, is added to the front of its parent in the tree (multifrontal method: Duff and Reid 1983, Liu 1992).

use std::ops::Range;

use super::pattern::Block;

/// A front. Ranges are into the lists of [`super::symbolic::Symbolic`].
#[derive(Clone, Debug, Default)]
pub(super) struct Front {
    /// First pivot in the order of elimination.
    pub(super) first: usize,
    /// Number of pivots.
    pub(super) pivots: usize,
    /// Number of non-pivot unknowns of the front.
    pub(super) update: usize,
    /// Numbers of pivots (`p`) and of non-pivot unknowns (`u`), padded to multiples of four.
    pub(super) p: usize,
    pub(super) u: usize,
    /// Start of the front's factors in `factors`: `p * p` for the pivot block, `u * p` below it, `u * p` to its right.
    pub(super) factors: usize,
    /// Range of the front's non-pivot unknowns in `rows`.
    pub(super) rows: Range<usize>,
    /// Range in `runs` with the positions of non-pivot unknowns among the pivots of the parent's front.
    pub(super) to_pivots: Range<usize>,
    /// Range in `runs` with the positions of non-pivot unknowns among the other unknowns of the parent's front.
    pub(super) to_others: Range<usize>,
    pub(super) parent: Option<u32>,
    /// Range of the child fronts, whose update matrices are added to this front, in ascending order.
    pub(super) children: Range<usize>,
    /// Range of the matrix blocks inside the pivot block.
    pub(super) inside: Range<usize>,
    /// Range of the matrix blocks beside the pivot block.
    pub(super) beside: Range<usize>,
}

impl Front {
    /// Length of the front's factors.
    pub(super) fn length(&self) -> usize {
        (self.p + 2 * self.u) * self.p
    }

    /// Floating-point operations of the front's elimination.
    pub(super) fn operations(&self) -> f64 {
        let (p, u) = (self.pivots as f64, self.update as f64);
        2.0 / 3.0 * p * p * p + 2.0 * p * p * u + 2.0 * p * u * u
    }

    /// Time of the front's elimination in units of one operation; assembling one entry costs about twenty.
    pub(super) fn work(&self) -> f64 {
        let side = (self.p + self.u) as f64;
        self.operations() + 20.0 * side * side
    }
}

/// Matrix block in the pivot block of a front.
#[derive(Clone, Copy, Debug)]
pub(super) struct PivotBlock {
    pub(super) source: Block,
    /// Position of the block's first entry in the pivot block.
    pub(super) target: u32,
    /// Vertices of the rows and columns.
    pub(super) row: u32,
    pub(super) column: u32,
}

/// Matrix block below the pivot block, and its counterpart to the right.
#[derive(Clone, Copy, Debug)]
pub(super) struct OffDiagonalBlock {
    pub(super) lower: Block,
    pub(super) upper: Block,
    /// Position of the first entry of both blocks; the right one is stored transposed.
    pub(super) target: u32,
    /// Vertex among the pivots.
    pub(super) pivot: u32,
    /// Vertex outside the pivots.
    pub(super) other: u32,
}

/// Unknowns of an update that are contiguous in the parent's front.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    /// Position of the run's first unknown in the child's update matrix.
    pub(super) source: u32,
    /// Position of the first unknown among the pivots or the non-pivot unknowns of the parent front.
    pub(super) target: u32,
    pub(super) length: u32,
}

impl Run {
    /// Part of the run within `count` positions from `first` on, with its target relative to `first`.
    pub(super) fn within(&self, first: usize, count: usize) -> Option<Self> {
        let (first, end) = (first as u32, (first + count) as u32);
        let from = self.target.max(first);
        let to = (self.target + self.length).min(end);
        (from < to).then(|| Run { source: self.source + from - self.target, target: from - first, length: to - from })
    }
}

/// Numbering of fronts and pivots.
pub(super) struct Numbering {
    /// Last vertex of each front, by positions in the order of elimination as everywhere in the tree.
    pub(super) roots: Vec<u32>,
    /// First pivot of each vertex.
    pub(super) first: Vec<u32>,
    /// Vertices in the order of their pivots.
    pub(super) sequence: Vec<u32>,
}
