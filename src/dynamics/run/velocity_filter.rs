//! Velocity filter of a dissipating scheme at the end of a step (`step/velocity_filter.rs`), and its entry in the ledger.

use super::engine::Engine;
use super::velocity_correction::VelocityCorrection;
use crate::bodies::{Elements, Space};
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::parts::nodal::half_product;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::impulse_response::ImpulseResponse;
use crate::dynamics::step::iterate::Linearization;
use crate::dynamics::step::newton::Solution;
use crate::dynamics::step::start::{Motion, StepStart};
use crate::linear::LinearError;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Adds the velocity filter to the jump at the end of a converged step; returns `jump` unchanged for schemes without a filter.
    ///
    /// # Errors
    /// The run was interrupted.
    pub fn filter(
        &mut self,
        motion: &Motion,
        solution: &Solution,
        jump: Option<VelocityCorrection>,
    ) -> Result<Option<VelocityCorrection>, Failure> {
        let share = motion.scheme.dissipation.velocity;
        if share == 0.0 || self.system.dampings.is_empty() {
            return Ok(jump);
        }
        let v = self.corrected_velocities(motion, solution, jump.as_ref());
        let mut jump = jump.unwrap_or_else(|| VelocityCorrection::none(v.len(), self.state.reserve.clone()));
        let Some(response) = self.balanced_filter(motion, solution, &v)? else { return Ok(Some(jump)) };
        let momenta = self.system.nodes.momenta_of(&response.velocity);
        let [second, first] = [half_product(&response.velocity, &momenta), 2.0 * half_product(&v, &momenta)];
        let lost = share * (response.work - first - share * second);
        jump.add(share, &response, motion.dt);
        // Round-off may be negative where no energy is lost.
        jump.dissipated = lost.max(0.0);
        Ok(Some(jump))
    }

    /// Dissipation of the time integrator in a step that ends at an iterate with the velocity correction `jump` `[energy]`.
    pub(super) fn taken(&self, start: &StepStart, at: &Linearization, jump: Option<&VelocityCorrection>) -> f64 {
        self.system.dissipated_by_strains(start, at) + jump.map_or(0.0, |jump| jump.dissipated)
    }

    /// Velocity filter with the work of moving supports: with the constraints active at both ends of the step, or only ties and joints if
    /// these depend on one another; `None` if the ties and joints do, too.
    fn balanced_filter(&mut self, motion: &Motion, solution: &Solution, v: &[f64]) -> Result<Option<ImpulseResponse>, Failure> {
        let slips = self.system.slips_at_rest(&solution.at.q_1, &solution.at.pairs);
        let (rows, beta) = ([&solution.at.pairs[..], &slips[..]], 0.25 * motion.dt * motion.dt);
        for with_contact in [true, false] {
            let hold = self.closed_throughout(solution, with_contact);
            match self.system.filtered(&solution.at, beta, rows, &hold, v) {
                Ok(Some(mut response)) => {
                    let moving = self.system.supports.prescribed.iter().zip(motion.prescribed_v_1);
                    response.work += moving.map(|(prescribed, v)| v * response.impulse[prescribed.unknown]).sum::<f64>();
                    return Ok(Some(response));
                }
                Err(failure @ Failure::Linear(LinearError::Interrupted | LinearError::OutOfMemory { .. } | LinearError::Ranks(_))) => {
                    return Err(failure.or_end(self.state.row.time));
                }
                Ok(None) | Err(_) => {}
            }
        }
        Ok(None)
    }

    /// Constraints of the filter: ties and joints and, with contact, constraints active or sticking at both ends of the step.
    fn closed_throughout(&self, solution: &Solution, with_contact: bool) -> Vec<bool> {
        let mut hold = self.system.bilateral_rows(&solution.at.pairs, |_| true);
        let is_closed = |row: usize| [&self.state.active, &solution.active].iter().all(|active| active[row] == RowState::Closed);
        for pair in &self.system.pairs {
            if !pair.law.is_bilateral() && with_contact && pair.has_multipliers() {
                pair.rows.clone().for_each(|row| hold[row] = is_closed(row));
                let sticking = pair.tangential().filter(|(row, normal_row)| pair.turn.is_none() && is_closed(*row) && hold[*normal_row]);
                let sticking: Vec<usize> = sticking.map(|(row, _)| row).collect();
                let held = |row: usize| solution.at.held[row - self.system.normal_count];
                sticking.into_iter().for_each(|row| hold[row] = !held(row));
            }
        }
        hold
    }
}
