//! Sparse matrices of small dense blocks, stored by rows, and vectors of blocks.
//!
//! Every row of a product is summed by one thread in a fixed order, so that results do not depend on the number of threads.

use std::ops::Range;

use crate::math::simd::{Kernel, dispatch};
use crate::math::workers::Workers;

/// Number of rows that a thread takes at a time.
pub(super) const TOGETHER: usize = 512;

/// Dense block with `R` rows and `C` columns.
pub(super) type Block<const R: usize, const C: usize> = [[f64; C]; R];

/// Sparse matrix of blocks with `R` rows and `C` columns each.
#[derive(Clone, Debug)]
pub(super) struct BlockMatrix<const R: usize, const C: usize> {
    /// Range of each block row in `columns` and `blocks`.
    pub starts: Vec<usize>,
    /// Block column of every block, ascending within a row.
    pub columns: Vec<u32>,
    /// Dense blocks, row by row in the order of `columns`.
    pub blocks: Vec<Block<R, C>>,
}

impl<const R: usize, const C: usize> BlockMatrix<R, C> {
    /// Matrix without rows.
    pub fn empty() -> Self {
        BlockMatrix { starts: vec![0], columns: Vec::new(), blocks: Vec::new() }
    }

    /// Number of block rows.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Columns and blocks of a row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> (&[u32], &[Block<R, C>]) {
        let range = self.starts[row]..self.starts[row + 1];
        (&self.columns[range.clone()], &self.blocks[range])
    }

    /// Appends a row.
    pub fn push_row(&mut self, row: impl IntoIterator<Item = (u32, Block<R, C>)>) {
        for (column, block) in row {
            self.columns.push(column);
            self.blocks.push(block);
        }
        self.starts.push(self.columns.len());
    }

    /// Size in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.columns[..]) + size_of_val(&self.blocks[..])
    }

    /// `y := base + factor A x`, where `base` is given by its rows.
    pub fn multiply(&self, factor: f64, x: &[[f64; C]], base: &[[f64; R]], y: &mut [[f64; R]], workers: &Workers) {
        struct Rows<'a, const R: usize, const C: usize> {
            matrix: &'a BlockMatrix<R, C>,
            factor: f64,
            x: &'a [[f64; C]],
            base: &'a [[f64; R]],
            first: usize,
            y: &'a mut [[f64; R]],
        }
        impl<const R: usize, const C: usize> Kernel for Rows<'_, R, C> {
            type Output = ();

            #[inline(always)]
            fn run<const FMA: bool>(self) {
                for (k, y) in self.y.iter_mut().enumerate() {
                    let (columns, blocks) = self.matrix.row(self.first + k);
                    let mut sum = [[0.0; C]; R];
                    for (&column, block) in columns.iter().zip(blocks) {
                        let x = &self.x[column as usize];
                        for i in 0..R {
                            for j in 0..C {
                                sum[i][j] += block[i][j] * x[j];
                            }
                        }
                    }
                    for i in 0..R {
                        y[i] = self.base[self.first + k][i] + self.factor * sum[i].iter().sum::<f64>();
                    }
                }
            }
        }
        let mut parts: Vec<&mut [[f64; R]]> = y.chunks_mut(TOGETHER).collect();
        workers.for_each(&mut parts, 1, |part, y| {
            dispatch(Rows { matrix: self, factor, x, base, first: part * TOGETHER, y });
        });
    }

    /// Transposed matrix.
    pub fn transposed(&self, columns: usize) -> BlockMatrix<C, R> {
        let mut starts = vec![0usize; columns + 1];
        for &column in &self.columns {
            starts[column as usize + 1] += 1;
        }
        for k in 0..columns {
            starts[k + 1] += starts[k];
        }
        let mut next = starts.clone();
        let mut transposed = BlockMatrix { columns: vec![0; self.columns.len()], blocks: vec![[[0.0; R]; C]; self.columns.len()], starts };
        for row in 0..self.rows() {
            let (columns, blocks) = self.row(row);
            for (&column, block) in columns.iter().zip(blocks) {
                let place = &mut next[column as usize];
                transposed.columns[*place] = row as u32;
                transposed.blocks[*place] = transpose(block);
                *place += 1;
            }
        }
        transposed
    }
}

impl<const N: usize> BlockMatrix<N, N> {
    /// Block of the diagonal; zero if it is not stored.
    pub fn diagonal(&self, row: usize) -> Block<N, N> {
        let (columns, blocks) = self.row(row);
        columns.binary_search(&(row as u32)).map_or([[0.0; N]; N], |place| blocks[place])
    }
}

/// Transposed block.
pub(super) fn transpose<const R: usize, const C: usize>(block: &Block<R, C>) -> Block<C, R> {
    std::array::from_fn(|i| std::array::from_fn(|k| block[k][i]))
}

/// `sum += a b`.
#[inline(always)]
pub(super) fn add_product<const R: usize, const K: usize, const C: usize>(sum: &mut Block<R, C>, a: &Block<R, K>, b: &Block<K, C>) {
    for i in 0..R {
        for k in 0..K {
            for j in 0..C {
                sum[i][j] += a[i][k] * b[k][j];
            }
        }
    }
}

/// `a x`.
#[inline(always)]
pub(super) fn times<const R: usize, const C: usize>(a: &Block<R, C>, x: &[f64; C]) -> [f64; R] {
    std::array::from_fn(|i| a[i].iter().zip(x).map(|(a, x)| a * x).sum())
}

/// Square root of the sum of squares of all entries.
pub(super) fn frobenius<const R: usize, const C: usize>(block: &Block<R, C>) -> f64 {
    block.iter().flatten().map(|x| x * x).sum::<f64>().sqrt()
}

/// Inverse by elimination with row exchanges; rows and columns that are zero are left zero.
pub(super) fn inverse<const N: usize>(block: &Block<N, N>) -> Block<N, N> {
    let (mut a, mut inverse) = (*block, [[0.0; N]; N]);
    for i in 0..N {
        if a[i].iter().any(|x| *x != 0.0) {
            inverse[i][i] = 1.0;
        } else {
            a[i][i] = 1.0;
        }
    }
    for k in 0..N {
        let pivot = (k..N).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
        a.swap(k, pivot);
        inverse.swap(k, pivot);
        let factor = if a[k][k] == 0.0 { 0.0 } else { 1.0 / a[k][k] };
        for j in 0..N {
            a[k][j] *= factor;
            inverse[k][j] *= factor;
        }
        let (row, unit) = (a[k], inverse[k]);
        for i in (0..N).filter(|&i| i != k) {
            let factor = a[i][k];
            for j in 0..N {
                a[i][j] -= factor * row[j];
                inverse[i][j] -= factor * unit[j];
            }
        }
    }
    inverse
}

/// Matrix whose rows are computed in parts by several threads and concatenated in order.
pub(super) fn in_parts<const R: usize, const C: usize>(
    rows: usize,
    together: usize,
    workers: &Workers,
    work: impl Fn(Range<usize>, &mut BlockMatrix<R, C>) + Sync + Send,
) -> BlockMatrix<R, C> {
    // At most some hundred parts, because each part needs memory for all columns.
    let length = together.max(rows.div_ceil(256));
    let mut parts = vec![BlockMatrix::<R, C>::empty(); rows.div_ceil(length)];
    workers.for_each(&mut parts, 1, |k, part| work(k * length..((k + 1) * length).min(rows), part));
    let count = parts.iter().map(|part| part.blocks.len()).sum();
    let mut matrix =
        BlockMatrix { starts: Vec::with_capacity(rows + 1), columns: Vec::with_capacity(count), blocks: Vec::with_capacity(count) };
    matrix.starts.push(0);
    for part in parts {
        let before = matrix.columns.len();
        matrix.starts.extend(part.starts[1..].iter().map(|start| before + start));
        matrix.columns.extend(part.columns);
        matrix.blocks.extend(part.blocks);
    }
    matrix
}
