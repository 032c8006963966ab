//! Dense elimination of one front: LU of its pivot block, the two triangular solves beside it, and the Schur complement for the non-pivot
//! unknowns.
//!
//! Small fronts are eliminated in place. In large fronts, where each column occupies its own memory page, blocks of pivots are eliminated
//! in turn: their rows and columns are copied into strips, which stay in cache during the update of the remaining front and are shared
//! among threads ([`super::strips`]).

use std::ops::Range;

use pulp::Simd;

use super::panels::{Blocks, EliminationOptions, Scratch};
use super::strips::{COLUMNS, DEPTH, PANEL, STRIP, SolvePanel, SolveStrip, SubtractProducts, pack_columns, pack_rows, solve_strip};
use super::tiles::{WIDTH, four, outer_products, store, subtract_from, tiles};
use crate::math::simd::with_registers;
use crate::math::workers::Workers;

/// Number of entries beside the pivot block above which strips are copied.
const PACKED: usize = 4096;

/// Largest number of pivots that are eliminated as one block, whose factors fit into the cache.
const WHOLE: usize = 384;

impl Blocks<'_> {
    /// Eliminates the pivots. `swaps[k]` becomes the index of the row exchanged with row `k`; replaced pivots are reported.
    #[inline(always)]
    pub(super) fn eliminate<S: Simd>(
        &mut self,
        simd: S,
        manner: &EliminationOptions,
        swaps: &mut [u32],
        scratch: &mut Scratch,
        replaced: &mut impl FnMut(usize),
    ) {
        let (p, u) = (self.p, self.u);
        if p * u >= PACKED || p > WHOLE {
            let depth = if p <= WHOLE { p } else { DEPTH };
            for from in (0..p).step_by(depth) {
                let block = from..(from + depth).min(p);
                self.factor_block(simd, block.clone(), manner, swaps, scratch, replaced);
                self.swap_upper(swaps, block.clone());
                self.eliminate_block(block, manner, scratch);
                if (manner.stopped)() {
                    return;
                }
            }
            return;
        }
        if p <= PANEL {
            self.factor_columns(simd, 0..p, manner.tiny, swaps, &mut scratch.upper_rows, replaced);
        } else {
            self.factor_block(simd, 0..p, manner, swaps, scratch, replaced);
            self.gather_rows(0..p, scratch);
        }
        if u == 0 {
            return;
        }
        self.swap_upper(swaps, 0..p);
        let diagonal = &*self.diagonal;
        tiles!(i in 0, u; M => {
            solve_strip::<S, M, false, false>(simd, &mut self.lower[i..], u, diagonal, p, p, &scratch.upper_rows);
            solve_strip::<S, M, true, true>(simd, &mut self.upper[i..], u, diagonal, p, p, &[]);
        });
        for j in (0..u).step_by(WIDTH) {
            let column = &mut self.rest[j * u..];
            tiles!(i in 0, u; M => {
                let right = self.upper[j..].chunks(u).take(self.pivots).map(four);
                let mut tile = outer_products::<S, M>(simd, &self.lower[i..], u, right);
                subtract_from(simd, &column[i..], u, &mut tile);
                store::<S, M>(&tile, &mut column[i..], u);
            });
        }
    }

    /// Exchanges columns to the right of the pivot block according to the row exchanges `swaps` of a block of pivots.
    fn swap_upper(&mut self, swaps: &[u32], block: Range<usize>) {
        let u = self.u;
        for k in block.start..block.end.min(self.pivots) {
            let other = swaps[k] as usize;
            if other != k {
                let (left, right) = self.upper.split_at_mut(other * u);
                left[k * u..][..u].swap_with_slice(&mut right[..u]);
            }
        }
    }

    /// Copies the factors of a diagonal block for triangular solves of strips.
    fn gather_rows(&self, block: Range<usize>, scratch: &mut Scratch) {
        let (p, from) = (self.p, block.start);
        scratch.upper_rows.clear();
        scratch.lower_rows.clear();
        for j in block.step_by(WIDTH) {
            let columns: [&[f64]; WIDTH] = std::array::from_fn(|c| &self.diagonal[(j + c) * p + from..][..j - from]);
            scratch.upper_rows.extend((0..j - from).map(|k| columns.map(|column| column[k])));
            scratch.lower_rows.extend(self.diagonal[from * p + j..].chunks(p).take(j - from).map(|row| *four(row)));
        }
    }

    /// Eliminates a factored block of pivots from the adjacent rows and columns and from the remaining front.
    fn eliminate_block(&mut self, block: Range<usize>, manner: &EliminationOptions, scratch: &mut Scratch) {
        let (p, u, workers, Range { start: from, end: to }) = (self.p, self.u, manner.workers, block.clone());
        let (depth, pivots) = (to - from, self.pivots.min(to) - from);
        self.gather_rows(block, scratch);
        let Scratch { upper_rows, lower_rows, lower, upper, below, right } = scratch;
        let (left, columns) = self.diagonal.split_at_mut(to * p);
        let left = &left[from * p..];
        pack_rows(left, p, to, below);
        workers.for_each_part(columns, STRIP * p, |_, columns| with_registers(SolvePanel { left, columns, p, from, to }));
        pack_columns(columns, p, from..to, right);
        subtract(columns, p, to, below, right, depth, depth, manner);
        let diagonal = &left[from..];
        for (strips, source, rows, is_unit) in
            [(&mut *lower, &*self.lower, &*upper_rows, false), (&mut *upper, &*self.upper, &*lower_rows, true)]
        {
            if strips.len() < u * depth {
                strips.resize(u * depth, 0.0);
            }
            workers.for_each_part(&mut strips[..u * depth], STRIP * depth, |s, out| {
                if !(manner.stopped)() {
                    let source = &source[from * u + s * STRIP..];
                    match is_unit {
                        false => with_registers(SolveStrip::<false> { source, stride: u, diagonal, p, depth, rows, out }),
                        true => with_registers(SolveStrip::<true> { source, stride: u, diagonal, p, depth, rows, out }),
                    }
                }
            });
        }
        let (lower, upper) = (&lower[..u * depth], &upper[..u * depth]);
        for (strips, columns, other) in [(lower, &mut *self.lower, &*right), (upper, &mut *self.upper, &*below)] {
            unpack(strips, &mut columns[from * u..to * u], u, workers);
            subtract(&mut columns[to * u..], u, 0, strips, other, depth, depth, manner);
        }
        subtract(self.rest, u, 0, lower, upper, depth, pivots, manner);
    }
}

/// Copies strips of rows back into the columns.
fn unpack(strips: &[f64], columns: &mut [f64], u: usize, workers: &Workers) {
    let depth = columns.len() / u.max(1);
    workers.for_each_part(columns, (PANEL * u).max(1), |first, columns| {
        for (k, column) in columns.chunks_exact_mut(u).enumerate() {
            for (strip, rows) in strips.chunks(STRIP * depth).zip(column.chunks_mut(STRIP)) {
                rows.copy_from_slice(&strip[(first * PANEL + k) * rows.len()..][..rows.len()]);
            }
        }
    });
}

/// Subtracts the product of row strips and column strips from columns of length `stride`, below row `first`; only the leading `count` of
/// `depth` terms are nonzero.
#[expect(clippy::too_many_arguments, reason = "two operands, a result and their sizes")]
fn subtract(
    columns: &mut [f64],
    stride: usize,
    first: usize,
    rows: &[f64],
    right: &[f64],
    depth: usize,
    count: usize,
    manner: &EliminationOptions,
) {
    manner.workers.for_each_part(columns, (COLUMNS * stride).max(1), |j, columns| {
        if !(manner.stopped)() {
            let right = &right[j * COLUMNS * depth..];
            with_registers(SubtractProducts { rows, right, columns, stride, first, depth, count });
        }
    });
}
