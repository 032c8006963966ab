//! Dense elimination of one front: LU of its pivot block, the two triangular solves beside it, and the update of what remains.
//!
//! All blocks are column-major, their sides padded to multiples of four by zeros (the pivot block by the identity), so that every loop runs
//! over whole tiles of 8 or 4 rows by 4 columns. A tile is summed in registers (eight of sixteen; with twelve some would live in memory)
//! from outer products of columns that stand in memory as they are: nothing is packed in small fronts. In large ones, where each column is
//! on a page of its own, strips of rows are copied first, the pivot block is factored in blocks of columns, and strips are shared among
//! threads: what one computes depends on no other.
//!
//! Pivots are sought inside the pivot block only (threshold pivoting, the diagonal preferred): the structure found beforehand stays valid.

use std::ops::Range;

use pulp::bytemuck::cast;
use pulp::{Simd, WithSimd};

use crate::math::simd::with_registers;
use crate::math::workers::Workers;

/// Sides of all blocks are multiples of this.
pub(super) const WIDTH: usize = 4;

/// A diagonal entry is the pivot unless it is smaller than this times the largest entry below it.
const THRESHOLD: f64 = 0.01;

/// What replaces a pivot that is no pivot: the root of the round-off, which weighs the change of the matrix against growth in the factors.
pub(super) const REPLACEMENT: f64 = 1e-8;

/// Rows of a strip: the largest tile.
const STRIP: usize = 2 * WIDTH;

/// Columns of a pivot block that are factored before the rest of it is updated.
const PANEL: usize = 64;

/// Entries beside the pivot block from which on strips are copied, and pivots that are summed over before the next strip.
const PACKED: usize = 4096;
const DEPTH: usize = 192;

/// The next multiple of [`WIDTH`].
pub(super) const fn padded(x: usize) -> usize {
    x.next_multiple_of(WIDTH)
}

/// `4 * M` rows by four columns, column by column.
type Tile<S, const M: usize> = [[<S as Simd>::f64s; M]; WIDTH];

/// Leading [`WIDTH`] entries.
#[inline(always)]
fn four(x: &[f64]) -> &[f64; WIDTH] {
    x.first_chunk().expect("sides are multiples of four")
}

/// Four numbers in a register.
#[inline(always)]
fn load<S: Simd>(x: &[f64; WIDTH]) -> S::f64s {
    cast(*x)
}

/// The leading `4 * M` entries.
#[inline(always)]
fn load_rows<S: Simd, const M: usize>(x: &[f64]) -> [S::f64s; M] {
    let x: &[[f64; WIDTH]; M] = x.as_chunks().0.first_chunk().expect("sides are multiples of four");
    let mut rows = [load::<S>(&x[0]); M];
    for i in 1..M {
        rows[i] = load::<S>(&x[i]);
    }
    rows
}

/// `sum_k a_k b_k^T` with `a_k` the leading rows of the columns of `a`.
#[inline(always)]
fn outer_products<'b, S: Simd, const M: usize>(simd: S, a: &[f64], stride: usize, b: impl Iterator<Item = &'b [f64; WIDTH]>) -> Tile<S, M> {
    let mut sum = [[simd.splat_f64s(0.0); M]; WIDTH];
    for (b, a) in b.zip(a.chunks(stride)) {
        let Some(a) = a.as_chunks().0.first_chunk::<M>() else { break };
        let mut rows = [simd.splat_f64s(0.0); M];
        for i in 0..M {
            rows[i] = load::<S>(&a[i]);
        }
        for j in 0..WIDTH {
            let b = simd.splat_f64s(b[j]);
            for i in 0..M {
                sum[j][i] = simd.mul_add_e_f64s(rows[i], b, sum[j][i]);
            }
        }
    }
    sum
}

/// Replaces `tile` by the entries whose first one is the first of `c`, less what `tile` was.
#[inline(always)]
fn subtract_from<S: Simd, const M: usize>(simd: S, c: &[f64], stride: usize, tile: &mut Tile<S, M>) {
    for j in 0..WIDTH {
        let column = load_rows::<S, M>(&c[j * stride..]);
        for i in 0..M {
            tile[j][i] = simd.sub_f64s(column[i], tile[j][i]);
        }
    }
}

#[inline(always)]
fn store<S: Simd, const M: usize>(tile: &Tile<S, M>, c: &mut [f64], stride: usize) {
    for j in 0..WIDTH {
        let column: &mut [[f64; WIDTH]; M] = c[j * stride..].as_chunks_mut().0.first_chunk_mut().expect("sides are multiples of four");
        for i in 0..M {
            column[i] = cast(tile[j][i]);
        }
    }
}

/// Calls `$body` with the number of rows in units of [`WIDTH`] as a constant `M`, for tiles that cover `$from..$to`.
macro_rules! tiles {
    ($row:ident in $from:expr, $to:expr; $m:ident => $body:expr) => {{
        let mut $row: usize = $from;
        let end: usize = $to;
        while $row < end {
            match (end - $row) / WIDTH {
                1 => {
                    const $m: usize = 1;
                    $body;
                    $row += WIDTH;
                }
                _ => {
                    const $m: usize = 2;
                    $body;
                    $row += 2 * WIDTH;
                }
            }
        }
    }};
}

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
                inside[c] = REPLACEMENT.copysign(inside[c]);
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

/// Forward substitution of the rows `i..i + 4` of four columns with the unit lower factor whose columns begin with number `from`; `rows`
/// are those above. Returns the rows.
#[inline(always)]
fn substitute_four<'r, S: Simd>(
    simd: S,
    left: &[f64],
    p: usize,
    from: usize,
    i: usize,
    rows: impl Iterator<Item = &'r [f64; WIDTH]>,
    panel: &mut [f64],
) -> [[f64; WIDTH]; WIDTH] {
    let mut tile = outer_products::<S, 1>(simd, &left[i..], p, rows);
    subtract_from(simd, &panel[i..], p, &mut tile);
    let mut columns: [[f64; WIDTH]; WIDTH] = [[0.0; WIDTH]; WIDTH];
    for (column, [x]) in columns.iter_mut().zip(tile) {
        *column = cast(x);
        for c in 0..WIDTH - 1 {
            let below = four(&left[(i - from + c) * p + i..]);
            for r in c + 1..WIDTH {
                column[r] -= below[r] * column[c];
            }
        }
    }
    for (column, target) in columns.iter().zip(panel[i..].chunks_mut(p)) {
        target[..WIDTH].copy_from_slice(column);
    }
    std::array::from_fn(|r| std::array::from_fn(|c| columns[c][r]))
}

/// Copies a strip of rows out of its block and solves it there ([`solve_strip`]).
struct SolveStrip<'a, const UNIT: bool> {
    source: &'a [f64],
    stride: usize,
    diagonal: &'a [f64],
    p: usize,
    rows: &'a [[f64; WIDTH]],
    out: &'a mut [f64],
}

impl<const UNIT: bool> WithSimd for SolveStrip<'_, UNIT> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let SolveStrip { source, stride, diagonal, p, rows, out } = self;
        let width = out.len() / p;
        for (column, source) in out.chunks_exact_mut(width).zip(source.chunks(stride)) {
            column.copy_from_slice(&source[..width]);
        }
        match width / WIDTH {
            1 => solve_strip::<S, 1, UNIT, false>(simd, out, WIDTH, diagonal, p, rows),
            _ => solve_strip::<S, 2, UNIT, false>(simd, out, 2 * WIDTH, diagonal, p, rows),
        }
    }
}

/// Subtracts `lower * right^T` from a few columns of the remainder.
struct UpdateColumns<'a> {
    /// All strips of the rows below, and those of these columns.
    lower: &'a [f64],
    right: &'a [f64],
    columns: &'a mut [f64],
    p: usize,
    u: usize,
    pivots: usize,
}

impl WithSimd for UpdateColumns<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let UpdateColumns { lower, right, columns, p, u, pivots } = self;
        let width = columns.len() / u;
        for k in (0..pivots).step_by(DEPTH) {
            let depth = DEPTH.min(pivots - k);
            let right = &right[k * width..];
            tiles!(i in 0, u; M => {
                let strip = &lower[i * p + k * M * WIDTH..];
                for j in (0..width).step_by(WIDTH) {
                    let rows = right[j..].chunks(width).take(depth).map(four);
                    let mut tile = outer_products::<S, M>(simd, strip, M * WIDTH, rows);
                    let place = &mut columns[j * u + i..];
                    subtract_from(simd, place, u, &mut tile);
                    store::<S, M>(&tile, place, u);
                }
            });
        }
    }
}

/// Brings a few columns of the pivot block up to date with a panel to their left.
struct UpdatePanel<'a> {
    /// The panel's columns, and its rows from `to` on in strips.
    left: &'a [f64],
    strips: &'a [f64],
    columns: &'a mut [f64],
    p: usize,
    from: usize,
    to: usize,
}

impl WithSimd for UpdatePanel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let UpdatePanel { left, strips, columns, p, from, to } = self;
        let depth = to - from;
        let mut rows = [[0.0; WIDTH]; PANEL];
        for columns in columns.chunks_exact_mut(WIDTH * p) {
            for i in (from..to).step_by(WIDTH) {
                let new = substitute_four(simd, left, p, from, i, rows[..i - from].iter(), columns);
                rows[i - from..][..WIDTH].copy_from_slice(&new);
            }
            tiles!(i in to, p; M => {
                let strip = &strips[(i - to) * depth..];
                let mut tile = outer_products::<S, M>(simd, strip, M * WIDTH, rows[..depth].iter());
                subtract_from(simd, &columns[i..], p, &mut tile);
                store::<S, M>(&tile, &mut columns[i..], p);
            });
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

/// `X := X T^-1` for `4 * M` rows, with `T` the upper factor or (`UNIT`) the transposed lower factor of the pivot block, whose rows are
/// given as [`Blocks::factor_diagonal`] leaves them.
#[inline(always)]
fn solve_strip<S: Simd, const M: usize, const UNIT: bool, const STRIDED: bool>(
    simd: S,
    x: &mut [f64],
    stride: usize,
    diagonal: &[f64],
    p: usize,
    mut all_rows: &[[f64; WIDTH]],
) {
    for j in (0..p).step_by(WIDTH) {
        let (left, right) = x.split_at_mut(j * stride);
        let mut tile = if STRIDED {
            outer_products::<S, M>(simd, left, stride, diagonal[j..].chunks(p).take(j).map(four))
        } else {
            let (rows, later) = all_rows.split_at(j);
            all_rows = later;
            outer_products::<S, M>(simd, left, stride, rows.iter())
        };
        subtract_from(simd, right, stride, &mut tile);
        // Written out, not in loops: only so does the tile stay in registers.
        let t = |row: usize, column: usize| if UNIT { diagonal[(j + row) * p + j + column] } else { diagonal[(j + column) * p + j + row] };
        let [mut x_0, mut x_1, mut x_2, mut x_3] = tile;
        if !UNIT {
            scale(simd, &mut x_0, t(0, 0));
        }
        eliminate::<S, M>(simd, &mut x_1, &x_0, t(0, 1));
        eliminate::<S, M>(simd, &mut x_2, &x_0, t(0, 2));
        eliminate::<S, M>(simd, &mut x_3, &x_0, t(0, 3));
        if !UNIT {
            scale(simd, &mut x_1, t(1, 1));
        }
        eliminate::<S, M>(simd, &mut x_2, &x_1, t(1, 2));
        eliminate::<S, M>(simd, &mut x_3, &x_1, t(1, 3));
        if !UNIT {
            scale(simd, &mut x_2, t(2, 2));
        }
        eliminate::<S, M>(simd, &mut x_3, &x_2, t(2, 3));
        if !UNIT {
            scale(simd, &mut x_3, t(3, 3));
        }
        store::<S, M>(&[x_0, x_1, x_2, x_3], right, stride);
    }
}

/// `x *= factor`.
#[inline(always)]
fn scale<S: Simd, const M: usize>(simd: S, x: &mut [S::f64s; M], factor: f64) {
    let factor = simd.splat_f64s(factor);
    for x in x {
        *x = simd.mul_f64s(*x, factor);
    }
}

/// `x -= factor * y`.
#[inline(always)]
fn eliminate<S: Simd, const M: usize>(simd: S, x: &mut [S::f64s; M], y: &[S::f64s; M], factor: f64) {
    let factor = simd.splat_f64s(-factor);
    for (x, y) in x.iter_mut().zip(y) {
        *x = simd.mul_add_e_f64s(factor, *y, *x);
    }
}

/// `w := L^-1 w` for the pivot block, then `below -= L_21 w`.
#[inline(always)]
pub(super) fn substitute_lower<S: Simd>(simd: S, diagonal: &[f64], lower: &[f64], w: &mut [f64], below: &mut [f64]) {
    let (p, u) = (w.len(), below.len());
    for j in (0..p).step_by(WIDTH) {
        for c in 0..WIDTH {
            for r in c + 1..WIDTH {
                w[j + r] -= diagonal[(j + c) * p + j + r] * w[j + c];
            }
        }
        let factors = *four(&w[j..]);
        combine(simd, &diagonal[j * p..], p, j + WIDTH, factors, &mut w[j + WIDTH..]);
        if u > 0 {
            combine(simd, &lower[j * u..], u, 0, factors, below);
        }
    }
}

/// `target -= sum of four columns times factors`, rows from `first` on.
#[inline(always)]
fn combine<S: Simd>(simd: S, columns: &[f64], stride: usize, first: usize, factors: [f64; WIDTH], target: &mut [f64]) {
    let length = target.len();
    let column = |k: usize| S::as_simd_f64s(&columns[k * stride + first..][..length]).0;
    let (a, b, c, d) = (column(0), column(1), column(2), column(3));
    let factor = |k: usize| simd.splat_f64s(-factors[k]);
    let factors = [factor(0), factor(1), factor(2), factor(3)];
    for ((((x, a), b), c), d) in S::as_mut_simd_f64s(target).0.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        let mut sum = simd.mul_add_e_f64s(factors[0], *a, *x);
        sum = simd.mul_add_e_f64s(factors[1], *b, sum);
        sum = simd.mul_add_e_f64s(factors[2], *c, sum);
        *x = simd.mul_add_e_f64s(factors[3], *d, sum);
    }
}

/// `w := U^-1 (w - U_12 right)` for the pivot block.
#[inline(always)]
pub(super) fn substitute_upper<S: Simd>(simd: S, diagonal: &[f64], upper: &[f64], w: &mut [f64], right: &[f64]) {
    let (p, u) = (w.len(), right.len());
    if u > 0 {
        let right = S::as_simd_f64s(right).0;
        for (w, columns) in w.chunks_exact_mut(WIDTH).zip(upper.chunks_exact(WIDTH * u)) {
            let column = |k: usize| S::as_simd_f64s(&columns[k * u..][..u]).0;
            let (a, b, c, d) = (column(0), column(1), column(2), column(3));
            let mut sums = [simd.splat_f64s(0.0); WIDTH];
            for ((((x, a), b), c), d) in right.iter().zip(a).zip(b).zip(c).zip(d) {
                sums[0] = simd.mul_add_e_f64s(*a, *x, sums[0]);
                sums[1] = simd.mul_add_e_f64s(*b, *x, sums[1]);
                sums[2] = simd.mul_add_e_f64s(*c, *x, sums[2]);
                sums[3] = simd.mul_add_e_f64s(*d, *x, sums[3]);
            }
            for (w, sum) in w.iter_mut().zip(sums) {
                *w -= simd.reduce_sum_f64s(sum);
            }
        }
    }
    for j in (0..p).step_by(WIDTH).rev() {
        for c in (0..WIDTH).rev() {
            w[j + c] *= diagonal[(j + c) * p + j + c];
            for r in 0..c {
                w[j + r] -= diagonal[(j + c) * p + j + r] * w[j + c];
            }
        }
        let factors = *four(&w[j..]);
        combine(simd, &diagonal[j * p..], p, 0, factors, &mut w[..j]);
    }
}
