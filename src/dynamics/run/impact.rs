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

use super::engine::Engine;
use crate::bodies::{Elements, Space};
use crate::dynamics::parts::nodal::half_product;
use crate::dynamics::step::conditions::Conditions;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::newton::Solution;
use crate::dynamics::step::push::Push;
use crate::dynamics::step::start::Motion;
use crate::linear::LinearError;

/// A change of the velocities at the end of a step.
pub struct Jump {
    pub velocity: Vec<f64>,
    /// Impulse of supports and obstacles.
    pub impulse: Vec<f64>,
    /// Kinetic energy that it gives, as seen from what pushes.
    pub energy: f64,
    /// Kinetic energy that moving supports and obstacles add by their push.
    pub work: f64,
    /// Multipliers whose forces would give the same impulse over the step.
    pub lambda: Vec<f64>,
    /// The reserves after the step.
    pub reserve: Vec<f64>,
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

/// The constraints of the rule in a converged step.
struct Rows {
    /// Whether a row is under the rule.
    ours: Vec<bool>,
    /// Whether a row is closed at the end of the step, penalties left out.
    hold: Vec<bool>,
    /// The reserves, with the work of this step's closings.
    reserve: Vec<f64>,
    /// Whether some row has closed.
    is_closing: bool,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// The velocity jump of a converged step; nothing where no constraint of the rule has closed or holds a reserve.
    pub fn velocity_jump(&mut self, motion: &Motion, solution: &Solution, conditions: &Conditions) -> Result<Option<Jump>, Failure> {
        let Rows { ours, hold, reserve, is_closing } = self.rows_at_end(solution, conditions);
        if !is_closing && reserve.iter().all(|reserve| *reserve == 0.0) {
            return Ok(None);
        }
        let unknowns = solution.at.q_1.len();
        let mut v = motion.velocities(&solution.at.moved, &self.system.supports.prescribed);
        let mut jump = Jump {
            velocity: vec![0.0; unknowns],
            impulse: vec![0.0; unknowns],
            energy: 0.0,
            work: 0.0,
            lambda: vec![0.0; hold.len()],
            reserve,
        };
        if is_closing {
            self.close(motion, solution, &ours, &hold, &mut v, &mut jump)?;
        }
        self.open(motion, solution, &ours, &hold, &mut v, &mut jump)?;
        Ok(Some(jump))
    }

    fn rows_at_end(&self, solution: &Solution, conditions: &Conditions) -> Rows {
        let (state, count) = (&self.state, self.system.multipliers);
        let mut rows = Rows {
            ours: vec![false; count],
            hold: solution.active.iter().map(|row| row.is_closed()).collect(),
            reserve: state.reserve.clone(),
            is_closing: false,
        };
        for pair in &self.system.pairs {
            if !pair.has_multipliers() {
                rows.hold[pair.rows.clone()].fill(false);
            } else if pair.update.gives_back && !pair.equality {
                for row in pair.rows.clone() {
                    rows.ours[row] = true;
                    if solution.active[row].is_closed() {
                        let closing = conditions.gap_n[row] - conditions.targets[row];
                        rows.reserve[row] += solution.at.lambda[row] * closing;
                        rows.is_closing |= !state.active[row].is_closed() || closing.abs() > pair.closed();
                    }
                }
            }
        }
        rows
    }

    /// A plastic impact of the closed constraints; what it takes goes into their reserves, shared by the work of the impulses.
    fn close(
        &mut self,
        motion: &Motion,
        solution: &Solution,
        ours: &[bool],
        hold: &[bool],
        v: &mut [f64],
        jump: &mut Jump,
    ) -> Result<(), Failure> {
        let rates = self.system.rates(&solution.at.pairs, v);
        let target: Vec<f64> = rates.iter().zip(ours).map(|(rate, ours)| if *ours { -rate } else { 0.0 }).collect();
        let Some(push) = self.balanced_push(motion, solution, 0.0, &vec![0.0; hold.len()], hold, &target)? else { return Ok(()) };
        let (a, b) = self.kinetic_slopes(v, &push);
        let share = |row: usize| if hold[row] && ours[row] { (push.lambda[row] * rates[row]).abs() } else { 0.0 };
        let sum: f64 = (0..hold.len()).map(share).sum();
        if a + b < 0.0 && sum > 0.0 {
            (0..hold.len()).for_each(|row| jump.reserve[row] -= (a + b) * share(row) / sum);
            jump.energy += a + b;
            jump.add(1.0, &push, motion.dt, v);
        }
        Ok(())
    }

    /// Open constraints push in proportion to the impact that their reserve stands for, and give it back.
    fn open(
        &mut self,
        motion: &Motion,
        solution: &Solution,
        ours: &[bool],
        hold: &[bool],
        v: &mut [f64],
        jump: &mut Jump,
    ) -> Result<(), Failure> {
        let (rows, dt) = (hold.len(), motion.dt);
        let has_opened = |reserve: &[f64], row: usize| ours[row] && reserve[row] > 0.0 && !solution.active[row].is_closed();
        let mut pushes = vec![0.0; rows];
        for pair in &self.system.pairs {
            for row in pair.rows.clone().filter(|&row| has_opened(&jump.reserve, row)) {
                pushes[row] = (jump.reserve[row] / pair.kernel.weights()[row - pair.rows.start]).sqrt();
            }
        }
        let energy: f64 = (0..rows).filter(|&row| has_opened(&jump.reserve, row)).map(|row| jump.reserve[row]).sum();
        if energy <= 0.0 {
            return Ok(());
        }
        let parting: f64 = pushes.iter().zip(self.system.rates(&solution.at.pairs, v)).map(|(push, rate)| push * rate).sum();
        if parting <= 0.0 {
            return Ok(());
        }
        let pushed = self.balanced_push(motion, solution, 0.25 * dt * dt, &pushes, hold, &vec![0.0; rows])?;
        let Some(push) = pushed else { return Ok(()) };
        let (a, b) = self.kinetic_slopes(v, &push);
        if a > 0.0 && b > 0.0 {
            let s = 2.0 * energy / (b + (b * b + 4.0 * a * energy).sqrt());
            jump.energy += s * (a * s + b);
            jump.add(s, &push, dt, v);
            (0..rows).filter(|&row| pushes[row] > 0.0).for_each(|row| jump.reserve[row] = 0.0);
        }
        Ok(())
    }

    /// A push with the work of supports that move; nothing where constraints depend on one another: then nobody's velocity changes.
    fn balanced_push(
        &mut self,
        motion: &Motion,
        solution: &Solution,
        beta: f64,
        lambda: &[f64],
        hold: &[bool],
        rate: &[f64],
    ) -> Result<Option<Push>, Failure> {
        match self.system.push(&solution.at, beta, lambda, hold, rate) {
            Ok(mut push) => {
                let moving = self.system.supports.prescribed.iter().zip(motion.prescribed_v_1);
                push.work += moving.map(|(prescribed, v)| v * push.impulse[prescribed.unknown]).sum::<f64>();
                Ok(self.system.is_balanced(&push, &solution.at.q_1).then_some(push))
            }
            Err(failure @ Failure::Linear(LinearError::Interrupted | LinearError::OutOfMemory { .. })) => {
                Err(failure.or_end(self.state.row.time))
            }
            Err(_) => Ok(None),
        }
    }

    /// Kinetic energy of `v + s w`, as seen from what pushes: second and first order in `s`.
    fn kinetic_slopes(&self, v: &[f64], push: &Push) -> (f64, f64) {
        let momenta = self.system.nodes.momenta_of(&push.velocity);
        (half_product(&push.velocity, &momenta), 2.0 * half_product(v, &momenta) - push.work)
    }
}
