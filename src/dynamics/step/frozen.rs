//! Newton's system of one iterate, factorized with one active set and solved with others that differ from it in some constraints.
//!
//! With `A` the matrix of the set in the factors and `x_A` its solution, a constraint `r` that becomes active adds its multiplier
//! `lambda_r` as an unknown, a constraint `s` that becomes inactive a slack `t_s` in its equation:
//!
//! ```text
//! x = x_A + sum_r lambda_r A^-1 (w Gbar_r + e_r) + sum_s t_s A^-1 e_s,   (G_r dq + d_r lambda_r)(x) = right_r,   lambda_s(x) = 0
//! ```
//!
//! One substitution per changed constraint and a small system replace a factorization for every set (principal pivoting; Cottle, Pang and
//! Stone 1992, chapter 4).

use std::collections::BTreeMap;
use std::time::Instant;

use nalgebra::{DMatrix, DVector};

use super::constraint_rows::ConstraintRows;
use super::constraints::add_known;
use super::equations::Equations;
use super::failure::Failure;
use super::iterate::Linearization;
use super::start::StepStart;
use super::system::System;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::RowBlock;
use crate::dynamics::parts::force_shares::ForceShares;
use crate::dynamics::parts::laws::Equation;

/// Newton's system of one iterate, factorized with one active set.
pub struct Frozen {
    /// Equations of the active set in the factors.
    rows: ConstraintRows,
    /// Equations of the present active set.
    present: ConstraintRows,
    /// Right-hand side and solution of the active set in the factors.
    right: Vec<f64>,
    solution: Vec<f64>,
    /// Gaps and multipliers of all constraints for the active set in the factors.
    base: RowValues,
    /// Change of all gaps and multipliers per unit multiplier or slack, for each changed constraint.
    answers: BTreeMap<usize, RowValues>,
    /// Multiplier or slack of each changed constraint in the present active set.
    amounts: Vec<(usize, f64)>,
}

impl Frozen {
    /// Gaps and multipliers of the active set in the factors.
    pub fn base(&self) -> &RowValues {
        &self.base
    }
}

/// Linearized gaps and multipliers of all constraints for one solution of the frozen system.
#[derive(Clone, Debug)]
pub struct RowValues {
    /// Linear part of the weighted gaps, `G_1 dq`.
    pub gaps: Vec<f64>,
    /// Multipliers.
    pub lambda: Vec<f64>,
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// Factorizes Newton's system of an iterate with the equations of an active set, and solves it.
    ///
    /// # Errors
    /// The system is singular, or the run was interrupted.
    pub fn freeze(&mut self, start: &StepStart, at: &mut Linearization, rows: &ConstraintRows) -> Result<Frozen, Failure> {
        let right = self.write_system(start, at, rows)?;
        let (mut solution, known) = (right.clone(), self.known_multipliers(at, &[rows]));
        self.subtract_known(&at.tangent, &known, &mut solution);
        self.solve_with(&at.tangent, &mut solution, Instant::now())?;
        add_known(&known, &mut solution);
        self.refine(start, &at.tangent, &right, &mut solution)?;
        let base = self.row_values([&at.pairs, &at.slips], &solution, right.len()).remove(0);
        Ok(Frozen { rows: rows.clone(), present: rows.clone(), right, solution, base, answers: BTreeMap::new(), amounts: Vec::new() })
    }

    /// Refines a solution at rest, where the masters of rigid bodies have almost no stiffness: an admissible backward error of a solve,
    /// relative to the multipliers, leaves gaps of joints of several times their tolerance.
    fn refine(&mut self, start: &StepStart, values: &[f64], right: &[f64], solution: &mut [f64]) -> Result<(), Failure> {
        if !start.is_at_rest() || !self.has_rigid_bodies() {
            return Ok(());
        }
        let mut residual = vec![0.0; right.len()];
        self.matrix.pattern.multiply_into(values, solution, &mut residual);
        residual.iter_mut().zip(right).for_each(|(image, right)| *image = right - *image);
        self.substitute(values, &mut residual)?;
        solution.iter_mut().zip(&residual).for_each(|(x, d)| *x += d);
        Ok(())
    }

    fn substitute(&mut self, values: &[f64], right: &mut [f64]) -> Result<(), Failure> {
        let clock = Instant::now();
        let outcome = self.matrix.solver.solve(values, right);
        self.counters.times.solve += clock.elapsed();
        outcome.map(drop).map_err(Failure::Linear)
    }

    /// Gaps and multipliers with another active set, whose equations are `rows`; `None` if a new factorization with that set is preferable.
    pub fn rows_with(&mut self, frozen: &mut Frozen, start: &StepStart, at: &Linearization, rows: &ConstraintRows) -> Option<RowValues> {
        let changed: Vec<usize> = (0..self.multipliers).filter(|&row| rows.0[row] != frozen.rows.0[row]).collect();
        let fresh: Vec<usize> = changed.iter().copied().filter(|row| !frozen.answers.contains_key(row)).collect();
        if frozen.answers.len() + fresh.len() > self.matrix.solver.substitutions_for_a_factorization() {
            return None;
        }
        let unknowns = frozen.right.len();
        let mut rights = vec![0.0; unknowns * fresh.len()];
        for (row, right) in fresh.iter().zip(rights.chunks_exact_mut(unknowns)) {
            self.add_brought(frozen, start.shares(), at, &BTreeMap::from([(*row, 1.0)]), right);
        }
        // Estimated solutions only select active sets; the final set is solved to full accuracy.
        let clock = Instant::now();
        let outcome = self.matrix.solver.estimate(&at.tangent, &mut rights);
        self.counters.times.solve += clock.elapsed();
        outcome.ok()?;
        frozen.answers.extend(fresh.into_iter().zip(self.row_values([&at.pairs, &at.slips], &rights, unknowns)));
        if changed.is_empty() {
            frozen.amounts.clear();
            frozen.present.0.clone_from(&rows.0);
            return Some(frozen.base.clone());
        }
        // Left side of the equation of a changed constraint, or its multiplier if it becomes inactive.
        let of = |row: usize, values: &RowValues| {
            let Equation { acts, gradient, diagonal, normal, beside, .. } = rows.0[row];
            if !acts {
                return values.lambda[row];
            }
            let mut own = gradient * values.gaps[row] + diagonal * values.lambda[row];
            if normal != 0.0 {
                own += normal * values.lambda[self.pressing_row(row)];
            }
            if beside != [[0.0; 2]; 2] {
                let others = self.partner_rows(row).zip(beside);
                own +=
                    others.map(|(other, [by_gap, by_lambda])| by_gap * values.gaps[other] + by_lambda * values.lambda[other]).sum::<f64>();
            }
            own
        };
        let matrix = DMatrix::from_fn(changed.len(), changed.len(), |i, j| of(changed[i], &frozen.answers[&changed[j]]));
        let wanted = |row: usize| if rows.0[row].acts { rows.0[row].right } else { 0.0 };
        let right = DVector::from_iterator(changed.len(), changed.iter().map(|&row| wanted(row) - of(row, &frozen.base)));
        let amounts = matrix.lu().solve(&right).filter(|amounts| amounts.iter().all(|amount| amount.is_finite()))?;
        frozen.amounts = changed.iter().copied().zip(amounts.iter().copied()).collect();
        let mut values = frozen.base.clone();
        for (row, amount) in &frozen.amounts {
            let answer = &frozen.answers[row];
            values.gaps.iter_mut().zip(&answer.gaps).for_each(|(value, answer)| *value += amount * answer);
            values.lambda.iter_mut().zip(&answer.lambda).for_each(|(value, answer)| *value += amount * answer);
        }
        // Multipliers of inactive constraints are exactly zero.
        values.lambda.iter_mut().zip(&rows.0).filter(|(_, row)| !row.acts).for_each(|(lambda, _)| *lambda = 0.0);
        frozen.present.0.clone_from(&rows.0);
        Some(values)
    }

    /// Increment and multipliers with the active set of the last call of [`Self::rows_with`].
    ///
    /// # Errors
    /// The system is singular.
    pub fn thaw(&mut self, frozen: Frozen, start: &StepStart, at: &Linearization) -> Result<(Vec<f64>, Vec<f64>), Failure> {
        let amounts: BTreeMap<usize, f64> = frozen.amounts.iter().copied().collect();
        let mut solution;
        if amounts.is_empty() {
            solution = frozen.solution;
        } else {
            solution = frozen.right.clone();
            self.add_brought(&frozen, start.shares(), at, &amounts, &mut solution);
            let (right, known) = (solution.clone(), self.known_multipliers(at, &[&frozen.rows, &frozen.present]));
            self.subtract_known(&at.tangent, &known, &mut solution);
            self.substitute(&at.tangent, &mut solution)?;
            add_known(&known, &mut solution);
            self.refine(start, &at.tangent, &right, &mut solution)?;
            let unknowns = solution.len() - self.multipliers;
            amounts.keys().filter(|&&row| !frozen.present.0[row].acts).for_each(|row| solution[unknowns + row] = 0.0);
        }
        let lambda = solution.split_off(solution.len() - self.multipliers);
        Ok((solution, lambda))
    }
}

impl<const D: usize> Equations<D>
where
    Space<D>: Elements<D>,
{
    /// Linearized gaps and multipliers for several solutions one after another; the gradients are read once for all of them.
    fn row_values(&self, [pairs, slips]: [&[Evaluation]; 2], solutions: &[f64], length: usize) -> Vec<RowValues> {
        let of = |solution: &[f64]| RowValues { gaps: vec![0.0; self.multipliers], lambda: solution[length - self.multipliers..].to_vec() };
        let mut all: Vec<RowValues> = solutions.chunks_exact(length).map(of).collect();
        for block in self.blocks(pairs, slips) {
            for row in block.live_rows() {
                let gradient = &block.evaluation.gradient_end[row.gradient];
                for (values, solution) in all.iter_mut().zip(solutions.chunks_exact(length)) {
                    let gap = &mut values.gaps[row.row];
                    for (&node, gradient) in row.nodes.iter().zip(gradient.chunks_exact(D)) {
                        let increment = &solution[node as usize * D..][..D];
                        gradient.iter().zip(increment).for_each(|(gradient, increment)| *gap += gradient * increment);
                    }
                }
            }
        }
        all
    }

    /// Adds the contributions of changed constraints to a right-hand side.
    fn add_brought(&self, frozen: &Frozen, shares: ForceShares, at: &Linearization, amounts: &BTreeMap<usize, f64>, right: &mut [f64]) {
        let unknowns = right.len() - self.multipliers;
        for (&row, amount) in amounts {
            right[unknowns + row] += amount;
        }
        let changed = |block: &RowBlock| amounts.range(block.rows.clone()).next().is_some();
        for block in self.blocks(&at.pairs, &at.slips).filter(changed) {
            for row in block.live_rows() {
                let Some(amount) = amounts.get(&row.row).filter(|_| !frozen.rows.0[row.row].acts) else { continue };
                for (unknown, entry) in row.unknowns::<D>() {
                    if !self.supports.fixed[unknown] {
                        right[unknown] += amount * block.share(shares) * block.evaluation.gradient_bar[entry];
                    }
                }
            }
        }
    }
}
