//! Newton's system of an iterate with an active set: assembly, solution, and the resulting gaps.

use std::time::Instant;

use super::constraint_rows::ConstraintRows;
use super::equations::Equations;
use super::failure::Failure;
use super::iterate::Linearization;
use super::start::StepStart;
use super::system::System;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::{ContactPair, RowBlock};
use crate::dynamics::parts::force_shares::ForceShares;
use crate::linear::Pattern;

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// Solves Newton's system at an iterate for the increment and the new multipliers.
    ///
    /// # Errors
    /// The system is singular, or the run was interrupted.
    pub fn solve(&mut self, start: &StepStart, at: &mut Linearization, rows: &ConstraintRows) -> Result<(Vec<f64>, Vec<f64>), Failure> {
        let mut right = self.write_system(start, at, rows)?;
        let known = self.known_multipliers(at, &[rows]);
        self.subtract_known(&at.tangent, &known, &mut right);
        self.solve_with(&at.tangent, &mut right, Instant::now())?;
        add_known(&known, &mut right);
        let lambda = right.split_off(right.len() - self.multipliers);
        Ok((right, lambda))
    }

    /// Multipliers of an iterate, relative to which Newton's system is solved, for constraints that act in all sets; empty without joints,
    /// ties and rigid bodies.
    ///
    /// A backward error of a solve is relative to its largest unknowns. Stops and joints have large multipliers in short steps: solved for
    /// these, positions have an error whose energy exceeds the tolerance in every iteration (`tests/scripts/joints_in_short_steps.rhai`).
    pub(super) fn known_multipliers(&self, at: &Linearization, sets: &[&ConstraintRows]) -> Vec<f64> {
        if !self.has_point_constraints() {
            return Vec::new();
        }
        let acts = |row: usize| sets.iter().all(|rows| rows.0[row].acts);
        at.lambda.iter().enumerate().map(|(row, &lambda)| if acts(row) { lambda } else { 0.0 }).collect()
    }

    /// Subtracts the image of known multipliers from a right-hand side.
    pub(super) fn subtract_known(&self, values: &[f64], known: &[f64], right: &mut [f64]) {
        if known.is_empty() {
            return;
        }
        let mut all = vec![0.0; right.len()];
        all[right.len() - known.len()..].copy_from_slice(known);
        let mut image = vec![0.0; right.len()];
        self.matrix.pattern.multiply_into(values, &all, &mut image);
        right.iter_mut().zip(image).for_each(|(right, image)| *right -= image);
    }

    /// Writes Newton's system at an iterate into its tangent; returns the right-hand side.
    ///
    /// # Errors
    /// The tangent cannot be computed.
    pub fn write_system(&mut self, start: &StepStart, at: &mut Linearization, rows: &ConstraintRows) -> Result<Vec<f64>, Failure> {
        self.complete_tangent(start, at)?;
        let clock = Instant::now();
        let Linearization { forces, pairs, slips, tangent, lambda, .. } = at;
        let pattern = &self.matrix.pattern;
        self.equations.write_constraints(pattern, [pairs, slips], rows, start.shares(), |pair| &pair.gradient_bar, tangent);
        for pair in &self.equations.pairs {
            pair.reaction.iter().for_each(|reaction| reaction.couple(&rows.0[pair.rows.start], lambda, tangent));
        }
        let mut right: Vec<f64> = forces.without_contact.iter().map(|r| -r).collect();
        right.extend(rows.0.iter().map(|row| row.right));
        if !self.given.is_empty() {
            let mut image = vec![0.0; right.len()];
            self.matrix.pattern.multiply_into(tangent, &self.given, &mut image);
            right.iter_mut().zip(image).for_each(|(right, image)| *right -= image);
        }
        for (unknown, _) in self.supports.fixed.iter().enumerate().filter(|(_, fixed)| **fixed) {
            right[unknown] = self.nodes.modulus * self.given.get(unknown).unwrap_or(&0.0);
        }
        self.matrix.finish(rows, self.nodes.modulus, tangent);
        self.counters.times.factorization += clock.elapsed();
        Ok(right)
    }
}

/// Adds known multipliers to a solution relative to them.
pub(super) fn add_known(known: &[f64], solution: &mut [f64]) {
    let first = solution.len() - known.len();
    solution[first..].iter_mut().zip(known).for_each(|(lambda, known)| *lambda += known);
}

impl<const D: usize> System<D> {
    /// Factorizes values of the matrix and solves in place; assembly time is counted from `clock`.
    pub fn solve_with(&mut self, values: &[f64], right: &mut [f64], clock: Instant) -> Result<(), Failure> {
        self.factorize(values, clock)?;
        let clock = Instant::now();
        let outcome = self.matrix.solver.solve(values, right);
        self.counters.times.solve += clock.elapsed();
        outcome.map(drop).map_err(Failure::Linear)
    }

    /// Factorizes the given matrix values; `clock` is the start of the factorization.
    pub fn factorize(&mut self, values: &[f64], clock: Instant) -> Result<(), Failure> {
        self.counters.factorizations += 1;
        self.matrix.solver.factorize(values).map_err(Failure::Linear)?;
        self.counters.times.factorization += clock.elapsed();
        Ok(())
    }
}

impl<const D: usize> Equations<D> {
    /// True with ties, joints, couplings or rigid bodies.
    pub fn has_point_constraints(&self) -> bool {
        self.pairs.iter().any(ContactPair::has_quadratic_functions)
    }

    /// Writes rows `gradient G_1` and columns `-share columns^T` of the active constraints, and the coupling of tangential constraints to
    /// normal ones.
    pub fn write_constraints(
        &self,
        pattern: &Pattern,
        [pairs, slips]: [&[Evaluation]; 2],
        rows: &ConstraintRows,
        shares: ForceShares,
        columns: fn(&Evaluation) -> &Vec<f64>,
        values: &mut [f64],
    ) {
        pattern.clear_couplings(self.nodes.count(), values);
        for block in self.blocks(pairs, slips) {
            let places = (pattern, self.nodes.count());
            block.constraints_into::<D>(places, &rows.0, columns(block.evaluation), shares, values);
        }
        for friction in self.pairs.iter().filter_map(|pair| pair.friction.as_ref()) {
            friction.couple(&rows.0, values);
        }
    }

    /// Constraints of all pairs at an iterate: for each pair the normal ones, then the tangential ones.
    pub fn blocks<'a>(&'a self, pairs: &'a [Evaluation], slips: &'a [Evaluation]) -> impl Iterator<Item = RowBlock<'a>> {
        self.pairs.iter().zip(pairs).zip(slips).flat_map(|((pair, normal), slip)| pair.blocks([normal, slip]))
    }

    /// Rates `G_A v` of all normal and tangential constraints at the positions `q_1`, relative to moving obstacles.
    pub fn rates(&self, rows: [&[Evaluation]; 2], q_1: &[f64], v: &[f64]) -> Vec<f64> {
        let mut rates = vec![0.0; self.multipliers];
        self.for_each_end_gradient(rows, |pair, row, k, gradient| {
            rates[row] += gradient * (v[k] - pair.obstacle_velocity.along::<D>(k, q_1));
        });
        rates
    }

    /// Visits every entry of the constraint gradients at the end of the step: pair, constraint, unknown, value.
    pub fn for_each_end_gradient(&self, [pairs, slips]: [&[Evaluation]; 2], mut visit: impl FnMut(&ContactPair, usize, usize, f64)) {
        for block in self.blocks(pairs, slips) {
            for row in block.live_rows() {
                row.unknowns::<D>().for_each(|(k, entry)| visit(block.pair, row.row, k, block.evaluation.gradient_end[entry]));
            }
        }
    }
}
