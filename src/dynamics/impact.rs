//! What the `velocity` rule does with the velocities at the end of a step: closed constraints stay closed, and give back what their closing
//! took when they open.
//!
//! *At closing* a plastic impact makes the rates of all closed constraints zero: `v_1 + w` with `M w = G_1^T mu`, `G_1 (v_1 + w) = 0`, the
//! smallest change of the velocities that does so. What it takes, and the work `lambda (Phi_n - target)` of the closing itself, goes into a
//! *reserve*, constraint by constraint, which counts as potential energy. *At opening*, when the constraint has left the active set and its
//! gap grows, a smoothed jump `v_1 + s w`,
//!
//! ```text
//! (M + (dt/2)^2 K_m(q_1)) w = G_1^T (push + mu),    G_1 w = 0 where closed,    1/2 s^2 w.Mw + s v_1.Mw = reserve
//! ```
//!
//! returns it (energetic restitution, after Stronge, *Impact Mechanics*, 2000). `G_1` at the end of the step and the material stiffness
//! `K_m` have neither resultant nor moment there, so both momenta are exact. Given back at once, as in Laursen and Love (IJNME 53, 2002),
//! the energy throws the node off again, and a plane contact opens and closes in every second step.

use super::model::UpdateRule;
use super::newton::{Failure, Solution};
use super::pairs::Conditions;
use super::system::{Push, StepStart, System, half_product};
use super::time_loop::TimeLoop;
use crate::bodies::{Elements, Space};
use crate::linear::LinearError;

/// A change of the velocities at the end of a step.
pub(super) struct Jump {
    pub(super) velocity: Vec<f64>,
    /// Impulse of supports and obstacles.
    pub(super) impulse: Vec<f64>,
    /// Kinetic energy that it gives, as seen from what pushes.
    pub(super) energy: f64,
    /// Kinetic energy that moving supports and obstacles add by their push.
    pub(super) work: f64,
    /// Multipliers whose forces would give the same impulse over the step.
    pub(super) lambda: Vec<f64>,
    /// The reserves after the step.
    pub(super) reserve: Vec<f64>,
}

impl Jump {
    /// Adds `s` times a push to the jump and to the velocities.
    fn add(&mut self, s: f64, push: &Push, dt: f64, v: &mut [f64]) {
        let add = |sum: &mut [f64], s: f64, part: &[f64]| sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += s * part);
        add(v, s, &push.velocity);
        add(&mut self.velocity, s, &push.velocity);
        add(&mut self.impulse, s, &push.impulse);
        add(&mut self.lambda, s / dt, &push.lambda);
        self.work += s * push.work;
    }
}

impl<const D: usize> TimeLoop<D>
where
    Space<D>: Elements<D>,
{
    /// The velocity jump of a converged step; nothing where no constraint of the rule has closed or holds a reserve.
    pub(super) fn velocity_jump(
        &mut self,
        start: &StepStart,
        solution: &Solution,
        conditions: &Conditions,
    ) -> Result<Option<Jump>, Failure> {
        let (state, dt, rows) = (self.state.clone(), start.dt, self.system.multipliers);
        let (mut ours, mut hold) = (vec![false; rows], solution.active.clone());
        let (mut reserve, mut is_closing) = (state.reserve.clone(), false);
        for pair in &self.system.pairs {
            if pair.penalty > 0.0 {
                hold[pair.rows.clone()].fill(false);
            } else if pair.update == UpdateRule::Velocity && !pair.equality {
                for row in pair.rows.clone() {
                    ours[row] = true;
                    if solution.active[row] {
                        let closing = conditions.gap_n[row] - conditions.targets[row];
                        reserve[row] += solution.lambda[row] * closing;
                        is_closing |= !state.active[row] || closing.abs() > pair.closed();
                    }
                }
            }
        }
        if !is_closing && reserve.iter().all(|reserve| *reserve == 0.0) {
            return Ok(None);
        }
        let unknowns = solution.q_1.len();
        let mut v: Vec<f64> = (0..unknowns).map(|k| 2.0 / dt * (solution.q_1[k] - start.q_0[k]) - start.v_0[k]).collect();
        let moving: Vec<(usize, f64)> =
            self.system.prescribed.iter().zip(start.prescribed_v_1).map(|(prescribed, v)| (prescribed.unknown, *v)).collect();
        moving.iter().for_each(|&(k, v_1)| v[k] = v_1);
        let mut jump = Jump {
            velocity: vec![0.0; unknowns],
            impulse: vec![0.0; unknowns],
            energy: 0.0,
            work: 0.0,
            lambda: vec![0.0; rows],
            reserve: Vec::new(),
        };
        // A push with the work of supports that move; nothing where constraints depend on one another: then nobody's velocity changes.
        let completed = |system: &System<D>, push: Result<Push, LinearError>| match push {
            Ok(mut push) => {
                push.work += moving.iter().map(|&(k, v)| v * push.impulse[k]).sum::<f64>();
                Ok(system.is_balanced(&push, &solution.q_1).then_some(push))
            }
            Err(LinearError::Interrupted) => Err(Failure::Linear(LinearError::Interrupted).or_interrupt(state.row.time)),
            Err(_) => Ok(None),
        };
        // Kinetic energy of `v + s w`, as seen from what pushes: second and first order in `s`.
        let slopes =
            |momenta: &[f64], v: &[f64], push: &Push| (half_product(&push.velocity, momenta), 2.0 * half_product(v, momenta) - push.work);

        if is_closing {
            let rates = self.system.rates(&v);
            let target: Vec<f64> = (0..rows).map(|row| if ours[row] { -rates[row] } else { 0.0 }).collect();
            let push = self.system.push(&solution.q_1, 0.0, &vec![0.0; rows], &hold, &target);
            if let Some(push) = completed(&self.system, push)? {
                let (a, b) = slopes(&self.system.nodal_momenta(&push.velocity), &v, &push);
                // Shared by the work of the impulses.
                let share = |row: usize| if hold[row] && ours[row] { (push.lambda[row] * rates[row]).abs() } else { 0.0 };
                let sum: f64 = (0..rows).map(share).sum();
                if a + b < 0.0 && sum > 0.0 {
                    (0..rows).for_each(|row| reserve[row] -= (a + b) * share(row) / sum);
                    jump.energy += a + b;
                    jump.add(1.0, &push, dt, &mut v);
                }
            }
        }

        // Open constraints push in proportion to the impact that their reserve stands for.
        let opened = |row: usize| ours[row] && reserve[row] > 0.0 && !solution.active[row];
        let mut pushes = vec![0.0; rows];
        for pair in &self.system.pairs {
            for row in pair.rows.clone().filter(|&row| opened(row)) {
                pushes[row] = (reserve[row] / pair.kernel.weights()[row - pair.rows.start]).sqrt();
            }
        }
        let energy: f64 = (0..rows).filter(|&row| opened(row)).map(|row| reserve[row]).sum();
        let parting: f64 = if energy > 0.0 { pushes.iter().zip(self.system.rates(&v)).map(|(push, rate)| push * rate).sum() } else { 0.0 };
        if parting > 0.0 {
            let none = vec![0.0; rows];
            let push = self.system.push(&solution.q_1, 0.25 * dt * dt, &pushes, &hold, &none);
            if let Some(push) = completed(&self.system, push)? {
                let (a, b) = slopes(&self.system.nodal_momenta(&push.velocity), &v, &push);
                if a > 0.0 && b > 0.0 {
                    let s = 2.0 * energy / (b + (b * b + 4.0 * a * energy).sqrt());
                    jump.energy += s * (a * s + b);
                    jump.add(s, &push, dt, &mut v);
                    (0..rows).filter(|&row| pushes[row] > 0.0).for_each(|row| reserve[row] = 0.0);
                }
            }
        }
        jump.reserve = reserve;
        Ok(Some(jump))
    }
}
