//! Operations on strips: a few rows or columns of a front's blocks, which threads process independently.

use std::ops::Range;

use pulp::bytemuck::cast;
use pulp::{Simd, WithSimd};

use super::tiles::{WIDTH, four, outer_products, store, subtract_from, tiles};

/// Rows of a strip: the largest tile.
pub(super) const STRIP: usize = 2 * WIDTH;

/// Number of columns of a pivot block factored before the remaining columns are updated.
pub(super) const PANEL: usize = 64;

/// Number of terms of a sum, and of pivots per block of a large front; strips of this length fit into a fast cache.
pub(super) const DEPTH: usize = 192;

/// Number of columns updated together: their strips fit into a second-level cache.
pub(super) const COLUMNS: usize = 64;

/// Copies the rows from `first` on of some columns, strip by strip.
pub(super) fn pack_rows(columns: &[f64], height: usize, first: usize, strips: &mut Vec<f64>) {
    strips.clear();
    for start in (first..height).step_by(STRIP) {
        let rows = start..(start + STRIP).min(height);
        columns.chunks_exact(height).for_each(|column| strips.extend_from_slice(&column[rows.clone()]));
    }
}

/// Copies a range of rows of the columns, one strip of columns after another.
pub(super) fn pack_columns(columns: &[f64], height: usize, rows: Range<usize>, strips: &mut Vec<f64>) {
    strips.clear();
    for columns in columns.chunks(STRIP * height) {
        for k in rows.clone() {
            strips.extend(columns[k..].iter().step_by(height));
        }
    }
}

/// Forward substitution of rows `i..i + 4` of four columns with the unit lower factor, whose columns start at index `from`. `rows` contains
/// the solved rows above. Returns the four rows.
#[inline(always)]
pub(super) fn substitute_four<'r, S: Simd>(
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

/// Copies a strip of rows from its block and solves the copy in place ([`solve_strip`]).
pub(super) struct SolveStrip<'a, const UNIT: bool> {
    pub(super) source: &'a [f64],
    pub(super) stride: usize,
    /// Diagonal block, whose columns have length `p`.
    pub(super) diagonal: &'a [f64],
    /// Length of a column of the diagonal block.
    pub(super) p: usize,
    /// Size of the diagonal block.
    pub(super) depth: usize,
    pub(super) rows: &'a [[f64; WIDTH]],
    pub(super) out: &'a mut [f64],
}

impl<const UNIT: bool> WithSimd for SolveStrip<'_, UNIT> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let SolveStrip { source, stride, diagonal, p, depth, rows, out } = self;
        let width = out.len() / depth;
        for (column, source) in out.chunks_exact_mut(width).zip(source.chunks(stride)) {
            column.copy_from_slice(&source[..width]);
        }
        match width / WIDTH {
            1 => solve_strip::<S, 1, UNIT, false>(simd, out, WIDTH, diagonal, p, depth, rows),
            _ => solve_strip::<S, 2, UNIT, false>(simd, out, 2 * WIDTH, diagonal, p, depth, rows),
        }
    }
}

/// Subtracts the product of row strips and column strips from some columns, below row `first`.
pub(super) struct SubtractProducts<'a> {
    /// All row strips.
    pub(super) rows: &'a [f64],
    /// Strips of the columns to be updated.
    pub(super) right: &'a [f64],
    pub(super) columns: &'a mut [f64],
    pub(super) stride: usize,
    pub(super) first: usize,
    /// Length of a row of a strip.
    pub(super) depth: usize,
    /// Number of nonzero leading entries of a row of a strip.
    pub(super) count: usize,
}

impl WithSimd for SubtractProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let SubtractProducts { rows, right, columns, stride, first, depth, count } = self;
        for k in (0..count).step_by(DEPTH) {
            let terms = DEPTH.min(count - k);
            tiles!(i in 0, stride - first; M => {
                let strip = &rows[i * depth + k * M * WIDTH..];
                for (columns, right) in columns.chunks_mut(STRIP * stride).zip(right.chunks(STRIP * depth)) {
                    let width = columns.len() / stride;
                    for j in (0..width).step_by(WIDTH) {
                        let right = right[k * width + j..].chunks(width).take(terms).map(four);
                        let mut tile = outer_products::<S, M>(simd, strip, M * WIDTH, right);
                        let place = &mut columns[j * stride + first + i..];
                        subtract_from(simd, place, stride, &mut tile);
                        store::<S, M>(&tile, place, stride);
                    }
                }
            });
        }
    }
}

/// Solves some rows of four columns with the unit lower factor of a diagonal block, and stores them in `rows`.
#[inline(always)]
fn substitute<S: Simd>(simd: S, left: &[f64], p: usize, range: Range<usize>, rows: &mut [[f64; WIDTH]], columns: &mut [f64]) {
    let from = range.start;
    for i in range.step_by(WIDTH) {
        let new = substitute_four(simd, left, p, from, i, rows[..i - from].iter(), columns);
        rows[i - from..][..WIDTH].copy_from_slice(&new);
    }
}

/// Solves rows `from..to` of a few columns with the unit lower factor of a diagonal block.
pub(super) struct SolvePanel<'a> {
    /// The block's columns.
    pub(super) left: &'a [f64],
    pub(super) columns: &'a mut [f64],
    pub(super) p: usize,
    pub(super) from: usize,
    pub(super) to: usize,
}

impl WithSimd for SolvePanel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let SolvePanel { left, columns, p, from, to } = self;
        let mut rows = [[0.0; WIDTH]; DEPTH];
        for columns in columns.chunks_exact_mut(WIDTH * p) {
            substitute(simd, left, p, from..to, &mut rows, columns);
        }
    }
}

/// Updates a few columns of the pivot block by the factored panel to their left.
pub(super) struct UpdatePanel<'a> {
    /// Columns of the panel.
    pub(super) left: &'a [f64],
    /// Rows of the panel from `to` on, in strips.
    pub(super) strips: &'a [f64],
    pub(super) columns: &'a mut [f64],
    pub(super) p: usize,
    pub(super) from: usize,
    pub(super) to: usize,
}

impl WithSimd for UpdatePanel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let UpdatePanel { left, strips, columns, p, from, to } = self;
        let depth = to - from;
        let mut rows = [[0.0; WIDTH]; PANEL];
        for columns in columns.chunks_exact_mut(WIDTH * p) {
            substitute(simd, left, p, from..to, &mut rows, columns);
            tiles!(i in to, p; M => {
                let strip = &strips[(i - to) * depth..];
                let mut tile = outer_products::<S, M>(simd, strip, M * WIDTH, rows[..depth].iter());
                subtract_from(simd, &columns[i..], p, &mut tile);
                store::<S, M>(&tile, &mut columns[i..], p);
            });
        }
    }
}

/// Solves `X := X T^-1` for `4 * M` rows. `T` is the upper factor of a diagonal block, or if `UNIT` its transposed unit lower factor; it
/// has the size `depth`, columns of length `p`, and the row order of the factorization.
#[inline(always)]
pub(super) fn solve_strip<S: Simd, const M: usize, const UNIT: bool, const STRIDED: bool>(
    simd: S,
    x: &mut [f64],
    stride: usize,
    diagonal: &[f64],
    p: usize,
    depth: usize,
    mut all_rows: &[[f64; WIDTH]],
) {
    for j in (0..depth).step_by(WIDTH) {
        let (left, right) = x.split_at_mut(j * stride);
        let mut tile = if STRIDED {
            outer_products::<S, M>(simd, left, stride, diagonal[j..].chunks(p).take(j).map(four))
        } else {
            let (rows, later) = all_rows.split_at(j);
            all_rows = later;
            outer_products::<S, M>(simd, left, stride, rows.iter())
        };
        subtract_from(simd, right, stride, &mut tile);
        // Unrolled by hand, since loops would not keep the tile in registers.
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
