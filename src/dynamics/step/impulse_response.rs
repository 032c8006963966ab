//! A change of the velocities by impulses of the constraints, at the end of a step.

use std::time::Instant;

use super::constraint_rows::ConstraintRows;
use super::failure::Failure;
use super::iterate::Linearization;
use super::system::System;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::PairKind;
use crate::dynamics::parts::laws::Equation;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// A change of the velocities by impulses.
pub struct ImpulseResponse {
    /// The change.
    pub velocity: Vec<f64>,
    /// Impulses of all rows, of those that press and the tangential ones.
    pub lambda: Vec<f64>,
    /// Impulses of supports and obstacles on the nodes.
    pub impulse: Vec<f64>,
    /// Work of obstacles that move.
    pub work: f64,
}

/// What makes a push.
pub struct Cause<'a> {
    /// What the rows are at the end of the step, those that press and the tangential ones.
    pub rows: [&'a [Evaluation]; 2],
    /// Impulses that are given.
    pub lambda: &'a [f64],
    /// Rows whose rates are given, and their changes.
    pub hold: &'a [bool],
    pub rate: &'a [f64],
    /// Impulses of tangential rows over those of the rows that press beside them, in the order of all rows.
    pub ratios: &'a [f64],
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// `w` with `(M + beta K_m(q_1)) w = G_1^T (lambda + mu)` and `G_1 w = rate` where `hold`, at an iterate; `lambda + mu` of tangential
    /// rows is that of the row that presses times their ratio. `K_m` is the material stiffness: its forces have neither resultant nor
    /// moment at `q_1`, so that `v_1 + s w` has the momenta of `v_1` for every `s`, up to what supports and obstacles push.
    ///
    /// # Errors
    /// The system is singular, or the run was interrupted.
    pub fn push(&mut self, at: &Linearization, beta: f64, cause: &Cause) -> Result<ImpulseResponse, Failure> {
        let clock = Instant::now();
        let (q_1, &Cause { rows: evaluated, lambda, hold, rate, ratios }) = (&at.q_1, cause);
        let mut values = vec![0.0; self.matrix.pattern.values()];
        self.add_mass_and_stiffness(&at.u_1, beta, &mut values);
        let free_values = self.supports.fixed.contains(&true).then(|| values.clone());
        // Masses as large as gradients, or the round-off of the constraints would be felt as momentum.
        let gradient = evaluated[0].iter().map(|pair| largest_size(&pair.gradient_end)).fold(0.0, f64::max);
        let scale = gradient / self.nodes.largest_nodal_mass;
        values.iter_mut().for_each(|value| *value *= scale);
        let mut rows = ConstraintRows::held(hold);
        let mut given: Vec<f64> = hold.iter().zip(rate).map(|(hold, rate)| if *hold { *rate } else { 0.0 }).collect();
        for pair in &self.pairs {
            for (row, pressing) in pair.tangential().filter(|(row, _)| ratios[*row] != 0.0) {
                rows.0[row] = Equation { acts: true, normal: -ratios[row], ..Equation::OPEN };
                given[row] = scale * ratios[row] * lambda[pressing];
            }
        }
        self.write_constraints(evaluated, &rows, 1.0, |pair| &pair.gradient_end, &mut values);
        self.matrix.finish(&rows, self.nodes.modulus, &mut values);
        let mut right = vec![0.0; q_1.len()];
        self.for_each_end_gradient(evaluated, |_, row, k, gradient| right[k] += scale * lambda[row] * gradient);
        right.iter_mut().zip(&self.supports.fixed).filter(|(_, fixed)| **fixed).for_each(|(f, _)| *f = 0.0);
        right.extend(given);
        self.counters.times.assembly += clock.elapsed();
        self.solve_with(&values, &mut right, Instant::now())?;
        let mu = right.split_off(q_1.len());
        let lambda: Vec<f64> = lambda.iter().zip(&mu).map(|(lambda, mu)| lambda + mu / scale).collect();
        let mut push = ImpulseResponse { velocity: right, lambda, impulse: Vec::new(), work: 0.0 };
        let (mut on_nodes, mut from_obstacles, mut work) = (vec![0.0; q_1.len()], vec![0.0; q_1.len()], 0.0);
        self.for_each_end_gradient(evaluated, |pair, row, k, gradient| {
            let f = push.lambda[row] * gradient;
            on_nodes[k] += f;
            if pair.kind == PairKind::Obstacle {
                from_obstacles[k] += f;
                work += f * pair.obstacle_velocity_along(k % D);
            }
        });
        (push.impulse, push.work) = (from_obstacles, work);
        // What the supports must push so that their nodes stay, besides what obstacles push.
        if let Some(values) = free_values {
            let mut vector = push.velocity.clone();
            vector.resize(q_1.len() + self.multipliers, 0.0);
            let mut needed = vec![0.0; q_1.len() + self.multipliers];
            self.matrix.pattern.multiply_into(&values, &vector, &mut needed);
            for k in (0..q_1.len()).filter(|&k| self.supports.fixed[k]) {
                push.impulse[k] += needed[k] - on_nodes[k];
            }
        }
        Ok(push)
    }

    /// Whether the momenta of a push that the model keeps are the impulses from outside, as far as round-off lets them: where constraints
    /// all but depend on one another, the solution is accurate in its residual and in nothing else.
    pub fn is_balanced(&self, push: &ImpulseResponse, q_1: &[f64]) -> bool {
        let momenta = self.nodes.momenta_of(&push.velocity);
        let sizes = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>();
        let (size, reach) = (sizes(&momenta), largest_size(q_1).max(self.nodes.extent));
        let off: Vec<f64> = momenta.iter().zip(&push.impulse).map(|(momentum, impulse)| momentum - impulse).collect();
        let far = |sum: [f64; 3], limit: f64| sum.iter().any(|x| x.abs() > limit);
        let (resultant, moment) = (self.nodes.resultant(&off), self.nodes.moment(q_1, &off));
        !far(resultant, tolerances::PUSH * size) && !far(moment, tolerances::PUSH * size * reach)
    }
}
