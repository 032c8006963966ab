//! Dense elimination of one front: LU of its pivot block, the two triangular solves beside it, and the update of what remains.
//!
//! All blocks are column-major, their sides padded to multiples of four by zeros (the pivot block by the identity), so that every loop runs
//! over whole tiles ([`super::tiles`]) and nothing is packed in small fronts. In large ones, where each column is on a page of its own,
//! strips of rows are copied first, the pivot block is factored in blocks of columns, and strips are shared among threads
//! ([`super::strips`]).
//!
//! Pivots are sought inside the pivot block only (threshold pivoting, the diagonal preferred): the structure found beforehand stays valid.

use std::ops::Range;

use pulp::Simd;

use super::strips::{PANEL, STRIP, SolveStrip, UpdateColumns, UpdatePanel, solve_strip, substitute_four};
use super::tiles::{WIDTH, four, outer_products, store, subtract_from, tiles};
use crate::math::simd::with_registers;
use crate::math::tolerances::LINEAR_REPLACEMENT;
use crate::math::workers::Workers;

/// A diagonal entry is the pivot unless it is smaller than this times the largest entry below it.
const THRESHOLD: f64 = 0.01;

/// Entries beside the pivot block from which on strips are copied.
const PACKED: usize = 4096;

/// One front: `pivots` eliminated unknowns and `update` that remain.
pub(super) struct Blocks<'a> {
    /// Number of pivots.
    pub(super) pivots: usize,
    /// Padded number of pivots and of the others.
    pub(super) p: usize,
    pub(super) u: usize,
    /// Pivot block, `p x p`; becomes the unit lower factor and the upper factor with the reciprocals of the pivots.
    pub(super) diagonal: &'a mut [f64],
    /// Rows below, `u x p`.
    pub(super) lower: &'a mut [f64],
    /// Columns to the right, transposed, `u x p`.
    pub(super) upper: &'a mut [f64],
    /// What remains, `u x u`.
    pub(super) rest: &'a mut [f64],
}

/// Room for copies of what is read often.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Four columns of the upper factor above each 4 x 4 block on the diagonal, row by row; four rows of the lower one likewise.
    upper_rows: Vec<[f64; WIDTH]>,
    lower_rows: Vec<[f64; WIDTH]>,
    /// Strips of the blocks beside the pivot block.
    lower: Vec<f64>,
    upper: Vec<f64>,
}

/// How an elimination runs.
pub(super) struct Manner<'a> {
    /// Pivots smaller than this are replaced.
    pub(super) tiny: f64,
    pub(super) workers: &'a Workers,
    /// Whether what is computed is of no use any more.
    pub(super) stopped: &'a (dyn Fn() -> bool + Sync),
}

impl Blocks<'_> {
    /// Eliminates the pivots. `swaps[k]` becomes the row that was exchanged with row `k`; pivots that are replaced are reported.
    #[inline(always)]
    pub(super) fn eliminate<S: Simd>(
        &mut self,
        simd: S,
        manner: &Manner,
        swaps: &mut [u32],
        scratch: &mut Scratch,
        replaced: &mut impl FnMut(usize),
    ) {
        self.factor_diagonal(simd, manner, swaps, scratch, replaced);
        if self.u == 0 {
            return;
        }
        for (k, &other) in swaps.iter().enumerate() {
            if other as usize != k {
                let (left, right) = self.upper.split_at_mut(other as usize * self.u);
                left[k * self.u..][..self.u].swap_with_slice(&mut right[..self.u]);
            }
        }
        if self.p * self.u >= PACKED {
            self.eliminate_in_strips(manner, scratch);
            return;
        }
        let (p, u, diagonal) = (self.p, self.u, &*self.diagonal);
        tiles!(i in 0, u; M => {
            solve_strip::<S, M, false, false>(simd, &mut self.lower[i..], u, diagonal, p, &scratch.upper_rows);
            solve_strip::<S, M, true, true>(simd, &mut self.upper[i..], u, diagonal, p, &[]);
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

    /// The part of a large front beside and beyond its pivot block.
    fn eliminate_in_strips(&mut self, manner: &Manner, scratch: &mut Scratch) {
        let (p, u, diagonal, workers) = (self.p, self.u, &*self.diagonal, manner.workers);
        let Scratch { upper_rows, lower_rows, lower, upper } = scratch;
        for strips in [&mut *lower, &mut *upper] {
            if strips.len() < u * p {
                strips.resize(u * p, 0.0);
            }
        }
        let (lower, upper) = (&mut lower[..u * p], &mut upper[..u * p]);
        let own = &*self.lower;
        workers.for_each_part(lower, STRIP * p, |s, out| {
            if !(manner.stopped)() {
                with_registers(SolveStrip::<false> { source: &own[s * STRIP..], stride: u, diagonal, p, rows: upper_rows, out });
            }
        });
        let own = &*self.upper;
        workers.for_each_part(upper, STRIP * p, |s, out| {
            if !(manner.stopped)() {
                with_registers(SolveStrip::<true> { source: &own[s * STRIP..], stride: u, diagonal, p, rows: lower_rows, out });
            }
        });
        for (strips, columns) in [(&*lower, &mut *self.lower), (&*upper, &mut *self.upper)] {
            workers.for_each_part(columns, PANEL * u, |first, columns| {
                for (k, column) in columns.chunks_exact_mut(u).enumerate() {
                    for (strip, rows) in strips.chunks(STRIP * p).zip(column.chunks_mut(STRIP)) {
                        rows.copy_from_slice(&strip[(first * PANEL + k) * rows.len()..][..rows.len()]);
                    }
                }
            });
        }
        let (lower, upper, pivots) = (&*lower, &*upper, self.pivots);
        workers.for_each_part(self.rest, STRIP * u, |j, columns| {
            if !(manner.stopped)() {
                let right = &upper[j * STRIP * p..];
                with_registers(UpdateColumns { lower, right, columns, p, u, pivots });
            }
        });
    }

    /// LU of the pivot block. The parts of the upper factor above its 4 x 4 blocks on the diagonal are left in `upper_rows`, row by row,
    /// for one column of blocks after the other; of a large front also the lower factor's in `lower_rows`.
    #[inline(always)]
    fn factor_diagonal<S: Simd>(
        &mut self,
        simd: S,
        manner: &Manner,
        swaps: &mut [u32],
        scratch: &mut Scratch,
        replaced: &mut impl FnMut(usize),
    ) {
        let p = self.p;
        let in_strips = p * self.u >= PACKED;
        if p <= PANEL && !in_strips {
            self.factor_columns(simd, 0..p, manner.tiny, swaps, &mut scratch.upper_rows, replaced);
            return;
        }
        for from in (0..p).step_by(PANEL) {
            let to = (from + PANEL).min(p);
            self.factor_columns(simd, from..to, manner.tiny, swaps, &mut scratch.upper_rows, replaced);
            if to < p && !(manner.stopped)() {
                self.update_right(from, to, manner.workers, &mut scratch.lower);
            }
        }
        scratch.upper_rows.clear();
        scratch.lower_rows.clear();
        for j in (0..if self.u > 0 { p } else { 0 }).step_by(WIDTH) {
            let columns: [&[f64]; WIDTH] = std::array::from_fn(|c| &self.diagonal[(j + c) * p..][..j]);
            scratch.upper_rows.extend((0..j).map(|k| columns.map(|column| column[k])));
            scratch.lower_rows.extend(self.diagonal[j..].chunks(p).take(j).map(|row| *four(row)));
        }
    }

    /// Brings the columns of the pivot block right of a factored panel up to date with it.
    fn update_right(&mut self, from: usize, to: usize, workers: &Workers, strips: &mut Vec<f64>) {
        let p = self.p;
        let (left, right) = self.diagonal.split_at_mut(to * p);
        let left = &left[from * p..];
        strips.clear();
        for start in (to..p).step_by(STRIP) {
            let rows = start..(start + STRIP).min(p);
            left.chunks_exact(p).for_each(|column| strips.extend_from_slice(&column[rows.clone()]));
        }
        let strips = &*strips;
        workers.for_each_part(right, STRIP * p, |_, columns| with_registers(UpdatePanel { left, strips, columns, p, from, to }));
    }

    /// LU of some columns of the pivot block, four at a time, each brought up to date with those to its left from column `from` on.
    #[inline(always)]
    fn factor_columns<S: Simd>(
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

    /// LU with pivoting of four columns that are up to date.
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
