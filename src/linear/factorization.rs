//! LU factorisation of a matrix on a [`Pattern`]: scaled, refined, its residual checked, with a fallback to partial pivoting.
//!
//! A pattern includes possible couplings: all facet pairs that could meet. Most of their blocks are zero at any time, and each would cost
//! fill. The structure of the factors therefore contains only blocks that are nonzero, or have been since the structure was made. Before
//! each factorization new nonzero blocks are detected; then the structure is rebuilt, keeping blocks that became zero while they are cheap.
//! Order and structure do not depend on blocks that were always zero, so that absent couplings change no result.
//!
//! Every vertex has a scale, a power of two: it brings the diagonal block of a node, and the constraint of a multiplier, to entries of
//! order one, so that pivots and residuals of stiffness and constraints are comparable. The multifrontal LU pivots inside a front only; if
//! it had to replace a pivot, or if the residual stays large, the sparse LU with partial pivoting is used.

use std::ops::Range;
use std::sync::Arc;

use super::elimination_order::{Account, EliminationOrder};
use super::error::LinearError;
use super::multifrontal::{Multifrontal, TOGETHER};
use super::ordering::{Order, alternatives, anchored, candidates};
use super::partial_pivoting::PartialPivoting;
use super::pattern::Pattern;
use super::scaling::{all_finite, spread, vertex_scales};
use super::symbolic::Symbolic;
use super::watch::InterruptWatch;
use super::work::Work;
use crate::machine::memory;
use crate::math::workers::Workers;

/// Excess operations per nonzero block after which a new order is computed: several times the cost of a dissection, because on coarse
/// meshes an order degrades within few steps and its cost then stays constant.
const DISSECTION: f64 = 1.5e5;

/// Number of operations of a factorization above which several dissections are compared: tenths of a second.
const WORTH_ALTERNATIVES: f64 = 2e9;

/// Operations of a factorization, relative to those with the blocks of one matrix only, up to which blocks that became zero stay in the
/// structure: they often become nonzero again, and a new structure costs a third of a factorization.
const WORTH_KEEPING: f64 = 1.1;

/// Number of factorizations within which blocks that became zero usually become nonzero again: about the number in a step.
const COME_BACK: usize = 4;

/// Number of factorizations after which the structure is searched for blocks that became zero, even if no new blocks appeared, for example
/// because bodies have separated.
const REVIEW: usize = 50;

/// Time of an operation of a substitution relative to one of a factorization, taken smaller than it is (2.5), because a factorization
/// discards the substitutions before it.
const SLOWER: f64 = 1.5;
/// Least number of substitutions that are preferred to a factorization.
pub(super) const SUBSTITUTIONS: usize = 64;

/// Factorization of a sequence of matrices: the order of elimination is kept while it is good, the structure while the pattern is
/// unchanged.
pub struct Factorization {
    pub(super) order: EliminationOrder,
    account: Account,
    /// True if `order` was restored for the next pattern.
    restored: bool,
    pub(super) pattern: Pattern,
    pub(super) symbolic: Symbolic,
    /// Ranges of matrix values outside of the structure of the factors; all of them have been zero so far.
    left_out: Vec<Range<u32>>,
    pub(super) multifrontal: Multifrontal,
    /// Largest number of bytes reserved for a factorisation.
    reserved: u64,
    work: Work,
    pub(super) workers: Workers,
    watch: InterruptWatch,
    pub(super) fallback: Option<Box<PartialPivoting>>,
    /// True if the fallback has factorized the last matrix and must solve.
    pub(super) fallen_back: bool,
    /// Scales of the vertices.
    vertex_scale: Vec<f64>,
    /// Scales of the unknowns.
    pub(super) scale: Vec<f64>,
    pub(super) solution: Vec<f64>,
    pub(super) residual: Vec<f64>,
    pub(super) null_vector: Option<Vec<f64>>,
}

impl Factorization {
    /// Factorization for matrices of a pattern.
    ///
    /// # Errors
    /// [`LinearError::OutOfMemory`].
    pub fn new(pattern: &Pattern) -> Result<Self, LinearError> {
        let mut factorization = Factorization {
            order: EliminationOrder::default(),
            account: Account::default(),
            restored: false,
            pattern: Pattern::new(&[], std::iter::empty()),
            symbolic: Symbolic::default(),
            left_out: Vec::new(),
            multifrontal: Multifrontal::default(),
            reserved: 0,
            work: Work::default(),
            workers: Workers::default(),
            watch: InterruptWatch::default(),
            fallback: None,
            fallen_back: false,
            vertex_scale: Vec::new(),
            scale: Vec::new(),
            solution: Vec::new(),
            residual: Vec::new(),
            null_vector: None,
        };
        factorization.renew(pattern)?;
        Ok(factorization)
    }

    /// Shares the work among threads; results do not depend on their number.
    pub fn with_workers(mut self, workers: &Workers) -> Self {
        self.workers = workers.clone();
        self
    }

    /// Sets the interrupt flag and the progress counter of a long factorisation.
    pub fn set_watch(&mut self, watch: InterruptWatch) {
        self.watch = watch;
    }

    /// Adapts to a changed pattern. The structure of the factors is kept if the vertices are unchanged.
    ///
    /// # Errors
    /// [`LinearError::OutOfMemory`].
    pub fn renew(&mut self, pattern: &Pattern) -> Result<(), LinearError> {
        let out_of_memory = LinearError::OutOfMemory { unknowns: pattern.unknowns(), needed: (size_of::<f64>() * pattern.values()) as u64 };
        if u32::try_from(pattern.values()).is_err() {
            return Err(out_of_memory);
        }
        self.pattern = pattern.clone();
        self.fallback = None;
        self.fallen_back = false;
        self.vertex_scale.resize(pattern.vertices(), 1.0);
        for buffer in [&mut self.scale, &mut self.solution, &mut self.residual] {
            buffer.resize(pattern.unknowns(), 0.0);
        }
        let is_other = std::mem::take(&mut self.restored);
        if !self.order.fits(pattern) {
            self.order.kept = Arc::default();
        } else if is_other {
            self.symbolic = self.order.structure(pattern, &self.order.kept);
            return self.use_structure();
        } else {
            self.symbolic.find_blocks(pattern);
            self.left_out = pattern.left_out(&self.order.kept);
        }
        Ok(())
    }

    /// Adapts the structure to a matrix. The order of elimination is kept unless vertices changed or the work has grown too much.
    fn adapt(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let pattern = &self.pattern;
        let present = pattern.present(values);
        let ordered = self.order.found.vertices.len() == pattern.vertices();
        // A new order is computed once the excess work of the old one reaches its price.
        let price = DISSECTION * present.count() as f64;
        let reorder = !ordered || self.account.wasted >= price;
        if !reorder && self.order.fits(pattern) && self.account.uses < COME_BACK {
            let kept = present.joined(&self.order.kept);
            let symbolic = self.order.structure(pattern, &kept);
            if symbolic.operations <= WORTH_KEEPING * self.order.least {
                self.symbolic = symbolic;
                self.order.kept = Arc::new(kept);
                return self.use_structure();
            }
        }
        if !reorder && present == *self.order.kept {
            // The search for blocks that became zero found none.
            self.account.uses = 0;
            return Ok(());
        }
        if ordered {
            self.symbolic = self.order.structure(pattern, &present);
        }
        if reorder {
            let restricted = pattern.restricted(&present);
            self.order.best = if ordered { self.symbolic.operations } else { f64::INFINITY };
            self.choose(&restricted, candidates(&restricted, &self.watch))?;
            self.work.dissections += 1;
            if self.symbolic.operations > WORTH_ALTERNATIVES {
                let orders = alternatives(&restricted, &self.watch, &self.workers);
                self.work.dissections += orders.len();
                self.choose(&restricted, orders)?;
            }
            // If the first matrix has no active contacts yet, the next structure gets a new order in any case.
            self.account.wasted = if ordered { 0.0 } else { f64::INFINITY };
        }
        (self.order.least, self.account.uses) = (self.symbolic.operations, 0);
        self.order.kept = Arc::new(present);
        self.use_structure()
    }

    /// Selects the order of elimination with the least work, if below that of the present one.
    fn choose(&mut self, pattern: &Pattern, orders: Vec<Vec<u32>>) -> Result<(), LinearError> {
        for order in orders {
            if self.watch.is_interrupted() {
                break;
            }
            let vertices = anchored(pattern, &order);
            let symbolic = Symbolic::new(pattern, &vertices);
            if symbolic.operations < self.order.best {
                self.order.best = symbolic.operations;
                self.order.found = Arc::new(Order::new(vertices, symbolic.parents.clone()));
                self.symbolic = symbolic;
            }
        }
        if self.watch.is_interrupted() {
            // The structure was made for an order that was not chosen, so that it is marked as invalid.
            self.order.kept = Arc::default();
            return Err(LinearError::Interrupted);
        }
        Ok(())
    }

    /// Makes room for the factors of the structure.
    fn use_structure(&mut self) -> Result<(), LinearError> {
        self.work.structures += 1;
        self.fallback = None;
        self.left_out = self.pattern.left_out(&self.order.kept);
        let needed = self.needed();
        let out_of_memory = LinearError::OutOfMemory { unknowns: self.pattern.unknowns(), needed };
        // The memory of the last structure is reused.
        memory::ensure(needed.saturating_sub(self.reserved)).map_err(|_| out_of_memory)?;
        self.reserved = self.reserved.max(needed);
        self.multifrontal.reserve(&self.symbolic, &self.workers).map_err(|_| out_of_memory)
    }

    /// Bytes of the factors, and of the update matrices of all threads.
    fn needed(&self) -> u64 {
        let (waiting, threads) = self.symbolic.waiting(&self.workers);
        (size_of::<f64>() * (self.symbolic.factors + waiting.handed + waiting.buffer + threads * waiting.of_task)) as u64
    }

    /// Number of unknowns.
    pub(super) fn unknowns(&self) -> usize {
        self.pattern.unknowns()
    }

    /// Order of elimination in use.
    pub fn order(&self) -> &EliminationOrder {
        &self.order
    }

    /// Returns the cost counters since the order of elimination was chosen.
    pub fn account(&self) -> Account {
        self.account
    }

    /// Restores an earlier order of elimination with its cost counters; [`Self::renew`] must follow.
    pub fn restore_order(&mut self, order: &EliminationOrder, account: Account) {
        self.order = order.clone();
        self.account = account;
        self.restored = true;
    }

    /// Floating-point operations of one factorisation.
    pub fn operations(&self) -> f64 {
        self.symbolic.operations
    }

    /// Returns the counters of the work done by this factorisation object.
    pub fn work(&self) -> Work {
        self.work
    }

    /// Bytes of the factors and of the stacked update matrices with one thread.
    pub fn bytes(&self) -> usize {
        size_of::<f64>() * (self.symbolic.factors + self.symbolic.alone.buffer)
    }

    /// Bytes of the factors alone.
    pub fn factor_bytes(&self) -> usize {
        size_of::<f64>() * self.symbolic.factors
    }

    /// True if the last solution came from the sparse LU with partial pivoting: pivots had to be replaced, or the residual was poor.
    #[cfg(test)]
    pub(crate) fn has_fallen_back(&self) -> bool {
        self.fallen_back
    }

    /// Backward error of a vector as the solution, row by row.
    #[cfg(test)]
    pub(crate) fn error_of(&mut self, values: &[f64], x: &[f64], right: &[f64]) -> f64 {
        self.solution.copy_from_slice(x);
        self.pattern.multiply_into(values, x, &mut self.residual);
        self.residual.iter_mut().zip(right).for_each(|(r, b)| *r = b - *r);
        self.error_by_rows(values, right)
    }

    /// Factorizes the matrix with these values.
    ///
    /// # Errors
    /// [`LinearError::NotFinite`], [`LinearError::OutOfMemory`], [`LinearError::Interrupted`]; whether the matrix is singular is found in
    /// [`Self::solve`].
    pub fn factorize(&mut self, values: &[f64]) -> Result<(), LinearError> {
        if !all_finite(values) {
            return Err(LinearError::NotFinite);
        }
        let is_due = self.account.uses >= REVIEW || !self.order.fits(&self.pattern);
        if is_due || self.left_out.iter().any(|range| values[range.start as usize..range.end as usize].iter().any(|&x| x != 0.0)) {
            self.adapt(values)?;
        }
        self.work.factorizations += 1;
        self.work.operations += self.symbolic.operations;
        self.account.uses += 1;
        self.account.wasted += (self.symbolic.operations - self.order.best).max(0.0);
        vertex_scales(&self.pattern, values, &mut self.vertex_scale);
        spread(&self.pattern, &self.vertex_scale, &mut self.scale);
        // The fallback's factors take several times the memory, and the next matrix rarely needs them.
        self.fallback = None;
        self.fallen_back = false;
        self.null_vector = None;
        let Factorization { multifrontal, symbolic, vertex_scale, workers, watch, .. } = self;
        if symbolic.tasks.is_empty() {
            multifrontal.factorize(symbolic, values, vertex_scale, &Workers::default(), watch);
        } else {
            workers.together(|| multifrontal.factorize(symbolic, values, vertex_scale, workers, watch));
        }
        self.watch.ended();
        if self.watch.is_interrupted() { Err(LinearError::Interrupted) } else { Ok(()) }
    }

    /// Solves with the last factorized values, which are given again for the residual; `right` becomes the solution.
    ///
    /// Returns the backward error `|r| / (|A| |x| + |b|)` (Rigal and Gaches 1967) in the maximum norm of the scaled system, with `|A| = 1`
    /// since scaling makes its entries of order one. The residual is not measured by `|b|` alone, because near an equilibrium `b` is hardly
    /// more than round-off. Rows with larger entries have more round-off: if the backward error is large, the residual of every row is
    /// compared with the terms of this row, `max_i |r_i| / max(sum_j |A_ij| |x_j| + |b_i|, |x|)` (Oettli and Prager 1964).
    ///
    /// # Errors
    /// [`LinearError::Singular`], [`LinearError::NotFinite`], or [`LinearError::Inaccurate`] when the backward error stays above
    /// [`crate::math::tolerances::LINEAR_RESIDUAL`] or the residual above [`crate::math::tolerances::LINEAR_UNSOLVED`] of `b`.
    pub fn solve(&mut self, values: &[f64], right: &mut [f64]) -> Result<f64, LinearError> {
        self.solve_from(values, right, None)
    }

    /// Solves as [`Self::solve`] for right-hand sides one after another, which become the solutions. Returns the largest backward error.
    ///
    /// # Errors
    /// Errors of [`Self::solve`].
    pub fn solve_all(&mut self, values: &[f64], rights: &mut [f64]) -> Result<f64, LinearError> {
        let (unknowns, mut worst) = (self.unknowns().max(1), 0.0f64);
        for rights in rights.chunks_mut(unknowns * TOGETHER) {
            let (mut first, mut images) = (Vec::new(), Vec::new());
            if rights.len() > unknowns && !self.fallen_back && self.multifrontal.replaced().is_empty() {
                first.extend_from_slice(rights);
                self.multifrontal.solve(&self.symbolic, &self.scale, &mut first, &self.workers);
                images.resize(first.len(), 0.0);
                self.pattern.multiply_each_into(values, &first, &mut images);
            }
            let mut known = first.chunks_exact(unknowns).zip(images.chunks_exact(unknowns));
            for right in rights.chunks_exact_mut(unknowns) {
                worst = worst.max(self.solve_from(values, right, known.next())?);
            }
        }
        Ok(worst)
    }

    /// Substitutes right-hand sides one after another, without refinement and checks where all pivots were usable.
    ///
    /// # Errors
    /// Errors of [`Self::solve`].
    pub fn estimate(&mut self, values: &[f64], rights: &mut [f64]) -> Result<(), LinearError> {
        if self.fallen_back || !self.multifrontal.replaced().is_empty() {
            return self.solve_all(values, rights).map(drop);
        }
        for rights in rights.chunks_mut(self.unknowns().max(1) * TOGETHER) {
            self.multifrontal.solve(&self.symbolic, &self.scale, rights, &self.workers);
        }
        Ok(())
    }

    /// Number of right-hand sides whose estimated solutions cost about as much as a factorization.
    pub fn substitutions_for_a_factorization(&self) -> usize {
        let substitution = 2.0 * SLOWER * self.symbolic.factors as f64;
        SUBSTITUTIONS.max((self.symbolic.operations / substitution) as usize)
    }

    /// Estimated null vector after [`LinearError::Singular`], one component per unknown.
    pub fn near_null_vector(&self) -> Option<&[f64]> {
        self.null_vector.as_deref()
    }

    /// Number of negative eigenvalues of the last factored matrix, if symmetric; `None` if pivots were replaced, or after the fallback.
    pub fn negative_eigenvalues(&self) -> Option<usize> {
        if self.fallen_back { None } else { self.multifrontal.negative_eigenvalues(&self.symbolic) }
    }
}
