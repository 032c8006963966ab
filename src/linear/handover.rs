//! Iterative solver with the direct solver as its fallback.

#[cfg(unix)]
use super::distributed::Distributed;
use super::error::LinearError;
use super::factorization::Factorization;
use super::iterative::{Iterative, Refusal};
use super::pattern::Pattern;
use super::solver::{LinearSolver, SolverMemory, TakenOver};
use super::watch::InterruptWatch;
use super::work::Work;
use crate::math::workers::Workers;

/// Choice of the linear solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolverChoice {
    /// Iterative in space from [`ITERATED`] unknowns, or if the factors do not fit into memory; otherwise direct.
    #[default]
    Auto,
    /// Factorization of every matrix.
    Direct,
    /// Iteration for every matrix for which it converges.
    Iterative,
    /// Factorization of every matrix by MUMPS.
    Mumps {
        /// Number of processes to be started; 0: one, or those of the MPI job to which this process belongs.
        ranks: u16,
    },
}

impl SolverChoice {
    /// All choices by name.
    pub const ALL: [(&'static str, SolverChoice); 4] = [
        ("auto", SolverChoice::Auto),
        ("direct", SolverChoice::Direct),
        ("iterative", SolverChoice::Iterative),
        ("mumps", SolverChoice::Mumps { ranks: 0 }),
    ];

    /// Name of the choice.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, choice)| std::mem::discriminant(choice) == std::mem::discriminant(&self)).map_or("", |(name, _)| name)
    }
}

/// Number of unknowns in space from which [`SolverChoice::Auto`] iterates. For an elastic block both solvers take equal time at some ten
/// thousand unknowns (`docs/performance.md`); contact takes more iterations, and direct factors serve several active sets.
pub const ITERATED: usize = 100_000;

/// Number of matrices without convergence after which the iterative solver is no longer tried.
const PATIENCE: u32 = 3;

/// Iterative solver with the direct solver as fallback.
pub struct IterativeWithFallback {
    choice: SolverChoice,
    pattern: Pattern,
    positions: Vec<f64>,
    iterative: Iterative,
    direct: Option<Box<Factorization>>,
    /// State of the direct solver (order of elimination), kept while no direct solver exists.
    kept: SolverMemory,
    taken_over: TakenOver,
    /// True if the direct solver has factorized the last matrix.
    is_direct: bool,
    /// Work counters of direct solvers that have been freed, and number of preconditioners made.
    done: Work,
    workers: Workers,
    watch: InterruptWatch,
}

/// Creates the solver of a choice for matrices of a pattern. `positions`: coordinates of the leading vertices, as many as each has
/// unknowns.
///
/// # Errors
/// [`LinearError::OutOfMemory`], [`LinearError::Ranks`].
pub fn solver_of(
    choice: SolverChoice,
    pattern: &Pattern,
    positions: &[f64],
    workers: &Workers,
) -> Result<Box<dyn LinearSolver>, LinearError> {
    if choice == SolverChoice::Direct {
        return Ok(Box::new(Factorization::new(pattern)?.with_workers(workers)));
    }
    if let SolverChoice::Mumps { ranks } = choice {
        #[cfg(unix)]
        return Ok(Box::new(Distributed::new(pattern, u32::from(ranks), workers)?));
        #[cfg(not(unix))]
        return Err(super::error::RanksError::NoProgram.into());
    }
    let mut solver = IterativeWithFallback {
        choice,
        pattern: Pattern::new(&[], std::iter::empty()),
        positions: positions.to_vec(),
        iterative: Iterative::default(),
        direct: None,
        kept: SolverMemory::default(),
        taken_over: TakenOver::default(),
        is_direct: false,
        done: Work::default(),
        workers: workers.clone(),
        watch: InterruptWatch::default(),
    };
    solver.analyse(pattern)?;
    // A direct solver determines its elimination order now, so that the solver memory contains it from the start.
    if !solver.iterates() {
        solver.direct()?;
    }
    Ok(Box::new(solver))
}

impl IterativeWithFallback {
    /// True if the next matrix is to be solved by iteration.
    fn iterates(&self) -> bool {
        let is_large = || self.pattern.unknowns() >= ITERATED && self.pattern.size(0) == 3;
        self.taken_over.unconverged < PATIENCE && (self.choice == SolverChoice::Iterative || is_large())
    }

    /// The direct solver, made if needed.
    fn direct(&mut self) -> Result<&mut Factorization, LinearError> {
        if self.direct.is_none() {
            let mut direct = Factorization::new(&self.pattern)?.with_workers(&self.workers);
            direct.set_watch(self.watch.clone());
            if self.kept.order.is_some() {
                direct.recall(&self.kept);
                direct.renew(&self.pattern)?;
            }
            self.direct = Some(Box::new(direct));
        }
        self.direct.as_deref_mut().ok_or(LinearError::Interrupted)
    }

    /// Frees the direct solver, whose factors need several times the memory of the multigrid hierarchy.
    fn free_direct(&mut self) {
        if let Some(direct) = self.direct.take() {
            self.kept = LinearSolver::memory(&*direct);
            self.done = self.done.and(direct.work());
        }
    }

    /// Factorizes a matrix by the direct solver in place of the iterative one.
    fn take_over(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.iterative.clear();
        self.is_direct = true;
        self.direct()?.factorize(values)
    }

    /// Makes the preconditioner of a matrix.
    fn prepare(&mut self, values: &[f64]) -> Result<(), Refusal> {
        self.iterative.prepare(&self.pattern, &self.positions, values, &self.workers, &self.watch)?;
        self.done.hierarchies += 1;
        self.is_direct = false;
        Ok(())
    }
}

impl LinearSolver for IterativeWithFallback {
    fn analyse(&mut self, pattern: &Pattern) -> Result<(), LinearError> {
        let out_of_memory = LinearError::OutOfMemory { unknowns: pattern.unknowns(), needed: (size_of::<f64>() * pattern.values()) as u64 };
        u32::try_from(pattern.values()).map_err(|_| out_of_memory)?;
        self.pattern = pattern.clone();
        self.iterative.clear();
        match &mut self.direct {
            Some(direct) => direct.renew(pattern),
            None => Ok(()),
        }
    }

    fn locate(&mut self, positions: &[f64]) {
        self.positions.clear();
        self.positions.extend_from_slice(positions);
    }

    fn factorize(&mut self, values: &[f64]) -> Result<(), LinearError> {
        if !self.iterates() {
            return match self.take_over(values) {
                // The factors do not fit into memory; the multigrid hierarchy of the iterative solver may fit.
                Err(error @ LinearError::OutOfMemory { .. }) if self.choice == SolverChoice::Auto => {
                    self.free_direct();
                    self.prepare(values).map_err(|_| error)
                }
                outcome => outcome,
            };
        }
        self.free_direct();
        match self.prepare(values) {
            Ok(()) => Ok(()),
            Err(Refusal::Error(error)) => Err(error),
            Err(_) => {
                self.taken_over.is_unsuited |= self.choice == SolverChoice::Iterative;
                self.take_over(values)
            }
        }
    }

    fn factorize_directly(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.take_over(values)
    }

    fn solve(&mut self, values: &[f64], rights: &mut [f64]) -> Result<f64, LinearError> {
        if self.is_direct {
            return self.direct()?.solve_all(values, rights);
        }
        let mut worst = 0.0f64;
        for right in rights.chunks_exact_mut(self.pattern.unknowns()) {
            if !self.is_direct {
                match self.iterative.solve(&self.pattern, values, right, &self.workers, &self.watch) {
                    Ok(error) => {
                        worst = worst.max(error);
                        continue;
                    }
                    Err(Refusal::Error(error)) => return Err(error),
                    Err(_) => {
                        self.taken_over.unconverged += 1;
                        self.take_over(values)?;
                    }
                }
            }
            worst = worst.max(self.direct()?.solve(values, right)?);
        }
        Ok(worst)
    }

    fn estimate(&mut self, values: &[f64], rights: &mut [f64]) -> Result<(), LinearError> {
        if self.is_direct { self.direct()?.estimate(values, rights) } else { self.solve(values, rights).map(drop) }
    }

    fn near_null_vector(&self) -> Option<&[f64]> {
        self.direct.as_ref()?.near_null_vector()
    }

    fn negative_eigenvalues(&self) -> Option<usize> {
        self.direct.as_ref().filter(|_| self.is_direct)?.negative_eigenvalues()
    }

    fn substitutions_for_a_factorization(&self) -> usize {
        match &self.direct {
            Some(direct) if self.is_direct => direct.substitutions_for_a_factorization(),
            _ => 2,
        }
    }

    fn memory(&self) -> SolverMemory {
        let direct = self.direct.as_ref().map_or_else(|| self.kept.clone(), |direct| LinearSolver::memory(&**direct));
        SolverMemory { taken_over: self.taken_over, ..direct }
    }

    fn recall(&mut self, memory: &SolverMemory) {
        self.taken_over = memory.taken_over;
        match (&mut self.direct, &memory.order) {
            (Some(direct), Some(_)) => direct.recall(memory),
            _ => {
                self.free_direct();
                self.kept = memory.clone();
            }
        }
    }

    fn work(&self) -> Work {
        let done = Work { iterations: self.iterative.iterations, ..self.done };
        self.direct.as_ref().map_or(done, |direct| done.and(direct.work()))
    }

    fn taken_over(&self) -> TakenOver {
        self.taken_over
    }

    fn bytes(&self) -> usize {
        self.direct.as_ref().map_or_else(|| self.iterative.bytes(), |direct| direct.bytes())
    }

    fn set_watch(&mut self, watch: InterruptWatch) {
        if let Some(direct) = &mut self.direct {
            direct.set_watch(watch.clone());
        }
        self.watch = watch;
    }
}
