//! Velocity filter of a dissipating scheme at the end of a step: `v - k (I - F)^2 v`, `F = (M + beta K)^-1 M`.
//!
//! `K` is the stiffness by the bodies' moduli at rest, at the positions of the end (`parts/step_damping.rs`). Rigid velocities are in its
//! null space, so that linear and angular momentum are conserved. Active constraints act as infinite stiffness: velocities that violate
//! them are filtered, too. With `d = -(I - F) v`,
//!
//! ```text
//! [ M + beta K   -G^T ] [ d ]   [ -beta K v ]
//! [ G              0  ] [ p ] = [ -G v      ]
//! ```
//!
//! where velocities of obstacles and supports do not count as violations; in the second application the right side has `K d` and `G d`.
//! `I - F` is symmetric in the kinetic energy, between 0 and 1: energy can only grow by the work of moving obstacles and supports.

use std::time::Instant;

use super::equations::Equations;
use super::failure::Failure;
use super::impulse_response::ImpulseResponse;
use super::iterate::Linearization;
use super::system::System;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::PairKind;
use crate::integrators::Derivative;
use crate::math::norms::sum_of_sizes;
use crate::math::tolerances;

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// Change `-(I - F)^2 v` of the velocities with the constraints active at the end of the step; `None` if these nearly depend on one
    /// another.
    ///
    /// # Errors
    /// The system is singular, or the run was interrupted.
    pub fn filtered(
        &mut self,
        at: &Linearization,
        beta: f64,
        evaluated: [&[Evaluation]; 2],
        hold: &[bool],
        v: &[f64],
    ) -> Result<Option<ImpulseResponse>, Failure> {
        let clock = Instant::now();
        let (unknowns, scale) =
            (v.len(), if hold.contains(&true) { self.end_scale(evaluated) } else { 1.0 / self.nodes.largest_nodal_mass });
        let mut stiffness = vec![0.0; self.matrix.pattern.values()];
        self.dampings.iter().for_each(|damping| damping.add_stiffness(&at.u_1, beta, &mut stiffness));
        let mut values = stiffness.clone();
        self.add_mass_and_stiffness(&at.u_1, 0.0, &mut values);
        let rows = self.held_rows(hold, evaluated, false);
        let matrix = self.end_matrix(evaluated, &rows, scale, values);
        let rates = self.rates(evaluated, &at.q_1, v);
        let mut lost: Vec<f64> = (0..hold.len()).map(|row| if hold[row] { -rates[row] } else { 0.0 }).collect();
        for pair in self.pairs.iter().filter(|pair| pair.drive.is_some()) {
            // Driven coordinates keep their rates.
            lost[pair.rows.clone()].fill(0.0);
        }
        let against: Vec<f64> = self.image(&stiffness, v).iter().map(|force| -force).collect();
        let first = self.right_side(&against, scale, &lost);
        self.counters.times.assembly += clock.elapsed();
        self.factorize(&matrix.values, Instant::now())?;
        let first = self.solve_factorized(&matrix, first)?;
        let force = self.image(&stiffness, &first[..unknowns]);
        let second = self.right_side(&force, scale, &lost);
        let mut second = self.solve_factorized(&matrix, second)?;
        let lambda: Vec<f64> = second.split_off(unknowns).iter().map(|p| p / scale).collect();
        let mut response = self.response((evaluated, &at.q_1), &matrix, second, lambda, &force);
        self.add_driven(at, &rates, &mut response);
        let momenta = self.nodes.momenta_of(v);
        let round_off = tolerances::PUSH * sum_of_sizes(&momenta) + tolerances::FILTER * sum_of_sizes(&force);
        Ok(self.is_balanced(&response, &at.q_1, round_off).then_some(response))
    }
}

impl<const D: usize> Equations<D>
where
    Space<D>: Elements<D>,
{
    /// Right-hand side: scaled forces at free unknowns, then the constraint values.
    fn right_side(&self, force: &[f64], scale: f64, rows: &[f64]) -> Vec<f64> {
        let free = force.iter().zip(&self.supports.fixed).map(|(force, fixed)| if *fixed { 0.0 } else { scale * force });
        free.chain(rows.iter().copied()).collect()
    }

    /// Adds the impulses of the ground through joints to the external impulses, and the work of drives.
    pub fn add_driven(&self, at: &Linearization, rates: &[f64], response: &mut ImpulseResponse) {
        for pair in self.pairs.iter().filter(|pair| matches!(pair.kind, PairKind::Joint | PairKind::Coupling(_))) {
            let (lambda, none) = (&response.lambda[pair.rows.clone()], vec![0.0; pair.rows.len()]);
            if pair.drive.is_some() {
                response.work += pair.rows.clone().map(|row| response.lambda[row] * rates[row]).sum::<f64>();
            }
            pair.kernel.obstacle_force_into(Derivative::AT_END, &at.q_1, &none, lambda, &mut response.impulse);
        }
    }
}
