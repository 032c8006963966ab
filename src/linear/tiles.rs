//! Register tiles of a matrix: 8 or 4 rows by 4 columns, summed from outer products of contiguous columns.
//!
//! Eight of sixteen registers hold a tile; with twelve, some registers would spill to memory.

use pulp::Simd;
use pulp::bytemuck::cast;

/// Width of a tile; the sides of all blocks are multiples of it.
pub(super) const WIDTH: usize = 4;

/// The next multiple of [`WIDTH`].
pub(super) const fn padded(x: usize) -> usize {
    x.next_multiple_of(WIDTH)
}

/// `4 * M` rows by four columns, column by column.
pub(super) type Tile<S, const M: usize> = [[<S as Simd>::f64s; M]; WIDTH];

/// Leading [`WIDTH`] entries.
#[inline(always)]
pub(super) fn four(x: &[f64]) -> &[f64; WIDTH] {
    x.first_chunk().expect("sides are multiples of four")
}

/// Four numbers in a register.
#[inline(always)]
pub(super) fn load<S: Simd>(x: &[f64; WIDTH]) -> S::f64s {
    cast(*x)
}

/// The leading `4 * M` entries.
#[inline(always)]
pub(super) fn load_rows<S: Simd, const M: usize>(x: &[f64]) -> [S::f64s; M] {
    let x: &[[f64; WIDTH]; M] = x.as_chunks().0.first_chunk().expect("sides are multiples of four");
    let mut rows = [load::<S>(&x[0]); M];
    for i in 1..M {
        rows[i] = load::<S>(&x[i]);
    }
    rows
}

/// `sum_k a_k b_k^T` with `a_k` the leading rows of the columns of `a`.
#[inline(always)]
pub(super) fn outer_products<'b, S: Simd, const M: usize>(
    simd: S,
    a: &[f64],
    stride: usize,
    b: impl Iterator<Item = &'b [f64; WIDTH]>,
) -> Tile<S, M> {
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

/// Subtraction `c - tile`, stored in `tile`.
#[inline(always)]
pub(super) fn subtract_from<S: Simd, const M: usize>(simd: S, c: &[f64], stride: usize, tile: &mut Tile<S, M>) {
    for j in 0..WIDTH {
        let column = load_rows::<S, M>(&c[j * stride..]);
        for i in 0..M {
            tile[j][i] = simd.sub_f64s(column[i], tile[j][i]);
        }
    }
}

#[inline(always)]
pub(super) fn store<S: Simd, const M: usize>(tile: &Tile<S, M>, c: &mut [f64], stride: usize) {
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

pub(super) use tiles;
