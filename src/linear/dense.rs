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

/// `sum_k a_k b_k^T` with `a_k` the leading rows of the columns of `a`.
#[inline(always)]
fn outer_products<const FMA: bool, const M: usize>(a: &[f64], stride: usize, b: impl Iterator<Item = [f64; WIDTH]>) -> Tile<M> {
    let mut sum = [[[0.0; WIDTH]; M]; WIDTH];
    for (b, a) in b.zip(a.chunks(stride)) {
        let Some(a) = a.as_chunks::<WIDTH>().0.first_chunk::<M>() else { break };
        for j in 0..WIDTH {
            for i in 0..M {
                for l in 0..WIDTH {
                    sum[j][i][l] = multiply_add::<FMA>(a[i][l], b[j], sum[j][i][l]);
                }
            }
        }
    }
    sum
}

/// The tile whose first entry is the first of `c`.
#[inline(always)]
fn load<const M: usize>(c: &[f64], stride: usize) -> Tile<M> {
    std::array::from_fn(|j| {
        let column: &[f64] = &c[j * stride..][..M * WIDTH];
        std::array::from_fn(|i| std::array::from_fn(|l| column[i * WIDTH + l]))
    })
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

#[inline(always)]
fn subtract<const M: usize>(mut tile: Tile<M>, sum: &Tile<M>) -> Tile<M> {
    for j in 0..WIDTH {
        for i in 0..M {
            for l in 0..WIDTH {
                tile[j][i][l] -= sum[j][i][l];
            }
        }
    }
    tile
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
fn four(x: &[f64]) -> [f64; WIDTH] {
    std::array::from_fn(|l| x[l])
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
        for (k, &other) in swaps.iter().enumerate() {
            if other as usize != k {
                let (left, right) = self.upper.split_at_mut(other as usize * self.u);
                left[k * self.u..][..self.u].swap_with_slice(&mut right[..self.u]);
            }
        }
        let (p, u, diagonal) = (self.p, self.u, &*self.diagonal);
        tiles!(i in 0, u; M => {
            solve_strip::<FMA, M, false>(&mut self.lower[i..], u, diagonal, p);
            solve_strip::<FMA, M, true>(&mut self.upper[i..], u, diagonal, p);
        });
        for j in (0..u).step_by(WIDTH) {
            let column = &mut self.rest[j * u..];
            tiles!(i in 0, u; M => {
                let right = self.upper[j..].chunks(u).take(self.pivots).map(four);
                let sum = outer_products::<FMA, M>(&self.lower[i..], u, right);
                store(&subtract(load::<M>(&column[i..], u), &sum), &mut column[i..], u);
            });
        }
    }

    /// LU of the pivot block, four columns at a time, each brought up to date with all columns to its left.
    #[inline(always)]
    fn factor_diagonal<const FMA: bool>(
        &mut self,
        tiny: f64,
        swaps: &mut [u32],
        rows: &mut Vec<[f64; WIDTH]>,
        replaced: &mut impl FnMut(usize),
    ) {
        let (p, pivots) = (self.p, self.pivots);
        for j in (0..p).step_by(WIDTH) {
            let (left, panel) = self.diagonal.split_at_mut(j * p);
            // Rows of the upper factor, kept in `rows`.
            rows.clear();
            for i in (0..j).step_by(WIDTH) {
                let sum = outer_products::<FMA, 1>(&left[i..], p, rows.iter().copied());
                let mut tile = subtract(load::<1>(&panel[i..], p), &sum);
                for c in 0..WIDTH {
                    let factors = four(&left[(i + c) * p + i..]);
                    for k in 0..WIDTH {
                        for r in c + 1..WIDTH {
                            tile[k][0][r] -= factors[r] * tile[k][0][c];
                        }
                    }
                }
                store(&tile, &mut panel[i..], p);
                rows.extend((0..WIDTH).map(|r| std::array::from_fn(|k| tile[k][0][r])));
            }
            if j > 0 {
                tiles!(i in j, p; M => {
                    let sum = outer_products::<FMA, M>(&left[i..], p, rows.iter().copied());
                    store(&subtract(load::<M>(&panel[i..], p), &sum), &mut panel[i..], p);
                });
            }
            for k in j..j + WIDTH {
                if k >= pivots {
                    break;
                }
                let column = &self.diagonal[k * p..][..pivots];
                let mut chosen = k;
                let mut largest = column[k].abs() / THRESHOLD;
                for (i, x) in column.iter().enumerate().skip(k + 1) {
                    if x.abs() > largest {
                        largest = x.abs();
                        chosen = i;
                    }
                }
                swaps[k] = chosen as u32;
                if chosen != k {
                    for column in self.diagonal.chunks_exact_mut(p) {
                        column.swap(k, chosen);
                    }
                }
                let (done, rest) = self.diagonal.split_at_mut((k + 1) * p);
                let column = &mut done[k * p..];
                if column[k].is_nan() || column[k].abs() < tiny {
                    column[k] = REPLACEMENT.copysign(column[k]);
                    replaced(k);
                }
                let reciprocal = 1.0 / column[k];
                column[k] = reciprocal;
                for x in &mut column[k + 1..] {
                    *x *= reciprocal;
                }
                for other in rest.chunks_exact_mut(p).take(j + WIDTH - 1 - k) {
                    let factor = other[k];
                    for (x, l) in other[k + 1..].iter_mut().zip(&column[k + 1..]) {
                        *x = multiply_add::<FMA>(-factor, *l, *x);
                    }
                }
            }
        }
    }
}

/// `X := X T^-1` for `4 * M` rows, with `T` the upper factor or (`UNIT`) the transposed lower factor of the pivot block.
#[inline(always)]
fn solve_strip<const FMA: bool, const M: usize, const UNIT: bool>(x: &mut [f64], stride: usize, diagonal: &[f64], p: usize) {
    for j in (0..p).step_by(WIDTH) {
        let (left, right) = x.split_at_mut(j * stride);
        let sum = if UNIT {
            let rows = diagonal[j..].chunks(p).take(j).map(four);
            outer_products::<FMA, M>(left, stride, rows)
        } else {
            let [a, b, c, d] = std::array::from_fn(|k| &diagonal[(j + k) * p..][..j]);
            let rows = a.iter().zip(b).zip(c).zip(d).map(|(((a, b), c), d)| [*a, *b, *c, *d]);
            outer_products::<FMA, M>(left, stride, rows)
        };
        let mut tile = subtract(load::<M>(right, stride), &sum);
        for c in 0..WIDTH {
            for b in 0..c {
                let factor = if UNIT { diagonal[(j + b) * p + j + c] } else { diagonal[(j + c) * p + j + b] };
                for i in 0..M {
                    for l in 0..WIDTH {
                        tile[c][i][l] = multiply_add::<FMA>(-factor, tile[b][i][l], tile[c][i][l]);
                    }
                }
            }
            if !UNIT {
                let reciprocal = diagonal[(j + c) * p + j + c];
                for i in 0..M {
                    for l in 0..WIDTH {
                        tile[c][i][l] *= reciprocal;
                    }
                }
            }
        }
        store(&tile, right, stride);
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
        let factors = four(&w[j..]);
        combine::<FMA>(&diagonal[j * p..], p, j + WIDTH, factors, &mut w[j + WIDTH..]);
        if u > 0 {
            combine::<FMA>(&lower[j * u..], u, 0, factors, below);
        }
    }
}

/// `target -= sum of four columns times factors`, rows from `first` on.
#[inline(always)]
fn combine<const FMA: bool>(columns: &[f64], stride: usize, first: usize, factors: [f64; WIDTH], target: &mut [f64]) {
    let [a, b, c, d] = std::array::from_fn(|k| &columns[k * stride + first..][..target.len()]);
    for ((((x, a), b), c), d) in target.iter_mut().zip(a).zip(b).zip(c).zip(d) {
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
        let factors = four(&w[j..]);
        combine::<FMA>(&diagonal[j * p..], p, 0, factors, &mut w[..j]);
    }
}
