//! Nodal accelerations by the forces of a state.

use std::time::Instant;

use super::constraint_rows::ConstraintRows;
use super::failure::Failure;
use super::iterate::Linearization;
use super::system::System;
use crate::bodies::{Elements, Space};
use crate::dynamics::parts::force_shares::ForceShares;
use crate::math::norms::largest_size;

/// Accelerations of the nodes under the forces of a state, with the constraint forces of ties.
pub struct Accelerations {
    /// Accelerations of all nodes.
    pub nodes: Vec<f64>,
    /// Constraint forces of the ties on the nodes, in addition to those of the state's multipliers `[force]`.
    pub ties: Vec<f64>,
    /// Multipliers of the ties for these constraint forces, in the order of all constraints.
    pub lambda: Vec<f64>,
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// `a` with `M a = -f + G^T lambda` and `G a = 0` for the ties, at an unmoved iterate at rest with the static forces `f`; `given`:
    /// accelerations of prescribed nodes, 0 for all others.
    ///
    /// # Errors
    /// The system is singular, or the run was interrupted.
    pub fn accelerations(&mut self, at: &Linearization, given: Vec<f64>) -> Result<Accelerations, Failure> {
        let clock = Instant::now();
        let unknowns = given.len();
        // Contact forces that enter only their own step are not part of the history.
        let hold = self.bilateral_rows(&at.pairs, |pair| !pair.forces_stay_in_step());
        let mut values = vec![0.0; self.matrix.pattern.values()];
        self.add_mass_and_stiffness(&at.u_1, 0.0, &mut values);
        // Masses are scaled to the size of the constraint gradients.
        let gradient = at.pairs.iter().map(|pair| largest_size(&pair.gradient_end)).fold(0.0, f64::max);
        let scale = if gradient > 0.0 { gradient } else { 1.0 } / self.nodes.largest_nodal_mass;
        values.iter_mut().for_each(|value| *value *= scale);
        let mut right: Vec<f64> = self.nodes.momenta_of(&given);
        let pushed = |k: usize| at.forces.whole(at.forces.residual(k));
        right.iter_mut().enumerate().for_each(|(k, right)| *right = -scale * (pushed(k) + *right));
        right.iter_mut().zip(&self.supports.fixed).filter(|(_, fixed)| **fixed).for_each(|(right, _)| *right = 0.0);
        let mut needed = vec![0.0; self.multipliers];
        self.for_each_end_gradient([&at.pairs, &at.slips], |_, row, k, gradient| needed[row] -= gradient * given[k]);
        right.extend(hold.iter().zip(needed).map(|(hold, needed)| if *hold { needed } else { 0.0 }));
        let rows = ConstraintRows::held(&hold);
        self.write_constraints(
            &self.matrix.pattern,
            [&at.pairs, &at.slips],
            &rows,
            ForceShares::WHOLE,
            |pair| &pair.gradient_end,
            &mut values,
        );
        self.matrix.finish(&rows, scale * self.nodes.largest_nodal_mass, &mut values);
        self.counters.times.assembly += clock.elapsed();
        self.solve_with(&values, &mut right, Instant::now())?;
        let lambda: Vec<f64> = right.split_off(unknowns).iter().map(|mu| mu / scale).collect();
        right.iter_mut().zip(given).for_each(|(a, given)| *a += given);
        let mut ties = vec![0.0; unknowns];
        self.for_each_end_gradient([&at.pairs, &at.slips], |_, row, k, gradient| ties[k] += lambda[row] * gradient);
        Ok(Accelerations { nodes: right, ties, lambda })
    }
}
