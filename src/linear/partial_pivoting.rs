//! Sparse LU with partial pivoting over whole columns, by the crate `faer`. Several times slower than the multifrontal LU, but not
//! restricted to pivots inside a front: its fallback, and its reference in tests.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::PartialPivLuParams;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::lu::{LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Spec};

use super::error::LinearError;
use super::pattern::Pattern;

/// The factors of a matrix.
pub(super) struct PartialPivoting {
    starts: Vec<usize>,
    rows: Vec<usize>,
    /// Position of the value of each entry; `None` for zero entries.
    places: Vec<Option<usize>>,
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, f64>,
    memory: MemBuffer,
    scaled: Vec<f64>,
}

/// Bytes of the matrix without its factors, whose number is unknown before the factorization.
fn bytes_of(rows: &[usize]) -> u64 {
    (size_of::<f64>() * rows.len()) as u64
}

impl PartialPivoting {
    /// Orders the columns (COLAMD) and finds the structure of the factors.
    pub(super) fn new(pattern: &Pattern) -> Result<Self, LinearError> {
        let unknowns = pattern.unknowns();
        let (starts, rows, places) = pattern.compressed_columns();
        let out_of_memory = LinearError::OutOfMemory { unknowns, needed: bytes_of(&rows) };
        let structure = SymbolicSparseColMatRef::new_checked(unknowns, unknowns, &starts, None, &rows);
        let parameters = LuSymbolicParams { supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL, ..Default::default() };
        let symbolic = factorize_symbolic_lu(structure, parameters).map_err(|_| out_of_memory)?;
        let scratch = symbolic
            .factorize_numeric_lu_scratch::<f64>(Par::Seq, Spec::<PartialPivLuParams, f64>::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let memory = MemBuffer::try_new(scratch).map_err(|_| out_of_memory)?;
        Ok(PartialPivoting { scaled: vec![0.0; rows.len()], starts, rows, places, symbolic, numeric: NumericLu::new(), memory })
    }

    /// Factorizes `diag(scale) A diag(scale)`, with one scale per unknown.
    pub(super) fn factorize(&mut self, values: &[f64], scale: &[f64]) -> Result<(), LinearError> {
        let unknowns = scale.len();
        for column in 0..unknowns {
            for k in self.starts[column]..self.starts[column + 1] {
                let value = self.places[k].map_or(0.0, |place| values[place]);
                self.scaled[k] = value * scale[self.rows[k]] * scale[column];
            }
        }
        let structure = SymbolicSparseColMatRef::new_checked(unknowns, unknowns, &self.starts, None, &self.rows);
        let matrix = SparseColMatRef::new(structure, &self.scaled[..]);
        let stack = MemStack::new(&mut self.memory);
        match self.symbolic.factorize_numeric_lu(&mut self.numeric, matrix, Par::Seq, stack, Spec::<PartialPivLuParams, f64>::default()) {
            Ok(_) => Ok(()),
            Err(faer::sparse::linalg::LuError::SymbolicSingular { .. }) => Err(LinearError::Singular { vertex: None }),
            Err(_) => Err(LinearError::OutOfMemory { unknowns, needed: bytes_of(&self.rows) }),
        }
    }

    /// `x := A^-1 x`.
    pub(super) fn solve(&mut self, scale: &[f64], x: &mut [f64]) {
        for (x, scale) in x.iter_mut().zip(scale) {
            *x *= scale;
        }
        let unknowns = x.len();
        let vector = MatMut::from_column_major_slice_mut(x, unknowns, 1);
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            vector,
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
        for (x, scale) in x.iter_mut().zip(scale) {
            *x *= scale;
        }
    }
}
