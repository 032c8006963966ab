//! Velocity responses to impulses of single constraints at the end of a step, for impacts of rigid bodies.

use std::time::Instant;

use super::constraint_rows::ConstraintRows;
use super::failure::Failure;
use super::impulse_response::{EndMatrix, ImpulseResponse};
use super::iterate::Linearization;
use super::system::System;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::math::tolerances;

/// Velocity responses to impulses with ties, joints and rigid bodies as constraints.
pub struct Responses {
    matrix: EndMatrix,
    scale: f64,
    unknowns: usize,
    /// Gradients of the constraints by unknowns.
    gradients: Vec<Vec<(usize, f64)>>,
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// Factorizes the mass matrix with the constraints `hold`; `rows` are the constraints that receive impulses.
    ///
    /// # Errors
    /// The system is singular, or the run was interrupted.
    pub fn responses(
        &mut self,
        at: &Linearization,
        evaluated: [&[Evaluation]; 2],
        hold: &[bool],
        rows: &[usize],
    ) -> Result<Responses, Failure> {
        let clock = Instant::now();
        let mut values = vec![0.0; self.matrix.pattern.values()];
        self.add_mass_and_stiffness(&at.u_1, 0.0, &mut values);
        let scale = self.end_scale(evaluated);
        let matrix = self.end_matrix(evaluated, &ConstraintRows::held(hold), scale, values);
        let mut place = vec![usize::MAX; self.multipliers];
        rows.iter().enumerate().for_each(|(index, &row)| place[row] = index);
        let mut gradients = vec![Vec::new(); rows.len()];
        self.for_each_end_gradient(evaluated, |_, row, k, gradient| {
            if let Some(gradients) = gradients.get_mut(place[row]) {
                gradients.push((k, gradient));
            }
        });
        let mut still = vec![0.0; at.q_1.len() + self.multipliers];
        self.solve_with(&matrix.values, &mut still, clock)?;
        Ok(Responses { matrix, scale, unknowns: at.q_1.len(), gradients })
    }

    /// Rates of all constraints by a unit impulse of each, row by row, zero where bodies are held; and the power of the holding constraints
    /// per unit impulse at their rates `held`, which are zero only to the order of the step.
    ///
    /// # Errors
    /// The system is singular, or the run was interrupted.
    pub fn response_matrix(&mut self, responses: &Responses, held: &[f64]) -> Result<[Vec<f64>; 2], Failure> {
        let count = responses.gradients.len();
        let (mut of_rates, mut powers) = (vec![0.0; count * count], vec![0.0; count]);
        for row in 0..count {
            let mut impulses = vec![0.0; count];
            impulses[row] = 1.0;
            let velocity = self.velocity_by(responses, &impulses)?;
            for (other, gradient) in responses.gradients.iter().enumerate() {
                of_rates[other * count + row] = gradient.iter().map(|&(k, g)| g * velocity[k]).sum();
            }
            powers[row] = velocity[responses.unknowns..].iter().zip(held).map(|(mu, rate)| mu / responses.scale * rate).sum();
        }
        // Impulses on bodies that are held move nothing but by round-off.
        for (row, gradient) in responses.gradients.iter().enumerate() {
            let of_free_body = gradient.iter().map(|(_, g)| g * g).sum::<f64>() / self.nodes.total_mass;
            if of_rates[row * count + row] <= tolerances::HELD_RESPONSE * of_free_body {
                (0..count).for_each(|other| (of_rates[row * count + other], of_rates[other * count + row]) = (0.0, 0.0));
                powers[row] = 0.0;
            }
        }
        // Symmetric but for round-off.
        for row in 0..count {
            for other in 0..row {
                let mean = 0.5 * (of_rates[row * count + other] + of_rates[other * count + row]);
                (of_rates[row * count + other], of_rates[other * count + row]) = (mean, mean);
            }
        }
        Ok([of_rates, powers])
    }

    /// Change of the velocities by impulses, followed by the multipliers of the holding constraints.
    fn velocity_by(&mut self, responses: &Responses, impulses: &[f64]) -> Result<Vec<f64>, Failure> {
        let mut right = vec![0.0; responses.unknowns + self.multipliers];
        for (gradient, impulse) in responses.gradients.iter().zip(impulses).filter(|(_, impulse)| **impulse != 0.0) {
            gradient.iter().for_each(|&(k, g)| right[k] += responses.scale * impulse * g);
        }
        right.iter_mut().zip(&self.supports.fixed).filter(|(_, fixed)| **fixed).for_each(|(f, _)| *f = 0.0);
        let clock = Instant::now();
        self.matrix.solver.solve(&responses.matrix.values, &mut right).map_err(Failure::Linear)?;
        self.counters.times.solve += clock.elapsed();
        Ok(right)
    }

    /// Change of the velocities by impulses of the `rows` at the `rates` of all constraints, including reactions of supports, obstacles and
    /// joints on the ground.
    ///
    /// # Errors
    /// The system is singular, or the run was interrupted.
    pub fn response_to(
        &mut self,
        at: &Linearization,
        evaluated: [&[Evaluation]; 2],
        responses: &Responses,
        rows: &[usize],
        impulses: &[f64],
        rates: &[f64],
    ) -> Result<ImpulseResponse, Failure> {
        let mut velocity = self.velocity_by(responses, impulses)?;
        let mut lambda: Vec<f64> = velocity.split_off(at.q_1.len()).iter().map(|mu| mu / responses.scale).collect();
        rows.iter().zip(impulses).for_each(|(&row, impulse)| lambda[row] = *impulse);
        let mut response = self.response((evaluated, &at.q_1), &responses.matrix, velocity, lambda, &[]);
        self.add_driven(at, rates, &mut response);
        Ok(response)
    }
}
