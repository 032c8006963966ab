//! LU factorisation of a matrix on a [`Pattern`], with equilibration, one iterative refinement and a checked residual.
//!
//! By faer's supernodal LU with partial pivoting (column ordering COLAMD). Rows and columns are scaled by powers of two so that multipliers
//! (entries of order one) and displacements (entries of the stiffness) are of one size when pivots are compared.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::PartialPivLuParams;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::lu::{LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Spec};
use thiserror::Error;

use super::pattern::Pattern;

/// Why a linear system could not be solved.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum LinearError {
    /// The factorisation met no usable pivot.
    #[error("the matrix is singular")]
    Singular,
    /// The solution does not satisfy the system.
    #[error("the linear solve left a relative residual of {residual:.1e}")]
    Inaccurate {
        /// Largest residual over the largest right-hand side.
        residual: f64,
    },
    /// There is not enough memory.
    #[error("the factorisation of {unknowns} unknowns does not fit into memory")]
    OutOfMemory {
        /// Number of unknowns.
        unknowns: usize,
    },
}

/// The factorisation of a matrix on one pattern: made once, computed for many values.
pub struct Factorization {
    unknowns: usize,
    starts: Vec<usize>,
    rows: Vec<usize>,
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, f64>,
    memory: MemBuffer,
    row_scale: Vec<f64>,
    column_scale: Vec<f64>,
    scaled: Vec<f64>,
    solution: Vec<f64>,
    residual: Vec<f64>,
}

/// The power of two next to `1/x`, 1 for zero: scaling by it is exact.
fn reciprocal_power(x: f64) -> f64 {
    if x > 0.0 && x.is_finite() { (-x.log2().round()).exp2() } else { 1.0 }
}

impl Factorization {
    /// Orders the unknowns and finds the structure of the factors.
    ///
    /// # Errors
    /// [`LinearError::OutOfMemory`].
    pub fn new(pattern: &Pattern) -> Result<Self, LinearError> {
        let unknowns = pattern.unknowns();
        let out_of_memory = LinearError::OutOfMemory { unknowns };
        let (starts, rows) = pattern.compressed_columns();
        let structure = SymbolicSparseColMatRef::new_checked(unknowns, unknowns, &starts, None, &rows);
        let parameters = LuSymbolicParams { supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL, ..Default::default() };
        let symbolic = factorize_symbolic_lu(structure, parameters).map_err(|_| out_of_memory)?;
        let scratch = symbolic
            .factorize_numeric_lu_scratch::<f64>(Par::Seq, Spec::<PartialPivLuParams, f64>::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let memory = MemBuffer::try_new(scratch).map_err(|_| out_of_memory)?;
        Ok(Factorization {
            unknowns,
            scaled: vec![0.0; rows.len()],
            starts,
            rows,
            symbolic,
            numeric: NumericLu::new(),
            memory,
            row_scale: vec![1.0; unknowns],
            column_scale: vec![1.0; unknowns],
            solution: vec![0.0; unknowns],
            residual: vec![0.0; unknowns],
        })
    }

    /// Factors the matrix with these values.
    ///
    /// # Errors
    /// [`LinearError::Singular`], also for values that are not finite.
    pub fn factorize(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.equilibrate(values)?;
        let structure = SymbolicSparseColMatRef::new_checked(self.unknowns, self.unknowns, &self.starts, None, &self.rows);
        let matrix = SparseColMatRef::new(structure, &self.scaled[..]);
        let stack = MemStack::new(&mut self.memory);
        match self.symbolic.factorize_numeric_lu(&mut self.numeric, matrix, Par::Seq, stack, Spec::<PartialPivLuParams, f64>::default()) {
            Ok(_) => Ok(()),
            Err(faer::sparse::linalg::LuError::SymbolicSingular { .. }) => Err(LinearError::Singular),
            Err(_) => Err(LinearError::OutOfMemory { unknowns: self.unknowns }),
        }
    }

    fn equilibrate(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let mut largest = vec![0.0f64; self.unknowns];
        for (&row, &value) in self.rows.iter().zip(values) {
            largest[row] = largest[row].max(value.abs());
        }
        if largest.iter().any(|x| !x.is_finite()) || values.iter().any(|x| x.is_nan()) {
            return Err(LinearError::Singular);
        }
        for (scale, &size) in self.row_scale.iter_mut().zip(&largest) {
            *scale = reciprocal_power(size);
        }
        for column in 0..self.unknowns {
            let range = self.starts[column]..self.starts[column + 1];
            let size = range.clone().map(|k| (values[k] * self.row_scale[self.rows[k]]).abs()).fold(0.0, f64::max);
            let scale = reciprocal_power(size);
            self.column_scale[column] = scale;
            for k in range {
                self.scaled[k] = values[k] * self.row_scale[self.rows[k]] * scale;
            }
        }
        Ok(())
    }

    /// Solves with the last factorised values, which are given again for the refinement; `right` becomes the solution.
    /// Returns the relative residual after one refinement.
    ///
    /// # Errors
    /// [`LinearError::Inaccurate`] when the residual stays above [`crate::math::tolerances::LINEAR_RESIDUAL`].
    pub fn solve(&mut self, values: &[f64], right: &mut [f64]) -> Result<f64, LinearError> {
        self.solution.fill(0.0);
        self.residual.copy_from_slice(right);
        let size = right.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        let mut relative = if size > 0.0 { 1.0 } else { 0.0 };
        for _ in 0..2 {
            if relative == 0.0 {
                break;
            }
            self.substitute();
            for (x, d) in self.solution.iter_mut().zip(&self.residual) {
                *x += d;
            }
            // residual = right - A solution
            self.residual.copy_from_slice(right);
            for column in 0..self.unknowns {
                let x = self.solution[column];
                for k in self.starts[column]..self.starts[column + 1] {
                    self.residual[self.rows[k]] -= values[k] * x;
                }
            }
            relative = self.residual.iter().fold(0.0f64, |size, x| if x.is_nan() { f64::NAN } else { size.max(x.abs()) }) / size;
        }
        if relative.is_nan() || relative > crate::math::tolerances::LINEAR_RESIDUAL {
            return Err(LinearError::Inaccurate { residual: relative });
        }
        right.copy_from_slice(&self.solution);
        Ok(relative)
    }

    /// Replaces `residual` by the inverse of the factorised matrix times it.
    fn substitute(&mut self) {
        for (x, scale) in self.residual.iter_mut().zip(&self.row_scale) {
            *x *= scale;
        }
        let factors = LuRef::new_unchecked(&self.symbolic, &self.numeric);
        let vector = MatMut::from_column_major_slice_mut(&mut self.residual, self.unknowns, 1);
        factors.solve_in_place_with_conj(Conj::No, vector, Par::Seq, MemStack::new(&mut self.memory));
        for (x, scale) in self.residual.iter_mut().zip(&self.column_scale) {
            *x *= scale;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of two-component nodes with a multiplier at its end: saddle point, unsymmetric values.
    fn chain(nodes: u32) -> (Pattern, Vec<f64>) {
        let mut sizes = vec![2u8; nodes as usize];
        sizes.push(1);
        let cliques: Vec<[u32; 2]> = (0..nodes).map(|v| [v, v + 1]).collect();
        let pattern = Pattern::new(&sizes, cliques.iter().map(|c| &c[..]));
        let mut values = vec![0.0; pattern.values()];
        for v in 0..nodes {
            let own = pattern.block(v, v);
            for i in 0..2 {
                for k in 0..2 {
                    values[own.at(i, k)] = if i == k { 2e5 } else { 1e3 * (i as f64 - 0.4) };
                }
            }
            if v + 1 < nodes {
                for (a, b) in [(v, v + 1), (v + 1, v)] {
                    values[pattern.block(a, b).at(0, 0)] = -9e4;
                    values[pattern.block(a, b).at(1, 1)] = -8e4;
                }
            }
        }
        for k in 0..2 {
            values[pattern.block(nodes - 1, nodes).at(k, 0)] = -0.7;
            values[pattern.block(nodes, nodes - 1).at(0, k)] = 0.6 + 0.1 * k as f64;
        }
        (pattern, values)
    }

    #[test]
    fn saddle_point_with_entries_of_very_different_size_is_solved_to_round_off() {
        let (pattern, values) = chain(50);
        let exact: Vec<f64> = (0..pattern.unknowns()).map(|i| (i as f64 * 0.7).sin()).collect();
        let (starts, rows) = pattern.compressed_columns();
        let mut right = vec![0.0; pattern.unknowns()];
        for column in 0..pattern.unknowns() {
            for k in starts[column]..starts[column + 1] {
                right[rows[k]] += values[k] * exact[column];
            }
        }
        let mut factorization = Factorization::new(&pattern).unwrap();
        factorization.factorize(&values).unwrap();
        let relative = factorization.solve(&values, &mut right).unwrap();
        assert!(relative < 1e-14, "residual {relative}");
        for (x, e) in right.iter().zip(&exact) {
            // The multiplier is seen through a stiffness of 1e5: it keeps 1e-16 * 1e5 / 0.7 of absolute accuracy.
            assert!((x - e).abs() < 1e-9);
        }
    }

    #[test]
    fn singular_and_not_finite_matrices_are_refused() {
        let (pattern, mut values) = chain(5);
        let mut factorization = Factorization::new(&pattern).unwrap();
        let mut right = vec![1.0; pattern.unknowns()];
        values[0] = f64::NAN;
        assert_eq!(factorization.factorize(&values), Err(LinearError::Singular));
        values.fill(0.0);
        let outcome = factorization.factorize(&values).and_then(|()| factorization.solve(&values, &mut right));
        assert!(outcome.is_err());
    }
}
