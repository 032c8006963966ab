//! Velocity correction of the `velocity` rule at the end of a step: the rates of active constraints vanish, and the impact energy stored at
//! their closing is returned at their opening (`reserve.rs`).
//!
//! *At closing* a plastic impact makes the rates of all closed constraints zero: `v_1 + w` with `M w = G_1^T mu`, `G_1 (v_1 + w) = 0`, the
//! smallest such velocity change. Its energy loss, and the work `lambda (Phi_n - target)` of the closing, are stored for each constraint as
//! *reserve*, which counts as potential energy. *At opening*, when the constraint has become inactive and its gap grows, a smoothed jump
//! `v_1 + s w`,
//!
//! ```text
//! (M + (dt/2)^2 K_m(q_1)) w = G_1^T (push + mu),    G_1 w = 0 where closed,    1/2 s^2 w.Mw + s v_1.Mw = reserve
//! ```
//!
//! returns the energy (energetic restitution, after Stronge, *Impact Mechanics*, 2000). The forces of `G_1` and of the material stiffness
//! `K_m` at the end of the step have no resultant and no moment, so linear and angular momentum are exact. Energy returned at once, as in
//! Laursen and Love (IJNME 53, 2002), repels the node, and a plane contact opens and closes in every second step.
//!
//! Friction acts in both: ratios of tangential to normal impulses are those of the step, so that the sum stays within the friction cone,
//! and an impact transfers the tangential momentum `mu` times the normal one.

use super::engine::Engine;
use super::velocity_correction::{Ending, VelocityCorrection};
use crate::bodies::{Elements, Space};
use crate::dynamics::step::conditions::Conditions;
use crate::dynamics::step::contact_set::slips_at;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::newton::Solution;
use crate::dynamics::step::start::Motion;

/// The constraints of the rule in a converged step.
struct Rows {
    /// True for each constraint under the `velocity` rule.
    ours: Vec<bool>,
    /// True for each constraint that is active at the end of the step, without penalties.
    hold: Vec<bool>,
    /// Stored impact energy of each constraint, including the work of closing in this step `[energy]`.
    reserve: Vec<f64>,
    /// True if a constraint has closed in this step.
    is_closing: bool,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Velocity jump of a converged step; `None` where no constraint of the rule has closed or has stored impact energy.
    ///
    /// # Errors
    /// Closed constraints depend on one another, or the run was interrupted.
    pub fn velocity_jump(
        &mut self,
        motion: &Motion,
        solution: &Solution,
        conditions: &Conditions,
    ) -> Result<Option<VelocityCorrection>, Failure> {
        let Rows { ours, hold, reserve, is_closing } = self.rows_at_end(solution, conditions);
        if !is_closing && reserve.iter().all(|reserve| *reserve == 0.0) {
            return Ok(None);
        }
        let slips = self.system.slips_at_rest(&solution.at.q_1, &solution.at.pairs);
        let v = motion.velocities(&solution.at.moved, &self.system.supports.prescribed);
        let mut ratios = self.ratios(solution, conditions);
        loop {
            let mut jump = VelocityCorrection::none(v.len(), reserve.clone());
            let mut end = Ending { motion, solution, ours: &ours, hold: &hold, v: v.clone(), slips: &slips, ratios: &ratios };
            if is_closing {
                self.close(&mut end, &mut jump)?;
            }
            self.give_back(&mut end, &mut jump)?;
            if !self.drop_gaining(solution, &jump, &mut ratios) {
                return Ok(Some(jump));
            }
        }
    }

    /// Ratios of tangential to normal impulses in a velocity jump: as in this step or, for a constraint that has opened, as in the previous
    /// step, without the parts of film and adhesion. Obstacles that turn about their own axis, and joints, have none.
    fn ratios(&self, solution: &Solution, conditions: &Conditions) -> Vec<f64> {
        let mut ratios = vec![0.0; self.system.multipliers];
        for place in slips_at(&self.system, &solution.at).filter(|place| !place.pair.spins_in_place() && place.pair.reaction.is_none()) {
            let lambda = if solution.active[place.normal_row].is_closed() { &solution.at.lambda } else { &self.state.lambda };
            let of_group = place.under(conditions, lambda).impulse_ratios();
            place.rows.clone().zip(of_group).for_each(|(row, ratio)| ratios[row] = ratio);
        }
        ratios
    }

    /// Removes the friction of a jump from contacts in which it would supply energy, step and jump together; returns true if there were
    /// any.
    fn drop_gaining(&self, solution: &Solution, jump: &VelocityCorrection, ratios: &mut [f64]) -> bool {
        let work = self.friction_work(&solution.at, &solution.multipliers(), Some(jump));
        let mut is_any = false;
        // Friction of joints belongs to no contact and has no part in a jump.
        let pairs = self.system.pairs.iter().enumerate().filter(|(_, pair)| pair.friction.is_some() && pair.reaction.is_none());
        for (_, pair) in pairs.filter(|(index, _)| work[self.system.contact_of(*index)] > 0.0) {
            pair.tangential().for_each(|(row, _)| is_any |= std::mem::take(&mut ratios[row]) != 0.0);
        }
        is_any
    }

    fn rows_at_end(&self, solution: &Solution, conditions: &Conditions) -> Rows {
        let (state, count) = (&self.state, self.system.multipliers);
        let mut rows = Rows {
            ours: vec![false; count],
            hold: solution.active.iter().enumerate().map(|(row, state)| row < self.system.normal_count && state.is_closed()).collect(),
            reserve: state.reserve.clone(),
            is_closing: false,
        };
        for pair in &self.system.pairs {
            if !pair.has_multipliers() {
                rows.hold[pair.rows.clone()].fill(false);
            } else if pair.restitution.is_some() {
                // Contacts with restitution are resolved in `rigid_impacts.rs`; their constraints may be linearly dependent.
                rows.hold[pair.rows.clone()].fill(false);
            } else if pair.update.gives_back && pair.is_unilateral() {
                for row in pair.rows.clone() {
                    rows.ours[row] = true;
                    if solution.active[row].is_closed() {
                        let closing = conditions.gap_n[row] - conditions.targets[row];
                        rows.reserve[row] += solution.at.lambda[row] * closing;
                        rows.is_closing |= !state.active[row].is_closed() || closing.abs() > pair.closed;
                    }
                }
            }
        }
        rows
    }

    /// Plastic impact of the active constraints; its energy loss is stored, divided among the constraints by the work of the impulses.
    ///
    /// # Errors
    /// Closed constraints depend on one another, or the run was interrupted.
    fn close(&mut self, end: &mut Ending, jump: &mut VelocityCorrection) -> Result<(), Failure> {
        let rates = self.system.rates(end.rows(), &end.solution.at.q_1, &end.v);
        let target: Vec<f64> = rates.iter().zip(end.ours).map(|(rate, ours)| if *ours { -rate } else { 0.0 }).collect();
        let push = self.push(end, 0.0, &vec![0.0; rates.len()], &target)?;
        let slopes = self.slopes(end, &push);
        let energy = slopes.normal[0] + slopes.normal[1];
        let share = |row: usize| if end.hold[row] && end.ours[row] { (push.lambda[row] * rates[row]).abs() } else { 0.0 };
        let sum: f64 = (0..rates.len()).map(share).sum();
        if energy < 0.0 && sum > 0.0 {
            (0..rates.len()).for_each(|row| jump.reserve[row] -= energy * share(row) / sum);
            end.add(jump, 1.0, &push, &slopes);
        }
        Ok(())
    }
}
