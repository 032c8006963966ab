//! Dense elimination of one front: LU of its pivot block, the two triangular solves beside it, and the update of what remains.
//!
//! All blocks are column-major, their sides padded to multiples of four by zeros (the pivot block by the identity), so that every loop runs
//! over whole tiles of 12, 8 or 4 rows by 4 columns. A tile is summed in registers from outer products of columns that stand in memory as
//! they are: nothing is packed in small fronts. In large ones, where each column is on a page of its own, strips of rows are copied first,
//! the pivot block is factored in blocks of columns, and strips are shared among threads: what one computes depends on no other. Plain
//! arrays that the compiler vectorises where [`crate::math::simd`] tells it which instructions exist.
//!
//! Pivots are sought inside the pivot block only (threshold pivoting, the diagonal preferred): the structure found beforehand stays valid.

use crate::math::simd::{Kernel, dispatch};
use crate::math::workers::Workers;

/// Sides of all blocks are multiples of this.
pub(super) const WIDTH: usize = 4;

/// A diagonal entry is the pivot unless it is smaller than this times the largest entry below it.
const THRESHOLD: f64 = 0.01;

/// What replaces a pivot that is no pivot: the root of the round-off, which weighs the change of the matrix against growth in the factors.
pub(super) const REPLACEMENT: f64 = 1e-8;

/// Rows of a strip: the largest tile.
const STRIP: usize = 3 * WIDTH;

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
type Tile<const M: usize> = [[[f64; WIDTH]; M]; WIDTH];

#[inline(always)]
fn multiply_add<const FMA: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

/// `sum_k a_k b_k^T` with `a_k` the leading rows of the columns of `a`. The entries of `b_k` come by reference, so that each is read when
/// it is multiplied: four in registers at once would push a part of the tile out of them.
#[inline(always)]
fn outer_products<'b, const FMA: bool, const M: usize>(a: &[f64], stride: usize, b: impl Iterator<Item = [&'b f64; WIDTH]>) -> Tile<M> {
    let mut sum = [[[0.0; WIDTH]; M]; WIDTH];
    for (b, a) in b.zip(a.chunks(stride)) {
        let Some(a) = a.as_chunks::<WIDTH>().0.first_chunk::<M>() else { break };
        for j in 0..WIDTH {
            let b = *b[j];
            for i in 0..M {
                for l in 0..WIDTH {
                    sum[j][i][l] = multiply_add::<FMA>(a[i][l], b, sum[j][i][l]);
                }
            }
        }
    }
    sum
}

/// Replaces `tile` by the entries whose first one is the first of `c`, less what `tile` was.
#[inline(always)]
fn subtract_from<const M: usize>(c: &[f64], stride: usize, tile: &mut Tile<M>) {
    for j in 0..WIDTH {
        let column = &c[j * stride..][..M * WIDTH];
        for i in 0..M {
            for l in 0..WIDTH {
                tile[j][i][l] = column[i * WIDTH + l] - tile[j][i][l];
            }
        }
    }
}

#[inline(always)]
fn store<const M: usize>(tile: &Tile<M>, c: &mut [f64], stride: usize) {
    for j in 0..WIDTH {
        let column = &mut c[j * stride..][..M * WIDTH];
        for i in 0..M {
            for l in 0..WIDTH {
                column[i * WIDTH + l] = tile[j][i][l];
            }
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
                2 => {
                    const $m: usize = 2;
                    $body;
                    $row += 2 * WIDTH;
                }
                _ => {
                    const $m: usize = 3;
                    $body;
                    $row += 3 * WIDTH;
                }
            }
        }
    }};
}

/// Leading [`WIDTH`] entries.
#[inline(always)]
fn four(x: &[f64]) -> &[f64; WIDTH] {
    x.first_chunk().expect("sides are multiples of four")
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
    pub(super) fn eliminate<const FMA: bool>(
        &mut self,
        manner: &Manner,
        swaps: &mut [u32],
        scratch: &mut Scratch,
        replaced: &mut impl FnMut(usize),
    ) {
        self.factor_diagonal::<FMA>(manner, swaps, scratch, replaced);
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
            solve_strip::<FMA, M, false, false>(&mut self.lower[i..], u, diagonal, p, &scratch.upper_rows);
            solve_strip::<FMA, M, true, true>(&mut self.upper[i..], u, diagonal, p, &[]);
        });
        for j in (0..u).step_by(WIDTH) {
            let column = &mut self.rest[j * u..];
            tiles!(i in 0, u; M => {
                let right = self.upper[j..].chunks(u).take(self.pivots).map(|row| four(row).each_ref());
                let mut tile = outer_products::<FMA, M>(&self.lower[i..], u, right);
                subtract_from(&column[i..], u, &mut tile);
                store(&tile, &mut column[i..], u);
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
                dispatch(SolveStrip::<false> { source: &own[s * STRIP..], stride: u, diagonal, p, rows: upper_rows, out });
            }
        });
        let own = &*self.upper;
        workers.for_each_part(upper, STRIP * p, |s, out| {
            if !(manner.stopped)() {
                dispatch(SolveStrip::<true> { source: &own[s * STRIP..], stride: u, diagonal, p, rows: lower_rows, out });
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
                dispatch(UpdateColumns { lower, right, columns, p, u, pivots });
            }
        });
    }

    /// LU of the pivot block. The parts of the upper factor above its 4 x 4 blocks on the diagonal are left in `upper_rows`, row by row,
    /// for one column of blocks after the other; of a large front also the lower factor's in `lower_rows`.
    #[inline(always)]
    fn factor_diagonal<const FMA: bool>(
        &mut self,
        manner: &Manner,
        swaps: &mut [u32],
        scratch: &mut Scratch,
        replaced: &mut impl FnMut(usize),
    ) {
        let p = self.p;
        let in_strips = p * self.u >= PACKED;
        if p <= PANEL && !in_strips {
            self.factor_columns::<FMA>(0, p, manner.tiny, swaps, &mut scratch.upper_rows, replaced);
            return;
        }
        for from in (0..p).step_by(PANEL) {
            let to = (from + PANEL).min(p);
            self.factor_columns::<FMA>(from, to, manner.tiny, swaps, &mut scratch.upper_rows, replaced);
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
        workers.for_each_part(right, STRIP * p, |_, columns| dispatch(UpdatePanel { left, strips, columns, p, from, to }));
    }

    /// LU of some columns of the pivot block, four at a time, each brought up to date with those to its left from column `from` on.
    #[inline(always)]
    fn factor_columns<const FMA: bool>(
        &mut self,
        from: usize,
        to: usize,
        tiny: f64,
        swaps: &mut [u32],
        all_rows: &mut Vec<[f64; WIDTH]>,
        replaced: &mut impl FnMut(usize),
    ) {
        let p = self.p;
        all_rows.clear();
        for j in (from..to).step_by(WIDTH) {
            let (left, panel) = self.diagonal.split_at_mut(j * p);
            let left = &left[from * p..];
            let start = all_rows.len();
            for i in (from..j).step_by(WIDTH) {
                let rows = substitute_four::<FMA>(left, p, from, i, all_rows[start..].iter(), panel);
                all_rows.extend(rows);
            }
            let rows = &all_rows[start..];
            if j > from {
                tiles!(i in j, p; M => {
                    let mut tile = outer_products::<FMA, M>(&left[i..], p, rows.iter().map(|row| row.each_ref()));
                    subtract_from(&panel[i..], p, &mut tile);
                    store(&tile, &mut panel[i..], p);
                });
            }
            self.factor_panel::<FMA>(j, tiny, swaps, replaced);
        }
    }

    /// LU with pivoting of four columns that are up to date.
    #[inline(always)]
    fn factor_panel<const FMA: bool>(&mut self, j: usize, tiny: f64, swaps: &mut [u32], replaced: &mut impl FnMut(usize)) {
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
            let (below, _) = below.as_chunks_mut::<WIDTH>();
            for x in below.iter_mut() {
                for x in x {
                    *x *= reciprocal;
                }
            }
            for other in rest.chunks_exact_mut(p).take(WIDTH - 1 - c) {
                let (other_inside, other_below) = other[j..].split_at_mut(WIDTH);
                let factor = other_inside[c];
                for r in c + 1..WIDTH {
                    other_inside[r] = multiply_add::<FMA>(-factor, inside[r], other_inside[r]);
                }
                for (x, l) in other_below.as_chunks_mut::<WIDTH>().0.iter_mut().zip(&*below) {
                    for (x, l) in x.iter_mut().zip(l) {
                        *x = multiply_add::<FMA>(-factor, *l, *x);
                    }
                }
            }
        }
    }
}

/// Forward substitution of the rows `i..i + 4` of four columns with the unit lower factor whose columns begin with number `from`; `rows`
/// are those above. Returns the rows.
#[inline(always)]
fn substitute_four<'r, const FMA: bool>(
    left: &[f64],
    p: usize,
    from: usize,
    i: usize,
    rows: impl Iterator<Item = &'r [f64; WIDTH]>,
    panel: &mut [f64],
) -> [[f64; WIDTH]; WIDTH] {
    let mut tile = outer_products::<FMA, 1>(&left[i..], p, rows.map(|row| row.each_ref()));
    subtract_from(&panel[i..], p, &mut tile);
    for [x] in &mut tile {
        for c in 0..WIDTH - 1 {
            let below = four(&left[(i - from + c) * p + i..]);
            let pivot = x[c];
            for r in c + 1..WIDTH {
                x[r] = multiply_add::<FMA>(-below[r], pivot, x[r]);
            }
        }
    }
    store(&tile, &mut panel[i..], p);
    std::array::from_fn(|r| std::array::from_fn(|column| tile[column][0][r]))
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

impl<const UNIT: bool> Kernel for SolveStrip<'_, UNIT> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let SolveStrip { source, stride, diagonal, p, rows, out } = self;
        let width = out.len() / p;
        for (column, source) in out.chunks_exact_mut(width).zip(source.chunks(stride)) {
            column.copy_from_slice(&source[..width]);
        }
        match width / WIDTH {
            1 => solve_strip::<FMA, 1, UNIT, false>(out, WIDTH, diagonal, p, rows),
            2 => solve_strip::<FMA, 2, UNIT, false>(out, 2 * WIDTH, diagonal, p, rows),
            _ => solve_strip::<FMA, 3, UNIT, false>(out, 3 * WIDTH, diagonal, p, rows),
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

impl Kernel for UpdateColumns<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let UpdateColumns { lower, right, columns, p, u, pivots } = self;
        let width = columns.len() / u;
        for k in (0..pivots).step_by(DEPTH) {
            let depth = DEPTH.min(pivots - k);
            let right = &right[k * width..];
            tiles!(i in 0, u; M => {
                let strip = &lower[i * p + k * M * WIDTH..];
                for j in (0..width).step_by(WIDTH) {
                    let rows = right[j..].chunks(width).take(depth).map(|row| four(row).each_ref());
                    let mut tile = outer_products::<FMA, M>(strip, M * WIDTH, rows);
                    let place = &mut columns[j * u + i..];
                    subtract_from(place, u, &mut tile);
                    store(&tile, place, u);
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

impl Kernel for UpdatePanel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let UpdatePanel { left, strips, columns, p, from, to } = self;
        let depth = to - from;
        let mut rows = [[0.0; WIDTH]; PANEL];
        for columns in columns.chunks_exact_mut(WIDTH * p) {
            for i in (from..to).step_by(WIDTH) {
                let new = substitute_four::<FMA>(left, p, from, i, rows[..i - from].iter(), columns);
                rows[i - from..][..WIDTH].copy_from_slice(&new);
            }
            tiles!(i in to, p; M => {
                let strip = &strips[(i - to) * depth..];
                let mut tile = outer_products::<FMA, M>(strip, M * WIDTH, rows[..depth].iter().map(|row| row.each_ref()));
                subtract_from(&columns[i..], p, &mut tile);
                store(&tile, &mut columns[i..], p);
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
fn solve_strip<const FMA: bool, const M: usize, const UNIT: bool, const STRIDED: bool>(
    x: &mut [f64],
    stride: usize,
    diagonal: &[f64],
    p: usize,
    mut all_rows: &[[f64; WIDTH]],
) {
    for j in (0..p).step_by(WIDTH) {
        let (left, right) = x.split_at_mut(j * stride);
        let mut tile = if STRIDED {
            let rows = diagonal[j..].chunks(p).take(j).map(|row| four(row).each_ref());
            outer_products::<FMA, M>(left, stride, rows)
        } else {
            let (rows, later) = all_rows.split_at(j);
            all_rows = later;
            outer_products::<FMA, M>(left, stride, rows.iter().map(|row| row.each_ref()))
        };
        subtract_from(right, stride, &mut tile);
        // Written out, not in loops: only so does the tile stay in registers.
        let t = |row: usize, column: usize| if UNIT { diagonal[(j + row) * p + j + column] } else { diagonal[(j + column) * p + j + row] };
        let [mut x_0, mut x_1, mut x_2, mut x_3] = tile;
        if !UNIT {
            scale(&mut x_0, t(0, 0));
        }
        eliminate::<FMA, M>(&mut x_1, &x_0, t(0, 1));
        eliminate::<FMA, M>(&mut x_2, &x_0, t(0, 2));
        eliminate::<FMA, M>(&mut x_3, &x_0, t(0, 3));
        if !UNIT {
            scale(&mut x_1, t(1, 1));
        }
        eliminate::<FMA, M>(&mut x_2, &x_1, t(1, 2));
        eliminate::<FMA, M>(&mut x_3, &x_1, t(1, 3));
        if !UNIT {
            scale(&mut x_2, t(2, 2));
        }
        eliminate::<FMA, M>(&mut x_3, &x_2, t(2, 3));
        if !UNIT {
            scale(&mut x_3, t(3, 3));
        }
        store(&[x_0, x_1, x_2, x_3], right, stride);
    }
}

/// `x *= factor`.
#[inline(always)]
fn scale<const M: usize>(x: &mut [[f64; WIDTH]; M], factor: f64) {
    for x in x {
        for x in x {
            *x *= factor;
        }
    }
}

/// `x -= factor * y`.
#[inline(always)]
fn eliminate<const FMA: bool, const M: usize>(x: &mut [[f64; WIDTH]; M], y: &[[f64; WIDTH]; M], factor: f64) {
    for (x, y) in x.iter_mut().zip(y) {
        for (x, y) in x.iter_mut().zip(y) {
            *x = multiply_add::<FMA>(-factor, *y, *x);
        }
    }
}

/// `w := L^-1 w` for the pivot block, then `below -= L_21 w`.
#[inline(always)]
pub(super) fn substitute_lower<const FMA: bool>(diagonal: &[f64], lower: &[f64], w: &mut [f64], below: &mut [f64]) {
    let (p, u) = (w.len(), below.len());
    for j in (0..p).step_by(WIDTH) {
        for c in 0..WIDTH {
            for r in c + 1..WIDTH {
                w[j + r] -= diagonal[(j + c) * p + j + r] * w[j + c];
            }
        }
        let factors = *four(&w[j..]);
        combine::<FMA>(&diagonal[j * p..], p, j + WIDTH, factors, &mut w[j + WIDTH..]);
        if u > 0 {
            combine::<FMA>(&lower[j * u..], u, 0, factors, below);
        }
    }
}

/// `target -= sum of four columns times factors`, rows from `first` on.
#[inline(always)]
fn combine<const FMA: bool>(columns: &[f64], stride: usize, first: usize, factors: [f64; WIDTH], target: &mut [f64]) {
    let length = target.len();
    let column = |k: usize| &columns[k * stride + first..][..length];
    for ((((x, a), b), c), d) in target.iter_mut().zip(column(0)).zip(column(1)).zip(column(2)).zip(column(3)) {
        let mut sum = multiply_add::<FMA>(-factors[0], *a, *x);
        sum = multiply_add::<FMA>(-factors[1], *b, sum);
        sum = multiply_add::<FMA>(-factors[2], *c, sum);
        *x = multiply_add::<FMA>(-factors[3], *d, sum);
    }
}

/// `w := U^-1 (w - U_12 right)` for the pivot block.
#[inline(always)]
pub(super) fn substitute_upper<const FMA: bool>(diagonal: &[f64], upper: &[f64], w: &mut [f64], right: &[f64]) {
    let (p, u) = (w.len(), right.len());
    if u > 0 {
        for (w, columns) in w.chunks_exact_mut(WIDTH).zip(upper.chunks_exact(WIDTH * u)) {
            let mut sums = [[0.0; WIDTH]; WIDTH];
            for (i, x) in right.as_chunks::<WIDTH>().0.iter().enumerate() {
                for k in 0..WIDTH {
                    let column = four(&columns[k * u + i * WIDTH..]);
                    for l in 0..WIDTH {
                        sums[k][l] = multiply_add::<FMA>(column[l], x[l], sums[k][l]);
                    }
                }
            }
            for k in 0..WIDTH {
                w[k] -= (sums[k][0] + sums[k][1]) + (sums[k][2] + sums[k][3]);
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
        combine::<FMA>(&diagonal[j * p..], p, 0, factors, &mut w[..j]);
    }
}
