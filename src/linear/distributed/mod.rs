//! Distributed direct solver: MUMPS on the ranks of an MPI job, in a program of its own (`packages/mumps`).
//!
//! Assembly, scaling, refinement and checks are here, on rank 0, as for the other solvers; the ranks hold the factors. Where MUMPS replaces
//! null pivots, or its solution is not accurate, the direct solver of this process takes the matrix over, so that verdicts on singular
//! matrices are the same.

mod connection;
mod entries;
mod launch;

use std::sync::{Arc, Mutex};

pub use connection::end_ranks;
use connection::{Command, Ranks, head, locked, ranks};
use entries::{for_each_entry, is_symmetric};
pub use launch::{MpiProcess, become_rank};

use super::error::LinearError;
use super::factorization::{Factorization, SUBSTITUTIONS};
use super::pattern::{Couplings, Pattern};
use super::refinement::REFINEMENTS;
use super::scaling::{all_finite, largest, spread, vertex_scales};
use super::solver::{LinearSolver, SolverMemory, TakenOver};
use super::watch::InterruptWatch;
use super::work::Work;
use crate::math::tolerances;
use crate::math::workers::Workers;

/// Ratio of stored couplings to those of a matrix above which couplings that became zero are dropped.
const WORTH_KEEPING: f64 = 1.2;

/// Statuses of MUMPS for lack of memory: of integers and of real numbers.
const OUT_OF_MEMORY: [i64; 3] = [-7, -13, -19];

/// Factorization of a sequence of matrices by MUMPS.
pub(super) struct Distributed {
    ranks: Arc<Mutex<Ranks>>,
    /// Number of the matrix on the ranks.
    matrix: i64,
    pattern: Pattern,
    /// Couplings for which the ranks store values, and the pattern restricted to these; `None` before the first matrix.
    kept: Option<(Couplings, Pattern)>,
    /// True if the ranks have received the structure `kept`.
    is_sent: bool,
    /// True if the ranks have the lower triangle of a symmetric matrix.
    is_symmetric: bool,
    vertex_scale: Vec<f64>,
    scale: Vec<f64>,
    negative: usize,
    /// Largest memory of each rank so far `[bytes]`.
    memory: Vec<u64>,
    /// Direct solver, while it has taken over the last matrix.
    direct: Option<Box<Factorization>>,
    taken_over: TakenOver,
    work: Work,
    workers: Workers,
    watch: InterruptWatch,
}

impl Distributed {
    /// Solver for matrices of a pattern on a number of ranks, which are started if needed.
    ///
    /// # Errors
    /// [`LinearError::Ranks`].
    pub fn new(pattern: &Pattern, wanted: u32, workers: &Workers) -> Result<Self, LinearError> {
        let watch = InterruptWatch::default();
        let ranks = ranks(wanted, &watch)?;
        let (matrix, count) = {
            let mut ranks = locked(&ranks);
            (ranks.new_matrix(), ranks.count)
        };
        Ok(Distributed {
            ranks,
            matrix,
            pattern: pattern.clone(),
            kept: None,
            is_sent: false,
            is_symmetric: true,
            vertex_scale: Vec::new(),
            scale: Vec::new(),
            negative: 0,
            memory: vec![0; count],
            direct: None,
            taken_over: TakenOver::default(),
            work: Work::default(),
            workers: workers.clone(),
            watch,
        })
    }

    /// Adapts the structure to the nonzero blocks of a matrix.
    fn adapt(&mut self, values: &[f64]) {
        let present = self.pattern.present(values);
        let kept = self.kept.take().map(|(kept, _)| kept).filter(|kept| kept.vertices() == self.pattern.vertices());
        let joined = kept.as_ref().map_or_else(|| present.clone(), |kept| present.joined(kept));
        let chosen = if joined.count() as f64 <= WORTH_KEEPING * present.count() as f64 { joined } else { present };
        self.is_sent &= kept.is_some_and(|kept| kept == chosen);
        let restricted = self.pattern.restricted(&chosen);
        self.kept = Some((chosen, restricted));
    }

    /// Sends a matrix to the ranks, which factorize it; returns the status of MUMPS and the number of null pivots.
    fn hand_out(&mut self, values: &[f64]) -> Result<(i64, i64), LinearError> {
        let Some((_, pattern)) = &self.kept else { return Ok((0, 0)) };
        let (is_symmetric, matrix, watch) = (self.is_symmetric, self.matrix, &self.watch);
        let mut ranks = locked(&self.ranks);
        if !self.is_sent {
            let mut count = 0;
            for_each_entry(pattern, is_symmetric, |_| {
                count += 1;
                Ok::<(), LinearError>(())
            })?;
            let unknowns = pattern.unknowns() as i64;
            ranks.put_head(head(Command::Structure, &[matrix, i64::from(is_symmetric), unknowns, count]), watch)?;
            for_each_entry(pattern, is_symmetric, |entry| ranks.put(&(entry.row as i32 + 1).to_ne_bytes(), watch))?;
            for_each_entry(pattern, is_symmetric, |entry| ranks.put(&(entry.column as i32 + 1).to_ne_bytes(), watch))?;
            self.is_sent = true;
        }
        ranks.put_head(head(Command::Factorize, &[matrix]), watch)?;
        let scales = &self.vertex_scale;
        for_each_entry(pattern, is_symmetric, |entry| {
            let value = entry.place.map_or(0.0, |place| values[place] * scales[entry.vertices[0]] * scales[entry.vertices[1]]);
            ranks.put(&value.to_ne_bytes(), watch)
        })?;
        ranks.flush(watch)?;
        let answer = ranks.answer(watch)?;
        let mut megabytes = vec![0.0; ranks.count];
        ranks.receive_numbers(&mut megabytes, watch)?;
        for (most, megabytes) in self.memory.iter_mut().zip(megabytes) {
            *most = (*most).max((1e6 * megabytes) as u64);
        }
        self.negative = answer[2] as usize;
        Ok((answer[0], answer[3]))
    }

    /// `x := S A^-1 S x` on the ranks for vectors one after another, with the scales `S` of the unknowns; returns the status.
    fn substitute(&mut self, vectors: &mut [f64]) -> Result<i64, LinearError> {
        let (unknowns, watch) = (self.pattern.unknowns(), &self.watch);
        let mut ranks = locked(&self.ranks);
        ranks.put_head(head(Command::Solve, &[self.matrix, (vectors.len() / unknowns) as i64]), watch)?;
        for vector in vectors.chunks_exact(unknowns) {
            vector.iter().zip(&self.scale).try_for_each(|(x, scale)| ranks.put(&(x * scale).to_ne_bytes(), watch))?;
        }
        ranks.flush(watch)?;
        let status = ranks.answer(watch)?[0];
        if status == 0 {
            ranks.receive_numbers(vectors, watch)?;
            for vector in vectors.chunks_exact_mut(unknowns) {
                vector.iter_mut().zip(&self.scale).for_each(|(x, scale)| *x *= scale);
            }
        }
        Ok(status)
    }

    /// Factorizes a matrix by the direct solver of this process.
    fn take_over(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.taken_over.unconverged += 1;
        let mut direct = Factorization::new(&self.pattern)?.with_workers(&self.workers);
        direct.set_watch(self.watch.clone());
        direct.factorize(values)?;
        self.direct = Some(Box::new(direct));
        Ok(())
    }

    /// Solves with iterative refinement; returns the largest backward error, or `None` if a solution is not accurate.
    fn refined(&mut self, values: &[f64], rights: &[f64], solutions: &mut [f64]) -> Result<Option<f64>, LinearError> {
        let unknowns = self.pattern.unknowns();
        let mut residuals = rights.to_vec();
        let mut worst = 0.0;
        for _ in 0..=REFINEMENTS {
            if self.substitute(&mut residuals)? != 0 {
                return Ok(None);
            }
            solutions.iter_mut().zip(&residuals).for_each(|(x, change)| *x += change);
            worst = 0.0f64;
            let mut is_solved = true;
            for (k, right) in rights.chunks_exact(unknowns).enumerate() {
                let (solution, residual) = (&solutions[k * unknowns..][..unknowns], &mut residuals[k * unknowns..][..unknowns]);
                self.pattern.multiply_into(values, solution, residual);
                residual.iter_mut().zip(right).for_each(|(r, b)| *r = b - *r);
                let scaled = |vector: &[f64]| largest(vector.iter().zip(&self.scale).map(|(x, scale)| x * scale));
                let (size, left) = (scaled(right), scaled(residual));
                let own = left / (size + largest(solution.iter().zip(&self.scale).map(|(x, scale)| x / scale)));
                is_solved &= size == 0.0 || left <= tolerances::LINEAR_UNSOLVED * size;
                worst = if size == 0.0 || own <= worst { worst } else { own };
            }
            if is_solved && worst <= tolerances::LINEAR_REFINED {
                return Ok(Some(worst));
            }
            if !is_solved && worst.is_nan() {
                return Ok(None);
            }
        }
        Ok(Some(worst).filter(|worst| *worst <= tolerances::LINEAR_FALLBACK))
    }
}

impl LinearSolver for Distributed {
    fn analyse(&mut self, pattern: &Pattern) -> Result<(), LinearError> {
        let out_of_memory = LinearError::OutOfMemory { unknowns: pattern.unknowns(), needed: (size_of::<f64>() * pattern.values()) as u64 };
        u32::try_from(pattern.values()).map_err(|_| out_of_memory)?;
        i32::try_from(pattern.unknowns()).map_err(|_| out_of_memory)?;
        self.pattern = pattern.clone();
        self.direct = None;
        Ok(())
    }

    fn factorize(&mut self, values: &[f64]) -> Result<(), LinearError> {
        if !all_finite(values) {
            return Err(LinearError::NotFinite);
        }
        self.direct = None;
        self.work.factorizations += 1;
        self.vertex_scale.resize(self.pattern.vertices(), 1.0);
        self.vertex_scale.fill(1.0);
        self.scale.resize(self.pattern.unknowns(), 1.0);
        vertex_scales(&self.pattern, values, &mut self.vertex_scale);
        spread(&self.pattern, &self.vertex_scale, &mut self.scale);
        let is_symmetric = is_symmetric(&self.pattern, values, &self.vertex_scale);
        self.is_sent &= is_symmetric == self.is_symmetric;
        self.is_symmetric = is_symmetric;
        self.adapt(values);
        match self.hand_out(values)? {
            (0, 0) => Ok(()),
            (status, _) if OUT_OF_MEMORY.contains(&status) => {
                Err(LinearError::OutOfMemory { unknowns: self.pattern.unknowns(), needed: self.memory.iter().sum() })
            }
            _ => self.take_over(values),
        }
    }

    fn solve(&mut self, values: &[f64], rights: &mut [f64]) -> Result<f64, LinearError> {
        if self.direct.is_none() && !rights.is_empty() {
            if !all_finite(rights) {
                return Err(LinearError::NotFinite);
            }
            let mut solutions = vec![0.0; rights.len()];
            if let Some(error) = self.refined(values, rights, &mut solutions)? {
                rights.copy_from_slice(&solutions);
                return Ok(error);
            }
            self.take_over(values)?;
        }
        self.direct.as_mut().map_or(Ok(0.0), |direct| direct.solve_all(values, rights))
    }

    fn estimate(&mut self, values: &[f64], rights: &mut [f64]) -> Result<(), LinearError> {
        if let Some(direct) = &mut self.direct {
            return direct.estimate(values, rights);
        }
        if !rights.is_empty() && self.substitute(rights)? != 0 {
            self.take_over(values)?;
            return self.estimate(values, rights);
        }
        Ok(())
    }

    fn substitutions_for_a_factorization(&self) -> usize {
        self.direct.as_ref().map_or(SUBSTITUTIONS, |direct| direct.substitutions_for_a_factorization())
    }

    fn near_null_vector(&self) -> Option<&[f64]> {
        self.direct.as_ref()?.near_null_vector()
    }

    fn negative_eigenvalues(&self) -> Option<usize> {
        match &self.direct {
            Some(direct) => direct.negative_eigenvalues(),
            None => Some(self.negative).filter(|_| self.is_symmetric),
        }
    }

    fn memory(&self) -> SolverMemory {
        SolverMemory { taken_over: self.taken_over, ..SolverMemory::default() }
    }

    fn recall(&mut self, memory: &SolverMemory) {
        self.taken_over = memory.taken_over;
    }

    fn work(&self) -> Work {
        self.work
    }

    fn taken_over(&self) -> TakenOver {
        self.taken_over
    }

    fn bytes(&self) -> usize {
        self.memory.iter().sum::<u64>() as usize
    }

    fn rank_bytes(&self) -> &[u64] {
        &self.memory
    }

    fn set_watch(&mut self, watch: InterruptWatch) {
        if let Some(direct) = &mut self.direct {
            direct.set_watch(watch.clone());
        }
        self.watch = watch;
    }
}

impl Drop for Distributed {
    fn drop(&mut self) {
        locked(&self.ranks).free(self.matrix);
    }
}
