//! Change of the velocities by impulses of the constraints at the end of a step.

use std::time::Instant;

use super::constraint_rows::ConstraintRows;
use super::equations::Equations;
use super::failure::Failure;
use super::iterate::Linearization;
use super::system::System;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::PairKind;
use crate::dynamics::parts::force_shares::ForceShares;
use crate::dynamics::parts::laws::Equation;
use crate::math::norms::{largest_size, sum_of_sizes};
use crate::math::tolerances;

/// A change of the velocities by impulses.
pub struct ImpulseResponse {
    /// Change of the velocities.
    pub velocity: Vec<f64>,
    /// Impulses of all normal and tangential constraints.
    pub lambda: Vec<f64>,
    /// Impulses of supports and obstacles on the nodes.
    pub impulse: Vec<f64>,
    /// Work of moving obstacles.
    pub work: f64,
}

/// The matrix of velocities at the end of a step.
pub(super) struct EndMatrix {
    /// Matrix values with supports and constraints.
    pub(super) values: Vec<f64>,
    /// Values of mass and stiffness alone, unscaled; `None` without supports.
    free: Option<Vec<f64>>,
    /// Numbers of the held constraints that have a compliance, each with its compliance.
    compliances: Vec<(usize, f64)>,
}

/// Given impulses and rates of constraints that change the velocities.
pub struct Cause<'a> {
    /// Normal and tangential constraints at the end of the step.
    pub rows: [&'a [Evaluation]; 2],
    /// Impulses of the constraints.
    pub lambda: &'a [f64],
    /// Constraints with given rates.
    pub hold: &'a [bool],
    /// Changes of the given rates.
    pub rate: &'a [f64],
    /// Impulses of tangential constraints relative to those of their normal constraints, in the order of all constraints.
    pub ratios: &'a [f64],
    /// True if unilateral constraints have a small compliance, because they depend on one another.
    pub is_eased: bool,
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// `w` with `(M + beta K_m(q_1)) w = G_1^T (lambda + mu)` and `G_1 w = rate` where `hold`, at an iterate; `lambda + mu` of a tangential
    /// constraint is that of its normal constraint times their ratio. `K_m` is the material stiffness: its forces have neither resultant
    /// nor moment at `q_1`, so that `v_1 + s w` has the momenta of `v_1` for every `s`, up to the impulses of supports and obstacles.
    ///
    /// # Errors
    /// The system is singular, or the run was interrupted.
    pub fn push(&mut self, at: &Linearization, beta: f64, cause: &Cause) -> Result<ImpulseResponse, Failure> {
        let clock = Instant::now();
        let (unknowns, &Cause { rows: evaluated, lambda, hold, rate, ratios, is_eased }) = (at.q_1.len(), cause);
        let mut values = vec![0.0; self.matrix.pattern.values()];
        self.add_mass_and_stiffness(&at.u_1, beta, &mut values);
        let scale = self.end_scale(evaluated);
        let mut rows = self.held_rows(hold, evaluated, is_eased);
        let mut given: Vec<f64> = hold.iter().zip(rate).map(|(hold, rate)| if *hold { *rate } else { 0.0 }).collect();
        for pair in &self.pairs {
            for (row, normal_row) in pair.tangential().filter(|(row, _)| ratios[*row] != 0.0) {
                rows.0[row] = Equation { acts: true, normal: -ratios[row], ..Equation::OPEN };
                given[row] = scale * ratios[row] * lambda[normal_row];
            }
        }
        let matrix = self.end_matrix(evaluated, &rows, scale, values);
        let mut right = vec![0.0; unknowns];
        self.for_each_end_gradient(evaluated, |_, row, k, gradient| right[k] += scale * lambda[row] * gradient);
        right.iter_mut().zip(&self.supports.fixed).filter(|(_, fixed)| **fixed).for_each(|(f, _)| *f = 0.0);
        right.extend(given);
        self.counters.times.assembly += clock.elapsed();
        self.factorize(&matrix.values, Instant::now())?;
        let mut right = self.solve_factorized(&matrix, right)?;
        let mu = right.split_off(unknowns);
        let lambda: Vec<f64> = lambda.iter().zip(&mu).map(|(lambda, mu)| lambda + mu / scale).collect();
        Ok(self.response((evaluated, &at.q_1), &matrix, right, lambda, &[]))
    }

    /// Solution by the factors of the matrix for a right side. Repeated solutions remove the influence of compliances: in each, the term of
    /// the last multipliers is added to the right side (proximal point method), until the velocities stay.
    pub(super) fn solve_factorized(&mut self, matrix: &EndMatrix, right: Vec<f64>) -> Result<Vec<f64>, Failure> {
        let (clock, first) = (Instant::now(), right.len() - self.multipliers);
        let repetitions = if matrix.compliances.is_empty() { 0 } else { tolerances::RATE_REPETITIONS };
        let mut solution = right.clone();
        self.matrix.solver.solve(&matrix.values, &mut solution).map_err(Failure::Linear)?;
        for _ in 0..repetitions {
            let mut next = right.clone();
            matrix.compliances.iter().for_each(|&(row, compliance)| next[first + row] += compliance * solution[first + row]);
            self.matrix.solver.solve(&matrix.values, &mut next).map_err(Failure::Linear)?;
            let change = next[..first].iter().zip(&solution).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
            solution = next;
            if change <= tolerances::SAME_RATE * largest_size(&solution[..first]) {
                break;
            }
        }
        self.counters.times.solve += clock.elapsed();
        Ok(solution)
    }

    /// Matrix of velocity changes at the end of a step: masses, stiffness and the given constraints.
    pub(super) fn end_matrix(&self, evaluated: [&[Evaluation]; 2], rows: &ConstraintRows, scale: f64, mut values: Vec<f64>) -> EndMatrix {
        let free = self.supports.fixed.contains(&true).then(|| values.clone());
        values.iter_mut().for_each(|value| *value *= scale);
        self.write_constraints(&self.matrix.pattern, evaluated, rows, ForceShares::WHOLE, |pair| &pair.gradient_end, &mut values);
        self.matrix.finish(rows, scale * self.nodes.largest_nodal_mass, &mut values);
        let is_compliant = |(_, row): &(usize, &Equation)| row.acts && row.gradient != 0.0 && row.diagonal != 0.0;
        let compliances = rows.0.iter().enumerate().filter(is_compliant).map(|(number, row)| (number, row.diagonal)).collect();
        EndMatrix { values, free, compliances }
    }

    /// Change of the velocities by constraint impulses, and by the forces `given` if any, including reactions of supports and obstacles.
    pub(super) fn response(
        &self,
        (evaluated, q_1): ([&[Evaluation]; 2], &[f64]),
        matrix: &EndMatrix,
        velocity: Vec<f64>,
        lambda: Vec<f64>,
        given: &[f64],
    ) -> ImpulseResponse {
        let unknowns = velocity.len();
        let mut push = ImpulseResponse { velocity, lambda, impulse: Vec::new(), work: 0.0 };
        let (mut on_nodes, mut from_obstacles, mut work) = (vec![0.0; unknowns], vec![0.0; unknowns], 0.0);
        self.for_each_end_gradient(evaluated, |pair, row, k, gradient| {
            let f = push.lambda[row] * gradient;
            on_nodes[k] += f;
            if pair.kind == PairKind::Obstacle {
                from_obstacles[k] += f;
                work += f * pair.obstacle_velocity.along::<D>(k, q_1);
            }
        });
        (push.impulse, push.work) = (from_obstacles, work);
        // Impulses of supports that keep their nodes at rest, in addition to those of obstacles.
        if let Some(values) = &matrix.free {
            let needed = self.image(values, &push.velocity);
            for k in (0..unknowns).filter(|&k| self.supports.fixed[k]) {
                push.impulse[k] += needed[k] - on_nodes[k] - given.get(k).unwrap_or(&0.0);
            }
        }
        push
    }

    /// Values of the matrix times a nodal vector.
    pub(super) fn image(&self, values: &[f64], nodal: &[f64]) -> Vec<f64> {
        let (mut vector, size) = (nodal.to_vec(), nodal.len() + self.multipliers);
        vector.resize(size, 0.0);
        let mut image = vec![0.0; size];
        self.matrix.pattern.multiply_into(values, &vector, &mut image);
        image.truncate(nodal.len());
        image
    }
}

impl<const D: usize> Equations<D>
where
    Space<D>: Elements<D>,
{
    /// Equations of the constraints that `hold`. If `is_eased`, and in models with couplings, unilateral constraints have a small
    /// compliance: those of both sides of a periodic pair are equal, so that without it the matrix would be singular.
    pub(super) fn held_rows(&self, hold: &[bool], evaluated: [&[Evaluation]; 2], is_eased: bool) -> ConstraintRows {
        let mut rows = ConstraintRows::held(hold);
        if is_eased || self.pairs.iter().any(|pair| matches!(pair.kind, PairKind::Coupling(_))) {
            let largest = largest_end_gradient(evaluated);
            for (pair, evaluation) in self.pairs.iter().zip(evaluated[0]).filter(|(pair, _)| pair.is_unilateral()) {
                // Other pairs may have gradients in other units: those of angles beside those of areas.
                let own = largest_size(&evaluation.gradient_end);
                let compliance = tolerances::RATE_COMPLIANCE * own * own / largest;
                let tangential = pair.tangential().map(|(row, _)| row);
                for row in pair.rows.clone().chain(tangential).filter(|&row| hold[row]) {
                    rows.0[row].diagonal += compliance;
                }
            }
        }
        rows
    }

    /// Factor that scales masses to the size of constraint gradients; without it the round-off of the constraints would appear as momentum.
    pub(super) fn end_scale(&self, evaluated: [&[Evaluation]; 2]) -> f64 {
        largest_end_gradient(evaluated) / self.nodes.largest_nodal_mass
    }

    /// True if the momenta of an impulse response equal the external impulses to round-off: nearly dependent constraints give a solution
    /// that is accurate in its residual only. `beside` is a momentum below which differences do not count.
    pub fn is_balanced(&self, push: &ImpulseResponse, q_1: &[f64], beside: f64) -> bool {
        let momenta = self.nodes.momenta_of(&push.velocity);
        let (limit, reach) = ((tolerances::PUSH * sum_of_sizes(&momenta)).max(beside), largest_size(q_1).max(self.nodes.extent));
        let off: Vec<f64> = momenta.iter().zip(&push.impulse).map(|(momentum, impulse)| momentum - impulse).collect();
        let far = |sum: [f64; 3], limit: f64| sum.iter().any(|x| x.abs() > limit);
        let (resultant, moment) = (self.nodes.resultant(&off), self.nodes.moment(q_1, &off));
        !far(resultant, limit) && !far(moment, limit * reach)
    }
}

/// Largest component of the gradients of the normal constraints at the end of a step.
fn largest_end_gradient(evaluated: [&[Evaluation]; 2]) -> f64 {
    evaluated[0].iter().map(|pair| largest_size(&pair.gradient_end)).fold(0.0, f64::max)
}
