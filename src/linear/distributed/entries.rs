//! Scaled entries of a matrix for the ranks.

use crate::linear::pattern::Pattern;
use crate::math::tolerances::LINEAR_ASYMMETRY;

/// An entry of the matrix.
pub(super) struct Entry {
    /// Row and column.
    pub row: usize,
    pub column: usize,
    /// Position of the entry among the values; `None` for couplings that the pattern lacks.
    pub place: Option<usize>,
    /// Vertices of row and column.
    pub vertices: [usize; 2],
}

/// Visits the entries of a pattern, column by column; for a symmetric matrix the lower triangle only.
///
/// # Errors
/// The first error of `visit`.
pub(super) fn for_each_entry<E>(pattern: &Pattern, is_symmetric: bool, mut visit: impl FnMut(Entry) -> Result<(), E>) -> Result<(), E> {
    for v in 0..pattern.vertices() {
        for k in 0..pattern.size(v) {
            let column = pattern.first_unknown(v) + k;
            for (&u, block) in pattern.neighbors(v).iter().zip(pattern.column_blocks(v)) {
                let u = u as usize;
                let is_there = block.start != u32::MAX;
                for i in 0..pattern.size(u) {
                    let row = pattern.first_unknown(u) + i;
                    if !is_symmetric || row >= column {
                        visit(Entry { row, column, place: is_there.then(|| block.at(i, k)), vertices: [u, v] })?;
                    }
                }
            }
        }
    }
    Ok(())
}

/// True if a matrix is symmetric up to round-off; `scales` of the vertices bring its entries to order one.
pub(super) fn is_symmetric(pattern: &Pattern, values: &[f64], scales: &[f64]) -> bool {
    (0..pattern.vertices()).all(|v| {
        pattern.neighbors(v).iter().filter(|u| **u as usize >= v).all(|&u| {
            let (below, above, scale) = (pattern.block(u, v as u32), pattern.block(v as u32, u), scales[u as usize] * scales[v]);
            (0..pattern.size(v)).all(|k| {
                (0..pattern.size(u as usize)).all(|i| scale * (values[below.at(i, k)] - values[above.at(k, i)]).abs() <= LINEAR_ASYMMETRY)
            })
        })
    })
}
