//! Dense elimination of one front: LU of its pivot block, the two triangular solves beside it, and the update of what remains.
//!
//! All blocks are column-major, their sides padded to multiples of four by zeros (the pivot block by the identity), so that every loop runs
//! over whole tiles of 12, 8 or 4 rows by 4 columns. A tile is summed in registers from outer products of columns that stand in memory as
//! they are: nothing is packed. Plain arrays that the compiler vectorises where [`crate::math::simd`] tells it which instructions exist.
//!
//! Pivots are sought inside the pivot block only (threshold pivoting, the diagonal preferred): the structure found beforehand stays valid.

/// Sides of all blocks are multiples of this.
pub(super) const WIDTH: usize = 4;

/// A diagonal entry is the pivot unless it is smaller than this times the largest entry below it.
const THRESHOLD: f64 = 0.01;

/// What replaces a pivot that is no pivot: the root of the round-off, which weighs the change of the matrix against growth in the factors.
pub(super) const REPLACEMENT: f64 = 1e-8;

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

impl Blocks<'_> {
    /// Eliminates the pivots. `swaps[k]` becomes the row that was exchanged with row `k`; pivots smaller than `tiny` are replaced and
    /// reported. `rows` is scratch.
    #[inline(always)]
    pub(super) fn eliminate<const FMA: bool>(
        &mut self,
        tiny: f64,
        swaps: &mut [u32],
        rows: &mut Vec<[f64; WIDTH]>,
        replaced: &mut impl FnMut(usize),
    ) {
        self.factor_diagonal::<FMA>(tiny, swaps, rows, replaced);
        if self.u == 0 {
            return;
        }
        let upper_rows = &*rows;
        for (k, &other) in swaps.iter().enumerate() {
            if other as usize != k {
                let (left, right) = self.upper.split_at_mut(other as usize * self.u);
                left[k * self.u..][..self.u].swap_with_slice(&mut right[..self.u]);
            }
        }
        let (p, u, diagonal) = (self.p, self.u, &*self.diagonal);
        tiles!(i in 0, u; M => {
            solve_strip::<FMA, M, false>(&mut self.lower[i..], u, diagonal, p, upper_rows);
            solve_strip::<FMA, M, true>(&mut self.upper[i..], u, diagonal, p, upper_rows);
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

    /// LU of the pivot block, four columns at a time, each brought up to date with all columns to its left. The parts of the upper factor
    /// above its 4 x 4 blocks on the diagonal are left in `all_rows`, row by row, for one column of blocks after the other.
    #[inline(always)]
    fn factor_diagonal<const FMA: bool>(
        &mut self,
        tiny: f64,
        swaps: &mut [u32],
        all_rows: &mut Vec<[f64; WIDTH]>,
        replaced: &mut impl FnMut(usize),
    ) {
        let p = self.p;
        all_rows.clear();
        for j in (0..p).step_by(WIDTH) {
            let (left, panel) = self.diagonal.split_at_mut(j * p);
            let start = all_rows.len();
            for i in (0..j).step_by(WIDTH) {
                let mut tile = outer_products::<FMA, 1>(&left[i..], p, all_rows[start..].iter().map(|row| row.each_ref()));
                subtract_from(&panel[i..], p, &mut tile);
                for [x] in &mut tile {
                    for c in 0..WIDTH - 1 {
                        let below = four(&left[(i + c) * p + i..]);
                        let pivot = x[c];
                        for r in c + 1..WIDTH {
                            x[r] = multiply_add::<FMA>(-below[r], pivot, x[r]);
                        }
                    }
                }
                store(&tile, &mut panel[i..], p);
                for r in 0..WIDTH {
                    all_rows.push([tile[0][0][r], tile[1][0][r], tile[2][0][r], tile[3][0][r]]);
                }
            }
            let rows = &all_rows[start..];
            if j > 0 {
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

/// `X := X T^-1` for `4 * M` rows, with `T` the upper factor (whose rows are given as [`Blocks::factor_diagonal`]
/// leaves them) or (`UNIT`) the transposed lower factor of the pivot block.
#[inline(always)]
fn solve_strip<const FMA: bool, const M: usize, const UNIT: bool>(
    x: &mut [f64],
    stride: usize,
    diagonal: &[f64],
    p: usize,
    mut upper_rows: &[[f64; WIDTH]],
) {
    for j in (0..p).step_by(WIDTH) {
        let (left, right) = x.split_at_mut(j * stride);
        let mut tile = if UNIT {
            let rows = diagonal[j..].chunks(p).take(j).map(|row| four(row).each_ref());
            outer_products::<FMA, M>(left, stride, rows)
        } else {
            let (rows, later) = upper_rows.split_at(j);
            upper_rows = later;
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
