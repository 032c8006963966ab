//! Change of the velocities at the end of a step: closings of the `velocity` rule (`impact.rs`), impacts of rigid bodies
//! (`rigid_impacts.rs`) and the filter of a scheme that dissipates (`velocity_filter.rs`), in this order.

use super::engine::Engine;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::parts::nodal::half_product;
use crate::dynamics::step::conditions::Conditions;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::impulse_response::{Cause, ImpulseResponse};
use crate::dynamics::step::newton::Solution;
use crate::dynamics::step::start::Motion;
use crate::linear::LinearError;

/// A change of the velocities at the end of a step.
pub struct VelocityCorrection {
    /// Change of the velocities.
    pub velocity: Vec<f64>,
    /// Impulse of supports and obstacles.
    pub impulse: Vec<f64>,
    /// Kinetic energy of the change without friction, in the frame of moving supports and obstacles.
    pub energy: f64,
    /// Kinetic energy added by moving supports and obstacles.
    pub work: f64,
    /// Multipliers whose forces give the same impulse over the step.
    pub lambda: Vec<f64>,
    /// Work of the tangential multipliers `[energy]`, in the order of all constraints.
    pub friction: Vec<f64>,
    /// Stored impact energy after the step.
    pub reserve: Vec<f64>,
    /// Dissipation of the time integrator's velocity filter `[energy]`.
    pub dissipated: f64,
    /// Energy lost in impacts of rigid bodies by restitution `[energy]`, never negative.
    pub impact: f64,
    /// Constraints of rigid contacts that participated in impacts.
    pub closed: Vec<usize>,
}

impl VelocityCorrection {
    /// No change of `unknowns` velocities.
    pub fn none(unknowns: usize, reserve: Vec<f64>) -> Self {
        let (still, none) = (vec![0.0; unknowns], vec![0.0; reserve.len()]);
        VelocityCorrection {
            velocity: still.clone(),
            impulse: still,
            energy: 0.0,
            work: 0.0,
            lambda: none.clone(),
            friction: none,
            reserve,
            dissipated: 0.0,
            impact: 0.0,
            closed: Vec::new(),
        }
    }

    /// Adds a share of an impulse response to velocities, impulses, multipliers and work of a step of size `dt`.
    pub fn add(&mut self, share: f64, response: &ImpulseResponse, dt: f64) {
        let add = |sum: &mut [f64], share: f64, part: &[f64]| sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += share * part);
        add(&mut self.velocity, share, &response.velocity);
        add(&mut self.impulse, share, &response.impulse);
        add(&mut self.lambda, share / dt, &response.lambda);
        self.work += share * response.work;
    }
}

/// Converged step at which the `velocity` rule is applied.
pub struct Ending<'a> {
    /// Scheme, step size and initial velocities of the step.
    pub motion: &'a Motion<'a>,
    /// Converged solution of the step.
    pub solution: &'a Solution,
    /// True for each constraint under the `velocity` rule.
    pub ours: &'a [bool],
    /// True for each constraint that is active at the end of the step, without penalties.
    pub hold: &'a [bool],
    /// Velocities at the end of the step, including the jump so far.
    pub v: Vec<f64>,
    /// Tangential constraints at the end of the step.
    pub slips: &'a [Evaluation],
    /// Ratios of tangential to normal impulses, in the order of all constraints.
    pub ratios: &'a [f64],
}

/// Coefficients of `s^2` and `s` in the kinetic energy of `v + s w`, in the frame of moving supports and obstacles.
pub struct Slopes {
    /// Contribution of the normal constraints.
    pub normal: [f64; 2],
    /// Contribution of each tangential constraint, in the order of all constraints.
    pub friction: Vec<[f64; 2]>,
}

impl Slopes {
    fn at([a, b]: [f64; 2], s: f64) -> f64 {
        s * (a * s + b)
    }
}

impl Ending<'_> {
    /// Adds `s` times an impulse response to the jump and to the velocities.
    pub fn add(&mut self, jump: &mut VelocityCorrection, s: f64, push: &ImpulseResponse, slopes: &Slopes) {
        self.v.iter_mut().zip(&push.velocity).for_each(|(v, w)| *v += s * w);
        jump.add(s, push, self.motion.dt);
        jump.energy += Slopes::at(slopes.normal, s);
        jump.friction.iter_mut().zip(&slopes.friction).for_each(|(sum, slopes)| *sum += Slopes::at(*slopes, s));
    }

    /// Normal and tangential constraints at the end of the step.
    pub fn rows(&self) -> [&[Evaluation]; 2] {
        [&self.solution.at.pairs, self.slips]
    }

    /// True if a constraint with stored impact energy has become inactive.
    pub fn has_opened(&self, row: usize, reserve: &[f64]) -> bool {
        self.ours[row] && reserve[row] > 0.0 && !self.solution.active[row].is_closed()
    }
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Change of the velocities at the end of a converged step; `None` without a change.
    ///
    /// # Errors
    /// The impulses of an impact have no solution at these positions, or the run was interrupted.
    pub fn velocity_correction(
        &mut self,
        motion: &Motion,
        solution: &Solution,
        conditions: &Conditions,
    ) -> Result<Option<VelocityCorrection>, Failure> {
        let closed = self.velocity_jump(motion, solution, conditions)?;
        let struck = self.rigid_impacts(motion, solution, conditions, closed)?;
        self.filter(motion, solution, struck)
    }

    /// Velocities at the end of a step, including the correction so far.
    pub fn corrected_velocities(&self, motion: &Motion, solution: &Solution, jump: Option<&VelocityCorrection>) -> Vec<f64> {
        let mut v = motion.velocities(&solution.at.moved, &self.system.supports.prescribed);
        jump.iter().for_each(|jump| v.iter_mut().zip(&jump.velocity).for_each(|(v, w)| *v += w));
        v
    }

    /// Impulse response with the work of moving supports, if its momenta are balanced to within `beside` and round-off.
    ///
    /// # Errors
    /// Constraints depend on one another, exactly or within the round-off of the momenta; or the run was interrupted.
    pub fn checked(
        &self,
        motion: &Motion,
        solution: &Solution,
        response: Result<ImpulseResponse, Failure>,
        beside: f64,
    ) -> Result<ImpulseResponse, Failure> {
        let mut response = response.map_err(|failure| failure.or_end(self.state.row.time))?;
        let moving = self.system.supports.prescribed.iter().zip(motion.prescribed_v_1);
        response.work += moving.map(|(prescribed, v)| v * response.impulse[prescribed.unknown]).sum::<f64>();
        match self.system.is_balanced(&response, &solution.at.q_1, beside) {
            true => Ok(response),
            false => Err(Failure::Linear(LinearError::Singular { vertex: None })),
        }
    }

    /// Impulse response smoothed by the stiffness with the factor `beta`, for given impulses `lambda` and rates `rate`; `None` for linearly
    /// dependent constraints.
    pub fn balanced_push(&mut self, end: &Ending, beta: f64, lambda: &[f64], rate: &[f64]) -> Result<Option<ImpulseResponse>, Failure> {
        let push = self.push(end, beta, lambda, rate);
        match push {
            Err(failure @ Failure::Fatal(_)) => Err(failure),
            push => Ok(push.ok()),
        }
    }

    /// Impulse response of the constraints at the end of a step, including impulses of joints on the ground.
    ///
    /// # Errors
    /// Constraints depend on one another, or the run was interrupted.
    pub fn push(&mut self, end: &Ending, beta: f64, lambda: &[f64], rate: &[f64]) -> Result<ImpulseResponse, Failure> {
        let mut response = |is_eased: bool| {
            let cause = Cause { rows: end.rows(), lambda, hold: end.hold, rate, ratios: end.ratios, is_eased };
            let push = self.system.push(&end.solution.at, beta, &cause).map(|mut push| {
                let rates = self.system.rates(end.rows(), &end.solution.at.q_1, &end.v);
                self.system.add_driven(&end.solution.at, &rates, &mut push);
                push
            });
            self.checked(end.motion, end.solution, push, 0.0)
        };
        match response(false) {
            Err(Failure::Linear(LinearError::Singular { .. })) => response(true),
            outcome => outcome,
        }
    }

    /// Kinetic energy coefficients of an impulse response.
    pub fn slopes(&self, end: &Ending, push: &ImpulseResponse) -> Slopes {
        let momenta = self.system.nodes.momenta_of(&push.velocity);
        let mut normal = [half_product(&push.velocity, &momenta), 2.0 * half_product(&end.v, &momenta) - push.work];
        let mut friction = vec![[0.0; 2]; push.lambda.len()];
        if end.ratios.iter().any(|ratio| *ratio != 0.0) {
            let after: Vec<f64> = end.v.iter().zip(&push.velocity).map(|(v, w)| v + w).collect();
            let (before, after) =
                (self.system.rates(end.rows(), &end.solution.at.q_1, &end.v), self.system.rates(end.rows(), &end.solution.at.q_1, &after));
            for row in self.system.normal_count..push.lambda.len() {
                let lambda = push.lambda[row];
                friction[row] = [0.5 * lambda * (after[row] - before[row]), lambda * before[row]];
                (0..2).for_each(|k| normal[k] -= friction[row][k]);
            }
        }
        Slopes { normal, friction }
    }
}
