//! Blocks of a front, and LU of columns of its pivot block.
//!
//! All blocks are column-major, their sides padded to multiples of four by zeros (the pivot block by the identity), so that every loop runs
//! over whole tiles ([`super::tiles`]).
//!
//! Pivots are sought inside the pivot block only (threshold pivoting, the diagonal preferred): the structure found beforehand stays valid.

use std::ops::Range;

use pulp::Simd;

use super::strips::{PANEL, STRIP, UpdatePanel, pack_rows, substitute_four};
use super::tiles::{WIDTH, outer_products, store, subtract_from, tiles};
use crate::math::simd::with_registers;
use crate::math::tolerances::LINEAR_REPLACEMENT;
use crate::math::workers::Workers;

/// Ratio of the diagonal entry to the largest entry below it from which the diagonal entry is the pivot.
const THRESHOLD: f64 = 0.01;

/// Blocks of one front: `pivots` eliminated unknowns and `update` remaining ones.
pub(super) struct Blocks<'a> {
    /// Number of pivots.
    pub(super) pivots: usize,
    /// Padded number of pivots and of remaining unknowns.
    pub(super) p: usize,
    pub(super) u: usize,
    /// Pivot block, `p x p`; becomes the unit lower factor and the upper factor with the reciprocals of the pivots.
    pub(super) diagonal: &'a mut [f64],
    /// Rows below the pivot block, `u x p`.
    pub(super) lower: &'a mut [f64],
    /// Columns to the right of the pivot block, transposed, `u x p`.
    pub(super) upper: &'a mut [f64],
    /// Remaining block of the non-pivot unknowns, `u x u`, which becomes the update matrix (Schur complement).
    pub(super) rest: &'a mut [f64],
}

/// Buffers for copies of frequently read factors.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Four columns of the upper factor above each diagonal 4 x 4 block, stored by rows.
    pub(super) upper_rows: Vec<[f64; WIDTH]>,
    /// Four rows of the lower factor beside each diagonal 4 x 4 block.
    pub(super) lower_rows: Vec<[f64; WIDTH]>,
    /// Strips of the rows below the pivot block.
    pub(super) lower: Vec<f64>,
    /// Strips of the columns to the right of the pivot block.
    pub(super) upper: Vec<f64>,
    /// Strips of the rows inside the pivot block.
    pub(super) below: Vec<f64>,
    /// Strips of the columns inside the pivot block.
    pub(super) right: Vec<f64>,
}

/// Parameters of an elimination.
pub(super) struct EliminationOptions<'a> {
    /// Pivots smaller than this are replaced.
    pub(super) tiny: f64,
    pub(super) workers: &'a Workers,
    /// Returns true if the elimination is to be abandoned.
    pub(super) stopped: &'a (dyn Fn() -> bool + Sync),
}

impl Blocks<'_> {
    /// LU of a block of columns whose rows above the block are complete: panel by panel, each followed by the update of the columns behind
    /// it.
    #[inline(always)]
    pub(super) fn factor_block<S: Simd>(
        &mut self,
        simd: S,
        block: Range<usize>,
        manner: &EliminationOptions,
        swaps: &mut [u32],
        scratch: &mut Scratch,
        replaced: &mut impl FnMut(usize),
    ) {
        for from in block.clone().step_by(PANEL) {
            let to = (from + PANEL).min(block.end);
            self.factor_columns(simd, from..to, manner.tiny, swaps, &mut scratch.upper_rows, replaced);
            if to < block.end && !(manner.stopped)() {
                self.update_panels(from..to, block.end, manner.workers, &mut scratch.below);
            }
        }
    }

    /// Updates the columns of the pivot block to the right of a factored panel, up to column `end`.
    fn update_panels(&mut self, panel: Range<usize>, end: usize, workers: &Workers, strips: &mut Vec<f64>) {
        let (p, Range { start: from, end: to }) = (self.p, panel);
        let (left, right) = self.diagonal[..end * p].split_at_mut(to * p);
        let left = &left[from * p..];
        pack_rows(left, p, to, strips);
        let strips = &*strips;
        workers.for_each_part(right, STRIP * p, |_, columns| with_registers(UpdatePanel { left, strips, columns, p, from, to }));
    }

    /// LU of some columns of the pivot block, four at a time, each updated by the columns to its left from column `from` on.
    #[inline(always)]
    pub(super) fn factor_columns<S: Simd>(
        &mut self,
        simd: S,
        columns: Range<usize>,
        tiny: f64,
        swaps: &mut [u32],
        all_rows: &mut Vec<[f64; WIDTH]>,
        replaced: &mut impl FnMut(usize),
    ) {
        let (p, from) = (self.p, columns.start);
        all_rows.clear();
        for j in columns.step_by(WIDTH) {
            let (left, panel) = self.diagonal.split_at_mut(j * p);
            let left = &left[from * p..];
            let start = all_rows.len();
            for i in (from..j).step_by(WIDTH) {
                let rows = substitute_four(simd, left, p, from, i, all_rows[start..].iter(), panel);
                all_rows.extend(rows);
            }
            let rows = &all_rows[start..];
            if j > from {
                tiles!(i in j, p; M => {
                    let mut tile = outer_products::<S, M>(simd, &left[i..], p, rows.iter());
                    subtract_from(simd, &panel[i..], p, &mut tile);
                    store::<S, M>(&tile, &mut panel[i..], p);
                });
            }
            self.factor_panel(simd, j, tiny, swaps, replaced);
        }
    }

    /// LU with pivoting of four columns that earlier pivots have already updated.
    #[inline(always)]
    fn factor_panel<S: Simd>(&mut self, simd: S, j: usize, tiny: f64, swaps: &mut [u32], replaced: &mut impl FnMut(usize)) {
        let p = self.p;
        for c in 0..WIDTH.min(self.pivots - j) {
            let k = j + c;
            let column = &self.diagonal[k * p..][..p];
            let largest = largest(&column[k + 1..]);
            let mut chosen = k;
            if column[k].abs() < THRESHOLD * largest {
                chosen = (k + 1..p).find(|&i| column[i].abs() == largest).unwrap_or(k);
                for column in self.diagonal.chunks_exact_mut(p) {
                    column.swap(k, chosen);
                }
            }
            swaps[k] = chosen as u32;
            let (done, rest) = self.diagonal.split_at_mut((k + 1) * p);
            let (inside, below) = done[k * p + j..].split_at_mut(WIDTH);
            if inside[c].is_nan() || inside[c].abs() < tiny {
                inside[c] = LINEAR_REPLACEMENT.copysign(inside[c]);
                replaced(k);
            }
            let reciprocal = 1.0 / inside[c];
            inside[c] = reciprocal;
            for x in &mut inside[c + 1..] {
                *x *= reciprocal;
            }
            let below = S::as_mut_simd_f64s(below).0;
            let factor = simd.splat_f64s(reciprocal);
            for x in below.iter_mut() {
                *x = simd.mul_f64s(*x, factor);
            }
            for other in rest.chunks_exact_mut(p).take(WIDTH - 1 - c) {
                let (other_inside, other_below) = other[j..].split_at_mut(WIDTH);
                let factor = other_inside[c];
                for r in c + 1..WIDTH {
                    other_inside[r] -= factor * inside[r];
                }
                let factor = simd.splat_f64s(-factor);
                for (x, l) in S::as_mut_simd_f64s(other_below).0.iter_mut().zip(&*below) {
                    *x = simd.mul_add_e_f64s(factor, *l, *x);
                }
            }
        }
    }
}

/// Largest absolute value.
#[inline(always)]
fn largest(x: &[f64]) -> f64 {
    let larger = |a: f64, b: f64| if a.abs() > b { a.abs() } else { b };
    let (groups, rest) = x.as_chunks::<WIDTH>();
    let mut lanes = [0.0; WIDTH];
    for group in groups {
        for l in 0..WIDTH {
            lanes[l] = larger(group[l], lanes[l]);
        }
    }
    lanes.iter().chain(rest).fold(0.0, |a, b| larger(*b, a))
}
